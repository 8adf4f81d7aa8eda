"""Contact between deformable parts at pairs of points: patch tests, tangents, friction, sliding, history."""

from __future__ import annotations

import csv
from itertools import pairwise

import numpy as np
import pytest
from failure_map.traps import TRAPS
from helpers import distance, move_at_random, tangents

import sheetfx as fx
from sheetfx.continuation.state import State
from sheetfx.discrete.discretisation import Discretisation
from sheetfx.discrete.pair_work import pairs_of
from sheetfx.discrete.pairs import friction_work
from sheetfx.scenes import dome
from sheetfx.show.pairs import draw_pairs, pair_history, pair_states

SECTION = {"section": fx.Rectangle(0.1, 0.1), "material": fx.Elastic(1.2e6, 0.0)}


def line(cells, start, end, dimension=2, name="bar"):
    nodes = {"start": start, "end": end}
    return fx.read(lambda: fx.meshes.frame(nodes, {name: ("start", "end", cells)}), dimension)


def works(path_or_discretisation):
    discretisation = getattr(path_or_discretisation, "discretisation", path_or_discretisation)
    return pairs_of(discretisation.system.contributions)


def stacked(moving, enforcement="penalty", dimension=2, **how):
    """A beam on another one of other cells, which lies on an elastic foundation; the upper one is loaded evenly."""
    upper, lower = (line(n, (0.0, y, 0.0)[:3], (1.0, y, 0.0)[:3], dimension) for n, y in ((3, 0.1), (5, 0.0)))
    beams = [fx.Beam(m, **SECTION) for m in (upper, lower)]
    how = {"reach": 0.1} | how
    contact = fx.PairContact(upper, "bar", (lower, None), moving=moving, enforcement=enforcement, **how)
    foundation = fx.Foundation(beams[1], (0.0, 50.0, 0.0)[:dimension])
    down = (0.0, -1.0, 0.0)[:dimension]
    held = {2: ("x rz", "x"), 3: ("x z rx ry rz", "x z rx ry")}[dimension]
    return fx.Scene(beams, [fx.Support(upper, "start", held[0]), fx.Support(lower, "start", held[1])],
                    [fx.LineForce(beams[0], down)], fx.Monitor(upper, "end", "y", -1.0), joints=[contact, foundation])


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_slips_that_are_not_known_are_not_drawn(friction):
    """Without friction there is no slip of zero, and no axes are empty."""
    record = leaf_spring(friction, 0.01)
    above, below = draw_pairs(record, pair_states(record)).subfigs
    assert all(axes.lines for axes in (*above.axes, *below.axes))
    assert ("largest slip" in [line.get_label() for axes in above.axes for line in axes.lines]) == (friction > 0)


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_table_of_pairs_tells_what_each_has_gone_through(friction, tmp_path):
    """Statuses of all states come again from those of the table and the loads where they begin."""
    record = leaf_spring(friction, 0.01)
    pair_history(record, tmp_path)
    with (tmp_path / "pairs.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    kept = np.load(tmp_path / "pairs.npz")
    assert len(rows) == kept["0 status"].shape[1] and len({row["statuses"] for row in rows}) > 1
    for row, status, place in zip(rows, kept["0 status"].T, kept["0 position"][0], strict=True):
        names, loads = row["statuses"].split(), [*map(float, row["loads"].split()), np.inf]
        assert all(one != other for one, other in pairwise(names))
        for name, begin, end in zip(names, loads[:-1], loads[1:], strict=True):
            within = (kept["load"] >= begin - 1e-7) & (kept["load"] < end - 1e-7)
            assert within.any() and (status[within] == name).all()
        assert bool(row["largest_slip"]) == (friction > 0)
        assert [float(row[x]) for x in "xy"] == pytest.approx(place, rel=1e-5)


TIP = pytest.mark.parametrize("friction, load", [(0.0, 356.1400), (0.2, 365.0142)])


def sliding_tip(friction, **how):
    """A cantilever presses its tip on another one that points to it, at one pair of points."""
    upper, lower = (fx.read(lambda places=places, cells=cells: fx.meshes.frame(places, {
        "x": ("start", "middle", cells[0]), "y": ("middle", "end", cells[1])}), 2) for places, cells in (
            ({"start": (0.0, 0.0), "middle": (400.0, 0.0), "end": (500.0, 0.0)}, (12, 4)),
            ({"start": (350.0, -10.0), "middle": (450.0, -10.0), "end": (900.0, -10.0)}, (4, 12))))
    beams = [fx.Beam(mesh, fx.Rectangle(20.0, 8.0), fx.Elastic(2e5, 0.0)) for mesh in (upper, lower)]
    contact = fx.PairContact(upper, ["x", "y"], (lower, None), toward=(0.0, -1.0), reach=420.0, gap=1.0,
                             friction=friction, **how)
    scene = fx.Scene(beams, [fx.clamp(upper, "start"), fx.clamp(lower, "end")],
                     [fx.PointForce(upper, "end", (-0.3, -1.0))], fx.Monitor(upper, "end", "y", -1.0), joints=[contact])
    return fx.Case(scene, until=fx.Until(deflection=30.6403))


@TIP
@pytest.mark.slow(quick=1)
def test_a_tip_that_slides_takes_long_steps(friction, load):
    """A step that is straight opens the pair, and the lower cantilever springs back through the upper one.

    Steps used to be a tenth as long, 150 of them to the deflection at which the load is compared, with that of steps
    shorter still.
    """
    record = fx.trace(sliding_tip(friction))
    assert record.states[-1].load == pytest.approx(load, rel=1e-4)
    assert len(record.states) < 30


@TIP
@pytest.mark.slow(quick=1)
def test_augmented_pressures_do_not_depend_on_the_stiffness_that_is_given(friction, load):
    """Pairs of a five-millionth of the default stiffness, and far softer than the cantilevers.

    Each step used to begin with them anew, as if nothing touched: 181 and 195 factorisations, where the default takes
    some fifty. What the stiffness has become is part of a state.
    """
    case = sliding_tip(friction, enforcement="uzawa", stiffness=0.1)
    record = fx.trace(case)
    assert record.states[-1].load == pytest.approx(load, rel=1e-5)
    assert max(state.penetration for state in record.states) < 1e-4
    assert record.path.tracer.total_factorisations < 80
    again = sliding_tip(friction, enforcement="uzawa", stiffness=0.1)
    rest = list(fx.Path(again.scene, again.control, again.until, start=record.states[:7]))
    assert rest[-1].step == record.states[-1].step
    assert [s.load for s in rest] == pytest.approx([record.states[s.step].load for s in rest], rel=1e-9)


@pytest.mark.parametrize("cells", [7, 24])
@pytest.mark.parametrize("upwards", [False, True])
@pytest.mark.slow(quick=1)
def test_pairs_of_symmetric_parts_are_symmetric(cells, upwards):
    """Where a line is beside two cells, or over both, it used to stay with the one that it came from.

    Pairs of a shallow arch of a thousand with the one below were eight thousandths off, those of the lower one's by a
    cell; arches between which nothing slips left their symmetric path, or not, as steps had it.
    """
    one, other = (shallow_arch(cells, y) for y in ((-30.0, 0.0) if upwards else (0.0, -30.0)))
    contact = fx.PairContact(one, [f"part {n}" for n in range(1, cells - 1)], (other, None), reach=40.0,
                             toward=(0.0, 1.0 if upwards else -1.0))
    places = contact.meeting.sides[0].places
    order = np.argsort(places[:, 0])
    for values, mirrored in ((places[:, 0], 1000.0 - places[:, 0]), (places[:, 1], places[:, 1])):
        assert values[order] == pytest.approx(mirrored[order[::-1]], abs=1e-9)
    assert contact.axes[order, 1, 1] == pytest.approx(-contact.axes[order[::-1], 1, 1], abs=1e-12)


def shallow_arch(cells, height):
    places = {f"{n}": (1000.0 * n / cells, height + 40.0 * np.sin(np.pi * n / cells)) for n in range(cells + 1)}
    lines = {f"part {n}": (f"{n}", f"{n + 1}", 1) for n in range(cells)}
    return fx.read(lambda: fx.meshes.frame(places, lines), 2)


def arch_above_a_beam(enforcement):
    """A shallow arch above a clamped beam that it meets behind its limit, and the arch alone."""
    arch, touched = shallow_arch(20, 0.0), line(10, (300.0, 0.0), (700.0, 0.0))
    beams = [fx.Beam(mesh, fx.Rectangle(20.0, 10.0), fx.Elastic(7e4)) for mesh in (arch, touched)]

    def gap(places):
        return np.interp(places[:, 0], 50.0 * np.arange(21), 40.0 * np.sin(np.pi * np.arange(21) / 20)) - 19.0

    supports = [fx.pin(arch, "0"), fx.pin(arch, "20")]
    loads = [fx.PointForce(arch, "10", (0.0, -1.0))]
    alone = fx.Scene(beams[:1], supports, loads, fx.Monitor(arch, "10", "y", -1.0))
    touch = fx.PairContact(arch, [f"part {n}" for n in range(6, 14)], (touched, None), toward=(0.0, -1.0), gap=gap,
                           reach=50.0, enforcement=enforcement)
    held = [fx.clamp(touched, end) for end in ("start", "end")]
    scene = fx.Scene(beams, [*supports, *held], loads, fx.Monitor(arch, "10", "y", -1.0), joints=[touch])
    return scene, alone


@pytest.mark.parametrize("enforcement", ["condensed", pytest.param("uzawa", marks=pytest.mark.slow)])
def test_an_arch_meets_a_beam_behind_its_limit(enforcement):
    """Its load falls by a per cent from the limit to where it touches, then rises.

    A step that led over both was taken: its ends show no turn of the load, but unstable modes. The limit of the arch
    was called a bifurcation, and the minimum was not seen. What touches later does not change the points before: 1e-6,
    by states that are searched with contact and without.
    """
    scene, alone = arch_above_a_beam(enforcement)
    found, free = (fx.trace(fx.Case(s, until=fx.Until(deflection=to))) for s, to in ((scene, 30.0), (alone, 20.0)))
    before = free.critical_points
    assert [p.name for p in before] == ["unstable symmetric", "maximum"]
    points = [p for p in found.critical_points if p.name != "corner"]
    assert [p.name for p in points] == ["unstable symmetric", "maximum", "minimum"]
    assert [p.load for p in points[:2]] == pytest.approx([p.load for p in before], rel=1e-6)


@pytest.mark.parametrize("moving", [False, True])
def test_constant_pressure_passes(moving):
    record = fx.trace(fx.Case(stacked(moving), fx.LoadControl(1.0, fixed=True)))
    work, = works(record.path)
    state = work.evaluate()
    assert np.abs(state.pressure - 1.0).max() < 1e-9  # of a stiffness of 3e6 times rounding
    assert record.states[-1].deflection == pytest.approx(1 / 50 + 1 / work.pairs.parameters[0], rel=1e-9)


@pytest.mark.parametrize("dimension, moving, friction", [
    (2, True, 1.3), *(pytest.param(*case, marks=pytest.mark.slow) for case in (
        (3, True, 1.3), (2, False, 1.3), (3, False, 1.3), (3, True, 0.0)))])
def test_tangent_is_the_derivative(dimension, moving, friction):
    """Far from equilibrium, partners in other cells than at first, one off the end; with friction not symmetric."""
    scene = stacked(moving, dimension=dimension, friction=friction, stiffness=1e3, tangential=1e3, gap=0.01)
    discretisation = Discretisation(scene, mixed_points=False)
    x = move_at_random(discretisation, size=0.05)
    work, = works(discretisation)
    assert set(work.evaluate().status) == ({"open", "slip", "stick"} if friction else {"open", "slip"})
    with discretisation.system.additive_increments():
        assembled, differences = tangents(discretisation.system, x, 1e-5)
    assert distance(assembled, differences) < 1e-7
    if friction:
        assert distance(assembled.T, differences) > 1e-4


def test_energy_is_that_of_the_forces():
    scene = stacked(True, stiffness=1e3, gap=0.01, strength=5.0)
    system = (discretisation := Discretisation(scene, mixed_points=False)).system
    work, = works(discretisation)
    x = move_at_random(discretisation, size=0.05)
    along, out, energies = system.create_vector(np.sin(np.arange(len(x.array)))), system.create_vector(), []
    along.array[system.fixed_rows] = 0
    with system.additive_increments():
        system.residual_of([work], out)
        for step in (1e-5, -1e-5):
            moved = x.copy()
            moved.axpy(step, along)
            system.configure(moved, system.factor)
            energies.append(work.energy())
    assert (energies[0] - energies[1]) / 2e-5 == pytest.approx(out.dot(along), rel=1e-7)


@pytest.mark.parametrize("arm, depth, step, wavers", [
    (0.0, 0.01, 0.02, 5e-3), pytest.param(0.1, 0.05, 0.01, 6e-3, marks=pytest.mark.slow)])
def test_slides_over_cells_without_a_jolt(arm, depth, step, wavers):
    """A rod pressed into a beam on an elastic foundation slides along ten of its cells.

    The force under a given travel is that of an infinite beam, which does not depend on the place: 2 k / beta for a
    unit of deflection with beta^4 = k / 4 EI (Hetenyi 1946, section 11), in series with the rod and the contact. With
    an arm between the axes the point that is touched jumps wherever the slope of the beam does; Newton's iteration
    stopped at nodes before the curve was smooth there.
    """
    stiffness = 5e3
    bar, rod = line(30, (0.0, 0.0), (3.0, 0.0)), line(1, (1.05, 0.3 + arm), (1.05, arm), name="rod")
    thin = {"section": fx.Rectangle(0.1, 0.1), "material": fx.Elastic(1.2e6, 0.0), "shear_rigidity": 1e7}
    beams = [fx.Beam(m, **thin) for m in (bar, rod)]
    contact = fx.PairContact(rod, "end", (bar, None), toward=(0.0, -1.0), stiffness=1e6, reach=arm)
    scene = fx.Scene(
        beams, [fx.Support(bar, "start", "x"), fx.Support(rod, "start", "rz")],
        [fx.PrescribedDisplacement(rod, "start", "x", 1.0)], fx.Monitor(rod, "start", "x"),
        joints=[contact, fx.Foundation(beams[0], (0.0, stiffness))],
        stages=[fx.Stage([fx.PrescribedDisplacement(rod, "start", "y", -depth)],
                         control=fx.LoadControl(step=1.0, fixed=True))])
    record = fx.trace(fx.Case(scene, fx.LoadControl(step=step, fixed=True)))
    forces = []
    for state in record.states:
        record.show(state)
        forces.append(record.pairs(contact).pressure[0])
    forces = np.array(forces[-round(1 / step):])
    beta = (stiffness / 4 / 10.0) ** 0.25
    spring = 1 / (beta / 2 / stiffness + 1e-6 + 0.3 / 1.2e4)
    assert np.ptp(forces) < wavers * forces.mean()
    assert np.abs(np.diff(forces)).max() < 0.12 * step * forces.mean()
    assert forces.mean() == pytest.approx(depth * spring, rel=5e-3)


@pytest.mark.slow
def test_strip_pressed_on_a_bar():
    """Half of a strip that is pressed through a gap g onto a rigid bar by a load q: force and length of contact.

    Where it touches it is straight; before that it is a beam without moments at its ends whose slope at
    the contact is zero, so that its length a has a^4 = 24 EI g / q. Contact has the pressure q, and the force q a / 2
    at its end. From forces of pairs the length is found by their moment about the middle. (The strip's shear makes
    3e-6, the contact's stiffness 2e-4.)
    """
    half, free, gap, cells = 0.5, 0.25, 1e-3, 50
    load = 24 * gap / free**4
    strip = line(cells, (0.0, 0.1), (half, 0.1))
    nodes = {f"n{i}": (half * i / 8, 0.0) for i in range(9)}
    bar = fx.read(lambda: fx.meshes.frame(nodes, {f"m{i}": (f"n{i}", f"n{i + 1}", 1) for i in range(8)}), 2)
    thin = fx.Beam(strip, fx.Rectangle(1.0, 0.01), fx.Elastic(12e6, 0.0), shear_rigidity=100.0)
    contact = fx.PairContact(strip, "bar", (bar, None), reach=0.1, gap=gap, stiffness=1e8)
    scene = fx.Scene(
        [thin, fx.Beam(bar, fx.Rectangle(1.0, 1.0), fx.Elastic(1e5, 0.0))],
        [fx.Support(strip, "start", "y"), fx.Support(strip, "end", "x rz"),
         *(fx.Support(bar, n, "x y rz") for n in nodes)],
        [fx.LineForce(thin, (0.0, -load))], fx.Monitor(strip, "end", "y", -1.0), joints=[contact])
    pairs = fx.trace(fx.Case(scene, fx.LoadControl(0.25))).pairs(contact)
    forces = pairs.weight * pairs.pressure
    assert forces.sum() == pytest.approx(load * (half - free / 2), rel=2e-3)
    moment = float(forces @ (half - pairs.position[:, 0]))
    assert 2 * moment / (load * half) == pytest.approx(half - free, rel=2e-3)
    touching = pairs.position[pairs.status != "open", 0]
    assert touching.min() == pytest.approx(free, abs=2 * half / cells)


def test_run_killed_as_it_slides_resumes_to_the_same_path(tmp_path):
    case = TRAPS["contact-stick-slip"].case()
    whole = fx.trace(case)
    contact, middle = case.scene.joints[0], len(whole.states) // 2
    whole.show(whole.states[middle])
    assert whole.pairs(contact).status == "slip"
    kept = []
    for state in whole.states[: middle + 1]:
        state.save(tmp_path / "state.npz")
        kept.append(State.load_from(tmp_path / "state.npz"))
    again = TRAPS["contact-stick-slip"].case()
    rest = list(fx.Path(again.scene, again.control, again.until, start=kept))
    assert [s.step for s in rest][-1] == whole.states[-1].step
    for state in rest:
        assert state.load == pytest.approx(whole.states[state.step].load, rel=1e-9)
        assert state.deflection == pytest.approx(whole.states[state.step].deflection, rel=1e-9)


@pytest.mark.parametrize("how, message", [
    ({"gap": -0.1}, "gap is -0.1; it must be zero or positive"),
    ({"friction": -0.2}, "friction is -0.2; it must be zero or positive"),
    ({"stiffness": 0.0}, "stiffness is 0.0; it must be positive"),
    ({"pairs": 0}, "pairs is 0; it must be at least 1"),
    ({"face": "butt"}, "face is 'butt', but the first part is no surface"),
    ({"face": "edge"}, "face is 'edge'; it must be one of seat, butt"),
    ({"enforcement": "exact"}, "enforcement is 'exact'"),
    ({"reach": 0.01}, "0.1 off the part that it is joined to, more than the reach of 0.01"),
    ({"toward": (1.0, 0.0)}, "no direction leads from one part to the other"),
])
def test_wrong_input_is_named(how, message):
    with pytest.raises(ValueError, match=message.replace("(", r"\(")):
        stacked(True, **{"reach": 0.1} | how)


def test_overlap_is_named():
    scene = stacked(True, gap=lambda x: 0.05 - x[:, 0])
    with pytest.raises(ValueError, match=r"overlap by 0.9.* at \(0.9.*move one of them"):
        Discretisation(scene)


def test_friction_takes_the_work_of_its_path():
    """A traction that grows with slip to its bound, then slides on: b^2 / 2 k until there, b times slip from there.

    Where it slips from the beginning, and the pressure grows, it is the mean traction times slip.
    """
    normal, stiffness, friction = 100.0, 4.0, 0.2
    table = np.tile([normal, stiffness, friction, 0.0, 0.0], (3, 1))
    slips = np.array([[0.3, 0.0], [0.0, -2.5], [0.6, 0.8]])
    gaps = np.array([[-0.1, -0.1, -0.05], [-0.1, -0.1, -0.15]])
    bound = friction * normal * 0.1
    before = np.array([[0.0, 0.0], [0.0, 0.0], [0.6, 0.8]])

    def work(slips, before):
        return friction_work(-normal * gaps[:, :len(slips)], slips, before, table[:len(slips)])

    assert work(slips, before) == pytest.approx(
        [1.2**2 / 2 / stiffness, bound**2 / 2 / stiffness + bound * (2.5 - bound / stiffness), 2.0], rel=1e-12)
    back = work(-slips[:1], np.array([[1.2, 0.0]]))
    assert back == pytest.approx([-1.2**2 / 2 / stiffness]), "elastic slip gives it back"


@pytest.mark.slow
def test_light_pressure_does_not_stop_steps():
    """Pairs of a dome that have just touched stick in a range so narrow that Newton's iteration hopped over it.

    The first step of the default length takes 11 factorisations; it took 117, and was a quarter as long.
    """
    case = dome.case(model="contact", divisions=5, form="naghdi-t2", friction=0.2)
    path = fx.Path(case.scene, case.control, fx.Until(steps=1))
    *_, last = path
    assert last.length == path.tracer.first and last.contact_points
    assert path.tracer.total_factorisations < 20


@pytest.mark.parametrize("unit", [1.0, 1e3])
def test_a_point_is_as_stiff_in_all_units(unit):
    """A stub on a short, clamped rod: penetration over its size hangs on neither the unit of length nor that of force.

    The default stiffness is ten times that of a cell of the softer part, EA over the length of its two cells.
    """
    stub, wall = line(1, (0.0, unit), (0.0, 0.0)), line(2, (-unit / 2, 0.0), (unit / 2, 0.0), name="wall")
    beams = [fx.Beam(m, fx.Rectangle(0.1 * unit, 0.1 * unit), fx.Elastic(1.2e6)) for m in (stub, wall)]
    contact = fx.PairContact(stub, "end", (wall, None), toward=(0.0, -1.0))
    scene = fx.Scene(beams, [fx.Support(stub, "start", "x rz"), fx.clamp(wall, "start"), fx.clamp(wall, "end")],
                     [fx.PointForce(stub, "start", (0.0, -unit**2))], fx.Monitor(stub, "start", "y"), joints=[contact])
    record = fx.trace(fx.Case(scene, fx.LoadControl(1.0, fixed=True)))
    record.show(record.states[-1])
    pairs = record.pairs(contact)
    assert pairs.pressure[0] == pytest.approx(unit**2, rel=1e-9)
    assert pairs.gap[0] / unit == pytest.approx(-1.0 / (10 * 1.2e4 / 0.5), rel=1e-9)


def leaf_spring(friction, load, enforcement="penalty"):
    return fx.trace(two_leaves(friction, load, enforcement))


def two_leaves(friction, load, enforcement="penalty"):
    """Two equal leaves clamped at one end touch along their length, without a gap; the upper one's tip is loaded."""
    length, depth = 1.0, 0.05
    upper, lower = (line(n, (0.0, y), (length, y)) for n, y in ((8, depth), (10, 0.0)))
    leaves = [fx.Beam(m, section=fx.Rectangle(0.1, depth), material=fx.Elastic(1.2e6, 0.0)) for m in (upper, lower)]
    touch = fx.PairContact(upper, "bar", (lower, None), friction=friction, reach=0.06, toward=(0.0, -1.0),
                           enforcement=enforcement)
    scene = fx.Scene(leaves, [fx.clamp(m, "start") for m in (upper, lower)],
                     [fx.PointForce(upper, "end", (0.0, -load))],
                     fx.Monitor(upper, "end", "y", -1.0), joints=[touch])
    return fx.Case(scene, until=fx.Until(load=abs(load)))


LEAVES = [1000.0, 800.0, 600.0]


def graded_leaves(cells, friction):
    """Three leaves touch along their length, without a gap; the upper one, which is loaded, is the longest."""
    depth = 8.0
    meshes = [line(cells + n, (0.0, -n * depth), (reach, -n * depth)) for n, reach in enumerate(LEAVES)]
    leaves = [fx.Beam(m, fx.Rectangle(50.0, depth), fx.Elastic(2e5, 0.0)) for m in meshes]
    touch = [fx.PairContact(lower, "bar", (upper, None), reach=2 * depth, friction=friction, toward=(0.0, 1.0))
             for upper, lower in zip(meshes, meshes[1:], strict=False)]
    scene = fx.Scene(leaves, [fx.clamp(m, "start") for m in meshes], [fx.PointForce(meshes[0], "end", (0.0, -1.0))],
                     fx.Monitor(meshes[0], "end", "y", -1.0), joints=touch)
    return fx.Case(scene, until=fx.Until(load=10.0))


@pytest.mark.parametrize("friction", [0.0, 0.3])
@pytest.mark.parametrize("cells", [24, pytest.param(60, marks=pytest.mark.slow)])
@pytest.mark.slow(quick=1)
def test_graded_leaves_on_fine_meshes(cells, friction):
    """They press each other at tips alone (the last pairs are a quarter of a per cent beside these).

    Friction bends them by its arm, half a per cent. Stiff pairs used to open and close by turns, so that no step
    converged; it takes seven factorisations. 60 cells have more pairs than a step may have that is no first one.
    """
    record = fx.trace(graded_leaves(cells, friction))
    tip = _tip_of_leaves(LEAVES, 10.0, friction * 8.0 / 2) / (2e5 * 50.0 * 8.0**3 / 12)
    assert record.states[-1].deflection == pytest.approx(tip, rel=2e-3)
    assert record.path.tracer.total_factorisations < 20


def _tip_of_leaves(lengths, load, arm):
    """Deflection of the first leaf's tip times EI, by slender cantilevers; tractions are `arm` times forces at tips."""
    def by_force(at, there):
        return there**2 * (3 * at - there) / 6 if there <= at else at**2 * (3 * there - at) / 6

    def by_moment(at, there):
        return there**2 / 2 if there <= at else at * (2 * there - at) / 2

    def down(at, there):
        return by_force(at, there) - arm * by_moment(at, there)

    def up(at, there):
        return by_force(at, there) + arm * by_moment(at, there)

    first, second, third = lengths
    alike = [[up(second, second) + down(second, second), -up(third, second)],
             [down(second, third), -up(third, third) - down(third, third)]]
    press, _ = np.linalg.solve(alike, [load * by_force(first, second), 0.0])
    return load * by_force(first, first) - press * up(second, first)


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_leaf_spring(friction):
    """They touch at the tip alone: each leaf carries half of the load.

    Friction bends them by its arm, which takes 3/4 of its coefficient times depth over length off the deflection
    (bending alone; shear adds a thousandth).
    """
    length, depth, load = 1.0, 0.05, 0.05
    last = leaf_spring(friction, load).states[-1]
    bending = load * length**3 / (6 * 1.2e6 * 0.1 * depth**3 / 12)
    assert last.load == pytest.approx(load)
    assert last.deflection == pytest.approx(bending * (1 - 0.75 * friction * depth / length), rel=2e-3)


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_leaves_are_pulled_apart(friction):
    """All pairs open in the first step, one after the other from the tip on: the upper leaf is alone.

    P L^3 / 3 EI + P L / k GA. Newton's iteration opens some pairs in each pass, and was given up before all were open.
    """
    load = 0.05
    last = leaf_spring(friction, -load).states[-1]
    alone = load * (1 / (3 * 1.2e6 * 0.1 * 0.05**3 / 12) + 1 / (5 / 6 * 0.6e6 * 0.1 * 0.05))
    assert last.load == pytest.approx(load) and not last.contact_points
    assert last.deflection == pytest.approx(-alone, rel=1e-3), "geometrical nonlinearity at 0.013"


def test_belt_over_a_drum():
    """A belt of radius r on a quarter of a drum of radius R is pulled at one end: T2 / T1 = exp(mu R / r pi / 2).

    (Eytelwein 1808; here with friction at the axis of the drum.) 5e-3: at half the size of cells it is 2e-3. Nothing
    has slipped before it is pulled: partners were beside those on the smooth curve, by 2e-5, so that all that touched
    seemed to slip, with four unstable modes that were lost again at loads of 1e-8.
    """
    radius, off, friction = 100.0, 1.0, 0.3
    belt, drum = (fx.read(lambda arc=arc: fx.meshes.arc(*arc), 2, 2) for arc in (
        (radius + off, 0.0, np.pi / 2, 24), (radius, -0.4, np.pi / 2 + 0.4, 28)))
    beams = [fx.Beam(mesh, fx.Rectangle(10.0, depth), fx.Elastic(2e5, 0.0)) for mesh, depth in (
        (belt, 0.2), (drum, 400.0))]
    touch = fx.PairContact(belt, "arch", (drum, None), friction=friction, reach=2 * off)
    supports = [fx.pin(belt, "start"), fx.clamp(drum, "start"), fx.clamp(drum, "end")]
    scene = fx.Scene(beams, supports, [fx.PointForce(belt, "end", (0.0, -1.0))], fx.Monitor(belt, "end", "y", -1.0),
                     joints=[touch])
    record = fx.trace(fx.Case(scene, until=fx.Until(load=1000.0)))
    record.show(record.states[0])
    assert np.abs(record.pairs(touch).slip).max() < 1e-12 * radius
    assert record.states[0].unstable_modes == 0 and record.critical_points == []
    held = abs(record.reactions(supports[0]).force[-1, 0])
    assert 1000.0 / held == pytest.approx(np.exp(friction * radius / (radius + off) * np.pi / 2), rel=5e-3)


def test_unloading_has_no_limit_point():
    """Up and down again under a prescribed load: it turns because it is told to, and deflections are the same (1 %)."""
    record = leaf_spring(0.0, 0.05)
    up = record.states[-1]
    back = list(fx.Path(record.case.scene, fx.LoadControl(0.25, target=0.1), start=[up]))
    assert [p for s in [*record.states, *back] for p in s.critical] == []
    assert back[-1].deflection == pytest.approx(0.1 * up.deflection, rel=0.01)


@pytest.mark.parametrize("side, bound", [(-1.0, 1.0), (1.0, 4.0)])
def test_column_beside_a_stop_that_it_touches(side, bound):
    """A little force bends a column away from a stop at its middle, or presses it on: its load, or four times that.

    Away from it the column is a free one: its middle moves by Q L^3 / 48 EI times 3 (tan u - u) / u^3 with
    u = L sqrt(P / EI) / 2 (Timoshenko and Gere 1961, section 1.8).
    """
    nodes = {"base": (0.0, 0.0), "middle": (0.0, 0.5), "top": (0.0, 1.0)}
    column = fx.read(lambda: fx.meshes.frame(nodes, {"a": ("base", "middle", 6), "b": ("middle", "top", 6)}), 2)
    stop = line(1, (0.0, 0.4), (0.0, 0.6), name="stop")
    beams = [fx.Beam(column, fx.Rectangle(0.01, 0.01), fx.Elastic(1.2e9, 0.0)),
             fx.Beam(stop, fx.Rectangle(0.1, 0.1), fx.Elastic(1.2e9, 0.0))]
    touch = fx.PairContact(column, "middle", (stop, None), toward=(1.0, 0.0))
    scene = fx.Scene(beams, [fx.pin(column, "base"), fx.Support(column, "top", "x"), fx.clamp(stop, "start"),
                             fx.clamp(stop, "end")],
                     [fx.PointForce(column, "top", (0.0, -1.0)), fx.PointForce(column, "middle", (1e-3 * side, 0.0))],
                     fx.Monitor(column, "middle", "x"), joints=[touch])
    record = fx.trace(fx.Case(scene, fx.LoadControl(target=0.9 * bound * np.pi**2), fx.Until()))
    last = record.states[-1]
    assert last.factor == pytest.approx(0.9 * bound * np.pi**2) and last.unstable_modes == 0
    assert record.critical_points == []
    if side < 0:
        assert not last.contact_points
        u = np.sqrt(last.factor) / 2
        exact = last.factor * 1e-3 / 48 * 3 * (np.tan(u) - u) / u**3
        assert last.deflection == pytest.approx(-exact, rel=2e-3), "shear and shortening take 2e-4 off the Euler load"


@pytest.mark.parametrize("friction", [0.0, 0.3])
@pytest.mark.slow(quick=1)
def test_condensed_pairs_take_fewer_factorisations(friction):
    """All pairs of the leaves close, open and slip at once: 13 factorisations in the place of 49 and 53.

    Where the leaves end does not depend on how it is found; both are in balance to 1e-8.
    """
    plain, condensed = (leaf_spring(friction, 0.05, enforcement) for enforcement in ("penalty", "condensed"))
    assert condensed.states[-1].deflection == pytest.approx(plain.states[-1].deflection, rel=1e-7)
    spent = [record.path.tracer.total_factorisations for record in (plain, condensed)]
    assert spent[1] < spent[0] / 2


def plate_on_a_frame(divisions, **how):
    """A square plate under its weight on bars along its edges, which it presses at their middles alone."""
    middles, corners = [(0, 1), (1, 2), (2, 1), (1, 0)], [(0, 0), (0, 2), (2, 2), (2, 0)]
    nodes = {f"{i}{j}": (i / 2, j / 2, 0.0) for i in range(3) for j in range(3)}
    around = ["{}{}".format(*place) for both in zip(corners, middles, strict=True) for place in both]
    bars = list(zip(around, around[1:] + around[:1], strict=True))
    panels = [(f"{i}{j}", f"{i + 1}{j}", f"{i + 1}{j + 1}", f"{i}{j + 1}") for i in range(2) for j in range(2)]
    table = fx.meshes.Table(nodes, bars, panels)
    mesh = fx.read_mixed(lambda: fx.meshes.structure(table, divisions, separate="bars"), ["bars"])
    plate = fx.Shell(mesh.surfaces, fx.Plate(0.01), fx.Elastic(1.0, 0.3), form="naghdi-t2")
    frame = fx.Beam(mesh.curves, fx.Rectangle(0.1, 0.1), fx.Elastic(1e6))
    on_bars = {f"edge {a}-{b} of panels" for a, b in bars} | {f"edge {b}-{a} of panels" for a, b in bars}
    edges = [name for name in fx.meshes.edges_of(table, "bars") if name in on_bars]
    supports = [fx.Support(mesh.surfaces, "11 of panels", "x y"), fx.Support(mesh.surfaces, "21 of panels", "y"),
                *(fx.clamp(mesh.curves, node) for node in around)]
    contact = fx.PairContact(mesh.surfaces, edges, (mesh.curves, None), toward=(0.0, 0.0, -1.0), **how)
    return fx.Scene([plate, frame], supports, [fx.SurfaceForce(plate, (0.0, 0.0, -1e-9))],
                    fx.Monitor(mesh.surfaces, "11 of panels", "z", -1.0), joints=[contact])


@pytest.mark.slow
def test_plate_lifts_its_corners_off_a_frame():
    """Pairs open one after another from the corners within the first iteration: that took 72 factorisations.

    With corners that are held the plate's deflection is the one known from Timoshenko and Woinowsky-Krieger (1959), by
    a per cent, since it may twist along its edges; free corners make it softer.
    """
    rigidity, found = 0.01**3 / 12 / (1 - 0.3**2), {}
    for name, how in (("free", {}), ("other way", {"enforcement": "penalty"}), ("held", {"strength": 1.0})):
        path = fx.Path(plate_on_a_frame(12, **how), until=fx.Until(deflection=1e-5))
        *_, last = path
        found[name] = 1e-5 * rigidity / (1e-9 * last.factor)
        if name == "free":
            assert path.tracer.total_factorisations <= 5
    assert found["held"] == pytest.approx(0.00406, rel=0.03)  # 1 % by its edges, 1.7 % by its mesh
    assert found["free"] == pytest.approx(found["other way"], rel=1e-6)
    assert 1.05 < found["free"] / found["held"] < 1.09  # 1.070 on a mesh of twice as many cells


@pytest.mark.slow
def test_path_turns_back_where_a_prop_lets_go():
    """A clamped column pressed against a prop, which lets go at a load of 100, four times what the column alone bears.

    From there on lateral load and deflection have opposite signs (Timoshenko and Gere 1961, section 1.11); 2 %: strains
    of half a percent along and across the column are not in the formula.
    """
    column, wall = line(8, (0.0, 0.0), (1.0, 0.0)), line(2, (0.9, 0.0), (1.1, 0.0), name="wall")
    prop = fx.PairContact(column, "end", (wall, None), moving=False, toward=(0.0, -1.0))
    scene = fx.Scene([fx.Beam(m, **SECTION) for m in (column, wall)],
                     [fx.clamp(column, "start"), fx.clamp(wall, "start"), fx.clamp(wall, "end")],
                     [fx.PointForce(column, "end", (-1.0, 0.01))], fx.Monitor(column, "end", "y"), joints=[prop],
                     stages=[fx.Stage([fx.PointForce(column, "end", (0.0, -1.0))])])
    record = fx.trace(fx.Case(scene, until=fx.Until(deflection=0.02)))
    limit, = (p for p in record.critical_points if p.kind == "limit")
    assert limit.name == "maximum" and limit.load == pytest.approx(100.0, rel=1e-3)
    other = fx.trace(fx.Case(scene, fx.ArcLength(step=0.02), fx.Until(deflection=0.02)))
    again, = (p for p in other.critical_points if p.kind == "limit")
    assert again.load == pytest.approx(limit.load, rel=2e-6), "what corners are told to; 5e-4 where steps were halved"
    assert other.path.tracer.total_factorisations < 400, "832 where steps were halved"
    behind = [s for s in record.states if s.stage and not s.contact_points]
    assert len(behind) > 5 and all(s.unstable_modes == 1 for s in behind)
    for state in behind:
        k = np.sqrt(state.factor / 10.0)
        assert state.deflection == pytest.approx((0.01 - 1 / state.factor) * (np.tan(k) / k - 1), rel=0.02, abs=1e-5)


@pytest.mark.silent("pairs")
def test_pairs_that_touch_without_pressure_are_told():
    """A column beside a stop that just touches it may buckle away from that, at a lower load than is found."""
    places = {"foot": (0.0, 0.0), "middle": (0.0, 0.5), "top": (0.0, 1.0)}
    bars = {"lower": ("foot", "middle", 4), "upper": ("middle", "top", 4)}
    column = fx.read(lambda: fx.meshes.frame(places, bars), 2)
    stop = line(2, (0.0, 0.4), (0.0, 0.6))
    parts = [fx.Beam(m, fx.Rectangle(0.01, 0.01), fx.Elastic(1e9, 0.0)) for m in (column, stop)]
    for gap, count in ((0.0, 1), (1e-3, 0)):
        touch = fx.PairContact(column, "middle", (stop, None), toward=(1.0, 0.0), gap=gap)
        scene = fx.Scene(parts, [fx.pin(column, "foot"), fx.Support(column, "top", "x"), fx.clamp(stop, "start"),
                                 fx.clamp(stop, "end")], [fx.PointForce(column, "top", (0.0, -1.0))],
                         fx.Monitor(column, "top", "y", -1.0), joints=[touch])
        record = fx.trace(fx.Case(scene, until=fx.Until(load=1.0)))
        assert sum("touch without pressure" in said for said in record.path.searched) == count
