"""Contact with surfaces: closest points, tangents, momentum, sliding over cells and off edges, the double plate."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from itertools import pairwise

import numpy as np
import pytest
from helpers import distance, move_at_random
from mpi4py import MPI
from scipy.integrate import fixed_quad, quad
from scipy.interpolate import CubicSpline
from two_elasticas import TwoElasticas

import sheetfx as fx
from sheetfx import meshes
from sheetfx.archive.folder import Archive
from sheetfx.continuation.state import State
from sheetfx.discrete.closest_point import SIZE, ClosestPoint
from sheetfx.discrete.discretisation import Discretisation
from sheetfx.discrete.pair_work import pairs_of
from sheetfx.mesh.patch import Patch
from sheetfx.mesh.projection import Cells
from sheetfx.scenes import double_plate
from sheetfx.scenes._stages import touches

POWERS = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2), (3, 0), (2, 1), (1, 2), (0, 3)]
FACTORS = [1, 1, 1, 0.5, 1, 0.5, 1 / 6, 0.5, 0.5, 1 / 6]


def plate(cells, lengths, at=(0.0, 0.0, 0.0), triangles=False):
    return fx.read(lambda: meshes.rectangle(cells, lengths, triangles), 3, 1, lambda x: x + np.array(at))


def work_of(discretisation):
    work, = pairs_of(discretisation.system.contributions)
    return work


def table(s, order=(0, 0)):
    """Derivative of the monomials of a surface's Taylor series, s^i t^j / i! j!."""
    values = []
    for (i, j), factor in zip(POWERS, FACTORS, strict=True):
        slope = [np.prod(np.arange(p, p - o, -1)) * x ** max(p - o, 0) for p, o, x in zip((i, j), order, s,
                                                                                         strict=True)]
        values.append(factor * np.prod(slope))
    return np.array(values)


def closest(point, rows):
    """Distance along the normal and coordinates of the closest point of a cubic surface, by Newton's iteration."""
    s = np.zeros(2)
    for _ in range(30):
        apart = point - table(s) @ rows
        slopes = np.array([table(s, o) @ rows for o in ((1, 0), (0, 1))])
        curvatures = np.array([[table(s, o) @ rows for o in line] for line in (((2, 0), (1, 1)), ((1, 1), (0, 2)))])
        step = np.linalg.solve(slopes @ slopes.T - curvatures @ apart, slopes @ apart)
        s = s + step
        if np.abs(step).max() < 1e-15:
            break
    normal = np.cross(*slopes)
    return normal @ apart / np.linalg.norm(normal), s


def test_derivatives_of_closest_points():
    """Against differences of the solution itself, at a point 0.4 off a surface with radii of about 2."""
    generator = np.random.default_rng(4)
    rows = generator.uniform(-0.3, 0.3, (10, 3)) + [[0, 0, 0], [1, 0.2, 0], [0.1, 0.9, 0], *[[0, 0, 0]] * 7]
    slopes = rows[1:3]
    normal = np.cross(*slopes) / np.linalg.norm(np.cross(*slopes))
    point = rows[0] + 0.4 * normal
    found = ClosestPoint((point - rows[0])[None], slopes[None], rows[[[3, 4], [4, 5]]][None],
                         rows[[[[6, 7], [7, 8]], [[7, 8], [8, 9]]]][None])

    def at(z):
        moved = rows.copy()
        moved[:6] += z[3:].reshape(6, 3)
        gap, s = closest(point + z[:3], moved)
        return np.array([gap, *s])

    def along(direction, step=1e-5):
        return (at(step * direction) - at(-step * direction)) / (2 * step)

    weights = np.array([[0.7, -1.3]])
    seconds = found.second_of_distance()[0], found.second_of_coordinates(weights)[0]
    for one, two in generator.uniform(-1, 1, (6, 2, SIZE)):
        first = along(one)
        assert [found.of_distance()[0] @ one, *(found.moves[0] @ one)] == pytest.approx(first, abs=1e-8)
        second = np.zeros(3)
        for first_sign, second_sign in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
            second += first_sign * second_sign * at(1e-4 * (first_sign * one + second_sign * two)) / 4e-8
        assert [one @ m @ two for m in seconds] == pytest.approx([second[0], weights[0] @ second[1:]], abs=2e-5)
    assert all(np.abs(m - m.T).max() < 1e-12 for m in seconds)


