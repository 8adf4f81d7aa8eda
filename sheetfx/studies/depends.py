"""What the load of a critical point depends on: its derivatives by the options of a scene and the numbers in it."""

from __future__ import annotations

import csv
import inspect
import io
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path as Folder
from typing import Any

import numpy as np

from ..archive.folder import write_whole
from ..case import Case
from ..continuation.state import CriticalPoint
from ..critical.bifurcation_gradient import NoDerivative
from ..critical.changed import Change
from ..critical.imperfect import imperfect
from ..critical.numbers import Number, numbers
from ..mesh.nodal_shapes import NodalShape
from ..model.scene import Scene
from ..record import Record

SMALL = 1e-6  # of the size, first movement of a node that differences are taken of
SAME = 1e-6  # relative difference between derivatives by an option and by a number of the scene, which are then one


@dataclass(frozen=True)
class Dependence:
    """How the load of a critical point changes with a number.

    Attributes
    ----------
    value : of the number
    derivative : of the load; of a point of several modes the lowest load's as the number grows
    percent_per_percent : change of the load in per cent by one per cent more; None: the load is zero
    """

    name: str
    value: float
    derivative: float
    percent_per_percent: float | None


def dependences(record: Record, point: CriticalPoint, function: Callable[..., Case], parameters: dict[str, Any]
                ) -> Iterator[Dependence | str]:
    """Dependences on the options of a scene that are numbers, and on the numbers in it; or why there is none.

    Parameters
    ----------
    function, parameters : that the case was made by
    """
    chosen = [*_options(function, parameters), *numbers(record.case.scene)]
    derivatives = record.load_gradient(point).derivatives(Change(number.scene, number.value) for number in chosen)
    found: list[Dependence] = []
    for number, known in zip(chosen, derivatives, strict=True):
        if isinstance(known, Exception):
            yield f"{number.name}: {known}"
            continue
        derivative = float(np.min(known))
        share = derivative * number.value / point.load if point.load else None
        one = Dependence(number.name, number.value, derivative, share)
        if any(one.value == o.value and abs(one.derivative - o.derivative) <= SAME * abs(o.derivative) for o in found):
            continue
        found.append(one)
        yield one


def _options(function: Callable[..., Case], parameters: dict[str, Any]) -> Iterator[Number]:
    for parameter in inspect.signature(function, eval_str=True).parameters.values():
        value = parameters.get(parameter.name, parameter.default)
        if isinstance(value, float) and value:
            yield Number(parameter.name, value, partial(_scene, function, parameters, parameter.name))


def _scene(function: Callable[..., Case], parameters: dict[str, Any], name: str, value: float) -> Scene:
    return function(**parameters | {name: value}).scene


def by_nodes(record: Record, point: CriticalPoint, shapes: Sequence[NodalShape],
             told: Callable[[int], None]) -> np.ndarray:
    """Derivatives of the load of a critical point by the movement of each node, shape (number of shapes,).

    Nodes that make a bifurcation's structure imperfect have none: NaN.

    Parameters
    ----------
    told : called with the number of nodes that are done
    """
    scene, size = record.case.scene, max(mesh.size for mesh in record.case.scene.meshes)

    def along(shape: NodalShape) -> Change:
        return Change(lambda way: imperfect(scene, shape, way), 0.0, SMALL * size, size)

    found = np.empty(len(shapes))
    for n, known in enumerate(record.load_gradient(point).derivatives(map(along, shapes))):
        if isinstance(known, Exception) and not isinstance(known, NoDerivative):
            raise known
        found[n] = np.nan if isinstance(known, NoDerivative) else np.min(known)
        told(n + 1)
    return found


def write_nodes(folder: Folder, shapes: Sequence[NodalShape], derivatives: np.ndarray) -> None:
    """Write `nodes.csv`: places, directions (empty: along the normal) and derivatives (empty: none)."""
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(["x", "y", "z", "along_x", "along_y", "along_z", "derivative"])
    for shape, value in zip(shapes, derivatives, strict=True):
        along = [""] * 3 if shape.direction is None else shape.direction.tolist()
        rows.writerow([*shape.place.tolist(), *along, "" if np.isnan(value) else repr(float(value))])
    write_whole(folder / "nodes.csv", text.getvalue())


def table(found: list[Dependence]) -> dict[str, dict[str, float | None]]:
    """What `depends.json` has."""
    return {one.name: {key: value for key, value in asdict(one).items() if key != "name"} for one in found}


def draw(found: list[Dependence], title: str, file: Folder) -> None:
    """Bars of the per cent by which the load changes, the longest on top."""
    from ..show.figure import Picture

    shown = [one for one in reversed(found) if one.percent_per_percent]
    figure = Picture(figsize=(8.0, 1.2 + 0.35 * len(shown)), dpi=150, layout="constrained")
    axes = figure.add_subplot()
    axes.barh([one.name for one in shown], [one.percent_per_percent for one in shown], color="#0b4f8a", height=0.6)
    axes.axvline(0.0, color="black", linewidth=0.8)
    axes.set_xlabel("change of the load by one per cent more (%)")
    axes.set_title(title, fontsize=10)
    axes.grid(axis="x", color="#dddddd", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    figure.savefig(file)
