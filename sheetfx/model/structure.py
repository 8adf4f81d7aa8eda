"""Structures of bars and sheets between named nodes, with sections, materials, supports and loads, and their file."""

from __future__ import annotations

import inspect
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from .. import meshes
from ..checks import NONZERO, check, require_components, require_known
from . import profiles
from .given_section import GivenSection
from .plasticity import Plastic
from .plate import Plate
from .section import Elastic, Rectangle, Section, Tube, round_bar

SECTIONS: dict[str, Callable[..., Section]] = {
    maker.__name__: maker for maker in (
        round_bar, Rectangle, Tube, profiles.Box, profiles.CSection, profiles.ISection, profiles.LSection,
        profiles.TSection, profiles.ZSection, GivenSection)}
Vector = Annotated[Sequence[float], NONZERO]


@dataclass(frozen=True, eq=False)
class Members:
    """Bars of one kind.

    Attributes
    ----------
    ends : pairs of nodes
    section, material : of a `Beam`
    up : direction of the section's depth
    """

    ends: Sequence[Sequence[str]]
    section: Section
    material: Elastic
    up: tuple[float, float, float] = (0.0, 0.0, 1.0)

    def __post_init__(self):
        check(self)
        if not self.ends:
            raise ValueError("Members: ends is empty; give at least one pair of nodes")


@dataclass(frozen=True, eq=False)
class Sheets:
    """Flat panels of one kind.

    Attributes
    ----------
    corners : three or four nodes in order around each panel
    plate, material : of a `Shell`
    """

    corners: Sequence[Sequence[str]]
    plate: Plate
    material: Elastic

    def __post_init__(self):
        check(self)
        if not self.corners:
            raise ValueError("Sheets: corners is empty; give the nodes of at least one panel")


@dataclass(frozen=True, eq=False)
class Structure:
    """Bars and sheets between named nodes, what holds them and what loads them.

    Attributes
    ----------
    nodes : name -> three coordinates
    bars, panels : by the names of their kinds
    supports : set or node -> components that are held there, as of a `Support`
    loads : set or node -> force on each of its nodes
    monitor : node or set of one node, component, and the sign of its displacement that counts as positive
    sets : name -> nodes
    under : direction from the sheets to the bars that they lie on, roughly

    Raises
    ------
    ValueError
        If there are no bars, or a node, bar, panel, support or load cannot be built.
    """

    nodes: Mapping[str, Sequence[float]]
    bars: Mapping[str, Members]
    panels: Mapping[str, Sheets]
    supports: Mapping[str, str]
    loads: Mapping[str, Vector]
    monitor: tuple[str, str, float]
    sets: Mapping[str, Sequence[str]] = field(default_factory=dict)
    under: Vector = (0.0, 0.0, -1.0)

    def __post_init__(self):
        check(self)
        if not self.bars:
            raise ValueError("Structure: bars is empty; panels alone are a Shell")
        for what, places in (("supports", self.supports), ("loads", self.loads), ("monitor", self.monitor[:1])):
            require_known(f"Structure: {what}", places, [*self.sets, *self.nodes])
        for place, force in self.loads.items():
            require_components(f"Structure: load at {place!r}", force, 3)
        require_components("Structure: under", self.under, 3)
        try:
            _ = self.table
        except ValueError as error:
            raise ValueError(f"Structure: {error}") from error

    @cached_property
    def table(self) -> meshes.Table:
        """Nodes, bars and panels, with a group for each kind; normals of panels point away from the bars under them."""
        bars = {f"bars {name}": [tuple(ends) for ends in kind.ends] for name, kind in self.bars.items()}
        panels = {f"panels {name}": [self._away(corners) for corners in kind.corners]
                  for name, kind in self.panels.items()}
        return meshes.Table(self.nodes, [row for rows in bars.values() for row in rows],
                            [row for rows in panels.values() for row in rows], self.sets,
                            {name: [f"bar {'-'.join(row)}" for row in rows] for name, rows in bars.items()}
                            | {name: [f"panel {'-'.join(row)}" for row in rows] for name, rows in panels.items()})

    def _away(self, corners: Sequence[str]) -> tuple[str, ...]:
        """The corners in the order in which the panel's normal points away from the bars under it."""
        x = [np.array(self.nodes[node], dtype=float) for node in corners if node in self.nodes][:3]
        turned = len(x) == 3 and np.cross(x[1] - x[0], x[2] - x[0]) @ np.asarray(self.under, dtype=float) > 0
        return tuple(reversed(corners)) if turned else tuple(corners)

    @property
    def mean_span(self) -> float:
        """Mean length of the bars."""
        x = np.array([[self.nodes[node] for node in ends] for ends in self.table.bars], dtype=float)
        return float(np.linalg.norm(x[:, 1] - x[:, 0], axis=1).mean())

    def elastic(self) -> Structure:
        """The same of materials that do not yield."""
        def unyielding(kinds: Mapping[str, Any]) -> dict[str, Any]:
            return {name: replace(kind, material=Elastic(kind.material.modulus, kind.material.poisson,
                                                         kind.material.density)) for name, kind in kinds.items()}

        return replace(self, bars=unyielding(self.bars), panels=unyielding(self.panels))


