"""Imperfections of a scene: its shapes, the loads with them, the worst and the quantiles, as files and pictures."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path as Folder
from typing import Any

import numpy as np

from ..archive.folder import write_whole
from ..case import Case
from ..continuation.control import ArcLength, LoadControl
from ..continuation.state import write_arrays
from ..critical.augmented import KINDS
from ..critical.imperfections import STEP, Imperfections, up_to_critical
from ..critical.limit_gradient import rubbing
from ..critical.reduced_energy import ReducedEnergy
from ..critical.shares import softest_modes
from ..critical.worst import ImperfectLoad, LoadQuantile, LoadsByShape
from ..mesh.field_components import field_components
from ..mesh.nodal_shapes import nodal_shapes
from ..model.scene import Scene
from ..notices import warn
from ..path import Path
from ..record import Record

FILES = ("imperfections.json", "loads.csv", "worst.csv", "worst.png", "imperfections.png", "kept/*.npz")
IN_RANGE = 0.02  # error of the reduced energy's load over the load, up to which that is in its range


@dataclass(frozen=True)
class Perfect:
    """The perfect structure's first critical load, and the softest modes there, this process's part."""

    load: float
    kind: str
    modes: list[np.ndarray]

    def save(self, file: Folder) -> None:
        file.parent.mkdir(exist_ok=True)
        write_arrays(file, load=self.load, kind=self.kind, modes=np.array(self.modes))

    @classmethod
    def load_from(cls, file: Folder) -> Perfect:
        with np.load(file) as kept:
            return cls(float(kept["load"]), str(kept["kind"]), list(kept["modes"]))


def path_of(case: Case, scene: Scene) -> Path:
    """The path of a scene as of a case, but by arc length in the place of load control, which ends at limits."""
    control = ArcLength() if isinstance(case.control, LoadControl) else case.control
    return Path(scene, control, case.until, mixed_points=case.mixed_points)


def perfect(name: str, case: Case, count: int) -> tuple[Record, Perfect]:
    """The path of the perfect structure up to its first critical point, and load and modes there.

    Raises
    ------
    ValueError
        If there is none, or parts rub against each other, so that loads have no gradients.
    """
    path = path_of(case, case.scene)
    if refused := rubbing(path.discretisation.system):
        raise ValueError(f"imperfections of {name}: {refused}")
    states, point = up_to_critical(path)
    if point is None:
        raise ValueError(f"imperfections of {name}: the path of the perfect structure has no limit point and no "
                         f"bifurcation up to load {states[-1].load:.6g}; let it go further")
    record = Record(case, path, states)
    return record, Perfect(point.load, point.kind, softest_modes(path, record.state_at(point), count))


@dataclass(frozen=True)
class Search:
    """The search, as the command's options have it."""

    amplitude: float
    shapes: int
    correlation: float | None
    nodes: bool
    quantile: Sequence[float]
    deviation: float
    samples: int
    starts: int
    seed: int
    reduced: int

    def shapes_of(self, case: Case, ideal: Perfect) -> Sequence[Any]:
        """Single nodes, components of a random field, or the softest modes of the perfect structure."""
        if self.nodes:
            return nodal_shapes(case.scene.meshes)
        if self.correlation is None:
            return ideal.modes
        return field_components(case.scene.meshes, self.correlation, self.shapes)

    def results(self, loads: LoadsByShape, near: Sequence[ImperfectLoad] = ()
                ) -> tuple[list[ImperfectLoad], list[LoadQuantile]]:
        """The worst imperfections, and the quantiles; the search starts `near` others."""
        worst = loads.worst(self.amplitude, starts=self.starts, seed=self.seed, near=near)
        return worst, self._quantiles(loads, self.samples)

    def of_energy(self, energy: ReducedEnergy) -> tuple[list[ImperfectLoad], dict[str, Any]]:
        """The worst imperfections by the reduced energy, and what the results tell of it."""
        worst = energy.worst(self.amplitude, starts=self.starts, seed=self.seed)
        error = energy.error(worst[0].coefficients)
        quantiles = self._quantiles(energy, self.reduced)
        return worst, {"worst": {"load": worst[0].load, "shape": worst[0].coefficients, "kind": worst[0].kind},
                       "error": _finite(error),
                       "in_range": bool(abs(error) <= IN_RANGE * abs(worst[0].load)),
                       "quantiles": {f"{q.probability:g}": q.load for q in quantiles}}

    def _quantiles(self, loads: LoadsByShape, samples: int) -> list[LoadQuantile]:
        return [loads.quantile(probability, self.deviation, samples=samples, seed=self.seed)
                for probability in self.quantile if samples]


