"""What comes out of a path: reactions against the loads, section forces against statics, energy against work."""

from __future__ import annotations

import csv
import json
from dataclasses import replace

import numpy as np
import pytest
from helpers import cantilever, follow, ring_under_pressure, straight
from petsc4py import PETSc
from scipy.spatial.transform import Rotation

import sheetfx as fx
from sheetfx.discrete.discretisation import Discretisation
from sheetfx.model.stresses import stresses
from sheetfx.scenes import load_case
from sheetfx.show.evaluate import ContactPoints, travel
from sheetfx.show.files import paraview
from sheetfx.show.tables import tables

BALANCED = 1e-10  # of the largest force along a path
EXACT = 1e-13  # residual over the load, so that equilibrium is met to rounding


@pytest.fixture
def exactly():
    """Newton's iterations go on to rounding: reactions balance loads as well as states are in equilibrium."""
    options = PETSc.Options()
    options["sheetfx_snes_rtol"] = EXACT
    yield
    del options["sheetfx_snes_rtol"]


def assert_balanced(record, loads, about=(0.0, 0.0, 0.0)):
    """Reactions and given loads have no resultant force, and no moment about a fixed place, in any state.

    Parameters
    ----------
    loads : function (record, state) -> pairs of a force, shape (3,), and the place where it acts now, and free moments
    """
    d, forces, moments, largest, turning = record.case.scene.meshes[0].dimension, [], [], 0.0, 0.0
    for state in record.states:
        record.show(state)
        reactions = [reaction for _, reaction in record.shown_reactions()]
        pairs, free = loads(record, state)
        force = sum(np.pad(r.force, (0, 3 - d)) for r in reactions) + sum(np.asarray(f) for f, _ in pairs)
        moment = sum(np.pad(m := r.moment(about[:d]), (3 - len(m), 0)) for r in reactions) + free
        forces.append(force)
        moments.append(moment + sum(np.cross(np.subtract(x, about), f) for f, x in pairs))
        largest = max([largest, *(np.abs(r.force).max() for r in reactions)])
        turning = max([turning, *(np.abs(r.moment(about[:d])).max() for r in reactions)])
    size = record.case.scene.meshes[0].size
    assert turning > 0
    assert np.abs(forces).max() <= BALANCED * max(largest, turning / size)
    assert np.abs(moments).max() <= BALANCED * max(largest * size, turning)


def place(record, at, start):
    """Where a named point is now, in space."""
    now = np.asarray(start, dtype=float)
    moved = record.displacement(at)
    return np.pad(now[:len(moved)] + moved, (0, 3 - len(moved)))


def test_reactions_of_a_frame(exactly):
    """Lee's frame along its whole path, through both limits and the snap-back, with its own shear stiffness."""
    case = load_case("lee-frame")(elements=5)
    yielding = [replace(part, shear_rigidity=1.0) for part in case.scene.parts]
    record = fx.trace(replace(case, scene=replace(case.scene, parts=yielding)))
    assert len(record.critical_points) >= 2
    assert_balanced(record, lambda r, s: ([((0.0, -s.factor, 0.0), place(r, "load", (24.0, 120.0)))], np.zeros(3)))
    loads, found = np.array([s.load for s in record.states]), [record.reactions(at) for at in ("base", "end")]
    assert found[0].force[:, 1] + found[1].force[:, 1] == pytest.approx(loads, abs=1e-9 * np.abs(loads).max())
    assert not found[0].moment.any(), "a hinge"


def test_reactions_of_bars(exactly):
    """A star dome through its limits: six hinges carry the apex."""
    record = fx.trace(load_case("star-dome")())
    assert len(record.states) > 10
    assert_balanced(record, lambda r, s: ([((0.0, 0.0, -s.factor), place(r, "apex", (0.0, 0.0, 8.216)))], np.zeros(3)))


@pytest.fixture(scope="module")
def roof():
    """A quarter of the cylindrical roof of 12.7 mm through both limits: a hinged edge and two planes of symmetry."""
    options = PETSc.Options()
    options["sheetfx_snes_rtol"] = EXACT
    record = fx.trace(load_case("roof")(cells=2))
    del options["sheetfx_snes_rtol"]
    return record


def test_reactions_of_a_shell(roof):
    """Forces along edges and moments about both axes of symmetry hold a quarter of the roof, not each alone."""
    assert len(roof.critical_points) == 2

    crown = 0.0, 0.0, 2540.0
    assert_balanced(roof, lambda r, s: ([((0.0, 0.0, -s.factor / 4), place(r, "crown", crown))], np.zeros(3)))


