"""Heat, prestress and lack of fit: strains at which parts are free of stress, and what begins out of balance."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np
import pytest
import ufl
from helpers import on_two_processes

import sheetfx as fx

E, A, SECOND, LENGTH = 2.1e11, 0.01, 0.1**4 / 12, 10.0
HOT = 100.0, 1e-5  # change of temperature, expansion
HEAT = HOT[0] * HOT[1]


def column(held="x y rz", monitored="y", joints=False, material=None, loads=None):
    mesh = fx.read(lambda: fx.meshes.frame({"a": (0, 0), "m": (LENGTH / 2, 0), "b": (LENGTH, 0)},
                                           {"l": ("a", "m", 8), "r": ("m", "b", 8)}), 2)
    beam = fx.Beam(mesh, fx.Rectangle(0.1, 0.1), material or fx.Elastic(E))
    load = loads(beam) if loads else fx.Temperature(beam, *HOT)
    springs = [fx.Spring(mesh, "b", "x", E * A)] if joints else []
    return beam, fx.Scene([beam], [fx.clamp(mesh, "a"), fx.Support(mesh, "b", held)], [load],
                          fx.Monitor(mesh, "m", monitored), joints=springs)


@pytest.mark.parametrize("control", [fx.ArcLength(), fx.LoadControl(), fx.ArcLength(shape="spherical")], ids=str)
@pytest.mark.slow(quick=1)
def test_heated_column_between_fixed_ends_buckles(control):
    """Nothing moves before it does: N is -EA alpha T, and N (1 + N / GA) that of Euler (Engesser 1891)."""
    beam, scene = column()
    record = fx.trace(fx.Case(scene, control, until=fx.Until(load=0.6)))
    (point,) = record.critical_points
    force, shear = point.load * E * A * HEAT, 5 / 6 * E / 2.6 * A
    assert point.title == "bifurcation point (stable symmetric)"
    euler = 4 * pi**2 * E * SECOND / LENGTH**2
    assert abs(force * (1 + force / shear) / euler - 1) < 1e-4  # 16 cells of degree 2
    assert np.abs(record.forces(beam)[..., 0] / (-0.6 * E * A * HEAT) - 1).max() < 1e-12
    assert abs(record.buckling(record.states[0])[0].load / point.load - 1) < 1e-9
    ends = []
    for branch in record.branches(point):
        *_, last = fx.Path(scene, fx.ArcLength(), fx.Until(load=0.6), start=[branch.start])
        ends.append(last.deflection)
    assert len(ends) == 2 and abs(sum(ends)) < 1e-9 < abs(ends[0])


def test_prestress_that_moves_nothing_and_stiffens_nothing():
    """Two bars alike in a line, held across: their forces are those that are given."""
    mesh = fx.read(lambda: fx.meshes.frame({"a": (0, 0), "m": (1.0, 0), "b": (2.0, 0)},
                                           {"l": ("a", "m", 1), "r": ("m", "b", 1)}), 2)
    bars = fx.Bar(mesh, fx.Rectangle(1.0, 1.0), fx.Elastic(1e6))
    scene = fx.Scene([bars], [fx.pin(mesh, "a"), fx.pin(mesh, "b"), fx.Support(mesh, "m", "y")],
                     [fx.InitialStrain(bars, -1e-3)], fx.Monitor(mesh, "m", "x"))
    record = fx.trace(fx.Case(scene, fx.LoadControl()))
    assert record.forces(bars).ravel() == pytest.approx([1000.0, 1000.0]) and not record.states[-1].deflection


class Heating(fx.Load):
    """Heat as a load of one's own, that does work on the axial strain of a beam."""

    def __init__(self, beam):
        self.beam = beam

    def work(self, fields):
        beam = self.beam
        strains = beam.strains(fields.displacement(beam.mesh), fields.rotation(beam.mesh), beam.frame())
        return fields.factor * E * A * HEAT * fields.vary(strains[0]) * beam.measure()