@pytest.mark.parametrize("triangles", [False, True])
def test_cells_know_what_is_beyond_their_borders(triangles):
    """Across each border inside there is the cell whose points are at the same places, with the same normal."""
    patch = Patch(Cells(mesh := plate((3, 2), (1.5, 1.0), triangles=triangles), mesh.group(None)))
    inside = 0
    for cell in range(len(patch.beyond)):
        for border in range(patch.beyond.shape[1]):
            ends = patch.ends[border]
            reference = (0.3 * ends[0] + 0.7 * ends[1])[None]
            assert patch.margins(reference)[0, border] == pytest.approx(0.0, abs=1e-15)
            if patch.beyond[cell, border] < 0:
                continue
            inside += 1
            which = np.array([cell])
            other, entered, flips = patch.pass_on(which, np.array([border]), reference)
            assert patch.cells.places(other, entered) == pytest.approx(patch.cells.places(which, reference))
            assert (flips[:, None] * patch.cells.normals(other, entered)
                    == pytest.approx(patch.cells.normals(which, reference)))
    assert inside == (26 if triangles else 14)


def two_plates(at="south", friction=0.0, **how):
    upper, lower = plate((1, 1), (1.0, 0.8), (0.13, 0.11, 0.3)), plate((2, 1), (1.3, 1.0))
    shells = [fx.Shell(m, fx.Plate(0.05), fx.Elastic(1e2, 0.3)) for m in (upper, lower)]
    how = {"distance": 0.3, "stiffness": 1e3, "tangential": 1e3, "enforcement": "penalty"} | how
    contact = fx.SurfaceContact(upper, at, (lower, None), friction=friction, **how)
    return fx.Scene(shells, [fx.clamp(upper, "north"), fx.clamp(lower, "west")],
                    [fx.PointForce(upper, "south-west", (0.0, 0.0, -1.0))],
                    fx.Monitor(upper, "south-west", "z", -1.0), joints=[contact])


@pytest.mark.parametrize("at, friction", [
    (None, 0.5), pytest.param("south", 0.0, marks=pytest.mark.slow), pytest.param(None, 0.0, marks=pytest.mark.slow)])
def test_tangent_is_the_derivative_and_forces_balance(at, friction):
    """Far from equilibrium, partners in other cells than at first; contact forces have no resultant and no moment."""
    discretisation = Discretisation(two_plates(at, friction), mixed_points=False)
    system, work = discretisation.system, work_of(discretisation)
    x = move_at_random(discretisation, size=0.05)
    assert {"open", "slip"} <= set(work.evaluate().status)
    out = system.create_vector()
    forces = system._forces()
    work.residual(forces)
    totals = np.zeros(6)
    for number, field in enumerate(discretisation.unknowns.fields):
        if (force := forces.given(number)) is not None:
            space = field.value.function_space
            places = space.tabulate_dof_coordinates() + field.table
            totals += np.concatenate([force.sum(axis=0), np.cross(places, force).sum(axis=0)])
    largest = np.abs(np.concatenate([f for n in (0, 2) if (f := forces.given(n)) is not None])).max()
    assert np.abs(totals).max() < 1e-12 * largest * 20
    with system.additive_increments():
        system.configure(x, system.factor)
        matrix, product = system.tangent().copy(), system.create_vector()
        for seed in range(4):
            along, difference = system.create_vector(), np.zeros(len(x.array))
            along.array[:] = np.random.default_rng(seed).uniform(-1, 1, len(x.array))
            along.array[system.fixed_rows] = 0
            for times, weight in ((1, 8), (-1, -8), (2, -1), (-2, 1)):
                moved = x.copy()
                moved.axpy(1e-5 * times, along)
                system.configure(moved, system.factor)
                system.residual(out)
                difference += weight * out.array / 1.2e-4
            matrix.mult(along, product)
            assert distance(product.array, difference) < 7e-8
            matrix.multTranspose(along, product)
            assert (distance(product.array, difference) > 1e-4) == bool(friction)


