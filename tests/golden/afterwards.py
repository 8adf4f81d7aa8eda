"""What is computed of a path when it is there: Koiter's coefficients, branches, falls, buckling, vibrations."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from math import radians

import numpy as np
from failure_map.traps import TRAPS, contact
from helpers import hinged_arch, whole_arch
from random_structures import scene as random_scene
from test_close_points import pyramid
from test_corner_branches import propped
from test_curves import propped_bar
from test_imperfections import SWAYS
from test_imperfections import propped_bar as upright_bar
from test_unilateral import spans

import sheetfx as fx
from sheetfx.critical.likely import load_quantile
from sheetfx.record import Record

FALLS = 2  # of a path, at most
NOTHING = 1e-5  # derivative of a load of the order of 10 that is rounding


def bifurcations(record: Record) -> dict[str, float]:
    """Koiter's coefficients, and of all branches whether their loads rise and how many unstable modes they have."""
    found = {}
    for n, point in enumerate(p for p in record.critical_points if p.kind == "bifurcation"):
        found |= {f"{key} {n}": value for key, value in (("a", point.slope), ("b", point.curvature))
                  if value is not None}
        starts = record.branches(point)
        found[f"branches {n}"] = len(starts)
        kinds = sorted((np.sign(b.start.load - point.load), b.start.unstable_modes) for b in starts)
        found |= {f"branch {n} {k}": rises * (1 + modes) for k, (rises, modes) in enumerate(kinds)}
    return found


def corner(record: Record) -> dict[str, float]:
    """Which props let go on the branches of a corner: each set but none and all."""
    point = next(p for p in record.critical_points if p.name == "corner")
    return {" ".join(map(str, np.sign(branch.direction))): branch.start.load for branch in record.branches(point)}


def returning(record: Record) -> dict[str, float]:
    """Points on a closed branch that passes through its bifurcation, by long steps."""
    point = next(p for p in record.critical_points if p.kind == "bifurcation")
    path = fx.Path(record.case.scene, fx.ArcLength(0.12, largest=2 / 3), fx.Until(steps=25),
                   start=[record.branches(point)[0].start])
    found = [p for state in path for p in state.critical]
    return {f"{n} {p.multiplicity} {p.name}": p.load for n, p in enumerate(found)}


def energies(record: Record) -> dict[str, float]:
    """Work of the loads, whether it is as accurate as asked for, and whether it is not stored."""
    found = record.balance(1e-6)
    return {"work": found.work[-1], "inaccurate": float(found.tolerance > 1e-6), "broken": float(bool(found.broken))}


def falls(record: Record, hold: str) -> dict[str, float]:
    """Where a test falls to from the first unstable states."""
    found: dict[str, float] = {}
    for snap in fx.snaps(record.path, record.states[:_enough(record)], hold):
        found |= {f"fall {len(found)}": snap.after.deflection, f"released {len(found)}": snap.energy_released}
    return found


def _enough(record: Record) -> int:
    """Number of states up to the second unstable piece."""
    pieces, before = 0, False
    for n, state in enumerate(record.states):
        now = bool(state.unstable_modes)
        pieces, before = pieces + (now and not before), now
        if pieces == FALLS:
            return n + 1
    return len(record.states)


def fall_with_friction(record: Record) -> dict[str, float]:
    """The fall from the first unstable state, by a viscous motion."""
    fall = record.snap(next(state for state in record.states if state.unstable_modes))
    return {"fall": fall.after.deflection, "released": fall.energy_released}


def linear(record: Record) -> dict[str, float]:
    """Buckling about the unloaded and a loaded state, and vibrations where there is mass."""
    found = {f"buckling {n}": load.factor for n, load in enumerate(record.buckling(record.states[0])[:3])}
    return found | {f"loaded {n}": load.factor for n, load in enumerate(record.buckling(record.states[1])[:2])}


def vibrations(record: Record) -> dict[str, float]:
    return {f"squared {k} {n}": v.squared for k in (0, -1)
            for n, v in enumerate(record.frequencies(record.states[k], 4))}


def imperfect_arch(record: Record) -> dict[str, float]:
    """Koiter's two-thirds law for a hinged shallow arch, see tests/test_sensitivity.py."""
    point = next(p for p in record.critical_points if p.kind == "bifurcation")
    before, after = record.states[point.step - 1: point.step + 1]

    def deviation(x):
        return np.sin(np.pi * np.arctan2(x[:, 0], x[:, 1]) / radians(7.338))

    def scene(amplitude):
        return hinged_arch(fx.imperfect(whole_arch(20), deviation, amplitude))

    rho = fx.imperfection_sensitivity(record.path, before, after, point, scene, 5e-3)
    return {"sensitivity": abs(rho), "limit": fx.limit_of_imperfect(point, 0.05, rho)}


