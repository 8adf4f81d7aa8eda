"""Paths with history: hinges, collapse, convergence, restart, bifurcation of the comparison solid, laws of the user."""

from __future__ import annotations

import os
import subprocess
import sys
import warnings
from dataclasses import dataclass
from math import pi
from resource import RUSAGE_CHILDREN, getrusage
from statistics import median
from time import process_time

import numpy as np
import pytest
from helpers import cantilever, follow, on_two_processes, straight
from test_shell_forms import surface

import sheetfx as fx
from sheetfx import meshes
from sheetfx.case import Case, run, trace
from sheetfx.discrete.plastic import plastic_share

SMALL = 1e-5  # yield strain, for which geometry hardly changes before collapse


def hinged_beam(kinematic=0.0):
    """Half of a beam on clamps under a force in its middle."""
    mesh = straight(40)
    material = fx.Plastic(1.0, 0.0, yield_stress=SMALL, kinematic=kinematic)
    beam = fx.Beam(mesh, fx.Rectangle(0.02, 0.02, points=10), material, shear_rigidity=1e2)
    return fx.Scene([beam], [fx.clamp(mesh, "base"), fx.symmetry(mesh, "tip")],
                    [fx.PointForce(mesh, "tip", (0, -1e-10))], fx.Monitor(mesh, "tip", "y", -1.0), symmetry_factor=2)


def test_clamped_beam_collapses_with_three_hinges():
    """P = 8 M_p / L with M_p = s b d^2 / 4. Hinges are at points of quadrature, 0.21 cells from the ends: 1.1 % more;
    ten of Gauss's points give a moment that is 0.9 % too large.
    """
    record = follow(hinged_beam(), fx.DisplacementControl(step=1e-4), deflection=6e-4)
    collapse = 8 * SMALL * 0.02**3 / 4 / 2.0
    assert record.states[-1].load == pytest.approx(collapse, rel=2.5e-2)
    assert record.states[-2].load == pytest.approx(record.states[-1].load, rel=5e-3)


def test_newton_converges_quadratically_in_flow():
    """Three residuals of a step, over the load: the logarithm doubles, but for what the last correction may leave.

    That keeps the tangent of the one before.
    """
    path = fx.Path(cantilever(straight(8), lambda beam: [fx.PointForce(beam.mesh, "tip", (0.0, 1.0))],
                              section=fx.Rectangle(0.1, 0.1, points=5),
                              material=fx.Plastic(1e3, 0.3, yield_stress=1.0, hardening=10.0)),
                   fx.LoadControl(step=0.4e-3, target=1.2e-3 * 0.25, fixed=True), mixed_points=False)
    residuals = [list(path.tracer.stepper.history) for state in path if state.step][-1]
    first, second, last = residuals[-3:]
    assert last < max(100 * second**2, 1e-9)
    assert second < 0.1


def pulled(law=fx.forms.section.linear_elastic, material=None, **scene):
    """A bar of unit length and area along x, its end free to move along it."""
    mesh = straight(1)
    bar = fx.Bar(mesh, fx.Rectangle(1.0, 1.0), material or fx.Elastic(1000.0), law=law)
    return fx.Scene([bar], [fx.pin(mesh, "base"), fx.Support(mesh, "tip", "y")],
                    [fx.PointForce(mesh, "tip", (scene.pop("force", 1.0), 0.0))], fx.Monitor(mesh, "tip", "x"),
                    **{name: value(mesh) for name, value in scene.items()})


@pytest.mark.parametrize("mixed_points", [True, False])
@pytest.mark.slow
def test_a_bar_unloads_elastically(mixed_points):
    """Pulled to 1.002 of its yield force, then let go: the plastic strain 0.002 / H stays."""
    scene = pulled(material=fx.Plastic(1e6, 0.3, yield_stress=1.0, hardening=1e3), force=-1.002,
                   stages=lambda mesh: [fx.Stage([fx.PointForce(mesh, "tip", (1.002, 0.0))], "pull")])
    *_, last = fx.Path(scene, fx.LoadControl(step=0.5), mixed_points=mixed_points)
    assert last.stage == 1 and last.factor == pytest.approx(1.0)
    assert last.deflection == pytest.approx(2e-6, rel=1e-5)


