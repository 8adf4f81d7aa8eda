"""Contact and friction by steps of any length, control and stiffness, against closed forms and other solutions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from test_pair_contact import stacked

import sheetfx as fx

UNIT = 1e-2


def node_on_a_rough_floor():
    """A node on a floor with the coefficient 1.5, on bars of the stiffness [[.6, .5], [.5, .6]], pressed down by 1.

    Pushed sideways by F it sticks to F = 1.5, slips by F = 1.5 - .15 u to 1.2 at u = 2, and opens (Klarbring 1990).
    """
    length, slope = 10.0, 10.0 / 2**0.5
    ends = {"dia end": (slope, slope), "ver end": (0.0, length), "hor end": (length, 0.0)}
    mesh = fx.read(lambda: fx.meshes.frame({"n": (0.0, 0.0), **ends}, {end[:3]: ("n", end, 1) for end in ends}), 2)
    bars = [fx.Bar(mesh, fx.Rectangle(1.0, 1.0), fx.Elastic(stiffness * length), group=group)
            for group, stiffness in (("dia", 1.0), ("ver", 0.1), ("hor", 0.1))]
    touch = fx.ObstacleContact(mesh, "n", fx.RigidPlane((0.0, 0.0), (0.0, 1.0)), distance=0.0, friction=1.5,
                               stiffness=1e3, tangential=1e3)
    pressed = fx.Stage([fx.PointForce(mesh, "n", (0.0, -UNIT))], control=fx.LoadControl(1.0, fixed=True))
    return fx.Scene(bars, [fx.pin(mesh, end) for end in ends], [fx.PointForce(mesh, "n", (-UNIT, 0.0))],
                    fx.Monitor(mesh, "n", "x", -1.0), joints=[touch], stages=[pressed])


@pytest.mark.silent("t03")
@pytest.mark.parametrize("control", [fx.ArcLength(), fx.ArcLength(5e-4), fx.DisplacementControl(),
                                     fx.DisplacementControl(0.002)], ids=["arc", "short arc", "moved", "moved less"])
@pytest.mark.slow(quick=1)
def test_limit_points_of_friction_lie_within_steps(control):
    """Corners are found to a fiftieth of a step: within 1 %."""
    record = fx.trace(fx.Case(node_on_a_rough_floor(), control, fx.Until(deflection=3.5 * UNIT)))
    assert [point.name for point in record.critical_points] == ["maximum", "minimum"]
    assert [point.load / UNIT for point in record.critical_points] == pytest.approx([1.5, 1.2], rel=1e-2)
    assert record.states[-1].load / UNIT == pytest.approx(1.2 + (3.5 - 2) * (0.6 - 0.25 / 0.6), rel=1e-2)


@pytest.mark.silent("t03")
@pytest.mark.slow
def test_load_control_stops_where_friction_gives_way():
    """At 1.5, but for what the stiffness of contact rounds."""
    with pytest.raises(fx.PathFailure) as failure:
        fx.trace(fx.Case(node_on_a_rough_floor(), fx.LoadControl(0.05, target=1.6)))
    assert 1.45 < failure.value.record.states[-1].load / UNIT < 1.5 * (1 + 1e-4)


def inclined(step, fixed, **how):
    """Friction force on the tip of a clamped, inclined beam that is pressed on a rough plane, and the pressing one."""
    mesh = fx.read(lambda: fx.meshes.frame({"a": (0, 0.3), "t": (1.0, 0.0)}, {"p": ("a", "t", 8)}), 2, 2)
    beam = fx.Beam(mesh, fx.Rectangle(0.1, 0.05), fx.Elastic(1.2e5, 0.3))
    touch = fx.ObstacleContact(mesh, None, fx.RigidPlane((1.0, -0.025), (0, 1.0)), samples=3, friction=0.3, **how)
    scene = fx.Scene([beam], [fx.clamp(mesh, "a")], [fx.PointForce(mesh, "t", (0.6, -2.0))], fx.Monitor(mesh, "t", "x"),
                     joints=[touch])
    record = fx.trace(fx.Case(scene, fx.LoadControl(step, fixed=fixed)))
    held = record.reactions("a").force[record.states[-1].step]
    return np.array([-(held[0] + 0.6), 2.0 - held[1]])


@pytest.mark.silent("t09")
@pytest.mark.slow
def test_friction_does_not_depend_on_steps_and_stiffness():
    """What a point moves before it touches is no slip, and what sticks does not creep: within two percent,
    as a ten-thousandth of a cell of slip is left where points stick.

    The force was -0.34 by steps of 0.1 and -0.0175 by those of 0.005, which is what creeping left of it.
    """
    fine = inclined(0.01, True)
    assert -fine[0] < 0.3 * fine[1]
    for other in (inclined(0.1, True), inclined(0.1, False), inclined(0.05, True, stiffness=1e4)):
        assert other == pytest.approx(fine, rel=2e-2)


@pytest.mark.parametrize("control", [fx.LoadControl(0.05, target=0.3), fx.LoadControl(0.05, target=0.3, fixed=True)])
@pytest.mark.parametrize("enforcement", ["condensed", "uzawa"])
@pytest.mark.slow(quick=1)
def test_a_tip_begins_to_slide(control, enforcement):
    """A rod is pressed on a bar by 0.01 and drawn: friction times that, less what its spring takes as the bar bends.

    A fixed step that is cut where slip begins grows again.
    """
    bar = fx.read(lambda: fx.meshes.frame({"p": (-1, 0), "q": (0.5, 0)}, {"bar": ("p", "q", 6)}), 2)
    rod = fx.read(lambda: fx.meshes.frame({"top": (0, 0.5), "tip": (0, 0.05)}, {"rod": ("top", "tip", 1)}), 2)
    beams = [fx.Beam(mesh, fx.Rectangle(0.05, 0.05), fx.Elastic(2e7, 0.0)) for mesh in (bar, rod)]
    touch = fx.PairContact(rod, "tip", (bar, None), toward=(0, -1.0), reach=0.1, friction=0.3, enforcement=enforcement)
    pressed = fx.Stage([fx.PointForce(rod, "top", (0.0, -0.01))], control=fx.LoadControl(1.0, fixed=True))
    scene = fx.Scene(beams, [fx.clamp(bar, "p"), fx.Support(rod, "top", "rz")],
                     [fx.PrescribedDisplacement(rod, "top", "x", 1.0)], fx.Monitor(rod, "top", "x"),
                     joints=[touch, fx.Spring(rod, "top", "y", 0.1)], stages=[pressed])
    record = fx.trace(fx.Case(scene, control, fx.Until(steps=60)))
    assert record.states[-1].deflection == pytest.approx(0.3)
    assert record.states[-1].load == pytest.approx(2.971e-3, rel=1e-3)


@pytest.mark.slow
def test_a_strip_slips_to_and_fro():
    """Shear lag with friction: 1 pulled, 1/2 let go, -1 pushed, 1 again, in F^2 / (2 EA mu q), on twenty cells.

    Slip ends within a cell, of twelve that slip: within 0.6 % of what is pulled out. Of these six slip where it is let
    go, so that the half is as far off: 0.5042 and 0.5034 by two sequences of steps, 0.5011 and 0.5016 on 40 and 80
    cells.
    """
    force, modulus, depth, rough, press = 0.6, 1e4, 0.01, 0.5, 2.0
    mesh = fx.read(lambda: fx.meshes.frame({"a": (0, 0), "b": (1.0, 0)}, {"s": ("a", "b", 20)}), 2, order=2)
    strip = fx.Beam(mesh, fx.Rectangle(1.0, depth), fx.Elastic(modulus, 0.0))
    touch = fx.ObstacleContact(mesh, None, fx.RigidPlane((0.0, -depth / 2), (0.0, 1.0)), friction=rough, stiffness=1e4)
    pressed = fx.Stage([fx.LineForce(strip, (0.0, -press))], control=fx.LoadControl(1.0, fixed=True))
    scene = fx.Scene([strip], [], [fx.PointForce(mesh, "b", (force, 0.0))], fx.Monitor(mesh, "b", "x"),
                     joints=[touch, fx.Spring(mesh, "b", "x", 1e-3)], stages=[pressed])
    states, found = [], []
    for target in (1.0, 0.0, -1.0, 1.0):
        states = list(fx.trace(fx.Case(scene, fx.LoadControl(0.1, target=target)), start=states).states)
        found.append(states[-1].deflection * 2 * modulus * depth * rough * press / force**2)
    assert found == pytest.approx([1.0, 0.5, -1.0, 1.0], abs=6e-3)


@pytest.mark.parametrize("thickness, modulus, weight", [(1e-4 / 0.297, 3e9, 0.785), (1e-3, 2.1e11, 77.0),
                                                        (5e-3, 5e6, 55.0)], ids=["paper", "steel", "rubber"])
@pytest.mark.slow(quick=1)
def test_a_sheet_lies_on_a_floor(thickness, modulus, weight):
    """Under its own weight it does not move, but for a millionth of a cell, and presses as much as it weighs."""
    mesh = fx.read(lambda: fx.meshes.rectangle((4, 4), (1.0, 1.0)), 3, 2)
    sheet = fx.Shell(mesh, fx.Plate(thickness), fx.Elastic(modulus, 0.3), form="naghdi-q2")
    touch = fx.ObstacleContact(mesh, None, fx.RigidPlane((0.0, 0.0, -thickness / 2), (0.0, 0.0, 1.0)))
    scene = fx.Scene([sheet], [fx.Support(mesh, "west", "x"), fx.Support(mesh, "south", "y")],
                     [fx.SurfaceForce(sheet, (0.0, 0.0, -weight))], fx.Monitor(mesh, "north-east", "z"), joints=[touch])
    record = fx.trace(fx.Case(scene, fx.LoadControl()))
    record.show(record.states[-1])
    pairs = record.pairs(touch)
    assert pairs.weight @ pairs.pressure == pytest.approx(weight, rel=1e-6)
    assert abs(record.states[-1].deflection) < 1e-6 / 4


def lifted_corner(thickness, modulus, weight, height=None, stiffness=None):
    """A sheet that lies on a floor, one corner of which is lifted, by a thousandth of its weight or a height."""
    mesh = fx.read(lambda: fx.meshes.rectangle((4, 4), (1.0, 1.0)), 3, 2)
    sheet = fx.Shell(mesh, fx.Plate(thickness), fx.Elastic(modulus, 0.3), form="naghdi-q2")
    floor = fx.RigidPlane((0.0, 0.0, -thickness / 2), (0.0, 0.0, 1.0))
    scene = fx.Scene([sheet], [fx.Support(mesh, "west", "x"), fx.Support(mesh, "south", "y")],
                     [fx.PointForce(mesh, "north-east", (0.0, 0.0, 1e-3 * weight))],
                     fx.Monitor(mesh, "north-east", "z"),
                     joints=[fx.ObstacleContact(mesh, None, floor, stiffness=stiffness)],
                     stages=[fx.Stage([fx.SurfaceForce(sheet, (0.0, 0.0, -weight))])])
    control = fx.DisplacementControl(height / 4) if height else fx.LoadControl(0.25)
    return fx.Case(scene, control, fx.Until(deflection=height, steps=40))


@pytest.mark.parametrize("thickness, modulus, weight", [(1e-3, 2.1e11, 77.0), (5e-3, 5e6, 55.0)],
                         ids=["steel", "rubber"])
@pytest.mark.slow(quick=1)
def test_a_corner_is_lifted_off_a_floor(thickness, modulus, weight):
    """It rises evenly, and as far with soft contact as with stiff: less than a thousandth of a cell."""
    lifted = []
    for stiffness in (None, 10 * modulus * thickness):
        states = fx.trace(lifted_corner(thickness, modulus, weight, stiffness=stiffness)).states
        lifted.append(states[-1].deflection)
        assert states[-1].load == pytest.approx(1e-3 * weight)
        assert all(s.deflection == pytest.approx(s.factor * lifted[-1], rel=5e-3) for s in states if s.stage == 1)
    assert lifted[0] == pytest.approx(lifted[1], rel=5e-3)


def test_a_force_lifts_a_corner_as_its_height():
    """From a hundred thousandth of a cell on: what penetrates, of which a millionth is allowed, is no motion."""
    heights = 2e-6, 2e-4
    low, high = (fx.trace(lifted_corner(5e-3, 5e6, 55.0, height)).states[-1].load / height for height in heights)
    assert low == pytest.approx(high, rel=1e-3)


def landing(control, law):
    """A cantilever that lands on a floor at the distance d under an even load q, and what its clamp bears at the end.

    It lies flat from a on, a^4 = 72 EI d / q, and the clamp bears 2/3 q a.
    """
    modulus, depth, width, length, distance, free = 2e5, 2.0, 10.0, 400.0, 5.0, 150.0
    mesh = fx.read(lambda: fx.meshes.frame({"a": (0.0, 0.0), "e": (length, 0.0)}, {"s": ("a", "e", 40)}), 2)
    beam = fx.Beam(mesh, fx.Rectangle(width, depth), fx.Elastic(modulus, 0.0))
    floor = fx.RigidPlane((0.0, -distance - depth / 2), (0.0, 1.0))
    touch = {"contacts": [fx.Contact(beam, floor)]} if law else {"joints": [fx.ObstacleContact(mesh, None, floor)]}
    most = 72 * modulus * width * depth**3 / 12 * distance / free**4
    scene = fx.Scene([beam], [fx.clamp(mesh, "a")], [fx.LineForce(beam, (0.0, -most))],
                     fx.Monitor(mesh, "e", "y", -1.0), **touch)
    return fx.Case(scene, control, fx.Until(load=most * length, steps=60)), 2 / 3 * most * free


@pytest.mark.parametrize("control", [fx.ArcLength(), pytest.param(fx.LoadControl(0.1), marks=pytest.mark.slow)],
                         ids=["arc", "loaded"])
@pytest.mark.parametrize("law", [False, True], ids=["obstacle", "law"])
@pytest.mark.slow(quick=1)
def test_a_cantilever_lands_on_a_floor(control, law):
    """Where its tip touches the load grows tenfold while the step's length, which displacements make, does not."""
    case, borne = landing(control, law)
    record = fx.trace(case)
    last = record.states[-1]
    assert last.factor == pytest.approx(1.0)
    assert record.reactions("a").force[last.step][1] == pytest.approx(borne, rel=2e-3)