def sliding(depth, apart, travel=1.0, start=1.05, step=0.02, friction=0.0, cells=30, **how):
    """A rod pressed into a strip on an elastic foundation slides along it, ten cells for a travel of 1."""
    strip = plate((cells, 1), (0.1 * cells, 0.1))
    nodes = {"start": (start, 0.05, 0.3 + apart), "end": (start, 0.05, apart)}
    rod = fx.read(lambda: meshes.frame(nodes, {"rod": ("start", "end", 1)}), 3)
    shell = fx.Shell(strip, fx.Plate(0.1), fx.Elastic(1.2e6, 0.0))
    beam = fx.Beam(rod, fx.Rectangle(0.1, 0.1), fx.Elastic(1.2e6, 0.0), up=(1.0, 0.0, 0.0))
    contact = fx.SurfaceContact(rod, "end", (strip, None), distance=apart, toward=(0.0, 0.0, -1.0), friction=friction,
                                **how)
    supports = [fx.Support(strip, "west", "x"), *(fx.Support(strip, f"south-{end}", "y") for end in ("west", "east")),
                fx.Support(rod, "start", "y rx ry rz")]
    scene = fx.Scene(
        [shell, beam], supports, [fx.PrescribedDisplacement(rod, "start", "x", travel)], fx.Monitor(rod, "start", "x"),
        joints=[contact, fx.Foundation(shell, (0.0, 0.0, 5e4))],
        stages=[fx.Stage([fx.PrescribedDisplacement(rod, "start", "z", -depth)],
                         control=fx.LoadControl(step=1.0, fixed=True))])
    record = fx.trace(fx.Case(scene, fx.LoadControl(step=step, fixed=True)))
    states = []
    for state in record.states[-round(1 / step):]:
        record.show(state)
        states.append(record.pairs(contact))
    return record, states


def strip_under_force(bending, shear, foundation):
    """Deflection under a unit force of an infinite beam with shear on a foundation, by Fourier's integral."""
    def share(wave):
        softer = 1 + bending * wave**2 / shear
        return softer / (bending * wave**4 + foundation * softer) / np.pi
    return quad(share, 0, np.inf, epsabs=1e-12)[0]


@pytest.mark.slow
@pytest.mark.parametrize("apart", [0.0, 0.1])
def test_slides_over_cells_without_a_jolt(apart):
    """Of ten cells, far from the ends; the force is that of an infinite beam in series with the rod.

    A contact without thickness and one off the mid-surface by a cell. The force changes by less than half a percent
    over all cells, which are a little softer about their nodes than between these.
    """
    _, states = sliding(0.01, apart, start=1.55, step=0.01, cells=40)
    forces = np.array([s.pressure[0] for s in states])
    spring = 1 / (strip_under_force(bending=10.0, shear=5e3, foundation=5e3) + 0.3 / 1.2e4)
    assert np.ptp(forces) < 5e-3 * forces.mean()
    assert forces.mean() == pytest.approx(0.01 * spring, rel=5e-3)


@pytest.mark.slow
def test_slides_over_bends_between_cells():
    """Pressed in by half a cell a strip bends where cells meet, as if it had a valley there.

    While its surface was as smooth as its cells, both pushed the rod to the other one, and a step failed.
    """
    _, states = sliding(0.05, 0.1, travel=0.2, start=1.4, step=0.05)
    forces = np.array([s.pressure[0] for s in states])
    assert np.ptp(forces) < 5e-3 * forces.mean()


def test_nothing_has_slipped_before_anything_moves():
    """On a cylinder of cells of 17 degrees the closest points of cells and of the smooth surface are 1.5e-3 apart.

    That counted as slip as soon as a path began.
    """
    def around(radius, first, last):
        def place(x):
            angle = first + (last - first) * x[:, 0]
            return np.column_stack((radius * np.sin(angle), 20.0 * x[:, 1], radius * np.cos(angle)))
        return place

    sheets = [fx.read(lambda cells=cells: meshes.rectangle(cells), 3, 2, place) for cells, place in (
        ((4, 1), around(102.0, 0.0, 1.0)), ((5, 1), around(100.0, -0.2, 1.3)))]
    shells = [fx.Shell(m, fx.Plate(1.0), fx.Elastic(1e4), form="naghdi-q2") for m in sheets]
    contact = fx.SurfaceContact(sheets[0], None, (sheets[1], None), friction=0.2)
    scene = fx.Scene(shells, [fx.clamp(m, "west") for m in sheets], [fx.EdgeForce(sheets[0], "east", (0.0, 0.0, -1.0))],
                     fx.Monitor(sheets[0], "south-east", "z"), joints=[contact])
    assert np.abs(work_of(Discretisation(scene)).evaluate().slip).max() < 1e-12 * 100.0


