"""Contact between parts along a path: arrays of all pairs, how many touch, stick and slip, and where."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path as Folder

import numpy as np

from ..discrete.contact import OPEN, SLIP, STICK
from ..discrete.pair_work import PairState, pairs_of
from .evaluate import communicator, last_state_kept, most_telling, unit_of, with_unit
from .saving import save_picture
from .shown import Shown

COLOURS = {OPEN: "#c9c9c9", STICK: "#0b4f8a", SLIP: "#c4432b"}
MOST = 3  # states drawn in plan


def pair_states(record: Shown) -> list[list[PairState]]:
    """For each state of a path the state of the pairs of each contact, the same on all processes."""
    works = pairs_of(record.path.discretisation.system.contributions)
    found = []
    with last_state_kept(record):
        for state in record.states:
            record.show(state)
            found.append([work.evaluate() for work in works])
    return found


def pair_history(record: Shown, folder: Folder) -> None:
    """Write pairs.npz, pairs.csv, pairs.png and paraview/pairs.pvd; nothing where no deformable parts touch.

    The table has a line for each pair: where it is at first, the statuses that it has had ("open slip open slip"), the
    load of the first state with each of them, its largest slip (with friction alone, else it is not known) and its
    largest pressure. The arrays of contact number i are called "i gap", "i pressure", "i slip", "i traction",
    "i status", "i position", of shape (states, pairs, ...), and "load" and "deflection", of shape (states,).
    """
    if not pairs_of(record.path.discretisation.system.contributions):
        return
    history, folder = pair_states(record), Folder(folder)
    if communicator(record).rank > 0:  # each process has all pairs
        return
    arrays = {"load": np.array([s.load for s in record.states]),
              "deflection": np.array([s.deflection for s in record.states])}
    for number, along in enumerate(zip(*history, strict=True)):
        for name in ("gap", "pressure", "slip", "traction", "status", "position"):
            arrays[f"{number} {name}"] = np.array([getattr(s, name) for s in along])
    np.savez_compressed(folder / "pairs.npz", **arrays)
    with (folder / "pairs.csv").open("w", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(("contact", "pair", *"xyz"[:history[0][0].position.shape[1]], "statuses", "loads",
                         "largest_slip", "largest_pressure"))
        writer.writerows(_histories(history, arrays["load"]))
    figure = draw_pairs(record, history)
    save_picture(record, lambda: figure, folder / "pairs.png")
    write_pairs(history, folder / "paraview")


def _histories(history: Sequence[Sequence[PairState]], loads: np.ndarray) -> Iterator[tuple]:
    """Rows of pairs.csv."""
    for number, along in enumerate(zip(*history, strict=True)):
        status = np.array([s.status for s in along])
        slip = np.max([np.linalg.norm(s.slip.reshape(len(s.gap), -1), axis=1) for s in along], axis=0)
        pressure, known = np.max([s.pressure for s in along], axis=0), slip.any()
        for pair, place in enumerate(along[0].position):
            begins = [0, *(1 + np.flatnonzero(status[1:, pair] != status[:-1, pair]))]
            yield (number, pair, *(f"{x:.6g}" for x in place), " ".join(status[begins, pair]),
                   " ".join(f"{load:.6g}" for load in loads[begins]), f"{slip[pair]:.6g}" if known else "",
                   f"{pressure[pair]:.6g}")


def draw_pairs(record: Shown, history: Sequence[Sequence[PairState]]):
    """A matplotlib figure: numbers of pairs by status, largest opening and slip, and places at critical points."""
    from .figure import Picture

    steps = [next(i for i, s in enumerate(record.states) if s.step == p.step)
             for p in most_telling(record.critical_points, MOST)] or [len(record.states) - 1]
    figure = Picture(figsize=(11.0, 7.5), dpi=150, layout="constrained")
    above, below = figure.subfigures(2, 1)
    length, deflection = unit_of(record.case.axes[0]), [s.deflection for s in record.states]
    pairs = sum(len(s.gap) for s in history[0])
    panels = {f"pairs that touch, of {pairs}": _along(history, sum, {
        "stick": lambda s: (s.status == STICK).sum(), "slip": lambda s: (s.status == SLIP).sum()}),
        f"length ({length})" if length else "length": _along(history, max, {
            "largest opening": lambda s: s.gap.max(initial=0.0),
            "largest slip": lambda s: np.linalg.norm(s.slip, axis=1).max(initial=0.0)})}  # known with friction alone
    panels = {name: lines for name, lines in panels.items() if lines}
    places = above.subplots(1, len(panels), squeeze=False)[0] if panels else ()
    for axes, (name, lines) in zip(places, panels.items(), strict=True):
        for label, values in lines.items():
            axes.plot(deflection, values, ".-", color=COLOURS.get(label), label=label)
        axes.set(xlabel=record.case.axes[0], ylabel=name)
        axes.legend(frameon=False)
    for place, step in zip(below.subplots(1, len(steps), squeeze=False)[0], steps, strict=True):
        _plan(place, history[step])
        place.set_title(f"at {with_unit(record.states[step].deflection, length)}", fontsize=10)
    return figure


def _along(history: Sequence[Sequence[PairState]], join: Callable, of_contact: dict[str, Callable]) -> dict[str, list]:
    """Numbers of all contacts joined to one for each state, by name, but those that are zero all along."""
    found = {name: [float(join(value(s) for s in states)) for states in history] for name, value in of_contact.items()}
    return {name: values for name, values in found.items() if any(values)}


def _plan(axes, states: Sequence[PairState]) -> None:
    """Pairs by status as seen along the last axis of space."""
    for status in (OPEN, SLIP, STICK):
        places = np.concatenate([s.position[s.status == status, :2] for s in states])
        if len(places):
            axes.plot(*places.T, ".", color=COLOURS[status], markersize=2 if status == OPEN else 5, label=status)
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.legend(frameon=False, fontsize=8, loc="upper right")


def write_pairs(history: Sequence[Sequence[PairState]], folder: Folder) -> None:
    """Write pairs.pvd for ParaView: the pairs as points with gap, pressure, slip, traction and status (0, 1, 2)."""
    import pyvista

    folder.mkdir(parents=True, exist_ok=True)
    lines = []
    for step, states in enumerate(history):
        places = np.concatenate([s.position for s in states])
        cloud = pyvista.PolyData(np.pad(places, [(0, 0), (0, 3 - places.shape[1])]))
        for name in ("gap", "pressure", "slip", "traction"):
            cloud[name] = np.concatenate([getattr(s, name) for s in states])
        cloud["status"] = np.concatenate([np.select([s.status == STICK, s.status == SLIP], [1, 2]) for s in states])
        cloud.save(folder / f"pairs{step:06d}.vtp")
        lines.append(f'<DataSet timestep="{step}" file="pairs{step:06d}.vtp"/>')
    (folder / "pairs.pvd").write_text('<VTKFile type="Collection" version="0.1"><Collection>' + "".join(lines)
                                      + "</Collection></VTKFile>\n", encoding="utf-8")
