"""Tables of nodes, of bars and panels between them: read from JSON or CSV, and checked."""

from __future__ import annotations

import csv
import json
import re
from codecs import BOM_UTF16_BE, BOM_UTF16_LE
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

SAME_PLACE = 1e-6  # over the size of the structure
_FILES = sorted((Path(__file__).parent / "domes").glob("*.json"))
DOMES = {file.stem.removeprefix("d0_"): file for file in _FILES if file.stem.startswith("d0_")}
STRUCTURES = {file.stem: file for file in _FILES if not file.stem.startswith("d0_")}


@dataclass(frozen=True, eq=False)
class Table:
    """A structure of straight bars and flat panels between named nodes.

    Attributes
    ----------
    nodes : name -> three coordinates
    bars : pairs of nodes
    panels : three or four nodes in order around each panel
    sets : name -> nodes, to be found together under this name
    groups : name -> bars, or panels, by names like "bar 1-2", to be found together under this name

    Raises
    ------
    ValueError
        If a node, bar or panel stands twice or cannot be built.
    """

    nodes: Mapping[str, Sequence[float]]
    bars: Sequence[Sequence[str]] = ()
    panels: Sequence[Sequence[str]] = ()
    sets: Mapping[str, Sequence[str]] = field(default_factory=dict)
    groups: Mapping[str, Sequence[str]] = field(default_factory=dict)

    def __post_init__(self):
        for name, x in self.nodes.items():
            if len(x) != 3 or not np.isfinite(x).all():
                raise ValueError(f"node {name}: its place is {list(x)}; give three finite numbers")
        _check_members(self)
        _check_places(self)
        for name, corners in self.named_panels.items():
            _check_flat(name, np.array([self.nodes[n] for n in corners], dtype=float), SAME_PLACE * self.size)

    @property
    def named_bars(self) -> dict[str, Sequence[str]]:
        """Nodes of each bar, by names like "bar 1-2"."""
        return _named("bar", self.bars)

    @property
    def named_panels(self) -> dict[str, Sequence[str]]:
        """Nodes of each panel, by names like "panel 1-2-3"."""
        return _named("panel", self.panels)

    @property
    def size(self) -> float:
        """Diagonal of the box around the structure."""
        x = np.array([*self.nodes.values()], dtype=float)
        return float(np.linalg.norm(np.ptp(x, axis=0)))


def read_table(file: str | Path, coordinates: str = "ideal") -> Table:
    """Table of a structure from a JSON or CSV file.

    JSON: an object with `nodes`, `bars`, `panels` and `sets` of a `Table`; what else is there are notes. Nodes are
    an object from names to coordinates, or a list of objects with an `id` and one or more named places, such as
    `{"id": 1, "ideal": [0, 0, 1], "measured": [0, 0, 0.98]}`. Names may be numbers. Bars and panels may stand by their
    kinds, as `read_structure` takes them: `{"ribs": {"ends": [[1, 2]]}}` and `{"roof": {"corners": [[1, 2, 3]]}}`.

    CSV: a line for each thing, which begins with its kind; empty lines and those that begin with # are notes::

        node, 1, 0, 0, 1
        bar, 1, 2
        panel, 1, 2, 3
        set, corners, 2, 3

    Semicolons, tabulators or spaces may stand for the commas, and then commas for decimal points. The text is in UTF-8
    or UTF-16, with or without a byte order mark, or else in Latin-1.

    Parameters
    ----------
    coordinates : which of several named places of nodes

    Raises
    ------
    ValueError
        If the file, or the structure in it, cannot be read.
    """
    file = Path(file)
    readers: dict[str, Callable[[str, str], Table]] = {".json": _from_json, ".csv": lambda text, _: _from_csv(text)}
    if file.suffix.lower() not in readers:
        raise ValueError(f"table {str(file)!r}: the name ends in {file.suffix!r}; give a file .json or .csv")
    if not file.is_file():
        raise ValueError(f"table {str(file)!r}: there is no such file in {file.parent.resolve()}; give another path")
    try:
        return readers[file.suffix.lower()](_text(file.read_bytes()), coordinates)
    except (ValueError, TypeError) as error:
        raise ValueError(f"table {str(file)!r}: {error}") from error