class Softening:
    """A law of a user's: an axial spring whose modulus falls for good with the largest strain it has seen."""

    remembered = 1

    def __init__(self, modulus):
        self.modulus = modulus

    def update(self, strains, history):
        largest = np.maximum(history, np.abs(strains[:, :1]))
        grows = np.abs(strains[:, :1]) >= history
        secant = self.modulus / (1 + 100 * largest)
        slope = np.where(grows, self.modulus / (1 + 100 * largest) ** 2, secant)
        return secant * strains, slope[:, :, None], largest


def test_law_with_history_of_the_user():
    """s = E e / (1 + 100 max e) on the way there, along the secant on the way back; history is what was accepted."""
    *_, last = states = list(fx.Path(pulled(Softening(1000.0)), fx.LoadControl(step=1.0, target=5.0, fixed=True)))
    assert len(states) == 6
    for state in states:
        strain = state.deflection
        assert state.load == pytest.approx(1000 * strain / (1 + 100 * strain), rel=1e-6)
        assert state.fields["history of part 0 0"][0, 0] == pytest.approx([strain, strain], rel=1e-12)
    scene = pulled(Softening(1000.0), force=-3.0, stages=lambda mesh: [
        fx.Stage([fx.PointForce(mesh, "tip", (5.0, 0.0))], "pull")])
    *_, back = fx.Path(scene, fx.LoadControl(step=0.25))
    assert back.deflection == pytest.approx(0.4 * last.deflection, rel=1e-5)
    assert back.fields["history of part 0 0"][0, 0, 1] == pytest.approx(last.deflection, rel=1e-6)


@dataclass
class Returning:
    """A law that returns what it is told."""

    resultants: object
    moduli: object
    history: object
    remembered: object = 1

    def update(self, strains, history):
        return self.resultants, self.moduli, self.history


@pytest.mark.parametrize(("law", "message"), [
    (Returning(0, 0, 0, None), "Bar: law Returning: remembered is None; give the number"),
    (Returning(np.zeros(2), np.zeros((2, 1, 1)), np.zeros((2, 1))), r"resultants of shape \(2,\) for 2 points with 1"),
    (Returning(np.zeros((2, 1)), np.zeros((2, 1)), np.zeros((2, 1))), r"moduli of shape \(2, 1\)"),
    (Returning(np.zeros((2, 1)), np.zeros((2, 1, 1)), np.zeros((2, 3))), r"history of shape \(2, 3\)"),
    (Returning(np.full((2, 1), np.nan), np.zeros((2, 1, 1)), np.zeros((2, 1))), "resultants that are no numbers"),
])
def test_law_that_returns_what_it_should_not_is_refused(law, message):
    with pytest.raises(ValueError, match=message):
        pulled(law)


def test_law_with_moduli_that_are_not_symmetric_is_refused():
    wrong = Returning(np.zeros((2, 3)), np.tile(np.triu(np.ones((3, 3))), (2, 1, 1)), np.zeros((2, 1)))
    with pytest.raises(ValueError, match="Beam: law Returning: its moduli are not symmetric: 1 of resultant 0 with"):
        fx.Beam(straight(1), fx.Rectangle(1.0, 1.0), fx.Elastic(1.0), law=wrong)


def test_what_needs_an_energy_is_refused_with_a_reason():
    record = follow(pulled(Softening(1000.0)), fx.LoadControl(step=1.0, target=2.0))
    with pytest.raises(ValueError, match="snap: laws with history would have to remember"):
        record.snap(record.states[-1])
    with pytest.raises(ValueError, match="a law with history does not say how much"):
        record.energies()


def frame(steps):
    return Case(hinged_beam(kinematic=0.01), fx.LoadControl(step=0.05, fixed=True), fx.Until(steps=steps))


def test_restart_in_the_middle_of_plastic_flow(tmp_path):
    """A run that is resumed from its folder takes the same path."""
    whole = trace(frame(9)).states
    run(frame(6), "beam", {}, tmp_path, False)
    assert whole[6].fields["history of part 0 0"][..., 3:].any()
    run(frame(9), "beam", {}, tmp_path, True)
    rows = np.genfromtxt(tmp_path / "path.csv", delimiter=",", names=True)
    assert [s.load for s in whole] == pytest.approx(rows["load"].tolist(), rel=1e-10)
    assert [s.deflection for s in whole] == pytest.approx(rows["deflection"].tolist(), rel=1e-10)