def test_reactions_under_a_force_that_follows(exactly):
    """A cantilever in space under a tip force that turns with it, to two thirds of a turn."""
    mesh, force = straight(6, dimension=3), np.array([0.0, 0.6, 0.2])
    record = follow(cantilever(mesh, lambda b: [fx.FollowerForce(mesh, "tip", tuple(force))]),
                    fx.LoadControl(step=0.25, target=4.0))

    def loads(record, state):
        scalar, *vector = record.rotation("tip")
        turned = Rotation.from_quat([*vector, scalar]).apply(state.factor * force)
        return [(turned, place(record, "tip", (1.0, 0.0, 0.0)))], np.zeros(3)

    assert_balanced(record, loads)
    assert np.linalg.norm(record.displacement("tip")) > 0.5


def test_reactions_with_an_obstacle(exactly):
    """Half an arch under a punch: clamp and plane of symmetry carry the punch's force, which contact hands on."""
    record = fx.trace(load_case("arch")(elements=20, to=25.0))
    force = sum(r.force for r in map(record.reactions, ("end", "crown")))
    loads = np.array([s.load for s in record.states]) / 2
    assert max(s.contact_points for s in record.states) > 0
    assert force[:, 1] == pytest.approx(loads, abs=BALANCED * loads.max())
    record.show(record.states[-1])
    punch, (contact,) = record.case.scene.contacts[0].obstacle, ContactPoints(record).evaluate()
    centre = np.asarray(punch.centre) + travel(record, punch)
    normals = contact.position - centre
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    assert force[-1] == pytest.approx(-(contact.weight * contact.pressure) @ normals, rel=1e-3)


@pytest.mark.slow
def test_reactions_of_prescribed_motions(exactly):
    """A clamp and a tip that is moved; a tip that is turned takes the moment EI angle / length of a circle."""
    mesh = straight(6)
    record = follow(cantilever(mesh, lambda b: [fx.PrescribedDisplacement(mesh, "tip", "y", 0.5)]), fx.LoadControl(0.2))
    assert_balanced(record, lambda r, s: ([], np.zeros(3)))
    motion = record.case.scene.loads[0]
    assert record.reactions(motion).force[:, 1] == pytest.approx([s.load for s in record.states], rel=1e-9)
    assert not record.reactions(motion).force[:, 0].any()
    for dimension, turn, exact in ((2, 3.0, 1e-8), (3, (0.0, 0.0, 3.0), 1e-4)):  # in space quaternions are interpolated
        mesh = straight(6, dimension=dimension)
        scene = cantilever(mesh, lambda b, m=mesh, t=turn: [fx.PrescribedRotation(m, "tip", t)])
        record = follow(scene, fx.LoadControl(0.2))
        assert_balanced(record, lambda r, s: ([], np.zeros(3)))
        factors, stiffness = np.array([s.factor for s in record.states]), 1.2e5 * 0.1**4 / 12
        assert record.reactions("tip").moment[:, -1] == pytest.approx(3.0 * stiffness * factors, rel=exact)


def test_reactions_of_shared_and_turned_nodes(exactly):
    """Two beams that share a node by compatibility, held there along axes of its own: what one mesh names both have."""
    first = fx.read(lambda: fx.meshes.frame({"a": (0, 0, 0), "b": (1, 0, 0)}, {"m": ("a", "b", 3)}), 3)
    second = fx.read(lambda: fx.meshes.frame({"b": (1, 0, 0), "c": (2, 0, 0)}, {"m": ("b", "c", 3)}), 3)
    section, material = fx.Rectangle(0.1, 0.1), fx.Elastic(1.2e5, 0.0)
    beams = [fx.Beam(mesh, section, material) for mesh in (first, second)]
    slope = np.sqrt([[0.5, 0.5, 0.0], [0.5, 0.5, 0.0], [0.0, 0.0, 1.0]]) * [[1, 1, 1], [-1, 1, 1], [1, 1, 1]]
    scene = fx.Scene(beams, [fx.clamp(first, "a"), fx.Support(first, "b", "y", axes=slope)],
                     [fx.PointForce(second, "c", (0.0, -0.5, 0.3))], fx.Monitor(second, "c", "z"),
                     joints=[fx.Compatible(second, first)])
    record = follow(scene, fx.LoadControl(0.5))
    assert_balanced(record, lambda r, s: (
        [((0.0, -0.5 * s.factor, 0.3 * s.factor), np.array([2.0, 0, 0]) + r.displacement("c", second))], np.zeros(3)))
    held = record.reactions("b").force[-1]
    assert held @ slope[0] == pytest.approx(0.0, abs=1e-9) and held @ slope[1] > 0.1