@pytest.mark.parametrize("control, friction", [
    (fx.DisplacementControl(0.005), 0.0), (fx.DisplacementControl(0.005), 0.01),
    pytest.param(fx.LoadControl(0.1), 0.0, marks=pytest.mark.slow),
    pytest.param(fx.ArcLength(), 0.0, marks=pytest.mark.slow)], ids=["moved", "rubbing", "loaded", "arc"])
@pytest.mark.slow(quick=1)
def test_a_heavy_strip_is_lifted_in_its_middle(control, friction):
    """F = 4/3 q l and h = q l^4 / 72 EI (beam of the length 2 l that touches without moment); half of it, in m and N.

    Within 0.5 %: the place where it touches is known to a cell's third. The load rises steeply at first, as the fourth
    root of the height.
    """
    thickness, width, modulus, length = 1e-3, 0.02, 2.1e11, 2.0
    weight, bending = 77e3 * width * thickness, modulus * width * thickness**3 / 12
    mesh = fx.read(lambda: fx.meshes.frame({"m": (0.0, 0.0), "e": (length, 0.0)}, {"s": ("m", "e", 40)}), 2, 2)
    strip = fx.Beam(mesh, fx.Rectangle(width, thickness), fx.Elastic(modulus, 0.0))
    floor = fx.RigidPlane((0.0, -thickness / 2), (0.0, 1.0))
    scene = fx.Scene([strip], [fx.symmetry(mesh, "m")], [fx.PointForce(mesh, "m", (0.0, 1.0))],
                     fx.Monitor(mesh, "m", "y"), joints=[fx.ObstacleContact(mesh, None, floor, friction=friction)],
                     stages=[fx.Stage([fx.LineForce(strip, (0.0, -weight))])])
    last = fx.trace(fx.Case(scene, control, fx.Until(deflection=0.01, steps=200))).states[-1]
    lifted = 3 * 2 * last.load / (4 * weight)
    assert last.deflection == pytest.approx(0.01, rel=1e-6)
    assert last.deflection == pytest.approx(weight * lifted**4 / (72 * bending), rel=5e-3)


