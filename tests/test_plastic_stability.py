"""Stability of structures that have yielded: history frozen in differences, columns and plates of the literature."""

from __future__ import annotations

from dataclasses import replace
from math import pi, sqrt, tan

import numpy as np
import pytest
from helpers import follow
from scipy.optimize import brentq
from test_plastic_paths import column, hinged_beam
from test_shell_forms import surface

import sheetfx as fx
from sheetfx.critical.koiter import expansion
from sheetfx.events.search import state_at
from sheetfx.model.plasticity import Layers

MODULUS, HARDENING = 200e3, 50e3  # of columns; the tangent modulus is a fifth of the elastic one


def test_linear_buckling_about_a_yielded_state():
    """At 0.9 of the tangent-modulus load the comparison solid buckles there; before it yields, at Euler's load.

    Differences about the state go both ways: were history not frozen, one of them would meet the elastic moduli.
    """
    scene, load = column(HARDENING, depth=0.01, shear_rigidity=30.0)
    record = follow(scene, fx.LoadControl(step=0.1, target=0.9, fixed=True))
    *_, elastic, _, yielded = record.states
    assert record.buckling(yielded, count=1)[0].load == pytest.approx(load, rel=2e-3)
    assert record.buckling(yielded, count=1, prebuckling=False)[0].load == pytest.approx(load, rel=2e-3)
    euler = record.buckling(elastic, count=1, prebuckling=False)[0].load
    assert euler == pytest.approx(load * (MODULUS + HARDENING) / HARDENING, rel=1e-2)


def test_koiters_coefficients_of_the_comparison_solid():
    """Those of the elastica, load / critical load = 1 + (pi w / L)^2 / 8, though it has yielded; 0.2 % compressed."""
    record = follow(column(HARDENING)[0], fx.LoadControl(step=0.1, target=1.2))
    (point,) = record.critical_points
    (mode,) = record.critical_modes(point)
    beside = record.states[-2:]
    tracer = record.path.tracer
    state = state_at(tracer, *beside, point)
    unit = tracer.system.create_vector(mode)
    unit.scale(1 / tracer.distance(0.0, mode))
    found = expansion(tracer, unit, beside)
    bend = -found.quartic / (6 * found.stiffness) / found.size**2 / state.factor
    assert bend == pytest.approx(pi**2 / 8, rel=1e-2)
    assert abs(found.cubic) < 1e-6 * found.quartic * found.size


def test_a_yielded_structure_does_not_snap():
    record = follow(hinged_beam(kinematic=0.01), fx.DisplacementControl(step=1e-4), deflection=3e-4)
    with pytest.raises(ValueError, match="snap: laws with history would have to remember the long steps of a fall"):
        record.snap(record.states[-1])


def slender():
    """The column of `column` with 20 fibres, its tangent-modulus load, and its reduced-modulus load.

    The latter is pi^2 E_r I / L^2, E_r = 4 E E_t / (sqrt E + sqrt E_t)^2 of a rectangle (von Karman 1910).
    """
    scene, load = column(HARDENING, depth=0.02, shear_rigidity=30.0, points=20)
    return scene, load, 4 / (1 + sqrt(HARDENING / (MODULUS + HARDENING))) ** 2 * load


@pytest.mark.parametrize("ratio", [1.1, 1.4])
def test_a_column_above_its_tangent_modulus_load_bends_with_the_reduced_modulus(ratio):
    """Under a load that is held each section loads on one side and unloads on the other, however small the moment.

    Deflection by a force in the middle: Q / (2 P k) (tan(k L / 2) - k L / 2), k^2 = P / (E_r I).
    """
    scene, tangent, reduced = slender()
    mesh, force = scene.parts[0].mesh, 1e-4 * tangent
    held = replace(scene, loads=[fx.PointForce(mesh, "middle", (0.0, force))],
                   stages=[fx.Stage([fx.PointForce(mesh, "tip", (-ratio * tangent, 0.0))], "press")])
    *_, last = fx.Path(held, fx.LoadControl(step=1.0, fixed=True, turn=4.0))
    k = pi * sqrt(ratio * tangent / reduced)
    assert last.deflection == pytest.approx(force / (2 * ratio * tangent * k) * (tan(k / 2) - k / 2), rel=3e-3)
    assert last.unstable_modes == 0