def test_own_load_that_only_stresses_is_followed_and_one_that_does_nothing_refused():
    _, scene = column(loads=Heating)
    record = fx.trace(fx.Case(scene, until=fx.Until(load=0.6)))
    _, same = column()
    right = fx.trace(fx.Case(same, until=fx.Until(load=0.6)))
    assert record.critical_points[0].load == pytest.approx(right.critical_points[0].load, rel=1e-9)
    beam, scene = column(loads=lambda beam: fx.PointForce(beam.mesh, "a", (1.0, 0.0)))
    with pytest.raises(ValueError, match="does not respond to its loads"):
        fx.trace(fx.Case(scene))


def test_forces_are_those_of_what_is_held():
    beam, scene = column("y rz", "x", joints=True)
    record = fx.trace(fx.Case(scene, until=fx.Until(load=1.0)))
    stiff, spring = E * A / LENGTH, E * A
    assert np.abs(record.forces(beam)[..., 0] / (-E * A * HEAT * spring / (spring + stiff)) - 1).max() < 1e-8
    assert abs(record.critical_points[0].load / 0.361526587 - 1) < 1e-6
    assert record.balance().untold == ("initial strain does not tell its work",)


def test_plastic_bar_flows_when_heated():
    """The rise of the yield stress with plastic strain: sigma = s0 + H (alpha T - sigma / E)."""
    yields, hardening = 100e6, 2e9
    beam, scene = column(material=fx.Plastic(E, 0.3, yield_stress=yields, hardening=hardening))
    record = fx.trace(fx.Case(scene, fx.LoadControl(turn=pi), until=fx.Until(load=1.0)))
    stress = (yields + hardening * HEAT) / (1 + hardening / E)
    assert np.abs(record.forces(beam)[..., 0] / (-A * stress) - 1).max() < 1e-9


@pytest.mark.parametrize("stages", [False, True])
@pytest.mark.slow(quick=1)
def test_two_changes_add_up(stages):
    """Half by temperature and half as a strain, in one stage or in two."""
    def loads(beam):
        return fx.Temperature(beam, HOT[0] / 2, HOT[1])

    beam, scene = column("y rz", "x", joints=True, loads=loads)
    other = fx.InitialStrain(beam, lambda x: [HEAT / 2 + 0 * x[0], 0.0, 0.0])
    scene = (replace(scene, stages=[fx.Stage([other])]) if stages else
             replace(scene, loads=[*scene.loads, other]))
    record = fx.trace(fx.Case(scene, until=fx.Until(load=1.0)))
    _, once = column("y rz", "x", joints=True)
    alone = fx.trace(fx.Case(once, until=fx.Until(load=1.0)))
    assert abs(record.states[-1].deflection - alone.states[-1].deflection) < 1e-9 * LENGTH * HEAT


@pytest.mark.parametrize(("gradient", "direction"), [(1e4, (-1,)), ((1e4, 0.0), (-1, 0)), ((0.0, 1e4), (0, -1))])
@pytest.mark.slow(quick=1)
def test_gradient_bends_to_a_circle_away_from_the_hot_side(gradient, direction):
    """The depth is along y, and the width, tangent x depth, along z."""
    dimension, bend = len(direction) + 1, 1e-5 * 1e4
    rest = (0.0,) * (dimension - 1)
    mesh = fx.read(lambda: fx.meshes.frame({"a": (0.0, *rest), "b": (1.0, *rest)}, {"l": ("a", "b", 4)}), dimension)
    up = {"up": (0, 1, 0)} if dimension == 3 else {}
    beam = fx.Beam(mesh, fx.Rectangle(0.02, 0.01), fx.Elastic(E), **up)
    scene = fx.Scene([beam], [fx.clamp(mesh, "a")], [fx.Temperature(beam, 0.0, 1e-5, gradient)],
                     fx.Monitor(mesh, "b", "x"))
    record = fx.trace(fx.Case(scene, fx.LoadControl()))
    right = [np.sin(bend) / bend - 1, *((1 - np.cos(bend)) / bend * np.array(direction))]
    assert np.abs(record.displacement("b") - right).max() < 1e-7
    assert np.abs(record.forces(beam)).max() < 1e-7 * E * 0.02 * 0.01 * bend


