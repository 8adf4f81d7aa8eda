"""The bifurcation diagram of a scene: branches of branches, each traced in a process of its own.

One generation after another is traced: the primary path, the branches of its bifurcations, theirs, and so on. Of
half-branches that are equivalent by symmetry one is traced (`diagram_branch` says which are). A branch ends where it
arrives at a point that an earlier generation knows. A branch from one known point to another is found from both ends:
the second is listed as the first one's reverse if it arrives where the other began, and the loads of their critical
points and their curves agree.
"""

from __future__ import annotations

import csv
import json
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, as_completed
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path as Folder
from typing import Any

import numpy as np
from mpi4py import MPI
from scipy.interpolate import CubicHermiteSpline, PPoly

from ..archive.folder import Archive
from ..case import Case
from ..interrupts import call
from .diagram_branch import Bounds
from .pool import alone, pool

PRIMARY = "0"
SAME = 1e-4  # relative difference of loads and nodal displacements of one point found on two branches
SAME_CURVE = 0.02  # of the ranges of load and norm, distance of a branch's states from the curve of its reverse
FINE = 1000  # points on such a curve
COLUMNS = ("branch", "parent", "step", "load", "deflection", "norm", "unstable")


@dataclass
class Traced:
    """A branch of the diagram.

    Attributes
    ----------
    name : "0" is the primary path, "2a" the first kind of half-branch of its second bifurcation, "2a.1b" a branch of
        that
    half : what its parent says of its start; None: the primary path
    origin : point that it begins at
    result : what its process wrote, see `diagram_branch.Task`
    reverse_of : name of the branch that goes the other way
    """

    name: str
    parent: Traced | None = None
    half: dict[str, Any] | None = None
    origin: dict[str, Any] | None = None
    result: dict[str, Any] = field(default_factory=dict)
    reverse_of: str | None = None
    children: list[Traced] = field(default_factory=list)

    @property
    def points(self) -> list[dict[str, Any]]:
        return self.result.get("points", [])

    @property
    def bifurcations(self) -> list[dict[str, Any]]:
        return [p for p in self.points if p["kind"] == "bifurcation" and p["norm"] is not None]

    def table(self, quantities: Sequence[str]) -> np.ndarray:
        """Some of its numbers, one state in each row."""
        return np.array([[state[name] for name in quantities] for state in self.result["states"]])

    def cubic(self, quantities: Sequence[str]) -> PPoly:
        """Curve of some of its numbers by the length of the path, with the tangents of the states; its knots are these.
        """
        states = self.result["states"]
        places = np.cumsum([0.0, *(state["chord"] for state in states[1:])])
        rates = np.array([[state["rates"][name] for name in quantities] for state in states])
        return CubicHermiteSpline(places, self.table(quantities), rates)


@dataclass(frozen=True)
class Plan:
    """What to draw the diagram of, and how far.

    Attributes
    ----------
    scene : name or script
    parameters : of its function
    bounds : of all paths
    levels : generations of branches beside the primary path
    processes : that trace branches at a time
    """

    scene: str
    parameters: dict[str, Any]
    bounds: Bounds
    levels: int = 1
    processes: int = 1


def bounds_of(case: Case, load: float | None, deflection: float | None, steps: int) -> Bounds:
    """Bounds of a diagram; those that are not given are the case's."""
    return Bounds(case.until.load if load is None else load,
                  case.until.deflection if deflection is None else deflection, steps)


def trace_diagram(plan: Plan, folder: Folder, resume: bool = False,
                  say: Callable[[Traced, int], None] = lambda branch, left: None) -> Traced | None:
    """Trace all branches, write `diagram.json` and `diagram.csv`, and return the primary path with its tree.

    Parameters
    ----------
    folder : gets a folder for each branch; to resume, finished ones are not traced again
    say : called with each branch that has ended and the number of branches of its generation still to come

    Returns
    -------
    primary path on process 0, None on others

    Raises
    ------
    ValueError
        Where the folder holds files of others or another run, or no run of these parameters to resume.
    """
    with pool(plan.processes) as executor:
        return _diagram(executor, plan, folder, resume, say) if executor else None