@pytest.mark.parametrize("friction", [0.0, 0.2])
@pytest.mark.slow(quick=1)
def test_pressed_on_a_vertex(friction):
    """A rod in the middle of a plate of four by four cells stays there, by symmetry."""
    plates = plate((4, 4), (1.0, 1.0))
    rod = fx.read(lambda: meshes.frame({"start": (0.5, 0.5, 0.4), "end": (0.5, 0.5, 0.1)},
                                       {"rod": ("start", "end", 1)}), 3)
    soft = fx.Elastic(1.2e6, 0.3)
    contact = fx.SurfaceContact(rod, "end", (plates, None), distance=0.1, toward=(0.0, 0.0, -1.0), friction=friction)
    scene = fx.Scene(
        [fx.Shell(plates, fx.Plate(0.02), soft), fx.Beam(rod, fx.Rectangle(0.1, 0.1), soft, up=(1.0, 0.0, 0.0))],
        [*(fx.clamp(plates, edge) for edge in ("west", "east", "south", "north")),
         fx.Support(rod, "start", "x y rx ry rz")],
        [fx.PrescribedDisplacement(rod, "start", "z", -0.06)], fx.Monitor(rod, "start", "z", -1.0), joints=[contact])
    record = fx.trace(fx.Case(scene, fx.LoadControl(step=0.25, fixed=True)))
    assert len(record.states) == 5
    record.show(record.states[-1])
    assert record.pairs(contact).position[0, :2] == pytest.approx([0.5, 0.5], abs=1e-9)


@pytest.mark.slow
def test_friction_over_cells():
    """Slip is what has been travelled, on whichever cell; the traction is that of the cone once it slips."""
    _, states = sliding(0.01, 0.1, friction=0.3)
    slips, forces = (np.array([getattr(s, name)[0] for s in states]) for name in ("slip", "traction"))
    pressures = np.array([s.pressure[0] for s in states])
    assert [s.status[0] for s in states[5:]] == ["slip"] * (len(states) - 5)
    assert np.linalg.norm(forces[5:], axis=1) == pytest.approx(0.3 * pressures[5:], rel=1e-9)
    travelled = np.diff(slips[5:], axis=0)
    assert np.linalg.norm(travelled, axis=1) == pytest.approx(0.02, rel=2e-2)


@pytest.mark.slow
def test_slides_off_the_edge():
    """Beyond the edge there is no partner and no force; the strip springs back, and nothing fails."""
    record, states = sliding(0.01, 0.1, travel=0.3, start=2.85, step=0.05)
    forces = np.array([s.pressure[0] for s in states])
    places = np.array([s.position[0, 0] for s in states])
    assert (forces[places < 2.99] > 0).all() and (forces[places > 3.06] == 0).all()
    record.show(record.states[-1])
    assert np.abs(record.displacement("north-east")).max() < 1e-9


@pytest.mark.slow
def test_few_augmentations_where_the_softer_part_is_stiff_where_it_is_touched():
    """A rod pressed and drawn across a clamped cylindrical panel of 4 mm; all lengths in metres.

    The panel is a thousand times stiffer at a point than its bending over the rod's length tells, from which the
    stiffness of the contact is taken. Steps end where it touches and where it slips.
    """
    def place(x):
        return np.column_stack((0.6 * (x[:, 0] - 0.5), 0.5 * np.sin(0.6 * (x[:, 1] - 0.5)),
                                0.5 * np.cos(0.6 * (x[:, 1] - 0.5)) - 0.5))

    panel = fx.read(lambda: meshes.rectangle((4, 4)), 3, 2, place)
    rod = fx.read(lambda: meshes.frame({"start": (-0.15, -0.1, 0.013), "end": (0.1, 0.06, 0.013)},
                                       {"rod": ("start", "end", 4)}), 3)
    steel = fx.Elastic(70e9, 0.3)
    contact = fx.SurfaceContact(rod, "rod", (panel, None), friction=0.1, toward=(0.0, 0.0, -1.0))
    ends = "start", "end"
    scene = fx.Scene(
        [fx.Shell(panel, fx.Plate(0.004), steel), fx.Beam(rod, fx.Rectangle(0.02, 0.02), steel)],
        [*(fx.clamp(panel, edge) for edge in ("west", "east", "south", "north")),
         *(fx.Support(rod, end, "y rx ry rz") for end in ends)],
        [fx.PrescribedDisplacement(rod, end, "x", 0.02) for end in ends], fx.Monitor(rod, "start", "x"),
        joints=[contact], stages=[fx.Stage([fx.PrescribedDisplacement(rod, end, "z", -0.002) for end in ends],
                                           control=fx.LoadControl(step=0.6))])
    record = fx.trace(fx.Case(scene, fx.LoadControl(step=0.5)))
    assert record.states[-1].contact_points > 0 and len(record.states) < 20
    assert max(s.iterations for s in record.states) < 40
    assert max(s.penetration for s in record.states) < 1e-6 * 0.15