@pytest.mark.slow
def test_held_beam_is_pressed_where_it_is_hot():
    rest = {"a": (0, 0, 0), "m": (0.5, 0, 0), "b": (1, 0, 0)}
    mesh = fx.read(lambda: fx.meshes.frame(rest, {"l": ("a", "m", 1), "r": ("m", "b", 1)}), 3)
    beam = fx.Beam(mesh, fx.Rectangle(0.02, 0.01), fx.Elastic(E), up=(0, 1, 0))
    scene = fx.Scene([beam], [fx.clamp(mesh, "a"), fx.clamp(mesh, "b")],
                     [fx.Temperature(beam, 0.0, 1e-5, (200.0, 300.0))], fx.Monitor(mesh, "m", "y"))
    record = fx.trace(fx.Case(scene, fx.LoadControl()))
    y, z = 0.003, -0.007
    assert np.abs(record.stresses(beam, (y, z)) / (-E * 1e-5 * (200 * y + 300 * z)) - 1).max() < 1e-9


def plate(triangles, cells=4):
    mesh = fx.read(lambda: fx.meshes.rectangle((cells, cells), (1.0, 1.0), triangles), 3, 2)
    shell = fx.Shell(mesh, fx.Plate(0.01), fx.Elastic(E, 0.3))
    edges = [fx.Support(mesh, at, f"x y z {turn}")
             for turn, ends in (("rx", ("west", "east")), ("ry", ("south", "north"))) for at in ends]
    return shell, fx.Scene([shell], edges, [fx.Temperature(shell, *HOT)], fx.Monitor(mesh, "north-east", "rz"))


@pytest.mark.parametrize("triangles", [False, True])
@pytest.mark.slow
def test_heated_plate_buckles(triangles):
    """Simply supported, its edges held in the plane: h^2 pi^2 / (6 (1 + nu) a^2) = alpha T (Timoshenko and Gere)."""
    shell, scene = plate(triangles, cells=8)
    record = fx.trace(fx.Case(scene, fx.ArcLength(), until=fx.Until(load=0.2)))
    (point,) = record.critical_points
    assert abs(point.load * HEAT / (pi**2 * 0.01**2 / (6 * 1.3)) - 1) < 1e-3  # shear flexibility: -6e-4
    assert abs(record.buckling(record.states[0])[0].load / point.load - 1) < 1e-6
    forces, right = record.forces(shell), -record.states[-1].factor * E * HEAT * 0.01 / 0.7
    assert np.abs(forces[..., :2] / right - 1).max() < 1e-9


@pytest.mark.slow
def test_free_plate_with_a_gradient_takes_a_spherical_shape():
    """Without supports that bend it: the hot side outside, no moment within."""
    mesh = fx.read(lambda: fx.meshes.rectangle((4, 4), (1.0, 1.0)), 3, 2)
    shell = fx.Shell(mesh, fx.Plate(0.01), fx.Elastic(E, 0.3))
    scene = fx.Scene([shell], [fx.symmetry(mesh, "west", "x"), fx.symmetry(mesh, "south", "y"),
                               fx.Support(mesh, "south-west", "z")],
                     [fx.Temperature(shell, 0.0, 1e-5, 10.0)], fx.Monitor(mesh, "north-east", "z"))
    record = fx.trace(fx.Case(scene, fx.LoadControl()))
    assert abs(record.states[-1].deflection / (-1e-5 * 10.0 * (1 + 1) / 2) - 1) < 1e-4
    moments = record.forces(shell)[..., 3:6]
    assert np.abs(moments).max() < 1e-4 * E * 0.01**3 / 12 * 1e-4