def test_branches_of_a_column_rise_from_the_tangent_modulus_load():
    """Shanley (1947): load and deflection rise together, 6 w / d at first, so that nothing unloads (Hutchinson 1974).

    The load then comes to a maximum below the reduced-modulus load.
    """
    scene, tangent, reduced = slender()
    record = follow(scene, fx.LoadControl(step=0.1, target=1.2))
    (point,) = record.critical_points
    rises = {}
    for amplitude in (1e-3, 1e-4):
        one, other = record.branches(point, amplitude)
        assert one.start.load == pytest.approx(other.start.load, rel=1e-9)
        assert one.start.deflection == pytest.approx(-other.start.deflection, rel=1e-6)
        assert not one.doubt and one.start.unstable_modes == 0
        rises[amplitude] = (one.start.load / point.load - 1) / (6 * abs(one.start.deflection) / 0.02)
    assert 0.6 < rises[1e-3] < 0.85 < rises[1e-4] < 1.0
    control = fx.DisplacementControl(step=5e-4, sign="projection", turn=4.0)
    states = list(fx.Path(scene, control, fx.Until(deflection=0.01), start=[one.start]))
    (limit,) = [p for s in states for p in s.critical if p.kind == "limit"]
    assert 1.2 * tangent < limit.load < reduced and limit.name == "maximum"


class DeformationTheory:
    """Hencky's law of a plate whose strains have grown in proportion: the return mapping from the virgin state.

    Backward Euler from there gives total plastic strains along the deviator, and its moduli are those of the theory.
    """

    remembered = 0

    def __init__(self, plate, material):
        self.flow = Layers(*plate.layers(), material, plate.stiffness(material))

    def update(self, strains, history):
        resultants, moduli, _ = self.flow.update(strains, np.zeros((len(strains), self.flow.remembered)))
        return resultants, moduli, history


PLATE, STEEL = fx.Plate(0.01, points=2), fx.Plastic(200e3, 0.3, yield_stress=40.0, hardening=30e3)


def plate_buckling_stress(theory):
    """Stress at which a simply supported square plate bifurcates in one half wave, by Mindlin's theory.

    Rates of plane stress about compression along x: strain rates are elastic ones plus (1 / E_t - 1 / E_s) n n^T times
    those of stress, n = (1, -1/2, 0), plus 3 / 2 (1 / E_s - 1 / E) times the deviator; flow theory takes E for E_s in
    both (Handelman and Prager 1948, Bijlaard 1949; Hutchinson 1974, section III).
    """
    e, nu, t = STEEL.modulus, STEEL.poisson, PLATE.thickness
    tangent = e * STEEL.hardening / (e + STEEL.hardening)
    elastic = np.array([[1, -nu, 0], [-nu, 1, 0], [0, 0, 2 + 2 * nu]]) / e
    deviator = np.array([[2 / 3, -1 / 3, 0], [-1 / 3, 2 / 3, 0], [0, 0, 2]])
    normal = np.array([1, -0.5, 0])

    def missing(stress):
        secant = stress / (stress / tangent - STEEL.yield_stress * (1 / tangent - 1 / e))
        secant = secant if theory == "deformation" else e
        moduli = np.linalg.inv(elastic + 1.5 * (1 / secant - 1 / e) * deviator
                               + (1 / tangent - 1 / secant) * np.outer(normal, normal))
        (a, b, _), (_, d, _), (_, _, g) = moduli * t**3 / 12
        shear = 5 / 6 * STEEL.shear_modulus * t
        stiffness = np.array([[a + g, b + g, 0], [b + g, d + g, 0], [0, 0, 0]]) * pi**2
        stiffness += shear * np.array([[1, 0, pi], [0, 1, pi], [pi, pi, 2 * pi**2]])
        stiffness[2, 2] -= stress * t * pi**2
        return np.linalg.det(stiffness) / shear**2

    return brentq(missing, STEEL.yield_stress, 1e3)


@pytest.mark.slow
@pytest.mark.parametrize("theory", ["flow", "deformation"])
def test_a_compressed_plate_buckles_in_the_plastic_range(theory):
    """The bifurcation by flow theory, and with a law of deformation theory the lower one: the plastic paradox."""
    mesh = surface("naghdi-q2", (6, 6), None, (0.5, 0.5))
    law = {"law": DeformationTheory(PLATE, STEEL)} if theory == "deformation" else {}
    shell = fx.Shell(mesh, PLATE, STEEL, **law)
    stress = plate_buckling_stress(theory)
    scene = fx.Scene([shell], [fx.symmetry(mesh, "west", "x"), fx.symmetry(mesh, "south", "y"),
                               fx.Support(mesh, "east", "z rx"), fx.Support(mesh, "north", "z ry")],
                     [fx.EdgeForce(mesh, "east", (-stress * PLATE.thickness, 0.0, 0.0))],
                     fx.Monitor(mesh, "north-east", "x", -1.0))
    record = follow(scene, fx.LoadControl(step=0.3, target=1.1))
    (point,) = record.critical_points
    assert point.kind == "bifurcation" and point.name == "comparison solid" * (theory == "flow")
    assert point.load / (0.5 * stress * PLATE.thickness) == pytest.approx(1.0, rel=2e-3)