def _diagram(executor: Executor, plan: Plan, folder: Folder, resume: bool,
             say: Callable[[Traced, int], None]) -> Traced:
    """As `trace_diagram`, on process 0."""
    archive = Archive(folder, MPI.COMM_SELF, ("branches/*", "diagram.json", "diagram.csv", "diagram.png"),
                      lambda: f"{sum(1 for _ in Folder(folder).glob('branches/*/result.json'))} paths")
    primary = Traced(PRIMARY)
    told = {"command": "diagram", "scene": plan.scene, "bounds": asdict(plan.bounds)} | plan.parameters
    with archive.opened(told, resume):
        generation, listed = [primary], []
        for level in range(plan.levels + 1):
            known = [{"label": label(branch, point), "load": point["load"], "file": f"../{_magnitudes(branch, point)}"}
                     for branch in listed for point in branch.bifurcations if "same_as" not in point]
            _trace_all(executor, plan, folder, generation, known, level < plan.levels, say)
            for branch in generation:
                branch.reverse_of = next((other.name for other in listed if reversed_of(branch, other)), None)
                if not branch.reverse_of:
                    _mark_same_points(branch, listed, Folder(folder) / "branches")
                    listed.append(branch)
            generation = [child for branch in generation if not branch.reverse_of for child in _children(branch)]
            plan = replace(plan, bounds=_bounded(plan.bounds, primary))
        archive.write_json("diagram.json", {"scene": plan.scene, "parameters": plan.parameters,
                                            "bounds": asdict(plan.bounds), "levels": plan.levels,
                                            "path": _tree(primary, plan)})
        _write_table(primary, Folder(folder) / "diagram.csv")
    return primary


def _bounded(bounds: Bounds, primary: Traced) -> Bounds:
    """Bounds of branches: where neither load nor deflection is bounded, the largest load of the primary path."""
    if bounds.load is None and bounds.deflection is None and primary.result["states"]:
        return replace(bounds, load=max(abs(state["load"]) for state in primary.result["states"]) or None)
    return bounds


def label(branch: Traced, point: dict[str, Any]) -> str:
    """Name of a point: the branch that it lies on, and its number there."""
    return f"{branch.name}:{point['number']}"


def everything(branch: Traced) -> Iterator[Traced]:
    """A branch and all that come of it."""
    yield branch
    for child in branch.children:
        yield from everything(child)


def _trace_all(executor: Executor, plan: Plan, folder: Folder, branches: Sequence[Traced], known: Sequence[dict],
               split: bool, say: Callable[[Traced, int], None]) -> None:
    """Results of a generation, each by a process of its own."""
    futures = {executor.submit(_traced, plan, folder, branch, known, split): branch for branch in branches}
    for left, future in zip(reversed(range(len(futures))), as_completed(futures), strict=True):
        futures[future].result = future.result()
        say(futures[future], left)


def _traced(plan: Plan, folder: Folder, branch: Traced, known: list[dict], split: bool) -> dict[str, Any]:
    """What becomes of a branch; one that was finished with the same task is not traced again."""
    home = Folder(folder) / "branches" / branch.name
    start = f"../{branch.parent.name}/starts/{branch.half['name']}.npz" if branch.parent and branch.half else None
    origin = label(branch.parent, branch.origin) if branch.parent and branch.origin else None
    task = json.loads(json.dumps({"scene": plan.scene, "parameters": plan.parameters, "bounds": asdict(plan.bounds),
                                  "start": start, "origin": origin, "known": known, "split": split}))
    files, archive = [home / name for name in ("task.json", "result.json")], Archive(home, MPI.COMM_SELF)
    if all(file.exists() for file in files) and json.loads(files[0].read_text()) == task:
        return json.loads(files[1].read_text())
    home.mkdir(parents=True, exist_ok=True)
    files[1].unlink(missing_ok=True)
    archive.write_json("task.json", task)
    if reason := _process(home):
        return {"status": "failed", "message": reason, "arrival": None, "searched": [], "states": [], "points": []}
    return json.loads(files[1].read_text())


def _process(home: Folder) -> str:
    """Do the task in a folder by a process of its own, and return why it fails."""
    command = [sys.executable, "-m", "sheetfx.studies.diagram_branch", str(home)]
    process = call(command, alone())
    lines = process.stderr.strip().splitlines() or [f"exit status {process.returncode}"]
    return lines[-1] if process.returncode else ""


def _children(branch: Traced) -> list[Traced]:
    """The half-branches of its bifurcations that are to be traced."""
    prefix = "" if branch.name == PRIMARY else f"{branch.name}."
    branch.children = [Traced(prefix + half["name"], branch, half, point)
                       for point in branch.bifurcations if "same_as" not in point for half in point["halves"]]
    return branch.children