@pytest.mark.slow
def test_load_of_a_heated_plate_has_an_error_bar_and_a_gradient():
    shell, scene = plate(False)
    record = fx.trace(fx.Case(scene, fx.ArcLength(), until=fx.Until(load=0.2)))
    (point,) = record.critical_points
    (bar,) = record.error_bars([point])
    _, finer = plate(False, cells=12)
    (right,) = fx.trace(fx.Case(finer, fx.ArcLength(), until=fx.Until(load=0.2))).critical_points
    assert 0.7 < bar.error / (point.load - right.load) < 1.4
    slope = record.gradient(point, lambda t: fx.remade(scene, {shell: replace(shell, section=fx.Plate(t))}), at=0.01)
    assert abs(slope * 0.01 / point.load - 2) < 5e-3  # the load goes with the square of the thickness


@pytest.mark.slow
def test_strip_of_two_metals():
    """Timoshenko 1925: a circle, with layers that press and pull each other without resultants."""
    alpha, moduli, thick, hot = (2e-5, 1e-5), (70e3, 210e3), (0.4, 0.6), 50.0
    mesh = fx.read(lambda: fx.meshes.rectangle((8, 1), (20.0, 1.0)), 3, 2)
    plies = fx.Laminate([fx.Ply(t, 0.0, e, e, 0.3, e / 2.6, expansion=(a, a))
                         for t, e, a in zip(thick, moduli, alpha, strict=True)])
    shell = fx.Shell(mesh, plies, axis=(1, 0, 0))
    held = [fx.symmetry(mesh, "west", "x"), fx.Support(mesh, "south-west", "y z"), fx.Support(mesh, "north-west", "z")]
    scene = fx.Scene([shell], held, [fx.Temperature(shell, hot)], fx.Monitor(mesh, "south-east", "z"))
    record = fx.trace(fx.Case(scene, fx.LoadControl()))
    m, n, whole = thick[0] / thick[1], moduli[0] / moduli[1], sum(thick)
    bend = 6 * (alpha[1] - alpha[0]) * hot * (1 + m) ** 2 / (
        whole * (3 * (1 + m) ** 2 + (1 + m * n) * (m**2 + 1 / (m * n))))
    assert abs(record.linear().displacement("south-east")[2]) == pytest.approx(abs(bend) * 20**2 / 2, rel=2e-3)
    assert np.abs(record.forces(shell)).max() < 1e-3 * moduli[1] * 1e-5 * hot
    places = np.linspace(-0.499, 0.499, 2001)
    stress = np.array([record.stresses(shell, z)[0, 0, 0] for z in places])
    assert np.abs(stress).max() > 5.0 and abs(np.trapezoid(stress, places)) < 0.02 * np.abs(stress).max()
    assert abs(np.trapezoid(stress * places, places)) < 0.01 * np.abs(stress).max()
    (low, high), step = (record.stresses(shell, z)[0, 0, 0] for z in (-0.1001, -0.0999)), alpha[0] - alpha[1]
    strains = [s * (1 - 0.3) / e for s, e in zip((low, high), moduli, strict=True)]
    assert strains[1] - strains[0] == pytest.approx(step * hot, rel=1e-2)
    with pytest.raises(ValueError, match="Ply: expansion is None"):
        fx.Temperature(replace(shell, section=fx.Laminate([fx.Ply(1.0, 0.0, 1.0, 1.0, 0.3, 0.4)])), hot)
    with pytest.raises(ValueError, match="the part has no plies"):
        fx.Temperature(column()[0], hot)


def net(shift=0.0, at_once=True, strain=-1e-3, loads=()):
    """Four cables from the middle of a cross, one of them tighter by `shift`."""
    ends = {"o": (0, 0, 0), "a": (2, 0, 0), "b": (-2, 0, 0), "c": (0, 2, 0), "d": (0, -2, 0)}
    mesh = fx.read(lambda: fx.meshes.frame(ends, {f"o{x}": ("o", x, 1) for x in "abcd"}), 3)
    cables = [fx.Bar(mesh, fx.Rectangle(1.0, 1.0), fx.Elastic(1e5), group=f"o{x}") for x in "abcd"]
    tight = fx.Stage([fx.InitialStrain(c, strain - shift * (c is cables[0])) for c in cables], "prestress",
                     at_once=at_once)
    return cables, fx.Scene(cables, [fx.pin(mesh, x) for x in "abcd"], [fx.PointForce(mesh, "o", (0, 0, 100.0))],
                            fx.Monitor(mesh, "o", "x" if shift else "z"), stages=[tight])