def heavy_column() -> fx.Case:
    """A column with mass on two hinges."""
    mesh = fx.read(lambda: fx.meshes.frame({"base": (0, 0), "tip": (1.0, 0)}, {"beam": ("base", "tip", 8)}), 2)
    beam = fx.Beam(mesh, fx.Rectangle(0.02, 0.01), fx.Elastic(1e7, 0.3, density=2.0))
    scene = fx.Scene([beam], [fx.pin(mesh, "base"), fx.Support(mesh, "tip", "y")],
                     [fx.PointForce(mesh, "tip", (-1.0, 0.0))], fx.Monitor(mesh, "tip", "x", -1.0))
    return fx.Case(scene, until=fx.Until(load=0.2))


def stayed_mast() -> fx.Case:
    """A mast on a hinge between stays that are a hundredth stiffer across than along, see tests/test_first_piece.py."""
    top = {"east": (1, 0), "west": (-1, 0), "north": (0, 1), "south": (0, -1)}
    nodes = {"base": (0, 0, 0), "top": (0, 0, 2.0)} | {name: (*place, 2.0) for name, place in top.items()}
    members = {"mast": ("base", "top", 1)} | {name: ("top", name, 1) for name in top}
    rigidities = {"mast": 2e6, "east": 1.0, "west": 1.0, "north": 1.01, "south": 1.01}
    mesh = fx.read(lambda: fx.meshes.frame(nodes, members), 3)
    bars = [fx.Bar(mesh, fx.Rectangle(1.0, 1.0), fx.Elastic(value), group=name) for name, value in rigidities.items()]
    scene = fx.Scene(bars, [fx.pin(mesh, name) for name in nodes if name != "top"],
                     [fx.PointForce(mesh, "top", (0.0, 0.0, -1.0))], fx.Monitor(mesh, "top", "x"))
    return fx.Case(scene, fx.LoadControl(step=1.4, target=4.444))


def secondary(record: Record) -> dict[str, float]:
    """The secondary bifurcation of a branch that begins at the first one."""
    branch = record.branches(record.critical_points[0])[-1]
    path = fx.Path(record.case.scene, fx.ArcLength(3.155e-3), fx.Until(deflection=0.0757), start=[branch.start])
    found = [point for state in path for point in state.critical]
    return {"points": len(found)} | {f"sway {n}": abs(point.deflection) for n, point in enumerate(found)}


def directly(record: Record) -> dict[str, float]:
    """Critical points by Newton's method from the states before them."""
    found = [fx.critical(record.path, record.states[point.step - 1]) for point in record.critical_points[:2]]
    return {"points": len(found)} | {f"direct {n}": critical.point.load for n, critical in enumerate(found)}


def errors(record: Record) -> dict[str, float]:
    """Loads with one degree more, and whether their order is said to be uncertain."""
    found: dict[str, float] = {}
    for n, bar in enumerate(record.error_bars(record.critical_points[:2])):
        found |= {f"corrected {n}": bar.point.load - (bar.error or 0.0), f"uncertain {n}": bool(bar.reason)}
    return found


def gradients(record: Record) -> dict[str, float]:
    """Derivatives by places of slender members, and whether an imperfection is told from what keeps a bifurcation."""
    found: dict[str, float] = {}
    for n, point in enumerate(record.critical_points[:2]):
        for name, shape in (("higher", lambda x: x[:, 1]), ("leaning", lambda x: np.sin(np.pi * x[:, 0] / 50.0))):
            def scene(times, shape=shape):
                return fx.imperfect(record.case.scene, lambda x: np.column_stack((0 * x[:, 0], (times - 1) * shape(x))))
            try:
                value = record.gradient(point, scene, 1.0)
                found |= {f"{name} {n}": value} if abs(value) > NOTHING else {}
            except ValueError:
                found[f"{name} {n} refused"] = 1.0
    return found


def unilateral(record: Record) -> dict[str, float]:
    """The lowest and the highest solution, and how many contacts the lowest one presses."""
    found = fx.unilateral_buckling(record.path, record.states[0])
    return {"lowest": found.factor, "pressed": found.pressed, "highest": max(found.others, default=found.load)}