@pytest.mark.parametrize("how", [{}, {"points": "nodes"}], ids=["layer", "nodes"])
def test_a_beam_that_lies_on_a_tensionless_foundation(how):
    """Weightless, pressed in its middle: 0.54517 P lambda / k, contact to pi / 2 (Weitsman 1970); it starts closed.

    A penalty's scale is the stiffness of the foundation.
    """
    stiffness, force, depth = 4.0, 0.1, 0.02
    mesh = fx.read(lambda: fx.meshes.frame({"a": (0, 0), "b": (8.0, 0)}, {"s": ("a", "b", 20)}), 2, order=2)
    beam = fx.Beam(mesh, fx.Rectangle(1.0, depth), fx.Elastic(12 / depth**3, 0.0))
    touch = fx.Contact(beam, fx.RigidPlane((0.0, 0.0), (0.0, 1.0)), distance=0.0, enforcement="penalty",
                       scale=stiffness, **how)
    scene = fx.Scene([beam], [fx.symmetry(mesh, "a", "x")], [fx.PointForce(mesh, "a", (0.0, -force / 2))],
                     fx.Monitor(mesh, "a", "y", -1.0), symmetry_factor=2, contacts=[touch])
    last = fx.trace(fx.Case(scene, fx.LoadControl(0.1))).states[-1]
    assert last.deflection == pytest.approx(0.5451657 * force / stiffness, rel=2e-4)