def test_prestressed_net():
    """Equilibrium of its node: P = 4 EA ((l - L) / L + e) w / l."""
    _, scene = net()
    record = fx.trace(fx.Case(scene, fx.LoadControl()))
    for state in record.states:
        long = np.hypot(2, state.deflection)
        force = 4e5 * ((long - 2) / 2 + 1e-3) * state.deflection / long
        assert abs(force - (state.load if state.stage else 0.0)) < 1e-6
    with pytest.raises(ValueError, match="move freely.*at_once=True"):
        fx.Path(net(at_once=False)[1])


def test_a_net_out_of_balance_begins_where_it_is_in_balance():
    cables, scene = net(shift=1e-3)
    record = fx.trace(fx.Case(scene, fx.LoadControl(), until=fx.Until(steps=0)))
    record.show(record.states[0])
    forces = [float(record.forces(cable)[0, 0, 0]) for cable in cables]
    u = record.states[0].deflection
    side = 1e5 * (np.hypot(2, u) / 2 - 1 + 1e-3) * u / np.hypot(2, u)
    assert forces[0] - forces[1] == pytest.approx(2 * side, abs=1e-5)
    assert record.states[0].deflection == pytest.approx(1e-3 * 1e5 / (2 * 1e5 / 2 + 2 * 1e5 * 1e-3 / 2), rel=1e-2)


def test_stress_of_an_own_law_at_rest_is_brought_into_balance():
    """u = (P - N0) / (EA 1.5), and the energy of what the load adds balances."""
    mesh = fx.read(lambda: fx.meshes.frame({"a": (0, 0), "m": (1.0, 0), "b": (3.0, 0)},
                                           {"l": ("a", "m", 1), "r": ("m", "b", 1)}), 2)
    bars = [fx.Bar(mesh, fx.Rectangle(0.01, 0.01), fx.Elastic(2e7), group="l",
                   law=lambda e, k: ufl.as_vector([k[0] * e[0] + 50.0])),
            fx.Bar(mesh, fx.Rectangle(0.01, 0.01), fx.Elastic(2e7), group="r")]
    scene = fx.Scene(bars, [fx.pin(mesh, "a"), fx.pin(mesh, "b"), fx.Support(mesh, "m", "y")],
                     [fx.PointForce(mesh, "m", (1.0, 0))], fx.Monitor(mesh, "m", "x"))
    with pytest.warns(UserWarning, match="out of balance by forces of 50 in all"):
        record = fx.trace(fx.Case(scene, fx.LoadControl(0.5)))
    assert [s.deflection for s in record.states] == pytest.approx([-50 / 3000, -49.5 / 3000, -49 / 3000], rel=1e-9)
    assert not record.balance().broken


@pytest.mark.slow
def test_initial_stress_of_beams_and_shells():
    """What is held keeps it, what is free lets it go; a held shell has what is given, coupled plies too."""
    beam, scene = column(loads=lambda part: fx.InitialStress(part, (-1e5, 0.0, 50.0)))
    record = fx.trace(fx.Case(scene, fx.LoadControl()))
    assert record.forces(beam).reshape(-1, 3) == pytest.approx(np.tile([-1e5, 0.0, 50.0], (32, 1)), rel=1e-3, abs=1e-3)
    ply = {"along": 25e9, "across": 1e9, "poisson": 0.25, "shear": 0.5e9}
    mesh = fx.read(lambda: fx.meshes.rectangle((2, 2)), 3, 2)
    plies = fx.Laminate([fx.Ply(0.001, 0.0, **ply), fx.Ply(0.001, 90.0, **ply)])
    shell = fx.Shell(mesh, plies, axis=(1, 0, 0))
    edges = [fx.clamp(mesh, at) for at in ("west", "east", "south", "north")]
    given = (2e3, 1e3, 0.0, 0.5, 0.2, 0.0, 0.0, 0.0, 0.0)
    held = fx.trace(fx.Case(fx.Scene([shell], edges, [fx.InitialStress(shell, given)],
                                     fx.Monitor(mesh, mesh.name_points("middle", (0.5, 0.5, 0.0)), "z")),
                            fx.LoadControl()))
    assert held.forces(shell).reshape(-1, 9) == pytest.approx(np.tile(given, (16, 1)), abs=1e-6 * 2e3)


