"""One branch of a bifurcation diagram as a task: traced in a process of its own, from files to files.

The folder of a branch holds `task.json`, which says what to do, then `states`, `starts` of the half-branches of its
bifurcations, `points` (sorted lengths of nodal displacements there) and `result.json`.
`python3 -m sheetfx.studies.diagram_branch FOLDER` does the task, again if need be.

Half-branches of one bifurcation count as equivalent by symmetry if their starts have one load, one number of unstable
modes and the same sorted lengths of nodal displacements: a symmetry moves nodes to nodes and turns displacements. The
monitored deflection is left out, since the monitored point need not share the symmetry. On the star dome the lists of
equivalent starts differ by 1e-10 to 1e-4 of the distance from the bifurcation, whose state has converged to no more;
those of others by 0.5 and more, as their modes do, or their loads differ as much. EQUIVALENT lies between.

What is confused: half-branches of structures whose symmetry is broken by less than that, and those whose displacements
differ in their directions alone at equal loads, as where parts that do not feel each other buckle. What is listed
twice: equivalent ones on a mesh that has not the symmetry.
"""

from __future__ import annotations

import json
import shutil
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path as Folder
from typing import Any

import numpy as np
from mpi4py import MPI
from scipy.interpolate import PchipInterpolator

from ..archive.folder import Archive
from ..case import Case
from ..continuation.control import ArcLength
from ..continuation.state import CriticalPoint, State
from ..critical.branches import Branch
from ..events.search import state_at
from ..path import Path, PathFailure, Until
from ..record import Record
from ..scenes import load_case

DISPLACEMENT = "displacement"  # name of fields of it
EQUIVALENT = 1e-2  # of the distance from the bifurcation in displacements and in load, difference of equivalent starts
FINER = 0.25  # steps over those of the case: longer ones cut corners where branches cross close together
SAME_LOAD, SAME_PLACE = 1e-3, 3e-3  # of the load, and of the largest norm so far, where a branch arrives at a point
BACK = 0.1  # of the distance of the start from its origin, where a branch is back there
TOGETHER = 1e-4  # of a step: limit and bifurcation where a branch passes the vertex of another one


@dataclass(frozen=True)
class Bounds:
    """Where every path of a diagram ends, and beyond which bifurcations are not followed.

    Attributes
    ----------
    load, deflection : absolute values; None: any
    steps : of each path
    """

    load: float | None = None
    deflection: float | None = None
    steps: int = 200

    def until(self, taken: int, event=None) -> Until:
        """The end of a path that starts after so many steps."""
        return Until(event, self.deflection, self.load, taken + self.steps)

    def hold(self, point: CriticalPoint) -> bool:
        pairs = (self.load, point.load), (self.deflection, point.deflection)
        return all(bound is None or abs(value) <= bound for bound, value in pairs)


def magnitudes(state: State, case: Case) -> np.ndarray:
    """Sorted lengths of the displacements of all nodes."""
    return np.sort(np.concatenate([np.linalg.norm(table, axis=1) for table in _tables(state.fields, case)]))


def _difference(one: np.ndarray, other: np.ndarray) -> float:
    """Root mean square of the differences of magnitudes."""
    return float(np.sqrt(((one - other) ** 2).mean()))


def norm(fields: Mapping[str, np.ndarray], case: Case) -> float:
    """Root mean square of the displacements of all nodes, which hides no branch."""
    squares = np.concatenate([(table**2).sum(axis=1) for table in _tables(fields, case)])
    return float(np.sqrt(squares.mean()))


def _tables(fields: Mapping[str, np.ndarray], case: Case) -> list[np.ndarray]:
    """Nodal displacements, one node in each row."""
    dimension = case.scene.meshes[0].dimension
    return [values.reshape(-1, dimension) for name, values in fields.items() if name.startswith(f"{DISPLACEMENT} ")]


