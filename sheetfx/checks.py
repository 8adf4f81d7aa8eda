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
class Also:
    """A rule beside the type, by a test of its own."""

    words: str
    holds: Callable[[Any], bool]


@dataclass(frozen=True)
class Like:
    """A rule instead of the type, by a test of its own."""

    words: str
    holds: Callable[[Any], bool]


def _real(value) -> bool:
    return isinstance(value, Real) and not isinstance(value, (bool, np.bool_))


def _whole(value) -> bool:
    return isinstance(value, Integral) and not isinstance(value, (bool, np.bool_))


def _sequence(value) -> bool:
    return isinstance(value, (AnySequence, np.ndarray)) and not isinstance(value, (str, bytes))


def _finite_array(value) -> bool:
    return _sequence(value) and np.asarray(value).dtype.kind in "fiu" and bool(np.isfinite(value).all())


POSITIVE, NOT_NEGATIVE, AT_LEAST_1 = Range(above=0), Range(least=0), Range(least=1)
NONZERO = Also("not zero", lambda value: np.linalg.norm(np.asarray(value, dtype=float)) > 0)
Positive = Annotated[float, POSITIVE]
NotNegative = Annotated[float, NOT_NEGATIVE]
Unbounded = Annotated[float, Like("a number", lambda value: _real(value) and not isnan(value))]
Count = Annotated[int, AT_LEAST_1]
Text = Annotated[str, Like("a text", lambda value: isinstance(value, str))]


def _objection(value, annotation) -> str | None:
    """What a value must be and is not, None if it is; anything is where an annotation says nothing."""
    if annotation in PLAIN:
        return next((words for words, holds in PLAIN[annotation] if not holds(value)), None)
    if (nested := NESTED.get(get_origin(annotation))) is not None:
        return nested(value, get_args(annotation))
    if isinstance(annotation, type) and annotation not in SAYS_NOTHING:
        return None if isinstance(value, annotation) else f"{_article(annotation.__name__)} {annotation.__name__}"
    return None


def _article(name: str) -> str:
    return "an" if name[0] in "AEIOU" else "a"


def _annotated(value, given) -> str | None:
    annotation, *rules = given
    likes = [rule for rule in rules if isinstance(rule, Like)]
    objection = None if likes else _objection(value, annotation)
    asked = [*likes, *(rule for rule in rules if isinstance(rule, (Range, Choice, Also)) and value is not None)]
    return objection or next((rule.words for rule in asked if not rule.holds(value)), None)


def _one_of_several(value, annotations) -> str | None:
    """What is nearest to the value: of numbers and sequences what their entries lack, else all kinds there are."""
    objections = [objection for annotation in annotations if (objection := _objection(value, annotation))]
    if len(objections) < len(annotations):
        return None
    kinds = [o for o in objections if o != "None"]
    near = [o for o in kinds if not o.startswith(("a ", "an "))] if _real(value) or _sequence(value) else []
    return " or ".join(dict.fromkeys(near or kinds))


def _tuple(value, annotations) -> str | None:
    if Ellipsis in annotations:
        return "not empty" if _sequence(value) and not len(value) else _sequence_of(value, annotations)
    if not _sequence(value) or len(value) != len(annotations):
        found = f", not {len(value)}" if _sequence(value) else ""
        return f"{len(annotations)} {'numbers' if annotations[0] in (float, int) else 'values'}{found}"
    return _entries(zip(value, annotations, strict=True))


def _sequence_of(value, annotations) -> str | None:
    if not _sequence(value):
        return f"a sequence{' of numbers' if annotations[0] in (float, int) else ''}"
    return _entries((v, annotations[0]) for v in value)


def _mapping(value, annotations) -> str | None:
    if not isinstance(value, AnyMapping):
        return "a mapping from names"
    return _entries(pair for item in value.items() for pair in zip(item, annotations, strict=True))


def _entries(pairs: Iterable[tuple[Any, Any]]) -> str | None:
    """What the first of values that is not as it must be lacks."""
    found = next((objection for pair in pairs if (objection := _objection(*pair))), None)
    return found if found in (None, "finite") else f"made of values that are each {found}"


def _function(value, _) -> str | None:
    return None if callable(value) else "a function"


PLAIN: dict[Any, list[tuple[str, Callable[[Any], bool]]]] = {
    float: [("a number", _real), ("finite", isfinite)], int: [("a whole number", _whole)],
    bool: [("True or False", lambda value: isinstance(value, (bool, np.bool_)))],
    str: [("a text that is not empty", lambda value: isinstance(value, str) and bool(value))],
    AnyCallable: [("a function", callable)], np.ndarray: [("an array of finite numbers", _finite_array)],
    None: [("None", lambda value: value is None)], type(None): [("None", lambda value: value is None)]}
NESTED: dict[Any, Callable[[Any, tuple], str | None]] = {
    Annotated: _annotated, Union: _one_of_several, types.UnionType: _one_of_several, tuple: _tuple,
    list: _sequence_of, AnySequence: _sequence_of, AnyMapping: _mapping, AnyCallable: _function}
SAYS_NOTHING = object, Any, inspect.Parameter.empty


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


def require_vector(what: str, found: Any, count: int | None = None) -> None:
    """Refuse what a function of the user's returns where it should return a UFL vector, of a number of components."""
    shape = getattr(found, "ufl_shape", None)
    if shape is None or len(shape) != 1 or (count is not None and shape != (count,)):
        given = f"UFL of shape {shape}" if shape is not None else reprlib.repr(found)
        size = f" of {count}" if count else ""
        raise ValueError(f"{what} returns {given}; return a UFL vector{size} (ufl.as_vector)")


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