def test_a_component_that_two_supports_hold_counts_once():
    mesh = straight(2)
    scene = cantilever(mesh, lambda b: [fx.PointForce(mesh, "tip", (0.0, 0.1))])
    scene = fx.Scene(scene.parts, [*scene.supports, fx.Support(mesh, "base", "y")], scene.loads, scene.monitor)
    record = follow(scene, fx.LoadControl(1.0))
    assert record.reactions("base").force[-1] == pytest.approx([0.0, -0.1], abs=1e-7)
    assert not record.reactions(scene.supports[1]).force.any()
    with pytest.raises(ValueError, match="no support or prescribed motion at 'tip'; choose from 'base'"):
        record.reactions("tip")


def test_section_forces_of_a_frame_against_statics(exactly):
    """N, V and M of Lee's frame in its deformed shape, from the hinge's reaction alone: members are cut, not solved."""
    record = fx.trace(load_case("lee-frame")(elements=10))
    part, base = record.case.scene.parts[0], record.reactions("base").force
    largest = np.zeros(3)
    for state, force in zip(record.states, base, strict=True):
        record.show(state)
        points, values = record.section_points(part), record.forces(part)
        column = np.isclose(points.reference[..., 0], 0.0)
        places, axes = points.places[column], points.axes[column]
        arms = -places  # from the cut to the hinge, which stays at the origin
        expected = np.column_stack((axes @ -force, -(arms[:, 0] * force[1] - arms[:, 1] * force[0])))
        largest = np.maximum(largest, np.abs(expected).max(axis=0, initial=0.0))
        assert np.abs(values[column] - expected).max() <= 1e-7 * max(1.0, np.abs(expected).max())
    assert (largest > [5e3, 5e3, 1e5]).all()


def test_section_forces_of_a_roof_against_statics():
    """Scordelis-Lo, its weight so small that it stays linear: axial forces of its middle section have no resultant
    and the moment w L^2 / 8 of the whole roof as a beam.
    """
    cells, weight = 4, 1e-3
    record = fx.trace(load_case("scordelis-lo")(cells=cells, load=weight))
    shell, mesh = record.case.scene.parts[0], record.case.scene.parts[0].mesh
    record.show(record.states[-1])
    points, values = record.section_points(shell), record.forces(shell)
    assert values.shape[:2] == points.reference.shape[:2]
    tangent = points.axes[:, :, 0]
    along = np.abs(tangent[..., 0]) > 0.5
    axial = np.where(along, values[..., 0], values[..., 1])
    bending = np.where(along, values[..., 3], values[..., 4])
    west = record.shown_reactions()[0][1]
    half = np.radians(40.0)
    beam = weight * 2 * half * 25.0 * 50.0**2 / 8
    assert abs(west.force[0]) < 1e-6 * np.abs(west.forces[:, 0]).sum(), "no resultant along the axis"
    assert 2 * abs(west.moment()[1]) == pytest.approx(beam, rel=2e-3), "the moment of a beam, both halves"
    x, angle = points.reference[..., 0], np.arctan2(points.reference[..., 1], points.reference[..., 2])
    rows = np.unique(np.round(x, 6))[:3]
    moments = []
    for row in rows:  # Gauss's points of cells of one size: 3 weights around the arc
        chosen = np.isclose(x, row)
        order = np.argsort(angle[chosen])
        weights = np.tile([5 / 18, 8 / 18, 5 / 18], cells) * half * 25.0 / cells
        height = 25.0 * np.cos(angle[chosen][order])
        n, m = axial[chosen][order], bending[chosen][order]
        moments.append(2 * weights @ (n * height + m * np.cos(angle[chosen][order])))
        assert abs(weights @ n) < 2e-3 * weights @ np.abs(n)
    expected = weight * 2 * half * 25.0 * (25.0**2 - rows**2) / 2
    assert np.abs(moments) == pytest.approx(expected, rel=3e-3)
    assert mesh.dimension == 3