@pytest.mark.parametrize("how, message", [
    ({"friction": -0.2}, "friction is -0.2; it must be zero or positive"),
    ({"stiffness": 0.0}, "stiffness is 0.0; it must be positive"),
    ({"samples": 0}, "samples is 0; it must be at least 1"),
    ({"enforcement": "exact"}, "enforcement is 'exact'"),
])
def test_wrong_input_is_named(how, message):
    with pytest.raises(ValueError, match=message):
        two_plates(**how)


def test_overlap_and_curves_are_named():
    with pytest.raises(ValueError, match="overlap by 0.05 at .*smaller distance"):
        Discretisation(two_plates(distance=0.35))
    mesh = plate((1, 1), (1.0, 1.0))
    line = fx.read(lambda: meshes.frame({"a": (0, 0, 0), "b": (1, 0, 0)}, {"line": ("a", "b", 1)}), 3)
    with pytest.raises(ValueError, match="no surface in space; give shells there, or use a PairContact"):
        fx.SurfaceContact(mesh, "west", (line, None))
    with pytest.raises(ValueError, match="does not have the contact"):
        fx.slide_off(two_plates(), fx.SurfaceContact(mesh, "west", (mesh, None)))
    scene = two_plates()
    pairs = fx.PairContact(scene.parts[0].mesh, "south", (line, None), toward=(0.0, 0.0, 1.0), reach=1.0)
    bar = fx.Beam(line, fx.Rectangle(0.1, 0.1), fx.Elastic(1.0), up=(0.0, 0.0, 1.0))
    with pytest.raises(ValueError, match="slide_off: contact is the PairContact.*give a SurfaceContact"):
        fx.slide_off(fx.Scene([*scene.parts, bar], scene.supports, scene.loads, scene.monitor,
                              joints=[*scene.joints, pairs]), pairs)


def strips_case(cells):
    """The double plate as strips: no lateral contraction, the modulus of a plate, a line load, middle lines touch."""
    modulus = double_plate.MODULUS / (1 - double_plate.POISSON**2)
    return double_plate.plates(fx.Elastic(modulus, 0.0), 0.0, 20.0, 40.0, cells, True, 0.01, 0.0)


def strips(cells):
    case = strips_case(cells)
    record = fx.trace(case)
    first = next(i for i, s in enumerate(record.states) if s.contact_points)
    loads, deflections = np.array([(s.load, s.deflection) for s in record.states]).T
    forces = CubicSpline(loads[first:], [touch.force for touch in touches(record)[first:]])
    largest = max(forces.derivative().roots(extrapolate=False), key=forces)
    found = case.quantities(record) | {
        "stiffness before A": CubicSpline(deflections[:first], loads[:first])(20.0, 1),
        "stiffness after A": CubicSpline(deflections[first:], loads[first:])(20.0, 1), "largest force": forces(largest),
        "its load": largest, "its deflection": CubicSpline(loads[first:], deflections[first:])(largest)}
    return found, loads[first:], deflections[first:]


