"""What the benchmarks of shells share: meshes for a form, readings at points, published points, charts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path as Folder
from typing import Annotated

import numpy as np
from typer import Option

from .. import meshes
from ..case import Case
from ..checks import AT_LEAST_1, NOT_NEGATIVE, POSITIVE, Choice
from ..continuation.control import LoadControl, StepRule
from ..mesh.reader import NamedMesh, read
from ..model.scene import Monitor, Scene
from ..model.shell import FORMS, TRIANGLE, Shell, named_form
from ..model.supports import Support
from ..path import Until
from ..record import Record
from ..show.course import curve_of, monitored
from ..show.curves import legend_above
from ..show.evaluate import communicator, last_state_kept, unit_of
from ..show.standard import STANDARD

Cells = Annotated[int, AT_LEAST_1, Option(help="cells along each side of the modelled part")]
Form = Annotated[str, Choice(tuple(FORMS)), Option(help=f"of the shell: {', '.join(FORMS)}")]
Steps = Annotated[int, AT_LEAST_1, Option(help="load steps")]
ShearFactor = Annotated[float, POSITIVE,
                        Option(help="on the transverse shear stiffness; with 200 the shell is shear-rigid")]
FirstArc = Annotated[float, POSITIVE, Option(help="first arc length")]
LinearSteps = Annotated[int, NOT_NEGATIVE,
                        Option(help="load steps of the nonlinear path; 0: the linear response alone")]

HIGHEST_GEOMETRY = 3  # of gmsh's quadrilaterals in DOLFINx


@dataclass(frozen=True)
class Reading:
    """A displacement that a benchmark is known for: a component of a point, times a sign."""

    at: str
    component: str
    sign: float = 1.0


@dataclass(frozen=True)
class Published:
    """Points of a published path.

    Attributes
    ----------
    source : of the points
    load : the load, as the scene reports it, at a fraction of 1
    rows : fraction of the load and the readings of the benchmark, in their order
    """

    source: str
    load: float
    rows: Sequence[tuple[float, ...]]


def surface(form: str, cells: tuple[int, int], place: Callable, points: dict[str, tuple[float, float]]) -> NamedMesh:
    """Unit square in cells that fit a form, placed in space.

    Parameters
    ----------
    form : name in `shell.FORMS`
    cells : number along the two sides
    place : function (s, t) -> (x, y, z) of arrays between 0 and 1
    points : names for corners of the square
    """
    discrete = named_form(form)
    if min(cells) < 1:
        raise ValueError(f"cells are {cells[0]} and {cells[1]}; at least 1 is needed")

    def build():
        meshes.rectangle(cells, triangles=discrete.cell == TRIANGLE, points=points)

    return read(build, 3, min(discrete.displacement[1], HIGHEST_GEOMETRY),
                lambda x: np.column_stack(np.broadcast_arrays(*place(x[:, 0], x[:, 1]))))


def cylinder(form: str, cells: tuple[int, int], radius: float, length: float, angle: float,
             points: dict[str, tuple[float, float]]) -> NamedMesh:
    """Part of a cylinder about the x axis: edges west and east at x = 0 and `length`, south at its top, z = radius.

    Parameters
    ----------
    cells : number along the axis and around it
    angle : from the top towards y, where the edge north is
    """
    return surface(form, cells, lambda s, t: (length * s, radius * np.sin(angle * t), radius * np.cos(angle * t)),
                   points)


def benchmark(
    shell: Shell,
    supports: Sequence[Support],
    loads: Sequence[object],
    readings: dict[str, Reading],
    axes: tuple[str, str],
    *,
    steps: int = 1,
    symmetry_factor: int = 1,
    control: StepRule | None = None,
    until: Until | None = None,
    published: Published | None = None,
    quantities: Callable[[Record], dict[str, float]] | None = None,
) -> Case:
    """Case of a benchmark.

    Parameters
    ----------
    readings : by name; paths are drawn against the first
    steps : equal load steps; 0: only the unloaded state with its linear response
    control, until : instead of equal load steps up to a load factor of 1
    published : points that `published.png` compares with
    quantities : function (record) -> name and value; None: the readings at a load factor of 1
    """
    first = next(iter(readings.values()))
    pictures = list(STANDARD)
    if published and steps:
        pictures.append(lambda record, folder: published_points(record, folder, readings, published))
    return Case(
        scene=Scene([shell], supports, loads, Monitor(shell.mesh, first.at, first.component, first.sign),
                    symmetry_factor=symmetry_factor),
        control=control or LoadControl(step=1 / max(steps, 1), target=min(steps, 1), fixed=True),
        until=until or Until(), quantities=quantities or (lambda record: at_load(record, readings)),
        pictures=pictures, axes=axes)


def read_off(record: Record, readings: dict[str, Reading], number: int) -> dict[str, float]:
    """Values of readings in a state."""
    record.show(record.states[number])
    mesh = record.case.scene.parts[0].mesh
    kinematics = record.path.discretisation.kinematics(mesh)
    return {name: r.sign * float(kinematics.displacement(mesh, r.at)["xyz".index(r.component)])
            for name, r in readings.items()}


def slopes(record: Record, readings: dict[str, Reading], number: int) -> dict[str, float]:
    """Readings by a unit of the load factor in a state, with the tangent of that state."""
    mesh, response = record.case.scene.parts[0].mesh, record.states[number].response
    return {name: r.sign * mesh.comm.allreduce(float(response[_owned(record, mesh, r)].sum()))
            for name, r in readings.items()}


def _owned(record: Record, mesh: NamedMesh, reading: Reading) -> np.ndarray:
    """Places of a reading in this process's part of the solver's vector."""
    return record.path.discretisation.kinematics(mesh).point_dofs(mesh, reading.at, reading.component)


def at_load(record: Record, readings: dict[str, Reading], factor: float = 1.0) -> dict[str, float]:
    """Readings where the path last passes a load factor, by Hermite's cubic between two states.

    A path that does not get there gives its last state.
    """
    from scipy.interpolate import CubicHermiteSpline

    factors = np.array([s.factor for s in record.states])
    passes = np.flatnonzero((factors[:-1] - factor) * (factors[1:] - factor) <= 0)
    if not len(passes):
        return read_off(record, readings, -1)
    i = int(passes[-1])
    ends = sorted((i, i + 1), key=lambda n: factors[n])
    values, rates = ([list(f(record, readings, n).values()) for n in ends] for f in (read_off, slopes))
    return dict(zip(readings, CubicHermiteSpline(factors[ends], values, rates)(factor).tolist(), strict=True))


def published_points(record: Record, folder: Folder, readings: dict[str, Reading], published: Published,
                     name: str = "published.png") -> None:
    """Draw load against all readings beside published points (process 0 writes the file)."""
    states, numbers = record.states, range(len(record.states))
    with last_state_kept(record):
        values = np.array([list(read_off(record, readings, i).values()) for i in numbers])
    rates = np.array([list(slopes(record, readings, i).values()) for i in numbers]) * [[s.load_rate] for s in states]
    loads, load_rates = (table[:, 1:] for table in monitored(record, states))
    curve, _ = curve_of(record, states, np.hstack((values, loads)), np.hstack((rates, load_rates)))
    if communicator(record).rank > 0:
        return
    from ..show.figure import Picture

    figure = Picture(figsize=(8.0, 5.2), layout="constrained")
    axes = figure.add_subplot()
    table = np.array(published.rows)
    for i, reading in enumerate(readings):
        axes.plot(curve[:, i], curve[:, -1], color=f"C{i}", linewidth=1.2, label=reading)
        axes.plot(values[:, i], loads, ".", color=f"C{i}")
        axes.plot(table[:, i + 1], published.load * table[:, 0], "o", color=f"C{i}", markerfacecolor="none",
                  label=f"{reading}, {published.source}")
    unit = unit_of(record.case.axes[0])
    axes.set_xlabel(f"displacement ({unit})" if unit else "displacement")
    axes.set_ylabel(record.case.axes[1])
    axes.grid(color="#dddddd", linewidth=0.6)
    axes.spines[["top", "right"]].set_visible(False)
    legend_above(axes)
    figure.savefig(Folder(folder) / name, dpi=150)


def members(sizes: dict[str, Sequence[int]], **parameters) -> list[dict]:
    """Members of a chart: forms by name, each on several meshes, with further parameters of the scene."""
    return [{"form": form, "cells": n} | parameters for form, cells in sizes.items() for n in cells]