def test_a_penalty_has_one_stiffness():
    mesh = fx.read(lambda: fx.meshes.frame({"a": (0, 0), "b": (8.0, 0)}, {"s": ("a", "b", 2)}), 2)
    with pytest.raises(ValueError, match=r"scale is 4 and layer 0.5.* give one of them"):
        fx.Contact(fx.Beam(mesh, fx.Rectangle(1.0, 0.1), fx.Elastic(1.0)), fx.RigidPlane((0.0, 0.0), (0.0, 1.0)),
                   enforcement="penalty", scale=4.0, layer=0.5)


@pytest.mark.parametrize("stiffness", [None, 1e5])
def test_a_free_wedge_whatever_the_stiffness(stiffness):
    """A wedge of slope 0.5 under the tip of a cantilever, EI = 1/75, moved by 0.2: H = 0.0021818 by the elastica."""
    mesh = fx.read(lambda: fx.meshes.frame({"a": (0, 0), "b": (1, 0)}, {"s": ("a", "b", 8)}), 2, order=2)
    beam = fx.Beam(mesh, fx.Rectangle(0.02, 0.02), fx.Elastic(1e6, 0.0))
    wedge = fx.RigidPlane((1.0, 0.0), (-np.sin(0.5), np.cos(0.5)), travel=(-1.0, 0.0))
    touch = fx.ObstacleContact(mesh, "b", wedge, distance=0.0, stiffness=stiffness)
    scene = fx.Scene([beam], [fx.clamp(mesh, "a")], [fx.ObstacleForce(wedge, 1.0)], fx.Monitor(wedge), joints=[touch])
    last = fx.trace(fx.Case(scene, fx.DisplacementControl(0.01), fx.Until(deflection=0.2))).states[-1]
    assert last.load == pytest.approx(0.0021818, rel=5e-4)


