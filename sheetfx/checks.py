"""Checks of input, with messages that name object, value and remedy."""


def require_positive(owner, *names: str) -> None:
    """Refuse attributes of `owner` that are neither None nor positive."""
    for name in names:
        value = getattr(owner, name)
        if value is not None and not value > 0:
            raise ValueError(f"{type(owner).__name__}: {name} is {value}; it must be positive")