TWO = """
from test_plastic_paths import *
for state in trace(frame(8)).states:
    print(repr(float(state.load)), repr(float(state.deflection)))
"""


def test_two_processes_take_the_same_path():
    lines = on_two_processes(TWO)
    found = np.array([line.split() for line in lines], dtype=float)
    alone = np.array([(s.load, s.deflection) for s in trace(frame(8)).states])
    assert found == pytest.approx(alone, rel=1e-9)


@pytest.mark.parametrize("turned, said", [(1.0, 1), (0.0, 0)])
def test_torsion_beside_plastic_hinges_is_told(turned, said):
    """A round cantilever of two legs, at a right angle or in a line, under a force across them; once for a path."""
    places = {"held": (0.0, 0.0, 0.0), "knee": (1.0, 0.0, 0.0), "tip": (2.0 - turned, turned, 0.0)}
    mesh = fx.read(lambda: meshes.frame(places, {"one": ("held", "knee", 4), "two": ("knee", "tip", 4)}), 3)
    bar = fx.Beam(mesh, fx.round_bar(0.1), fx.Plastic(2e5, 0.3, yield_stress=100.0, hardening=2e3), up=(0.0, 0.0, 1.0))
    scene = fx.Scene([bar], [fx.clamp(mesh, "held")], [fx.PointForce(mesh, "tip", (0.0, 0.0, 1.0))],
                     fx.Monitor(mesh, "tip", "z"))
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        trace(Case(scene, until=fx.Until(deflection=0.1)))
    assert sum("fibres flow where shear and torsion" in str(w.message) for w in told) == said


def column(hardening, depth=0.05, shear_rigidity=1e3, points=3):
    """Column on hinges that yields at 0.8 of its tangent-modulus load, and that load, pi^2 E_t I / L^2."""
    modulus = 200e3
    tangent = modulus * hardening / (modulus + hardening)
    load = pi**2 * tangent * depth**4 / 12
    material = fx.Plastic(modulus, 0.3, yield_stress=0.8 * load / depth**2, hardening=hardening)
    nodes = {"base": (0, 0), "middle": (0.5, 0), "tip": (1, 0)}
    mesh = fx.read(lambda: meshes.frame(nodes, {"lower": ("base", "middle", 8), "upper": ("middle", "tip", 8)}), 2)
    beam = fx.Beam(mesh, fx.Rectangle(depth, depth, points=points), material, shear_rigidity=shear_rigidity)
    return fx.Scene([beam], [fx.pin(mesh, "base"), fx.Support(mesh, "tip", "y")],
                    [fx.PointForce(mesh, "tip", (-load, 0.0))], fx.Monitor(mesh, "middle", "y")), load


@pytest.mark.parametrize("hardening", [200e3, 50e3])
def test_column_bifurcates_at_its_tangent_modulus_load(hardening):
    """Shanley (1947): the comparison solid's bifurcation. Shortening before it shortens the column: 0.2 % and less."""
    scene, load = column(hardening)
    record = follow(scene, fx.LoadControl(step=0.1, target=1.2))
    (point,) = record.critical_points
    assert (point.kind, point.name) == ("bifurcation", "comparison solid")
    assert point.load / load == pytest.approx(1.0, rel=3e-3)


@pytest.mark.slow
@pytest.mark.parametrize(("clamped", "cells", "factor", "tolerance", "resultants"), [
    (False, 6, 6.52, 1e-2, False), (True, 14, 12.5, 7e-2, False), (False, 6, 6.52, 1e-2, True)])