class Task:
    """A branch to trace.

    Parameters
    ----------
    home : folder of the branch, with `task.json`: scene, parameters, bounds, start (file, relative to the folder; None:
        the primary path), origin (label of the point that it comes from), known (points where the branch ends if it
        arrives), split (whether half-branches of its bifurcations are wanted)
    """

    def __init__(self, home: Folder):
        self.home, self.task = home, json.loads((home / "task.json").read_text())
        self.bounds = Bounds(**self.task["bounds"])
        self.case: Case = load_case(self.task["scene"])(**self.task["parameters"])
        self.start = [State.load_from(home / self.task["start"])] if self.task["start"] else []
        self.path = self._path()
        self.record = Record(self.case, self.path, list(self.start))
        self.largest = 0.0

    def _path(self) -> Path:
        case, taken = self.case, self.start[0].step if self.start else 0
        rule = case.control
        if self.start and not isinstance(rule, ArcLength):
            rule = ArcLength()
        if isinstance(rule, ArcLength):
            finer = {"largest": max(rule.largest * FINER, 1.0)} if rule.step is None else {"step": rule.step * FINER}
            rule = replace(rule, **finer)
        return Path(case.scene, rule, self.bounds.until(taken, case.until.event), start=self.start,
                    mixed_points=case.mixed_points, events=case.events)

    def run(self) -> dict[str, Any]:
        """Trace the branch, and return what `result.json` is to hold."""
        for name in ("states", "starts", "points"):
            shutil.rmtree(self.home / name, ignore_errors=True)
            (self.home / name).mkdir()
        status, arrival = "finished", None
        try:
            for state in self.path:
                if arrival := self._arrival(state):
                    break
                self.record.states.append(state)
            message = f"arrives at point {arrival['point']}" if arrival else self.path.message
        except PathFailure as failure:
            status, message = "failed", str(failure)
        states = self.record.states
        for state in states:
            state.save(self.home / "states" / f"{state.step:06d}.npz")
        points = [p for state in states for p in state.critical]
        points += arrival.pop("before") if arrival else []
        return {
            "status": status, "message": message, "arrival": arrival, "searched": self.path.searched,
            "states": self._rows([state for state in states if state.stage == states[-1].stage]),
            "points": [self._point(number, p) for number, p in enumerate(points, 1)],
        }

    def _rows(self, states: Sequence[State]) -> list[dict[str, Any]]:
        """What is drawn of states; rates are by the length of the path.

        Loads are multiples of the load factor, or reactions, whose rates are interpolated.
        """
        rows, factors, loads = list(map(self._row, states)), *np.array([(s.factor, s.load) for s in states]).T
        scale = loads @ factors / (factors @ factors or 1.0)
        if np.allclose(loads, scale * factors, rtol=1e-9, atol=0.0) or len(states) < 3:
            rates = [scale * state.load_rate for state in states]
        else:
            places = np.cumsum([0.0, *(row["chord"] for row in rows[1:])])
            rates = PchipInterpolator(places, loads).derivative()(places)
        return [row | {"rates": row["rates"] | {"load": float(rate)}} for row, rate in zip(rows, rates, strict=True)]

    def _row(self, state: State) -> dict[str, Any]:
        """A state in numbers; `chord` is the length of its last step."""
        tracer, size = self.path.tracer, norm(state.fields, self.case)
        rate = tracer.system.create_vector(state.tangent[1])
        fields = self.path.discretisation.unknowns.fields
        moves = np.concatenate([change.ravel() for f, change in zip(fields, tracer.system.changes(rate), strict=True)
                                if f.name == DISPLACEMENT])
        places = np.concatenate([table.ravel() for table in _tables(state.fields, self.case)])
        nodes = len(places) / self.case.scene.meshes[0].dimension
        return {"step": state.step, "load": state.load, "deflection": state.deflection, "norm": size,
                "unstable": state.unstable_modes, "length": state.length, "chord": tracer.distance(*state.direction),
                "rates": {"deflection": tracer.monitored_rate(rate),
                          "norm": float(places @ moves) / (nodes * size) if size else 0.0}}

    def _arrival(self, state: State) -> dict[str, Any] | None:
        """Which known point a state has brought to light, if any, and the points before it in its step.

        The branch passes through the vertex of another one: its load may be stationary there, or a limit and a
        bifurcation are found together.
        """
        self.largest = max(self.largest, norm(state.fields, self.case))
        for point in state.critical:
            near = [known for known in self.task["known"] if point.kind != "event"
                    and abs(known["load"] - point.load) <= SAME_LOAD * abs(known["load"])]
            if not near:
                continue
            try:
                there = self._state_at(point, [*self.record.states, state])
            except ArithmeticError:
                continue
            known = min(near, key=lambda known: self._off(there, known))
            if self._off(there, known) <= 1:
                before = [p for p in state.critical if p.length < point.length - TOGETHER * state.length]
                return {"point": known["label"], "load": point.load, "deflection": point.deflection,
                        "norm": norm(there.fields, self.case), "before": before}
        return None

    def _off(self, state: State, known: Mapping[str, Any]) -> float:
        """Distance of a state from a known point but for symmetry, over what it may be where they are one."""
        place = np.load(self.home / known["file"])
        allowed = SAME_PLACE * self.largest
        if known["label"] == self.task["origin"]:
            allowed = min(allowed, BACK * _difference(magnitudes(self.start[0], self.case), place))
        return _difference(magnitudes(state, self.case), place) / allowed

    def _state_at(self, point: CriticalPoint, states: Sequence[State]) -> State:
        by_step = {state.step: state for state in states}
        present = self.path.tracer.state
        try:
            state = state_at(self.path, by_step[point.step - 1], by_step[point.step], point)
        finally:
            self.path.tracer.back_to(present)
        if abs(state.load - point.load) > SAME_LOAD * max(abs(point.load), abs(by_step[point.step].load)):
            raise ArithmeticError(f"the {point.kind} at load {point.load:.6g} in step {point.step} is not found again: "
                                  f"the load there is {state.load:.6g}")
        return state

    def _point(self, number: int, point: CriticalPoint) -> dict[str, Any]:
        """A critical point in words and numbers, with the half-branches of a bifurcation."""
        found = {"number": number, "title": point.title} | asdict(point) | {
            "norm": None, "halves": [], "failure": None, "within": self.bounds.hold(point),
            "last_stage": self._stage(point) == len(self.case.scene.all_stages) - 1}
        try:
            state = self._state_at(point, self.record.states)
        except (ArithmeticError, KeyError) as error:
            return found | {"failure": str(error)}
        found |= {"norm": norm(state.fields, self.case)}
        if point.kind != "bifurcation":
            return found
        np.save(self.home / "points" / f"{number}.npy", magnitudes(state, self.case))
        if self.task["split"] and found["within"] and found["last_stage"]:
            try:
                halves = self.record.branches(point)
            except (ArithmeticError, ValueError) as error:
                return found | {"failure": str(error)}
            return found | {"halves": self._listed(number, halves, state)}
        return found

    def _stage(self, point: CriticalPoint) -> int:
        return next(state.stage for state in self.record.states if state.step == point.step)

    def _listed(self, number: int, halves: Sequence[Branch], bifurcation: State) -> list[dict[str, Any]]:
        """One of each class of equivalent half-branches, that with the highest load first; its start goes to a file."""
        classes: list[list[Branch]] = []
        for half in halves:
            for members in classes:
                if self._equivalent(half.start, members[0].start, bifurcation):
                    members.append(half)
                    break
            else:
                classes.append([half])
        classes.sort(key=lambda members: members[0].start.load, reverse=True)
        return [self._written(f"{number}{_letters(n)}", members) for n, members in enumerate(classes)]

    def _equivalent(self, one: State, other: State, bifurcation: State) -> bool:
        distance = norm({name: values - bifurcation.fields[name] for name, values in one.fields.items()}, self.case)
        rise = max(abs(one.load - bifurcation.load), abs(other.load - bifurcation.load))
        return (one.unstable_modes == other.unstable_modes
                and abs(one.load - other.load) <= EQUIVALENT * rise + 1e-8 * abs(bifurcation.load)
                and _difference(*(magnitudes(s, self.case) for s in (one, other))) <= EQUIVALENT * distance)

    def _written(self, name: str, members: Sequence[Branch]) -> dict[str, Any]:
        first = members[0]
        length = self.path.tracer.distance(*first.start.direction)
        replace(first.start, next_length=length).save(self.home / "starts" / f"{name}.npz")
        return {"name": name, "equivalent": len(members), "family": first.family, "doubt": first.doubt,
                "amplitude": first.amplitude, "load": first.start.load, "deflection": first.start.deflection}


def _letters(number: int) -> str:
    """a to z, then aa, ab and so on."""
    return (_letters(number // 26 - 1) if number >= 26 else "") + chr(ord("a") + number % 26)


def follow(home: Folder) -> None:
    """Do the task in a folder."""
    Archive(home, MPI.COMM_SELF).write_json("result.json", Task(home).run())


if __name__ == "__main__":
    follow(Folder(sys.argv[1]))
