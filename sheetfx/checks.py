"""The one check of input: values against the annotations that dataclasses, functions and options of scenes have.

An annotation says the type; numbers are finite, texts have letters and sequences of a given length have that. What
else is asked stands in the annotation too, as `Annotated[float, Range(above=0)]`, or by the names below.
"""

from __future__ import annotations

import inspect
import reprlib
import types
from collections.abc import Callable, Iterable, Sequence
from collections.abc import Callable as AnyCallable
from collections.abc import Mapping as AnyMapping
from collections.abc import Sequence as AnySequence
from dataclasses import dataclass, fields
from functools import cache, wraps
from math import inf, isfinite, isnan
from numbers import Integral, Real
from operator import attrgetter
from typing import Annotated, Any, TypeVar, Union, get_args, get_origin, get_type_hints

import numpy as np

Made = TypeVar("Made", bound=Callable)
VARIABLE = inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD


@dataclass(frozen=True)
class Range:
    """Bounds of numbers; below `above` and at it, or below `least`, they are refused."""

    above: float = -inf
    least: float = -inf
    most: float = inf
    below: float = inf

    @property
    def words(self) -> str:
        said = [f"above {self.above:g}"] * (self.above > -inf) + [f"at least {self.least:g}"] * (self.least > -inf)
        said += [f"at most {self.most:g}"] * (self.most < inf) + [f"below {self.below:g}"] * (self.below < inf)
        return {"above 0": "positive", "at least 0": "zero or positive"}.get(words := " and ".join(said), words)

    def holds(self, value) -> bool:
        return self.above < value < self.below and self.least <= value <= self.most


@dataclass(frozen=True)
class Choice:
    """The values that there are."""

    known: tuple

    @property
    def words(self) -> str:
        return f"one of {', '.join(map(str, self.known))}"

    def holds(self, value) -> bool:
        return any(value is k or (isinstance(value, type(k)) and value == k) for k in self.known)


@dataclass(frozen=True)
class Like:
    """What is told by a test of its own, instead of by its type."""

    words: str
    test: Callable[[Any], bool]

    def holds(self, value) -> bool:
        return bool(self.test(value))


def _not_zero(value) -> bool:
    return bool(np.linalg.norm(np.asarray(value, dtype=float)) > 0)


ANY_NUMBER = Like("a number", lambda value: _real(value) and not isnan(value))
MAY_BE_EMPTY = Like("a text", lambda value: isinstance(value, str))

POSITIVE, NOT_NEGATIVE, AT_LEAST_1 = Range(above=0), Range(least=0), Range(least=1)
Positive = Annotated[float, POSITIVE]
NotNegative = Annotated[float, NOT_NEGATIVE]
Unbounded = Annotated[float, ANY_NUMBER]
Count = Annotated[int, AT_LEAST_1]
Text = Annotated[str, MAY_BE_EMPTY]
NONZERO = Like("not zero", _not_zero)


def _real(value) -> bool:
    return isinstance(value, Real) and not isinstance(value, (bool, np.bool_))


def _whole(value) -> bool:
    return isinstance(value, Integral) and not isinstance(value, (bool, np.bool_))


def _sequence(value) -> bool:
    return isinstance(value, (AnySequence, np.ndarray)) and not isinstance(value, (str, bytes))


def _objection(value, annotation) -> str | None:
    """What a value must be and is not, None if it is; anything is where an annotation says nothing."""
    if get_origin(annotation) is Annotated:
        return _objection_to_annotated(value, *get_args(annotation))
    if get_origin(annotation) in (Union, types.UnionType):
        return _objection_to_all(value, get_args(annotation))
    if annotation in (None, type(None)):
        return None if value is None else "None"
    if annotation in (float, int):
        number = _real(value) if annotation is float else _whole(value)
        return ("a number" if annotation is float else "a whole number") if not number else (
            None if isfinite(value) else "finite")
    if annotation is bool:
        return None if isinstance(value, (bool, np.bool_)) else "True or False"
    if annotation is str:
        return None if isinstance(value, str) and value else "a text that is not empty"
    if AnyCallable in (annotation, get_origin(annotation)):
        return None if callable(value) else "a function"
    if get_origin(annotation) in (tuple, list, AnySequence):
        return _objection_to_sequence(value, get_origin(annotation), get_args(annotation))
    if get_origin(annotation) is AnyMapping:
        return _objection_to_mapping(value, *get_args(annotation))
    if annotation is np.ndarray:
        return None if _sequence(value) and np.asarray(value).dtype.kind in "fiu" and np.isfinite(
            value).all() else "an array of finite numbers"
    if isinstance(annotation, type) and annotation not in (object, Any, inspect.Parameter.empty):
        return None if isinstance(value, annotation) else f"a {annotation.__name__}"
    return None