def read_structure(file: str | Path, coordinates: str = "ideal") -> Structure:
    """Structure from a JSON file.

    The file has `nodes` and `sets` as `meshes.read_table` reads them, and ::

        "materials": {"steel": {"modulus": 2.06e5, "poisson": 0.3, "yield_stress": 235}},
        "bars": {"ribs": {"section": {"Rectangle": {"width": 8, "depth": 20}}, "material": "steel",
                          "up": [0, 0, 1], "ends": [[1, 2], [2, 3]]}},
        "panels": {"roof": {"thickness": 1, "material": "steel", "corners": [[1, 2, 3]]}},
        "supports": {"feet": "x y z"},
        "loads": {"apex": [0, 0, -1]},
        "monitor": {"at": "apex", "component": "z", "sign": -1},
        "under": [0, 0, -1]

    Supports, loads and `at` name a node or a set. Sections are those of Python (`round_bar`, `Rectangle`, `Tube`,
    `ISection`, ...) with their attributes; a material with `yield_stress` is a `Plastic` one; a thickness may be a
    whole `"plate"` with the attributes of `Plate`. `up`, `panels`, `sets` and `under` may be left out. What else is
    there are notes.

    Parameters
    ----------
    coordinates : which of several named places of nodes

    Raises
    ------
    ValueError
        If the file, or the structure in it, cannot be read.
    """
    if Path(file).suffix.lower() != ".json":
        raise ValueError(f"structure {str(file)!r}: give a JSON file; tables of nodes alone are read by `read_table`")
    table = meshes.read_table(file, coordinates)
    try:
        return _structure(json.loads(Path(file).read_text(encoding="utf-8-sig")), table)
    except (ValueError, TypeError, AttributeError) as error:
        raise ValueError(f"structure {str(file)!r}: {error}") from error


def _structure(data: Mapping[str, Any], table: meshes.Table) -> Structure:
    materials = {name: _made(f"material {name!r}", Plastic if "yield_stress" in given else Elastic, given)
                 for name, given in _part(data, "materials").items()}

    def material(kind: str, given: Mapping[str, Any]) -> Elastic:
        name = _part(given, "material", kind)
        require_known(f"{kind}: material", [name], materials)
        return materials[name]

    bars = {name: Members(_names(_part(given, "ends", f"bars {name!r}")), _section(f"bars {name!r}", given),
                          material(f"bars {name!r}", given), tuple(given.get("up", Members.up)))
            for name, given in _part(data, "bars").items()}
    panels = {name: Sheets(_names(_part(given, "corners", f"panels {name!r}")), _plate(f"panels {name!r}", given),
                           material(f"panels {name!r}", given)) for name, given in data.get("panels", {}).items()}
    seen = _part(data, "monitor")
    monitor = (str(_part(seen, "at", "monitor")), _part(seen, "component", "monitor"), float(seen.get("sign", 1.0)))
    return Structure(table.nodes, bars, panels, _part(data, "supports"), _part(data, "loads"), monitor, table.sets,
                     tuple(data.get("under", Structure.under)))


def _part(given: Mapping[str, Any], name: str, of: str = "the file") -> Any:
    if name not in given:
        raise ValueError(f"{of} has no {name!r}; add it")
    return given[name]


def _names(rows: Sequence[Sequence[Any]]) -> list[tuple[str, ...]]:
    return [tuple(map(str, row)) for row in rows]


def _section(kind: str, given: Mapping[str, Any]) -> Section:
    named = _part(given, "section", kind)
    if not isinstance(named, Mapping) or len(named) != 1:
        raise ValueError(f'{kind}: section is {named!r}; write it like {{"Rectangle": {{"width": 8, "depth": 20}}}}')
    (name, measures), = named.items()
    require_known(f"{kind}: section", [name], SECTIONS)
    return _made(f"{kind}: section {name}", SECTIONS[name], measures)


def _plate(kind: str, given: Mapping[str, Any]) -> Plate:
    return _made(f"{kind}: plate", Plate, given["plate"] if "plate" in given
                 else {"thickness": _part(given, "thickness", kind)})


def _made(what: str, maker: Callable, attributes: Mapping[str, Any]) -> Any:
    """Something made of attributes that are named in a file."""
    known = inspect.signature(maker).parameters
    require_known(what, attributes, known)
    missing = [name for name, p in known.items() if p.default is p.empty and name not in attributes]
    if missing:
        raise ValueError(f"{what} has no {missing[0]!r}; add it")
    return maker(**attributes)