@pytest.mark.slow
def test_two_strips_against_two_elasticas():
    """Stages and states of the whole path, and how they converge to those of an independent solution."""
    known = {
        "A_load": 15.115, "stiffness before A": 0.861, "stiffness after A": 5.391, "B_load": 54.46,
        "B_deflection": 33.06, "largest force": 39.39, "its load": 56.98, "its deflection": 38.51, "C_load": 81.62,
        "C_deflection": 55.66, "last_contact_force": 27.31}
    modulus = double_plate.MODULUS / (1 - double_plate.POISSON**2)
    theory, off = TwoElasticas(80.0, modulus * 20.0 * 0.7**3 / 12, 20.0, 40.0), []
    for cells, accuracy in ((4, 1e-2), (8, 2e-3), (16, 2e-3)):
        found, loads, deflections = strips(cells)
        assert {name: found[name] for name in known} == pytest.approx(known, rel=accuracy)
        path = theory.path(loads[:-1])
        off.append(np.abs([found["A_load"] / theory.first_touch() - 1,
                           found["largest force"] / path[:, 1].max() - 1]))
    assert (off[0] > 3 * off[1]).all() and (off[1] > off[2]).all() and off[2].max() < 1e-3
    assert loads[1:-1] == pytest.approx(CubicSpline(path[:, 0], loads[:-1])(deflections[1:-1]), rel=1e-3)
    last = theory.slides_off(81.0)
    assert [found["C_load"], found["C_deflection"], found["last_contact_force"]] == pytest.approx(last, rel=1e-3)


@pytest.mark.slow
def test_resumes_in_the_middle_of_plastic_sliding(tmp_path):
    def case():
        made = double_plate.case(cells=8)
        return fx.Case(made.scene, made.control, fx.Until(deflection=26.0))

    whole = fx.trace(case())
    middle = next(i for i, s in enumerate(whole.states) if s.contact_points) + 3
    kept = []
    for state in whole.states[: middle + 1]:
        state.save(tmp_path / "state.npz")
        kept.append(State.load_from(tmp_path / "state.npz"))
    again = case()
    rest = list(fx.Path(again.scene, again.control, again.until, start=kept))
    assert rest[-1].step == whole.states[-1].step
    for state in rest:
        assert state.load == pytest.approx(whole.states[state.step].load, rel=1e-8)
        assert state.deflection == pytest.approx(whole.states[state.step].deflection, rel=1e-8)


RUN = """
import sys
from dataclasses import replace
from pathlib import Path
import sheetfx as fx
from sheetfx.case import run
from sheetfx.scenes import double_plate
from sheetfx.scenes._stages import touches
made = replace(double_plate.case(cells=4), until=fx.Until(deflection=27.0), quantities=lambda record: {}, pictures=())
run(made, "double-plate", {}, Path(sys.argv[1]), len(sys.argv) > 2)
"""


@pytest.mark.slow
def test_killed_in_the_middle_of_plastic_sliding(tmp_path):
    """No converged step is lost, and what follows is the path of a run that was left alone."""
    command = [sys.executable, "-c", RUN]

    def table(folder):
        return np.loadtxt(folder / "path.csv", delimiter=",", skiprows=1, usecols=(0, 1, 2, 3))

    subprocess.run([*command, str(tmp_path / "whole")], check=True, capture_output=True)
    states = Archive(tmp_path / "whole", MPI.COMM_SELF).states()
    middle = next(s.step for s in states if s.contact_points) + 4
    process = subprocess.Popen([*command, str(tmp_path / "killed")], stdout=subprocess.DEVNULL,
                               stderr=subprocess.DEVNULL)
    kept = tmp_path / "killed" / "states"
    for _ in range(6000):
        if (kept / f"{middle:06d}.0.npz").exists() or process.poll() is not None:
            break
        time.sleep(0.02)
    process.send_signal(signal.SIGKILL)
    process.wait()
    left = Archive(tmp_path / "killed", MPI.COMM_SELF).states()
    assert [s.step for s in left] == list(range(len(left))) and middle <= left[-1].step < states[-1].step
    subprocess.run([*command, str(tmp_path / "killed"), "resume"], check=True, capture_output=True)
    assert table(tmp_path / "killed") == pytest.approx(table(tmp_path / "whole"), rel=1e-8, abs=1e-9)


@pytest.mark.slow
def test_close_plates_have_a_limit_point_after_they_soften():
    made = double_plate.case(friction=0.0, elastic=True, gap=5.0, cells=8)
    record = fx.trace(made)
    order = [p.name if p.kind == "event" else p.title for p in record.critical_points]
    assert order == [double_plate.A, double_plate.B, "limit point (maximum)", "limit point (minimum)",
                     double_plate.AGAIN, double_plate.C]
    loads = [p.load for p in record.critical_points if p.kind == "limit"]
    assert loads == pytest.approx([55.1, 40.4], rel=5e-3)