def test_weight_from_density():
    """q L^2 / 8 by 7850 kg/m3 of a beam, of a shell of plies and of bars; the load is the weight."""
    heavy, g = fx.Elastic(E, 0.3, 7850.0), 9.81
    mesh = fx.read(lambda: fx.meshes.frame({"a": (0, 0), "m": (1, 0), "b": (2, 0)},
                                           {"l": ("a", "m", 4), "r": ("m", "b", 4)}), 2)
    beam = fx.Beam(mesh, fx.Rectangle(0.1, 0.1), heavy)
    scene = fx.Scene([beam], [fx.pin(mesh, "a"), fx.Support(mesh, "b", "y")], [fx.Gravity(beam, (0.0, -g))],
                     fx.Monitor(mesh, "m", "y"))
    record = fx.trace(fx.Case(scene, until=fx.Until(steps=0)))
    linear = record.linear()
    moment = record.value_at(beam, linear.forces(beam), "m")[2]
    assert abs(moment) == pytest.approx(7850 * 0.01 * g * 2**2 / 8, rel=0.02)  # along the line through two points
    assert linear.load == pytest.approx(7850 * 0.01 * g * 2)
    sheet = fx.read(lambda: fx.meshes.rectangle((2, 2)), 3, 2)
    ply = {"along": 25e9, "across": 1e9, "poisson": 0.25, "shear": 0.5e9}
    plies = fx.Laminate([fx.Ply(0.001, 0.0, **ply, density=1500.0), fx.Ply(0.002, 0.0, **ply, density=2000.0)])
    shell, held = fx.Shell(sheet, plies, axis=(1, 0, 0)), fx.clamp(sheet, "west")
    hung = fx.trace(fx.Case(fx.Scene([shell], [held], [fx.Gravity(shell, (0.0, 0.0, -g))],
                                     fx.Monitor(sheet, "north-east", "z")), until=fx.Until(steps=0))).linear()
    assert hung.load == pytest.approx(5.5 * g) and hung.reaction(held)[2] == pytest.approx(5.5 * g, rel=1e-6)
    with pytest.raises(ValueError, match="Gravity: the Beam on group 'all' has no density; give its material one"):
        fx.Gravity(column()[0], (0.0, -g))


@pytest.mark.slow
def test_what_is_free_or_turned_is_the_same():
    """An offset changes nothing of a body that expands alike; a column that lies otherwise buckles at the same heat."""
    mesh = fx.read(lambda: fx.meshes.rectangle((3, 3)), 3, 2)
    shell = fx.Shell(mesh, fx.Plate(0.01), fx.Elastic(E, 0.3), offset=0.05)
    free = fx.trace(fx.Case(fx.Scene([shell], [], [fx.Temperature(shell, *HOT)], fx.Monitor(mesh, "north-east", "x")),
                            fx.LoadControl()))
    assert np.abs(free.forces(shell)).max() < 1e-9 * E * 0.01 * HEAT

    def turned(angle):
        way = np.array([np.cos(angle), np.sin(angle), 0.0])
        line = fx.read(lambda: fx.meshes.frame({n: tuple(d * way) for n, d in (("a", 0), ("m", 5), ("b", 10))},
                                               {"l": ("a", "m", 4), "r": ("m", "b", 4)}), 3)
        beam = fx.Beam(line, fx.Rectangle(0.1, 0.12), fx.Elastic(E))
        scene = fx.Scene([beam], [fx.clamp(line, "a"), fx.clamp(line, "b")], [fx.Temperature(beam, *HOT)],
                         fx.Monitor(line, "m", "z"))
        return [p.load for p in fx.trace(fx.Case(scene, until=fx.Until(load=0.6))).critical_points]

    assert turned(0.0) == pytest.approx(turned(0.7), rel=1e-8) and len(turned(0.0)) == 2