def test_stresses_integrate_to_resultants():
    """Of a plate and of a laminate by Gauss's rule through each ply; of beams from bending about both axes."""
    plies = [fx.Ply(0.02, angle, 1e5, 1e4, 0.3, 5e3) for angle in (0.0, 45.0, 90.0)]
    mesh, resultants = fx.read(lambda: fx.meshes.rectangle((1, 1)), 3), np.cos(np.arange(1.0, 19.0)).reshape(2, 9)
    for section, heights in ((fx.Plate(0.06), [-0.03, 0.03]), (fx.Laminate(plies), [-0.03, -0.01, 0.01, 0.03])):
        material = fx.Elastic(1e5, 0.3) if isinstance(section, fx.Plate) else None
        shell, found = fx.Shell(mesh, section, material, form="naghdi-q2", axis=(1.0, 0.0, 0.0)), np.zeros((2, 6))
        for low, high in zip(heights[:-1], heights[1:], strict=True):
            for point, weight in zip(*np.polynomial.legendre.leggauss(3), strict=True):
                z, thickness = (low + high + point * (high - low)) / 2, weight * (high - low) / 2
                stress = stresses(shell, resultants, z)
                found += thickness * np.concatenate((stress, z * stress), axis=1)
        assert found == pytest.approx(resultants[:, :6], abs=1e-12)
    with pytest.raises(ValueError, match="at is 0.04, outside of its thickness 0.06"):
        stresses(shell, resultants, 0.04)
    given = fx.Shell(mesh, fx.GivenPlate(0.06, section.stiffness()), form="naghdi-q2", axis=(1.0, 0.0, 0.0))
    with pytest.raises(ValueError, match="the stiffness of its GivenPlate does not tell stresses"):
        stresses(given, resultants, 0.0)
    line = straight(2, dimension=3)
    record = follow(cantilever(line, lambda b: [fx.PointForce(line, "tip", (1.0, 1e-4, 2e-4))],
                               section=fx.Rectangle(0.1, 0.2)), fx.LoadControl(1.0))
    beam = record.case.scene.parts[0]
    points = record.section_points(beam)
    arm = record.displacement("tip") + (1.0, 0.0, 0.0) - points.places
    moment = np.cross(arm, (1.0, 1e-4, 2e-4))
    for y, z in ((0.1, 0.05), (-0.1, 0.03)):
        along_y, along_z = (np.einsum("cpi,cpi->cp", moment, points.axes[:, :, i]) for i in (1, 2))
        expected = np.einsum("cpi,i->cp", points.axes[:, :, 0], (1.0, 1e-4, 2e-4)) / 0.02
        expected += along_y * z / (0.2 * 0.1**3 / 12) - along_z * y / (0.1 * 0.2**3 / 12)
        assert record.stresses(beam, (y, z))[..., 0] == pytest.approx(expected, rel=1e-5)
    with pytest.raises(ValueError, match="has 2 finite coordinates, at is 0.1"):
        record.stresses(beam, 0.1)


def assert_energy_balances(record, most=1e-6, accuracy=None):
    found = record.balance(accuracy)
    assert not found.untold and found.off <= most and not found.broken
    assert np.abs(found.work).max() > 0 and len(found.work) == len(record.states)
    return found


@pytest.mark.parametrize(("name", "parameters"), [
    ("von-mises-truss", {}), ("arch", {"no_punch": True, "elements": 16}), ("lee-frame", {"elements": 5}),
    ("deep-arch", {"elements": 16}), ("hemisphere", {"cells": 2}), ("roof", {"cells": 2}),
    pytest.param("arch", {"elements": 20, "to": 20.0}, marks=pytest.mark.slow, id="contact"),
    pytest.param("star-dome", {}, marks=pytest.mark.slow)])
@pytest.mark.slow(quick=2)
def test_energy_balances_along_whole_paths(name, parameters):
    """With the usual, long steps, through limits and snap-backs; states that are found within them make it sharp."""
    record = fx.trace(load_case(name)(**parameters))
    balance = assert_energy_balances(record, accuracy=1e-6)
    assert balance.tolerance < 1e-6
    assert record.balance().tolerance > 1e-4, "the states alone tell much less"
    np.testing.assert_array_equal(balance.parts, record.balance().parts)
    assert (np.diff(balance.work) < 0).any() == any(s.load < 0 for s in record.states), "work is given back"


def test_balance_notices_small_errors(monkeypatch):
    """Where the energy of a part is off by a hundred-thousandth, with the usual steps of an arch."""
    record = fx.trace(load_case("arch")(no_punch=True, elements=16))
    monkeypatch.setattr(Discretisation, "strain_energy", lambda self, part, told=Discretisation.strain_energy:
                        (1 + 1e-5) * told(self, part))
    assert record.balance(1e-6).broken and not record.balance().broken