def test_circular_plates_collapse(clamped, cells, factor, tolerance, resultants):
    """p R^2 / M_p by von Mises's condition: 6.52 on simple, 12.5 on clamped supports (Hopkins and Wang 1955).

    Simpson's five layers and Ilyushin's law give M_p exactly; the clamped plate's hinge at its edge converges with the
    cells' size only.
    """
    thickness, modulus, strength = 0.05, 1e5, 1.0

    def place(x):
        s, t = x[:, 0], x[:, 1]
        return np.column_stack((s * np.sqrt(1 - t**2 / 2), t * np.sqrt(1 - s**2 / 2), 0 * s))

    mesh = surface("naghdi-q2", (cells, cells), place)
    plate, material = fx.Plate(thickness, points=5, rule="simpson"), fx.Plastic(modulus, 0.3, yield_stress=strength)
    shell = fx.Shell(mesh, plate, material, **({"law": fx.Ilyushin(plate, material)} if resultants else {}))
    edge = "x y z rx ry rz" if clamped else "z"
    moment = strength * thickness**2 / 4
    scene = fx.Scene([shell], [fx.Support(mesh, "east", edge), fx.Support(mesh, "north", edge),
                               fx.symmetry(mesh, "west", "x"), fx.symmetry(mesh, "south", "y")],
                     [fx.SurfaceForce(shell, (0.0, 0.0, -moment))], fx.Monitor(mesh, "south-west", "z", -1.0))
    elastic = 62.5 * moment / 64 / (modulus * thickness**3 / 12 / 0.91)
    *_, last = fx.Path(scene, fx.DisplacementControl(step=elastic / 4), fx.Until(deflection=5 * elastic))
    assert last.factor == pytest.approx(factor, rel=tolerance)


@pytest.mark.slow
def test_a_plastic_path_costs_at_most_twice_its_elastic_one():
    """CPU time of each factorisation, with all that belongs to it, of a plate that flows nearly everywhere."""
    def seconds(material):
        mesh = surface("naghdi-q2", (20, 20), lambda x: np.column_stack((x[:, 0], x[:, 1], 0 * x[:, 0])))
        shell = fx.Shell(mesh, fx.Plate(0.01, points=5), material)
        scene = fx.Scene([shell], [fx.Support(mesh, edge, "x y z") for edge in ("west", "east", "south", "north")],
                         [fx.SurfaceForce(shell, (0.0, 0.0, -1e-3))], fx.Monitor(mesh, "south-west", "rx"))
        path, times = fx.Path(scene, fx.LoadControl(step=1.0, target=4.0, fixed=True)), []
        start, count = process_time(), path.tracer.total_factorisations
        for state in path:
            now = process_time(), path.tracer.total_factorisations
            times += [(now[0] - start) / (now[1] - count)] if state.step else []
            start, count = now
        return median(times), path

    elastic, path = seconds(fx.Elastic(1e3, 0.3))
    plastic, flowing = seconds(fx.Plastic(1e3, 0.3, yield_stress=0.5, hardening=50.0))
    assert 9000 < path.unknowns == flowing.unknowns
    assert plastic_share(flowing.discretisation) > 0.9
    assert plastic < 2 * elastic


STEP = """
import sheetfx as fx
mesh = fx.read(lambda: fx.meshes.rectangle((2, 2)), dimension=3, order=2)
shell = fx.Shell(mesh, fx.Plate(0.01, points=5), {material})
scene = fx.Scene([shell], [fx.clamp(mesh, "west")], [fx.SurfaceForce(shell, (0.0, 0.0, -1e-5))],
                 fx.Monitor(mesh, "south-east", "z", -1.0))
assert len(list(fx.Path(scene, fx.LoadControl(step=1.0, fixed=True)))) == 2
"""


@pytest.mark.slow
def test_plasticity_takes_at_most_1_3_times_as_long_to_compile(tmp_path):
    """CPU time of a shell's first step in a new process without compiled forms, the least of three in turn."""
    materials = {"elastic": "fx.Elastic(1e3, 0.3)", "plastic": "fx.Plastic(1e3, 0.3, yield_stress=0.5, hardening=50.0)"}

    def seconds(name, number):
        before = getrusage(RUSAGE_CHILDREN)
        subprocess.run([sys.executable, "-c", STEP.format(material=materials[name])], check=True,
                       env=os.environ | {"XDG_CACHE_HOME": str(tmp_path / f"{name}{number}")})
        after = getrusage(RUSAGE_CHILDREN)
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

    rounds = [[seconds(name, number) for name in materials] for number in range(3)]
    elastic, plastic = map(min, zip(*rounds, strict=True))
    again = seconds("elastic", 0)
    assert again < elastic / 2  # most of it is compilation
    assert plastic - again < 1.3 * (elastic - again)