@pytest.mark.silent("t04")
@pytest.mark.parametrize("cells, law", [(20, False), pytest.param(40, False, marks=pytest.mark.slow), (40, True)])
@pytest.mark.slow(quick=1)
def test_an_arch_falls_on_a_floor(cells, law):
    """Extremes of the load by a Fourier series with a point of contact that slides, within 6e-4 (points of contact).

    By a law of contact one step has the minimum and, behind it, the maximum.
    """
    span, rise = 100.0, 1.2
    x = np.linspace(0, span / 2, cells + 1)
    nodes = {f"n{i}": (float(a), float(rise * np.sin(np.pi * a / span))) for i, a in enumerate(x)}
    mesh = fx.read(lambda: fx.meshes.frame(nodes, {f"b{i}": (f"n{i}", f"n{i + 1}", 1) for i in range(cells)}), 2)
    beam = fx.Beam(mesh, fx.Rectangle(1.0, 0.5), fx.Elastic(1e4, 0.0), shear_rigidity=1e3)
    floor = fx.RigidPlane((0.0, -0.3), (0.0, 1.0))
    touch = ({"contacts": [fx.Contact(beam, floor, distance=0.0)]} if law else
             {"joints": [fx.ObstacleContact(mesh, None, floor, distance=0.0, samples=4)]})
    scene = fx.Scene([beam], [fx.pin(mesh, "n0"), fx.symmetry(mesh, f"n{cells}")], [fx.LineForce(beam, (0.0, -4e-4))],
                     fx.Monitor(mesh, f"n{cells}", "y", -1.0), **touch)
    record = fx.trace(fx.Case(scene, fx.ArcLength(), fx.Until(deflection=1.4)))
    found = [point.load for point in record.critical_points]
    assert found[:3] == pytest.approx([0.0252, 0.0034, 0.0133], abs=6e-4)