def dome(name: str | Path, coordinates: str = "ideal") -> Table:
    """Table of the three-way dome of 19 nodes, 42 bars and 24 panels, or of another one from a file.

    The thesis (section 5.2.2) gives neither coordinates nor a figure of the dome; three geometries are likely:

    - hex: a grid of equilateral triangles in plan
    - arc: two rings at equal arcs from the apex
    - plan: two rings at equal distances in plan

    Lengths are in mm. Sets of nodes: apex, corners (six, the supports of the thesis), rim (all twelve outer ones).

    Parameters
    ----------
    name : hex, arc, plan, or the path of a file for `read_table`
    """
    if name not in DOMES and not Path(name).suffix:
        raise ValueError(f"dome: no geometry {str(name)!r}; choose from {', '.join(DOMES)}, or give the path of a file")
    return read_table(DOMES.get(str(name), name), coordinates)


def _from_json(text: str, coordinates: str) -> Table:
    data = json.loads(text)
    if not isinstance(data, dict) or "nodes" not in data:
        raise ValueError("no nodes; give an object with nodes, bars and panels")
    nodes = data["nodes"]
    if isinstance(nodes, dict):
        nodes = [{"id": name, coordinates: x} for name, x in nodes.items()]
    for node in nodes:
        if node.get(coordinates) is None:
            places = ", ".join(key for key, x in node.items() if isinstance(x, list)) or "none"
            raise ValueError(f"node {node.get('id')} has no coordinates {coordinates!r}; it has {places}")
    _refuse_twice(str(node["id"]) for node in nodes)
    bars, panels = (_names(_of_all_kinds(data.get(kind, ()), of)) for kind, of in (("bars", "ends"),
                                                                                    ("panels", "corners")))
    sets = data.get("sets", {})
    return Table({str(n["id"]): n[coordinates] for n in nodes}, bars, panels,
                 dict(zip(sets, _names(sets.values()), strict=True)))


def _of_all_kinds(rows, of: str):
    return [row for kind in rows.values() for row in kind.get(of, ())] if isinstance(rows, dict) else rows


def _text(content: bytes) -> str:
    """Text of a file as editors and spreadsheets save it."""
    if content.startswith((BOM_UTF16_LE, BOM_UTF16_BE)):
        return content.decode("utf-16")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("latin-1")


def _from_csv(text: str) -> Table:
    rows: dict[str, list[list[str]]] = {"node": [], "bar": [], "panel": [], "set": []}
    places: dict[str, list[float]] = {}
    for number, line in enumerate(text.splitlines(), 1):
        kind, separator = _begin(line, rows)
        spaced = separator == " "
        signs = re.sub(" +", " ", line.strip()) if spaced else line.strip(" ")
        fields = [f.strip() for f in next(csv.reader([signs], delimiter=separator, skipinitialspace=not spaced), [])]
        while fields and not fields[-1]:
            fields.pop()
        if not fields or fields[0].startswith(("#", "sep=")):
            continue
        _, *values = fields
        if kind not in rows or not values:
            raise ValueError(f"line {number} is {line!r}; begin it with {', '.join(rows)} or #, and name nodes")
        if kind == "node":
            places[values[0]] = [_number(x, separator, number) for x in values[1:]]
        rows[kind].append(values)
    _refuse_twice(name for name, *_ in rows["node"])
    return Table(places, rows["bar"], rows["panel"], {name: members for name, *members in rows["set"]})


def _begin(line: str, kinds: Iterable[str]) -> tuple[str, str]:
    """Kind of thing that a line is about, and what separates its fields: the first sign after the kind."""
    found = re.match(rf'\s*"?({"|".join(kinds)})"?\s*?( *[,;\t]| )', line, re.IGNORECASE)
    return ("", ",") if found is None else (found[1].lower(), found[2].strip(" ") or " ")


