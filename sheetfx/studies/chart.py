"""Error against cost: the meshes and forms of a scene beside other programs, in one run.

A module of a scene takes part with `REFERENCE` (converged quantities by name), `CHART` (parameters
of the scene's function, one dict per member) and, optionally, `PEERS` (dicts with `driver`, the name
of a script in demos/peers or a path, and `arguments`).
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from shutil import rmtree
from statistics import median
from tempfile import mkdtemp

import typer

from .. import interrupts
from ..scenes import load_case, scene_names
from .chart_runs import ONE_THREAD, Unusable, call
from .ladder_chart import ladder, reference
from .run import run_app

TREE = Path(__file__).parents[2]


@dataclass(frozen=True, eq=False)
class Member:
    """The scene itself with some parameters, run as a user would."""

    scene: str
    parameters: dict

    @property
    def method(self) -> str:
        """The parameters that are no numbers: members that share them differ in their mesh."""
        chosen = [(k, v) for k, v in self.parameters.items() if isinstance(v, str | bool)]
        return ", ".join(["sheetfx", *(f"{k} {v}" if isinstance(v, str) else k for k, v in chosen if v)])

    @property
    def label(self) -> str:
        return ", ".join(f"{k} {v:g}" for k, v in self.parameters.items() if not isinstance(v, str | bool))

    def run(self) -> dict:
        """Run once in a process of its own; what `Point` takes."""
        folder = mkdtemp()
        with interrupts.finally_(lambda: rmtree(folder)):
            call([sys.executable, "-m", "sheetfx", "run", self.scene, *options(self.scene, self.parameters),
                  "--no-pictures", "--no-error", "-o", folder], os.environ | ONE_THREAD)
            summary = json.loads((Path(folder) / "summary.json").read_text())
        timings = summary["timings"]
        return {key: summary[key] for key in ("unknowns", "factorisations", "iterations", "quantities")} | {
            "method": self.method, "cpu_seconds": timings["path"]}


@dataclass(frozen=True, eq=False)
class Peer:
    """Another program, run by a script that prints a line of JSON."""

    driver: str
    arguments: Sequence[str]

    @property
    def method(self) -> str:
        return Path(self.driver).stem

    @property
    def label(self) -> str:
        return " ".join(map(str, self.arguments))

    def run(self) -> dict:
        """Run once in a process of its own; what `Point` takes. Every iteration factorises."""
        script = Path(self.driver) if self.driver.endswith(".py") else TREE / "demos" / "peers" / f"{self.driver}.py"
        if not script.is_file():
            raise Unusable(f"there is no driver {script}")
        packages = os.environ.get("SHEETFX_PEERS", str(TREE / ".peers"))
        paths = os.pathsep.join(filter(None, [packages, os.environ.get("PYTHONPATH")]))
        output = call([sys.executable, str(script), *map(str, self.arguments)],
                      os.environ | ONE_THREAD | {"PYTHONPATH": paths})
        lines = [line for line in output.splitlines() if line.startswith("{")]
        if not lines:
            raise Unusable("its driver printed no line of JSON")
        report = json.loads(lines[-1])
        return {"method": report["peer"], "cpu_seconds": report["cpu_s"], "factorisations": report["iterations"]} | {
            key: report[key] for key in ("unknowns", "iterations", "quantities")}


@dataclass(frozen=True)
class Point:
    """A method on the chart: medians over its runs.

    Attributes
    ----------
    runs : that count; 0: it has run once so far, to warm the caches
    """

    method: str
    label: str
    peer: bool
    unknowns: int
    factorisations: int
    iterations: int
    cpu_seconds: float
    error_percent: float
    quantities: dict[str, float]
    runs: int = 0


def options(scene: str, parameters: dict) -> list[str]:
    """Parameters of a scene's function as options of `sheetfx run`."""
    group = typer.main.get_command(run_app)
    known = {p.name: p for p in group.get_command(None, scene).params}
    words = []
    for name, value in parameters.items():
        if name not in known:
            raise ValueError(f"CHART of {scene} names {name!r}, which is no parameter of its scene")
        if value is True:
            words.append(known[name].opts[0])
        elif value is False:
            words += known[name].secondary_opts[:1]
        else:
            words += [known[name].opts[0], str(value)]
    return words