def by_energy(search: Search, record: Record, ideal: Perfect, paths: Imperfections
              ) -> tuple[Sequence[ImperfectLoad], dict[str, Any]]:
    """Imperfections that the reduced energy has the search start from, and what the results tell of that; where it is
    not asked for, or ends, none."""
    if not search.reduced:
        return (), {}
    state = record.state_at(next(p for p in record.critical_points if p.kind in KINDS))
    try:
        energy = ReducedEnergy(record.path, state, ideal.modes, paths.scene, paths.count, STEP * search.amplitude)
        near, told = search.of_energy(energy)
    except ValueError as failure:
        warn(f"no reduced energy: {failure}")
        return (), {"reduced": {"in_range": False, "reason": str(failure)}}
    if not told["in_range"]:
        error = "unknown" if told["error"] is None else f"{told['error'] / told['worst']['load']:+.1%}"
        warn(f"the reduced energy is out of its range: its worst load {told['worst']['load']:.6g} is off by {error}; "
             "only the ways of its shapes are used")
    return near, {"reduced": told}


def write_loads(loads: Iterable[ImperfectLoad], folder: Folder) -> None:
    """Write `loads.csv`: coefficients, load and kind of each path."""
    text, found = io.StringIO(), list(loads)
    table = csv.writer(text, lineterminator="\n")
    table.writerow([*(f"c{n + 1}" for n in range(len(found[0].coefficients))), "load", "kind"])
    table.writerows([*map(repr, one.coefficients), repr(one.load), one.kind] for one in found)
    write_whole(folder / "loads.csv", text.getvalue())


def read_loads(folder: Folder) -> list[ImperfectLoad]:
    """What `write_loads` wrote; none where there is no file."""
    if not (folder / "loads.csv").exists():
        return []
    with (folder / "loads.csv").open(newline="") as stream:
        rows = list(csv.reader(stream))[1:]
    return [ImperfectLoad(tuple(map(float, row[:-2])), float(row[-2]), row[-1]) for row in rows]


def write_results(folder: Folder, search: Search, told: dict[str, Any], worst: Sequence[ImperfectLoad],
                  quantiles: Sequence[LoadQuantile]) -> None:
    """Write `imperfections.json`; loads that no path has come to are null."""
    minima = [{"load": one.load, "shape": one.coefficients, "kind": one.kind} for one in worst]
    detail = {f"{q.probability:g}": {"interval": q.interval, "samples": len(q.samples)} for q in quantiles}
    found = {"amplitude": search.amplitude, "deviation": search.deviation, "correlation": search.correlation, **told,
             "worst": minima[0], "other_minima": minima[1:],
             "quantiles": {f"{q.probability:g}": q.load for q in quantiles}, "reliability": detail}
    write_whole(folder / "imperfections.json", json.dumps(found, indent=2) + "\n")


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None


def draw(folder: Folder, axis: str, title: str, perfect_load: float, loads: Sequence[ImperfectLoad],
         worst: ImperfectLoad, quantiles: Sequence[LoadQuantile]) -> None:
    """Loads against the size of the imperfection, with the worst ones and the quantiles."""
    from ..show.figure import Picture

    figure = Picture(figsize=(7.0, 4.5), dpi=150, layout="constrained")
    axes = figure.add_subplot()
    axes.plot([np.linalg.norm(one.coefficients) for one in loads], [one.load for one in loads], ".", color="#8aa6bf",
              markersize=4, label=f"{len(loads)} imperfect structures")
    axes.plot([0.0, np.linalg.norm(worst.coefficients)], [perfect_load, worst.load], "D-", color="#b3261e",
              markersize=5, linewidth=1.0, label="worst shape")
    axes.plot([0.0], [perfect_load], "o", color="black", markersize=5, label="perfect")
    for q in quantiles:
        line = axes.axhline(q.load, linewidth=1.0, linestyle="--", label=f"{100 * q.probability:g} % are below")
        axes.axhspan(*q.interval, color=line.get_color(), alpha=0.12, linewidth=0)
    axes.set_xlabel("size of the imperfection")
    axes.set_ylabel(axis)
    axes.set_title(f"{title}: first critical load of imperfect structures", fontsize=10)
    axes.grid(color="#dddddd", linewidth=0.6)
    axes.legend(frameon=False, fontsize=9)
    axes.spines[["top", "right"]].set_visible(False)
    figure.savefig(folder / "imperfections.png")