@pytest.mark.parametrize("enforcement", ["condensed", "penalty"])
@pytest.mark.slow(quick=1)
def test_pairs_that_tension_holds_remember_no_slip(enforcement):
    """Pulled apart elastically and pressed together again they are as where they are pressed at once."""
    scene = stacked(False, enforcement, friction=0.3, cohesion=1e6, strength=1e6, stiffness=10.0, tangential=10.0)
    beam = scene.parts[0]
    scene = replace(scene, monitor=fx.Monitor(beam.mesh, "end", "x"))
    lift = fx.Stage([fx.LineForce(beam, (0.0, 2.0))])
    pulled = replace(scene, loads=[fx.LineForce(beam, (0.5, -3.0))], stages=[lift])
    at_once = replace(scene, loads=[fx.LineForce(beam, (0.5, -1.0))])
    ends = [fx.trace(fx.Case(one, fx.LoadControl(0.25))).states[-1].deflection for one in (pulled, at_once)]
    assert ends[0] == pytest.approx(ends[1], rel=1e-6)


def test_a_crown_that_meets_a_floor_near_its_limit_invents_no_limit_point():
    """Displacements turn back where it touches, by penalty; the load of stable states goes on."""
    case = fx.load_case("roof")(cells=4, thickness=12.7)
    (shell,) = case.scene.parts
    crown = float(shell.mesh.domain.geometry.x[:, 2].max())
    floor = fx.RigidPlane((0.0, 0.0, crown - 8.0 - 12.7 / 2), (0.0, 0.0, 1.0))
    touch = fx.ObstacleContact(shell.mesh, "south", floor, enforcement="penalty", stiffness=1e4)
    scene = replace(case.scene, joints=[*case.scene.joints, touch])
    record = fx.trace(fx.Case(scene, case.control, fx.Until(deflection=15.0)))
    assert record.critical_points == [] and record.states[-1].load > 10 * 2057