def family(name: str, say: Callable[[str], None] = lambda line: None,
           known: dict[str, float] | None = None) -> tuple[dict[str, float], list, list[Peer]]:
    """Reference quantities, members and peers of a scene's chart; without REFERENCE and CHART its ladder of models.

    Parameters
    ----------
    known : reference of an earlier chart of the ladder, which takes time to find
    """
    module = sys.modules[load_case(name).__module__]
    given = [getattr(module, wanted, None) for wanted in ("REFERENCE", "CHART")]
    if not any(given):
        members = ladder(name)
        return known or reference(members, say), members, []
    for wanted, value in zip(("REFERENCE", "CHART"), given, strict=True):
        if not value:
            raise ValueError(f"the scene {name} has no {wanted} to draw a chart of; add it")
    return given[0], [Member(name, parameters) for parameters in given[1]], [
        Peer(**peer) for peer in getattr(module, "PEERS", [])]


def charts() -> list[str]:
    """Names of the built-in scenes that have a chart."""
    return [name for name in scene_names() if getattr(sys.modules[load_case(name).__module__], "CHART", None)]


def measure(reference: dict[str, float], members: list[Member], peers: list[Peer], repeat: int,
            say: Callable[[str], None] = lambda line: None,
            keep: Callable[[list[Point], dict[str, list[dict]]], None] = lambda points, runs: None,
            earlier: Mapping[str, list[dict]] | None = None) -> list[Point]:
    """Run all methods in turn, once to warm the caches and then `repeat` times.

    Each turn spreads the peers evenly between the members, so that a machine that gets slower or
    faster does so for all. A method that fails is left out with a line that says why.

    Parameters
    ----------
    say : called with what runs now
    keep : called after each run with the points so far, and all runs by their methods
    earlier : such runs of an interrupted chart, which are not repeated
    """
    earlier = earlier or {}
    places = [((i + 0.5) / len(group), method) for group in (members, peers) for i, method in enumerate(group)]
    runs = {method: earlier.get(_name(method), [])[:repeat + 1]
            for _, method in sorted(places, key=lambda place: place[0])}
    for turn in range(repeat + 1):
        say(f"run {turn} of {repeat}" if turn else "warming up")
        for method in [m for m, results in runs.items() if len(results) <= turn]:
            say(f"  {_name(method)}")
            try:
                result = method.run()
                error = error_percent(result["quantities"], reference)
            except Unusable as reason:
                say(f"{_name(method)} is left out: {reason}")
                del runs[method]
                continue
            runs[method].append(result | {"error_percent": error})
            keep(_points([*members, *peers], runs), {_name(m): results for m, results in runs.items()})
    return _points([*members, *peers], runs)


def _name(method: Member | Peer) -> str:
    return f"{method.method} {method.label}"


def _points(methods: Sequence[Member | Peer], runs: dict[Member | Peer, list[dict]]) -> list[Point]:
    """Of the methods that have run."""
    return [Point(**results[-1] | {"label": method.label, "peer": isinstance(method, Peer),
                                   "cpu_seconds": median(r["cpu_seconds"] for r in results[1:] or results),
                                   "runs": len(results) - 1})
            for method in methods if (results := runs.get(method))]


def error_percent(quantities: dict[str, float], reference: dict[str, float]) -> float:
    """Largest relative error of the reference quantities in percent."""
    missing = [name for name in reference if not isfinite(quantities.get(name, float("nan")))]
    if missing:
        raise Unusable(f"it reports no {', '.join(missing)}")
    return 100 * max(abs(quantities[name] / value - 1) for name, value in reference.items())


def rivals(points: Sequence[Point]) -> list[tuple[Point, Point | None]]:
    """Each peer with the cheapest member whose error is not larger, if there is one."""
    pairs = []
    for peer in (p for p in points if p.peer):
        fit = [p for p in points if not p.peer and p.error_percent <= peer.error_percent]
        pairs.append((peer, min(fit, key=lambda p: p.cpu_seconds, default=None)))
    return pairs