def _number(text: str, separator: str, line: int) -> float:
    """A coordinate, with a decimal comma where commas do not separate."""
    try:
        return float(text if separator == "," else text.replace(",", "."))
    except ValueError as error:
        raise ValueError(f"line {line}: the coordinate {text!r} is no number; write it like 1000.5") from error


def _names(rows) -> list[tuple[str, ...]]:
    return [tuple(map(str, row)) for row in rows]


def _refuse_twice(names) -> None:
    seen = set()
    for name in names:
        if name in seen:
            raise ValueError(f"node {name} stands twice; give each node its own name")
        seen.add(name)


def _named(kind: str, rows: Sequence[Sequence[str]]) -> dict[str, Sequence[str]]:
    return {f"{kind} {'-'.join(row)}": row for row in rows}


def _check_members(table: Table) -> None:
    """Refuse bars, panels and sets of wrong nodes, and members that stand twice or meet nothing."""
    members: dict[frozenset[str], str] = {}
    rows = [(f"{kind} {'-'.join(row)}", row, counts) for kind, of, counts in
            (("bar", table.bars, (2,)), ("panel", table.panels, (3, 4))) for row in of]
    for name, row, counts in rows:
        _check_known(name, row, table.nodes)
        if len(row) not in counts:
            raise ValueError(f"{name} has {len(row)} nodes; give {' or '.join(map(str, counts))}")
        if len(set(row)) < len(row):
            twice = next(n for n in row if row.count(n) > 1)
            raise ValueError(f"{name} has the node {twice} twice; give different nodes")
        if frozenset(row) in members:
            raise ValueError(f"{name} has the same nodes as {members[frozenset(row)]}; remove one of the two")
        members[frozenset(row)] = name
    for name, nodes in table.sets.items():
        _check_known(f"set {name}", nodes, table.nodes)
        if name in table.nodes:
            raise ValueError(f"set {name} has the name of a node; give it another")
    for name, among in table.groups.items():
        if not (set(among) <= set(table.named_bars) or set(among) <= set(table.named_panels)):
            raise ValueError(f"group {name} is {', '.join(among)}; give bars alone or panels alone, like 'bar 1-2'")
    uses = Counter(node for _, row, _ in rows for node in row)
    if lost := [node for node in table.nodes if node not in uses]:
        raise ValueError(f"node {lost[0]} belongs to no bar and no panel; remove it, or add what it belongs to")
    for name, row, _ in rows:
        if len(rows) > 1 and all(uses[node] == 1 for node in row):
            raise ValueError(f"{name} meets no bar and no panel at any of its nodes; join it to the others by a node")


def _check_known(name: str, row: Sequence[str], nodes: Mapping) -> None:
    if unknown := [node for node in row if node not in nodes]:
        raise ValueError(f"{name}: there is no node {unknown[0]!r}; nodes are {', '.join(nodes)}")


def _check_places(table: Table) -> None:
    """Refuse two nodes at one place."""
    names, x = list(table.nodes), np.array([*table.nodes.values()], dtype=float)
    for i, j in sorted(cKDTree(x).query_pairs(SAME_PLACE * table.size)):
        raise ValueError(f"nodes {names[i]} and {names[j]} are both at {x[i]}; make one of them")


def _check_flat(name: str, x: np.ndarray, small: float) -> None:
    """Refuse panels without area, that are not flat, or whose nodes do not go round them."""
    last, following = (x - np.roll(x, 1, axis=0)), (np.roll(x, -1, axis=0) - x)
    turns = np.cross(last, following)
    small_turn, normal = small * np.linalg.norm(last, axis=1).max(), turns.sum(axis=0)
    if np.linalg.norm(turns, axis=1).max() <= small_turn:
        raise ValueError(f"{name}: its nodes are in one line; give three corners of an area")
    if (turns @ normal <= small_turn * np.linalg.norm(normal)).any():
        raise ValueError(f"{name}: its nodes do not go round it with a corner at each; give them in order")
    off = abs((x[-1] - x[0]) @ turns[1]) / np.linalg.norm(turns[1])
    if off > small:
        raise ValueError(f"{name} is not flat: its last node is {off:.4g} off the plane of the others; divide it into "
                         "two panels of three nodes")
