"""Reactions, energies and section forces of all states as tables."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from pathlib import Path as Folder

import numpy as np

from ..continuation.state import State
from ..mesh.reader import COMPONENTS
from ..model.beam import Bar
from ..model.shell import Shell
from .evaluate import communicator, last_state_kept
from .shown import Shown

NAMES = {1: ["N"], 3: ["N", "V", "M"], 6: ["N", "V1", "V2", "T", "M1", "M2"],
         9: ["n11", "n22", "n12", "m11", "m22", "m12", "q1", "q2", "drilling"]}
ALONG = ("step", "stage", "factor", "load")


def tables(record: Shown, folder: Folder) -> None:
    """Write reactions.csv, energies.csv and forces.csv, for further parts forces1.csv and so on (process 0).

    Reactions are forces and moments on the modelled structure, for each support and prescribed motion; moments are
    about the middle of its nodes where they are now. Forces of parts are at the points of `Record.forces`, with their
    group and their places in the reference configuration.
    """
    with last_state_kept(record):
        _write(record, Folder(folder) / "reactions.csv", *_reactions(record))
        _write(record, Folder(folder) / "energies.csv", *_energies(record))
        for number, part in enumerate(record.case.scene.parts):
            _write(record, Folder(folder) / f"forces{number or ''}.csv", *_forces(record, part))


def names_of(part, count: int) -> list[str]:
    """Names of resultants: of beams N, V and M (in space two of each and the torque T), of shells n, m and q."""
    names = NAMES.get(count)
    fits = names is not None and (count == 9) == isinstance(part, Shell) and (count == 1) == isinstance(part, Bar)
    return names if names is not None and fits else [f"r{i + 1}" for i in range(count)]


def _along(state: State) -> list:
    return [getattr(state, name) for name in ALONG]


def _reactions(record: Shown) -> tuple[list[str], list]:
    dimension, rows = record.case.scene.meshes[0].dimension, []
    turns = COMPONENTS[dimension][dimension:]
    for state in record.states:
        record.show(state)
        for thing, reaction in record.shown_reactions():
            rows.append([*_along(state), type(thing).__name__, thing.at, *reaction.force, *reaction.moment()])
    return [*ALONG, "by", "at", *(f"f{c}" for c in "xyz"[:dimension]), *(f"m{c[1:]}" for c in turns)], rows


def _energies(record: Shown) -> tuple[list[str], list]:
    balance = record.balance()
    names = [f"{type(part).__name__} {part.group or i}" for i, part in enumerate(record.case.scene.parts)]
    columns = balance.joints, balance.dissipated, balance.work, balance.accuracy
    rows = [[*_along(state), *parts, *values] for state, parts, *values in zip(
        record.states, balance.parts, *columns, strict=True)]
    return [*ALONG, *names, "joints and contacts", "dissipated", "work of loads", "accuracy of work"], rows


def _forces(record: Shown, part) -> tuple[list[str], list]:
    comm, domain, rows = communicator(record), part.mesh.domain, []
    cells = domain.topology.index_map(domain.topology.dim).local_to_global(part.mesh.group(part.group)).tolist()
    for state in record.states:
        record.show(state)
        values, places = record.forces(part), record.section_points(part).reference
        group = part.group or ""
        own = [[group, cell, point, *place, *value] for cell, at, of in zip(cells, places, values, strict=True)
               for point, (place, value) in enumerate(zip(at, of, strict=True))]
        rows += [[*_along(state), *row] for gathered in comm.gather(own) or () for row in gathered]
    return [*ALONG, "group", "cell", "point", *"xyz"[:part.mesh.dimension], *names_of(part, values.shape[2])], rows


def _write(record: Shown, file: Folder, names: Sequence[str], rows: Iterable[Sequence]) -> None:
    if communicator(record).rank == 0:
        with file.open("w", newline="") as stream:
            writer = csv.writer(stream)
            writer.writerow(names)
            writer.writerows([[float(v) if isinstance(v, np.floating) else v for v in row] for row in rows])