def test_energy_that_does_not_balance_is_said(tmp_path):
    """A part that stores a hundredth more than its law says: the run warns, and its summary has the difference."""
    case = load_case("column")()
    plain = fx.run(case, "column", {}, tmp_path, False)
    assert plain["energy"]["off"] < 1e-6 and plain["energy"]["not_balanced"] == []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Discretisation, "strain_energy", lambda self, part, told=Discretisation.strain_energy:
                      1.01 * told(self, part))
        with pytest.warns(UserWarning, match="the energy does not balance: the loads have done"):
            wrong = fx.run(case, "column", {}, tmp_path, False)
    assert wrong["energy"]["off"] == pytest.approx(0.01, rel=0.02)
    assert json.loads((tmp_path / "summary.json").read_text())["energy"]["off"] == wrong["energy"]["off"]


def test_energy_balances_under_loads_of_all_kinds():
    """Loads that follow with and without a potential, prescribed motions, stages, springs and a foundation."""
    mesh, space = straight(4), straight(4, dimension=3)
    fine = fx.LoadControl(0.05, fixed=True)
    assert_energy_balances(follow(ring_under_pressure(), fx.LoadControl(0.5, target=2.0)))
    assert_energy_balances(follow(cantilever(space, lambda b: [fx.FollowerForce(space, "tip", (0.0, 1.0, 0.3))]), fine))
    assert_energy_balances(follow(cantilever(mesh, lambda b: [fx.PrescribedDisplacement(mesh, "tip", "y", 0.4)]), fine))
    assert_energy_balances(follow(cantilever(mesh, lambda b: [fx.PrescribedRotation(mesh, "tip", 2.0)]), fine))
    plain = cantilever(mesh, lambda b: [fx.PointForce(mesh, "tip", (0.0, 1.0))])
    record = follow(fx.Scene(
        plain.parts, plain.supports, plain.loads, plain.monitor,
        stages=[fx.Stage([fx.LineForce(plain.parts[0], (1.0, 2.0))])], joints=[
            fx.Spring(mesh, "tip", "rz", 2.0), fx.Foundation(plain.parts[0], (0.0, 5.0))]), fine)
    balance = assert_energy_balances(record)
    record.show(record.states[-1])
    angle, foundation = record.rotation("tip"), balance.joints[-1] - record.rotation("tip") ** 2
    assert angle > 0 and foundation > 0, "the spring's energy, and what is left for the foundation"


@pytest.mark.slow
def test_energy_of_contact_and_friction():
    """A contact layer stores a little; with friction there is no balance, which is said."""
    record = fx.trace(load_case("arch")(elements=20, to=20.0))
    balance = record.balance(1e-4)
    assert not balance.untold and balance.off < 1e-4 and not balance.broken and balance.joints[-1] > 0
    rough = fx.trace(load_case("arch")(elements=20, to=10.0, friction=0.3)).balance()
    assert rough.off is None and rough.untold == ("contact does not tell its energy",)
    assert rough.work[-1] == pytest.approx(rough.stored[-1], rel=1e-3), "friction hardly slides yet"


def test_tables_and_files(tmp_path):
    """Resultants in each cell of the files for ParaView, and tables that add up."""
    import pyvista

    record = fx.trace(load_case("lee-frame")(elements=5, to=20.0))
    paraview(record, tmp_path)
    tables(record, tmp_path)
    files = sorted((tmp_path / "paraview").glob("path*.vtu"))
    assert len(files) == len(record.states)
    grid, state = pyvista.read(files[-1]), record.states[-1]
    record.show(state)
    part = record.case.scene.parts[0]
    assert np.sort(grid["M"]) == pytest.approx(np.sort(record.forces(part)[..., 2].mean(axis=1)))
    assert grid["load"] == pytest.approx(state.load)
    along, across = (grid[name][:, :2] for name in ("along", "axis 1"))
    assert np.column_stack((-along[:, 1], along[:, 0])) == pytest.approx(across), "the normal is on the left"
    assert np.linalg.norm(along, axis=1) == pytest.approx(1.0)
    names = "reactions", "forces", "energies"
    rows = {name: list(csv.DictReader((tmp_path / f"{name}.csv").open())) for name in names}
    last = [float(row["fy"]) for row in rows["reactions"] if row["step"] == str(state.step)]
    assert len(last) == 2 and sum(last) == pytest.approx(state.load)
    assert len(rows["forces"]) == len(record.states) * record.forces(part)[..., 0].size
    assert float(rows["energies"][-1]["Beam 0"]) == pytest.approx(record.energies()[0])