def _mark_same_points(branch: Traced, listed: Sequence[Traced], folder: Folder) -> None:
    """Say of its bifurcations which are known from other branches, where two branches cross."""
    def place(owner, point):
        return np.load(folder / _magnitudes(owner, point))

    for point in branch.bifurcations:
        same = (label(other, p) for other in listed for p in other.bifurcations
                if p["multiplicity"] == point["multiplicity"]
                and abs(p["load"] - point["load"]) <= SAME * abs(p["load"])
                and np.linalg.norm(place(other, p) - place(branch, point)) <= SAME * np.linalg.norm(place(other, p)))
        if found := next(same, None):
            point["same_as"] = found


def _magnitudes(branch: Traced, point: dict[str, Any]) -> str:
    """File with the sorted lengths of nodal displacements at a bifurcation, in the folder of all branches."""
    return f"{branch.name}/points/{point['number']}.npy"


def reversed_of(branch: Traced, other: Traced) -> bool:
    """Whether two branches join the same points in opposite directions and are one by what lies between."""
    if not (branch.origin and other.origin and branch.result["arrival"] and other.result["arrival"]):
        return False
    ends = [(b.result["arrival"]["point"], label(b.parent, b.origin)) for b in (branch, other)]
    if ends[0] != ends[1][::-1] or len(branch.points) != len(other.points):
        return False
    loads = [[p["load"] for p in b.points] for b in (branch, other)]
    if not np.allclose(loads[0], loads[1][::-1], rtol=SAME):
        return False
    return max(_off(branch, other), _off(other, branch)) <= SAME_CURVE


def _off(branch: Traced, other: Traced) -> float:
    """Largest distance of the states of a branch from the curve of another, beside its length, over the ranges."""
    if len(other.result["states"]) < 2:
        return np.inf
    quantities = ("load", "norm")
    curve, places = other.cubic(quantities), branch.table(quantities)
    ends = curve.x[0], curve.x[-1]
    fine = curve(np.linspace(*ends, FINE))
    scale = np.ptp(fine, axis=0)
    distances = np.linalg.norm((places[:, None] - fine) / scale, axis=2)
    nearest = distances.argmin(axis=1)
    beside = (nearest > 0) & (nearest < FINE - 1)
    return float(distances.min(axis=1)[beside].max(initial=0.0)) if beside.any() else np.inf


def _tree(branch: Traced, plan: Plan) -> dict[str, Any]:
    """A branch with its points and what comes of them."""
    of_point: dict[int, list[Traced]] = {p["number"]: [] for p in branch.points}
    for child in branch.children:
        of_point[child.origin["number"]].append(child)
    points = [{k: v for k, v in p.items() if k not in ("halves", "step", "length")}
              | {"not_followed": _unfollowed(branch, p, plan),
                 "branches": [_tree(child, plan) for child in of_point[p["number"]]]}
              for p in branch.points]
    half = {k: branch.half[k] for k in ("equivalent", "family", "doubt", "amplitude")} if branch.half else {}
    arrival = branch.result["arrival"]
    return {"name": branch.name, "parent": branch.parent.name if branch.parent else None} | half | {
        "reverse_of": branch.reverse_of, "arrives_at": arrival["point"] if arrival else None,
        "status": branch.result["status"], "message": branch.result["message"],
        "searched": branch.result["searched"], "steps": len(branch.result["states"]), "points": points}


def _unfollowed(branch: Traced, point: dict[str, Any], plan: Plan) -> str | None:
    """Why no branches of a point are followed."""
    if point["kind"] != "bifurcation" or any(c.origin is point for c in branch.children):
        return None
    if branch.reverse_of:
        return f"lies on the reverse of branch {branch.reverse_of}"
    if "same_as" in point:
        return f"is point {point['same_as']} too"
    if point["failure"]:
        return f"failed: {point['failure']}"
    if not point["within"]:
        return "lies beyond the bounds"
    if not point["last_stage"]:
        return "lies in an earlier load stage"
    return f"lies beyond {plan.levels} levels of branches"


def _write_table(primary: Traced, file: Folder) -> None:
    """Write one line for each state of each branch."""
    with file.open("w", newline="") as stream:
        writer = csv.DictWriter(stream, COLUMNS, extrasaction="ignore")
        writer.writeheader()
        for branch in everything(primary):
            for state in branch.result["states"]:
                writer.writerow({"branch": branch.name, "parent": branch.parent.name if branch.parent else ""} | state)
