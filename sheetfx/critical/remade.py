"""Scenes like another in which some things are others: parts, sections, meshes."""

from __future__ import annotations

import copy
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from functools import cached_property
from typing import Any

from ..checks import checked
from ..discrete.contribution import Contribution
from ..model.scene import Scene
from ..model.work import Acting


@checked
def remade(scene: Scene, new: Mapping[Any, Any]) -> Scene:
    """A scene like another with some things in the place of others, wherever these occur.

    ```python
    thicker = fx.remade(scene, {shell: replace(shell, section=fx.Plate(13.0))})
    ```

    Parameters
    ----------
    new : thing of the scene, such as a part or a mesh -> what takes its place. Supports, loads, joints, contacts,
        stages and the monitor that refer to it are made again

    Raises
    ------
    ValueError
        If the scene has not one of the things.
    """
    again = Remade({id(old): other for old, other in new.items()})
    found = again.of(scene)
    if missing := [old for old in new if id(old) not in again.met]:
        raise ValueError(f"remade: the scene has not this {type(missing[0]).__name__}; give a part, load, support or "
                         "mesh of the scene itself")
    return found


class Remade:
    """Makes things again in which something is replaced, each once.

    Parameters
    ----------
    new : identity of a thing -> what takes its place

    Attributes
    ----------
    met : identities of replaced things that occurred
    """

    def __init__(self, new: dict[int, Any]):
        self._new, self._replaced = new, set(new)
        self.met: set[int] = set()

    def of(self, one: Any) -> Any:
        """One thing, or made again where something in it is replaced."""
        if id(one) in self._replaced:
            self.met.add(id(one))
        if id(one) in self._new:
            return self._new[id(one)]
        if isinstance(one, (tuple, list)):
            parts = [self.of(part) for part in one]
            return one if all(a is b for a, b in zip(one, parts, strict=True)) else type(one)(parts)
        if isinstance(one, type) or not (is_dataclass(one) or isinstance(one, (Acting, Contribution))):
            return one
        names = [f.name for f in fields(one) if f.init] if is_dataclass(one) else list(_kept(one))
        changed = {name: new for name in names if (new := self.of(old := getattr(one, name))) is not old}
        if changed:
            changed |= self.changes(one)
        self._new[id(one)] = one if not changed else _with(one, changed)
        return self._new[id(one)]

    def changes(self, one: Any) -> dict[str, Any]:
        """Further attributes that change in a thing that is made again."""
        return {}


def _kept(one: Any) -> Iterator[str]:
    """Names of what an object of one's own has, but for what it has computed."""
    return (name for name in vars(one) if not isinstance(getattr(type(one), name, None), cached_property))


def _with(one: Any, changed: dict[str, Any]) -> Any:
    """A thing like another with some attributes changed."""
    if is_dataclass(one) and not isinstance(one, type):
        return type(one)(**{f.name: getattr(one, f.name) for f in fields(one) if f.init} | changed)
    new = copy.copy(one)
    vars(new).clear()
    vars(new).update({name: vars(one)[name] for name in _kept(one)} | changed)
    return new