@pytest.mark.slow
def test_tight_membrane_sounds():
    """sqrt(2) / 2a sqrt(n / m) for a square one, whose bending stiffness is nothing beside its tension."""
    mesh = fx.read(lambda: fx.meshes.rectangle((8, 8)), 3, 2)
    shell = fx.Shell(mesh, fx.Plate(1e-4), fx.Elastic(1e9, 0.3, 1000.0))
    tight = fx.Stage([fx.InitialStress(shell, (100.0, 100.0, *7 * [0.0]))], at_once=True)
    scene = fx.Scene([shell], [fx.Support(mesh, at, "x y z") for at in ("west", "east", "south", "north")],
                     [fx.SurfaceForce(shell, (0, 0, 1.0))],
                     fx.Monitor(mesh, mesh.name_points("middle", (0.5, 0.5, 0.0)), "z"), stages=[tight])
    record = fx.trace(fx.Case(scene, until=fx.Until(steps=0)))
    (first,) = record.frequencies(record.states[0], 1)
    assert first.frequency == pytest.approx(np.sqrt(2) / 2 * np.sqrt(1000), rel=1e-4)


@pytest.mark.slow
def test_on_two_processes_and_resumed():
    script = """
from test_initial_strain import column, fx
beam, scene = column("y rz", "x", joints=True)
record = fx.trace(fx.Case(scene, until=fx.Until(load=0.5)))
print(record.states[-1].deflection, record.critical_points[0].load)
"""
    moved, load = map(float, on_two_processes(script)[0].split())
    _, scene = column("y rz", "x", joints=True)
    first = list(fx.Path(scene, fx.ArcLength(), fx.Until(load=0.2)))
    *_, last = path = list(fx.Path(scene, fx.ArcLength(), fx.Until(load=0.5), start=first))
    points = [point for state in path for point in state.critical]
    assert last.deflection == pytest.approx(moved, rel=1e-9)
    assert points[0].load == pytest.approx(load, rel=1e-9)


def test_what_is_refused():
    beam, scene = column()
    other, _ = column()
    cable, *others = net()[0]
    for make, words in ((lambda: replace(scene, loads=[fx.Temperature(other, *HOT)]), "Temperature"),
                        (lambda: fx.Temperature(replace(beam), 1.0, 0.0), "expansion is 0"),
                        (lambda: fx.Temperature(beam, 1.0, 1e-5, (1.0, 2.0)), "gradient"),
                        (lambda: fx.Temperature(cable, 1.0, 1e-5, 1.0), "bars do not bend"),
                        (lambda: fx.InitialStrain(beam, (1e-3,)), "axial, shear and bending"),
                        (lambda: fx.InitialStrain(beam, lambda x: 1e-3), "InitialStrain"),
                        (lambda: fx.Stage([fx.InitialStrain(cable, 1.0)], control=fx.LoadControl(), at_once=True),
                         "at_once is True")):
        with pytest.raises(ValueError, match=words):
            make()
    like = replace(beam)
    with pytest.raises(ValueError, match="no part of the scene"):
        replace(scene, loads=[fx.Temperature(like, *HOT)])
    own = fx.Bar(cable.mesh, cable.section, cable.material, group="oa",
                 strains=lambda *fields: ufl.as_vector(2 * [fx.forms.bar.engineering(*fields)[0]]),
                 law=lambda e, k: ufl.as_vector([k[0] * e[0], k[0] * e[1]]))
    with pytest.raises(ValueError, match="has 2 strains"):
        fx.Path(fx.Scene([own, *others], [fx.pin(own.mesh, x) for x in "abcd"], [fx.InitialStrain(own, 1e-3)],
                         fx.Monitor(own.mesh, "o", "x")))