@pytest.mark.parametrize(("side", "turned"), [("negative", True), ("positive", False)])
@pytest.mark.slow
def test_sides_and_normals(side, turned, tmp_path):
    """Pressure on the negative side pushes a plate along the normal that ParaView shows, on the positive against it."""
    import pyvista

    mesh = fx.read(lambda: fx.meshes.rectangle((2, 2)), 3, place=(lambda x: x[:, [1, 0, 2]]) if turned else None)
    shell = fx.Shell(mesh, fx.Plate(0.05), fx.Elastic(1e7), form="naghdi-q2", axis=(0.0, 1.0, 0.0))
    scene = fx.Scene([shell], [fx.clamp(mesh, "west")], [fx.Pressure(shell, 1.0, side)],
                     fx.Monitor(mesh, "north-east", "z"))
    record = fx.trace(fx.Case(scene, fx.LoadControl(1.0, fixed=True)))
    paraview(record, tmp_path)
    grid = pyvista.read(sorted((tmp_path / "paraview").glob("path*.vtu"))[-1])
    normal = grid["normal"]
    assert normal == pytest.approx(np.tile([0.0, 0.0, -1.0 if turned else 1.0], (4, 1)), abs=1e-2)
    assert record.states[-1].deflection * normal[0, 2] * (1 if side == "negative" else -1) > 1e-5
    assert np.abs(grid["axis 1"][:, 1]) == pytest.approx(1.0, rel=1e-2)
    assert np.cross(grid["axis 1"], grid["axis 2"]) == pytest.approx(normal, abs=1e-2)


def test_von_mises_stresses_on_faces(tmp_path):
    """A strip that is bent and pulled: N / A and 6 M / t^2 add up on one face, and the files have that of each cell."""
    import pyvista

    mesh = fx.read(lambda: fx.meshes.rectangle((4, 1), (4.0, 1.0)), 3)
    shell = fx.Shell(mesh, fx.Plate(0.1), fx.Elastic(1e7, 0.0), form="naghdi-q2")
    loads = [fx.EdgeForce(mesh, "east", (0.2, 0.0, 0.0)), fx.Moment(mesh, "east", (0.0, 1e-3, 0.0))]
    record = fx.trace(fx.Case(fx.Scene([shell], [fx.clamp(mesh, "west")], loads, fx.Monitor(mesh, "north-east", "x")),
                              fx.LoadControl(1.0, fixed=True)))
    paraview(record, tmp_path)
    grid = pyvista.read(sorted((tmp_path / "paraview").glob("path*.vtu"))[-1])
    found = np.sort([grid[f"von Mises stress, {face} face"] for face in ("lower", "upper")], axis=0)
    bending = 6 * 1e-3 / 0.1**2
    assert found == pytest.approx(np.array([[2.0 - bending] * 4, [2.0 + bending] * 4]), rel=2e-2)
    assert fx.von_mises(np.array([0.0, 0.0, 2.0])) == pytest.approx(2 * 3**0.5)
    assert fx.von_mises(np.array([[-3.0]])) == pytest.approx([3.0])


@pytest.mark.silent("f05", "t02")
@pytest.mark.parametrize("order", [("pressure", "push"), ("push", "pressure"), ("follower", "pressure", "push")])
def test_energy_balances_in_stages_of_all_kinds(order):
    """Of loads that follow the structure, and of dead ones after them."""
    mesh = straight(4)
    beam = fx.Beam(mesh, fx.Rectangle(0.1, 0.1), fx.Elastic(1e5, 0.0))
    known = {"pressure": fx.LinePressure(beam, 2.0), "push": fx.PointForce(mesh, "tip", (-1.0, 0.0)),
             "follower": fx.FollowerForce(mesh, "tip", (0.4, -0.3))}
    *first, last = (known[name] for name in order)
    scene = fx.Scene([beam], [fx.clamp(mesh, "base"), fx.Support(mesh, "tip", "y")], [last],
                     fx.Monitor(mesh, "tip", "x"), stages=[fx.Stage([load]) for load in first])
    assert fx.trace(fx.Case(scene, fx.LoadControl(0.25, fixed=True))).balance().off < 1e-8