def _objection_to_annotated(value, annotation, *rules) -> str | None:
    likes = [rule for rule in rules if isinstance(rule, Like) and rule is not NONZERO]
    objection = next((rule.words for rule in likes if not rule.holds(value)), None)
    if not likes:
        objection = _objection(value, annotation)
    asked = [rule for rule in rules if isinstance(rule, (Range, Choice)) or rule is NONZERO]
    if objection is None and value is not None:
        objection = next((rule.words for rule in asked if not rule.holds(value)), None)
    return objection


def _objection_to_all(value, annotations) -> str | None:
    objections = [objection for annotation in annotations if (objection := _objection(value, annotation)) is not None]
    if len(objections) < len(annotations):
        return None
    said = [o for o in objections if o not in ("None", "a number", "a whole number")] if _real(value) else objections
    close = [o for o in said if not o.startswith(("a ", "None"))] if _real(value) or _sequence(value) else []
    return " or ".join(dict.fromkeys(close or [o for o in said if o != "None"]))


def _objection_to_sequence(value, kind, annotations) -> str | None:
    of_any_length = kind is not tuple or Ellipsis in annotations
    inner = annotations[:1] if of_any_length else annotations
    size = "a sequence" if of_any_length else f"{len(inner)} values"
    if not _sequence(value):
        numbers = inner and inner[0] in (float, int)
        return f"{size.removesuffix('values') + 'numbers' if not of_any_length else size + ' of numbers'}" if (
            numbers) else size
    if not len(value) and kind is tuple:
        return "not empty"
    if not of_any_length and len(value) != len(inner):
        return f"{len(inner)} values, not {len(value)}"
    each = inner * len(value) if of_any_length else inner
    objections = [_objection(v, annotation) for v, annotation in zip(value, each, strict=False)]
    found = next((o for o in objections if o), None)
    return found if found in (None, "finite") else f"made of values that are each {found}"


def _objection_to_mapping(value, key, inner) -> str | None:
    if not isinstance(value, AnyMapping):
        return "a mapping from names"
    wrong = next((o for k, v in value.items() if (o := _objection(k, key) or _objection(v, inner))), None)
    return wrong if wrong in (None, "finite") else f"a mapping from names to what is each {wrong}"


@cache
def _annotations(owner: Any) -> dict[str, Any]:
    try:
        return get_type_hints(owner, include_extras=True)
    except (NameError, TypeError):  # of a user's own class or function, in which names are not known
        return {}


def require(owner: str, **values: tuple[Any, Any]) -> None:
    """Refuse values that are not what they must be.

    Parameters
    ----------
    owner : what messages call what has the values
    values : by name, each with its annotation

    Raises
    ------
    ValueError
        Names owner, value and remedy.
    """
    for name, (value, annotation) in values.items():
        if (objection := _objection(value, annotation)) is not None:
            raise ValueError(f"{owner}: {name} is {reprlib.repr(value)}; it must be {objection}")


def check(owner: Any) -> None:
    """Refuse attributes of a dataclass that are not what its annotations say; the first line of `__post_init__`."""
    at = getattr(owner, "at", None)
    title = f"{type(owner).__name__} at {at!r}" if isinstance(at, str) and at else type(owner).__name__
    annotations = _annotations(owner.__class__)
    require(title, **{field.name: (getattr(owner, field.name), annotations[field.name])
                      for field in fields(owner) if field.init and field.name in annotations})


def checked(function: Made, title: str = "", called: Callable[[inspect.Parameter], str] = attrgetter("name")) -> Made:
    """A function whose arguments are looked at first, as `check` looks at attributes; defaults are not.

    Parameters
    ----------
    title : what messages call the function; "": its name
    called : what messages call a parameter
    """
    @wraps(function)
    def looked_at(*positional, **named):
        bound = _signature(function).bind(*positional, **named)
        for name, value in bound.arguments.items():
            parameter = bound.signature.parameters[name]
            if parameter.kind not in VARIABLE and value is not parameter.default:
                require(title or function.__name__, **{called(parameter): (value, parameter.annotation)})
        return function(*positional, **named)

    return looked_at  # type: ignore[return-value]


@cache
def _signature(function: Callable) -> inspect.Signature:
    """With annotations as values, where their names are known."""
    try:
        return inspect.signature(function, eval_str=True)
    except NameError:
        return inspect.signature(function)


def require_components(what: str, given: Sequence[float], count: int) -> None:
    """Refuse a vector of another length than the structure's space demands."""
    if len(given) != count:
        raise ValueError(f"{what} {tuple(map(float, given))} has {len(given)} components; give {count}")


def require_known(what: str, names: Iterable[str], known: Iterable[str]) -> None:
    """Refuse names that are not among the known ones."""
    for name in names:
        if name not in known:
            raise ValueError(f"{what}: no {name!r}; choose from {', '.join(known)}")


def require_known_component(what: str, component: str, known) -> None:
    """Refuse a component that the structure does not have."""
    if component not in known:
        raise ValueError(f"{what}: no component {component!r}; choose from {' '.join(known)}")