@pytest.mark.slow
def test_plastic_hinge_does_not_depend_on_its_cell(monkeypatch):
    """Load at C with cells down to a third of the thickness; of the strains, those that hold in a hinge."""
    found = []
    for lines in ((0.0, 0.1, 0.25, 0.45, 0.7), (0.0, 0.05, 0.11, 0.2, 0.3, 0.45, 0.7)):
        monkeypatch.setattr(double_plate, "HINGE", lines)
        made = double_plate.case(friction=0.0)
        found.append(made.quantities(fx.trace(made)))
    for name in ("B_load", "C_load", "C_deflection"):
        assert found[0][name] == pytest.approx(found[1][name], rel=2.5e-3)
    assert found[0]["C_load"] == pytest.approx(11.76, rel=5e-3)


@pytest.mark.slow
def test_constant_pressure_passes_under_large_sliding():
    """A soft plate that is loaded evenly slides over a stiff one, by more than a cell of both."""
    upper, lower = plate((3, 2), (0.6, 0.4), (0.1, 0.13, 0.03)), plate((5, 3), (2.0, 0.7))
    soft, stiff = fx.Shell(upper, fx.Plate(0.02), fx.Elastic(1e4, 0.3)), fx.Shell(lower, fx.Plate(0.04),
                                                                                 fx.Elastic(1e13, 0.3))
    contact = fx.SurfaceContact(upper, None, (lower, None))
    edges = [fx.clamp(lower, edge) for edge in ("west", "east", "south", "north")]
    scene = fx.Scene(
        [soft, stiff], [*edges, fx.Support(upper, "west", "y")], [fx.PrescribedDisplacement(upper, "west", "x", 1.1)],
        fx.Monitor(upper, "south-west", "x"), joints=[contact],
        stages=[fx.Stage([fx.SurfaceForce(soft, (0.0, 0.0, -2.0))], control=fx.LoadControl(step=1.0, turn=4.0))])
    record = fx.trace(fx.Case(scene, fx.LoadControl(step=0.1, fixed=True)))
    for state in record.states[1:]:
        record.show(state)
        pressure = 2.0 * (1.0 if state.stage else state.factor)
        assert np.abs(record.pairs(contact).pressure - pressure).max() < 1e-6
    assert state.deflection == pytest.approx(1.1)


@pytest.mark.slow
def test_friction_takes_the_energy_that_is_missing():
    """Work of the load, stored energy and friction as the plates slide over two borders of cells to shortly before C.

    By splines through the states, which are close to each other, since points of the edge touch and leave on the way.
    """
    made = double_plate.plates(fx.Elastic(double_plate.MODULUS, 0.3), 0.3, 20.0, 40.0, 6, False, 0.01)
    record = fx.trace(fx.Case(made.scene, fx.ArcLength(step=0.01, largest=0.3), fx.Until(deflection=54.0)))
    contact, found = made.scene.joints[0], []
    touching = [s for s in record.states if s.contact_points][3:]
    for state in touching:
        record.show(state)
        pairs = record.pairs(contact)
        found.append((2 * sum(record.energies()), pairs.weight[:, None] * pairs.traction, pairs.slip))
    stored, forces, slips = (np.array(values) for values in zip(*found, strict=True))
    assert np.linalg.norm(slips[-1] - slips[0], axis=1).min() > 80.0 / 6
    deflections = np.array([s.deflection for s in touching])
    work = CubicSpline(deflections, [s.load for s in touching]).antiderivative()
    force, pace = CubicSpline(deflections, forces), CubicSpline(deflections, slips).derivative()
    rubbed = np.zeros(len(touching))
    for n, (before, after) in enumerate(pairwise(deflections)):
        rubbed[n + 1] = rubbed[n] + fixed_quad(lambda w: 2 * (force(w) * pace(w)).sum(axis=(1, 2)), before, after)[0]
    done = work(deflections) - work(deflections[0])
    assert rubbed[-1] > 0.05 * done[-1]
    assert stored - stored[0] + rubbed == pytest.approx(done, abs=1e-6 * done[-1])