def curve(record: Record) -> dict[str, float]:
    """The named points of a curve of limit points, and its end."""
    (point,) = record.critical_points
    modes = record.critical_modes(point)
    points = list(fx.CriticalCurve(point, record.state_at(point), modes, propped_bar, 0.1, -0.02, steps=2))
    return {p.name: p.load for p in points if p.name} | {"last": points[-1].load}


def imperfections(record: Record) -> dict[str, float]:
    """The worst imperfection, a quantile by few paths, and the load and error of the reduced energy.

    Which places are looked at may hang on last digits, as of two that lie symmetrically: the quantile's are rounded.
    """
    def follow(scene):
        return fx.Path(scene, record.case.control, record.case.until)

    def rounded(one):
        return replace(one, load=round(one.load, 8))

    paths, (point,) = fx.Imperfections(record.case.scene, SWAYS, follow), record.critical_points[:1]
    worst = paths.worst(0.05, starts=2)
    quantile = load_quantile(lambda c: rounded(paths.at(c)), len(SWAYS), 0.05, 0.05, samples=8, seed=0)
    state = record.state_at(point)
    energy = fx.ReducedEnergy(record.path, state, fx.softest_modes(record.path, state, 2), paths.scene, 2, 1e-5)
    return {"worst": worst[0].load, "minima": len(worst), "quantile": quantile.load, "reach": quantile.interval[1],
            "reduced": energy.at((0.01, 0.004)).load, "off": energy.error((0.01, 0.004))}


def trap(name: str) -> Callable[[], fx.Case]:
    return lambda: TRAPS[name].case()


BY_LOAD, BY_DISPLACEMENT = partial(falls, hold="load"), partial(falls, hold="displacement")

AFTERWARDS: dict[str, tuple[Callable[[], fx.Case], Callable[[Record], dict[str, float]]]] = {
    "branches-truss": (trap("von-mises-truss"), bifurcations),
    "branches-sinusoidal-arch": (trap("sinusoidal-arch-before"), bifurcations),
    "branches-frame": (trap("roorda-frame"), bifurcations),
    "branches-star-dome": (trap("star-dome"), bifurcations),
    "branches-augusti": (trap("augusti-exact"), bifurcations),
    "branches-close": (trap("close-modes-0.1-percent"), bifurcations),
    "branch-of-mast": (stayed_mast, secondary),
    "branches-column": (trap("column"), bifurcations),
    "branches-corner": (propped, corner),
    "branch-returns": (lambda: fx.Case(random_scene(pyramid(0.05)), until=fx.Until(deflection=3.0)), returning),
    "energies-roof": (trap("roof-12.7"), energies),
    "directly-truss": (trap("von-mises-truss"), directly),
    "directly-frame": (trap("roorda-frame"), directly),
    "directly-star-dome": (trap("star-dome"), directly),
    "falls-roof": (trap("roof-12.7"), BY_LOAD),
    "falls-lee-frame": (trap("lee-frame"), BY_DISPLACEMENT),
    "falls-truss": (trap("von-mises-truss"), BY_LOAD),
    "falls-punch": (trap("punch-arch"), BY_LOAD),
    "falls-friction": (lambda: contact.along_wall(0.02, 0.1, 2e-3 / contact.SLIPS, 0.5), fall_with_friction),
    "falls-star-dome": (trap("star-dome"), BY_LOAD),
    "buckling-roorda": (trap("roorda-frame"), linear),
    "buckling-panel": (trap("cylinder-panel"), linear),
    "unilateral": (lambda: fx.Case(spans(2), until=fx.Until(steps=1)), unilateral),
    "vibrations": (heavy_column, vibrations),
    "errors-panel": (trap("cylinder-panel"), errors),
    "errors-frame": (trap("lee-frame"), errors),
    "gradients-arch": (trap("sinusoidal-arch-before"), gradients),
    "gradients-frame": (trap("lee-frame"), gradients),
    "curve-bar": (lambda: fx.Case(propped_bar(0.1), fx.ArcLength(0.05), fx.Until(deflection=0.45)), curve),
    "imperfections-bar": (lambda: fx.Case(upright_bar(1.2), fx.ArcLength(0.2), fx.Until(deflection=0.9)),
                          imperfections),
    "imperfect-arch": (lambda: fx.Case(hinged_arch(whole_arch(20)), until=fx.Until(deflection=10.0)), imperfect_arch),
}
