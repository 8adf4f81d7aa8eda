"""Checks of input, with messages that name object, value and remedy."""

from math import isfinite


def require_positive(owner, *names: str) -> None:
    """Refuse attributes of `owner` that are neither None nor positive."""
    for name in names:
        value = getattr(owner, name)
        if value is not None and not value > 0:
            raise ValueError(f"{type(owner).__name__}: {name} is {value}; it must be positive")


def require_finite(owner, *names: str) -> None:
    """Refuse attributes of `owner` that are infinite or no numbers; None, and sequences of finite numbers, pass."""
    for name in names:
        value = getattr(owner, name)
        if value is not None and not all(isfinite(v) for v in (value if isinstance(value, (tuple, list)) else [value])):
            raise ValueError(f"{type(owner).__name__}: {name} is {value}; it must be finite")


def require_choice(owner, name: str, known) -> None:
    """Refuse an attribute of `owner` that is not among the known names."""
    value = getattr(owner, name)
    if value not in known:
        raise ValueError(f"{type(owner).__name__}: {name} is {value!r}; it must be one of {', '.join(known)}")


def require_positive_number(owner: str, **numbers: float) -> None:
    """Refuse numbers given to `owner` that are not positive."""
    for name, value in numbers.items():
        if not value > 0:
            raise ValueError(f"{owner}: {name} is {value}; it must be positive")


def require_components(what: str, given, count: int) -> None:
    """Refuse a vector of another length than the structure's space demands."""
    if len(given) != count:
        raise ValueError(f"{what} {tuple(map(float, given))} has {len(given)} components; give {count}")


def require_known_component(what: str, component: str, known) -> None:
    """Refuse a component that the structure does not have."""
    if component not in known:
        raise ValueError(f"{what}: no component {component!r}; choose from {' '.join(known)}")
