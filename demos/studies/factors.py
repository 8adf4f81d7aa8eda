"""What gap, friction, stiffness and number of pairs do to the dome with contact: `python3 demos/studies/factors.py`.

The four factor studies of the thesis (section 5.3.3) and its pressures augmented, on the dome with welds of 200 mm and
both faces, two runs at a time. Prints the loads at given deflections and draws a panel for each study. Takes four
minutes on two cores.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from multiprocessing import get_context
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import sheetfx as fx
from sheetfx.scenes import dome
from sheetfx.show.curves import smooth

DEFLECTIONS = (5.0, 10.0, 12.0)  # of the apex, mm, at which loads are told; paths end at the last one
COMMON = {"model": "contact", "divisions": 4, "grading": 2.5, "friction": 0.2, "to": DEFLECTIONS[-1]}


@dataclass(frozen=True)
class Study:
    """A factor that varies.

    Attributes
    ----------
    title : of its panel, with the unit of the factor
    option : of the scene that varies
    values : of the option
    fixed : other options
    """

    title: str
    option: str
    values: tuple[float, ...]
    fixed: dict[str, object]


@dataclass(frozen=True)
class Outcome:
    """What came of a run: its path (mm, kN), what is listed of it, and why it stopped; "" where it has not."""

    path: np.ndarray
    loads: list[float]
    factorisations: int
    seconds: float
    penetration: float
    stopped: str


STIFFNESSES = (2e3, 2e4, 2e5, 2e6, 2e7)
STUDIES = (
    Study("initial gap (mm)", "gap", (0.01, 0.1, 0.5, 1.0), {}),
    Study("friction", "friction", (0.0, 0.05, 0.2, 0.5), {}),
    Study("stiffness of a pair (N/mm), 8 pairs", "stiffness", STIFFNESSES, {"pairs": 8}),
    Study("the same, pressures augmented", "stiffness", STIFFNESSES, {"pairs": 8, "enforcement": "uzawa"}),
    Study("pairs along an edge, 2e5 N/mm each", "pairs", (2, 4, 8, 16), {"stiffness": 2e5}),
)


def run(study: Study, value: float) -> Outcome:
    """Follow one path; the given deflections are events on it."""
    case = dome.case(**COMMON | study.fixed | {study.option: value})
    events = [fx.Event(f"{d:g} mm", lambda state, d=d: state.deflection - d) for d in DEFLECTIONS[:-1]]
    stopped = ""
    try:
        record = fx.trace(replace(case, events=events))
    except fx.PathFailure as failure:
        record, stopped = failure.record, str(failure)
    first = {p.deflection: p.load for p in reversed(record.critical_points) if p.kind == "event"}
    last = record.states[-1]
    at = {round(deflection, 6): load for deflection, load in (first | {last.deflection: last.load}).items()}
    return Outcome(np.array([(s.deflection, s.load / 1e3) for s in record.states]),
                   [at.get(d, np.nan) / 1e3 for d in DEFLECTIONS], record.path.tracer.total_factorisations,
                   record.path.clock.total, max(s.penetration for s in record.states), stopped)


def told(study: Study, value: float, outcome: Outcome) -> str:
    """A run in one line."""
    loads = ", ".join(f"{load:.1f}" for load in outcome.loads)
    return (f"{study.title}: {value:g}: {loads} kN, {outcome.factorisations} factorisations, {outcome.seconds:.0f} s, "
            f"penetration {outcome.penetration:.2g} mm {outcome.stopped}").strip()


def outcomes(processes: int) -> Iterator[tuple[Study, float, Outcome]]:
    """All runs in the order of the studies."""
    with ProcessPoolExecutor(processes, get_context("spawn")) as pool:
        runs = [(study, value, pool.submit(run, study, value)) for study in STUDIES for value in study.values]
        for study, value, future in runs:
            yield study, value, future.result()


def draw(found: list[tuple[Study, float, Outcome]]) -> Figure:
    """A panel for each study, a curve for each value, lighter where it is smaller."""
    figure = Figure(figsize=(11.0, 6.6), layout="constrained")
    panels = figure.subplots(2, 3, sharex=True, sharey=True)
    panels[0, 0].set_xlim(0.0, DEFLECTIONS[-1])
    for axes, study in zip(panels.flat, STUDIES, strict=False):
        axes.set_title(study.title, loc="left", fontsize=10)
        axes.grid(color="#dddddd", linewidth=0.6)
        axes.spines[["top", "right"]].set_visible(False)
        for number, (_, value, outcome) in enumerate(entry for entry in found if entry[0] == study):
            grey = 0.8 * (1 - number / (len(study.values) - 1))
            axes.plot(*smooth(outcome.path)[0].T, color=str(grey), label=f"{value:g}")
        axes.legend(frameon=False, fontsize=8)
    panels[-1, -1].set_axis_off()
    figure.supxlabel("deflection of the apex (mm)", fontsize=10)
    figure.supylabel("load (kN)", fontsize=10)
    return figure


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--jobs", type=int, default=2, help="runs at a time")
    parser.add_argument("-o", "--output", type=Path, default=Path("dome_factors.png"))
    given = parser.parse_args()
    finished = []
    for entry in outcomes(given.jobs):
        print(told(*entry), flush=True)
        finished.append(entry)
    draw(finished).savefig(given.output, dpi=130)
