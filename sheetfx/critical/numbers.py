"""The numbers of a scene that critical loads may depend on: measures of sections, moduli, stiffnesses, gaps."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields, is_dataclass, replace
from functools import partial
from typing import Any

from ..model.scene import Scene
from .remade import remade


@dataclass(frozen=True)
class Number:
    """A number of a scene.

    Attributes
    ----------
    name : such as "Plate.thickness", with the groups of the parts that have it where several things have such a name
    value : as it is
    scene : function from another value to the scene with that
    """

    name: str
    value: float
    scene: Callable[[float], Scene]


def numbers(scene: Scene) -> list[Number]:
    """Numbers of sections and materials of parts, of joints and of contacts, but for those that are zero."""
    found = [(thing, where, name, value) for thing, where in _things(scene) for name, value in _own(thing)]
    names = Counter(f"{type(thing).__name__}.{name}" for thing, _, name, _ in found)
    return [Number(_named(f"{type(thing).__name__}.{name}", where, names), value,
                   partial(_changed, scene, thing, name)) for thing, where, name, value in found]


def _named(name: str, where: str, names: Counter) -> str:
    return f"{name} of {where}" if names[name] > 1 else name


def _changed(scene: Scene, thing: Any, name: str, value: float) -> Scene:
    return remade(scene, {thing: replace(thing, **{name: value})})


def _things(scene: Scene) -> Iterator[tuple[Any, str]]:
    """What has numbers, each once, and where it is in the scene."""
    places: dict[int, tuple[Any, list[str]]] = {}
    for number, part in enumerate(scene.parts, 1):
        thing: Any
        for thing in (part.section, part.material):
            if is_dataclass(thing):
                places.setdefault(id(thing), (thing, []))[1].append(part.group or f"part {number}")
    for kind in (scene.joints, scene.contacts):
        for number, thing in enumerate(kind, 1):
            if is_dataclass(thing):
                places[id(thing)] = thing, [f"{getattr(thing, 'at', None) or type(thing).__name__} ({number})"]
    return ((thing, ", ".join(where)) for thing, where in places.values())


def _own(thing: Any) -> Iterator[tuple[str, float]]:
    """Names and values of its numbers that are not whole ones, and not zero."""
    for one in fields(thing):
        value = getattr(thing, one.name)
        if one.init and value and (isinstance(value, float) or (
                isinstance(value, int) and not isinstance(value, bool) and "float" in str(one.type))):
            yield one.name, float(value)
