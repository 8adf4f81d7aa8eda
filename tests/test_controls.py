"""Shapes of the control equation, sign rules of the predictor, and Newton's variants, on paths with known turns.

Lee's frame has a limit of the load, two extremes of the deflection (61.0 and 51.0) and a second limit of the load.
"""

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from mpi4py import MPI
from petsc4py import PETSc
from scipy.sparse import random as sparse_array

import sheetfx as fx
from sheetfx import compat
from sheetfx.case import trace
from sheetfx.continuation.control import SIGNS, ArcLength, DisplacementControl, LoadControl
from sheetfx.continuation.linear import DirectSolver, SingularTangent
from sheetfx.model.scene import Monitor
from sheetfx.path import Path, PathFailure, Until
from sheetfx.scenes import arch, lee_frame, roll_up

COUNTING = "current stiffness with displacement extremes"


def frame(steps=60, **rule):
    case = lee_frame.case(elements=10)
    return replace(case, control=ArcLength(step=0.02, **rule), until=replace(case.until, steps=steps))


def shallow(**rule):
    return replace(arch.case(no_punch=True, elements=10), control=ArcLength(step=0.005, **rule))


def limits(case):
    return [(p.load, p.deflection) for p in trace(case).critical_points if p.kind == "limit"]


@pytest.fixture(scope="module")
def frame_limits():
    return limits(frame())


@pytest.mark.parametrize("sign", ["determinant", COUNTING])
def test_signs_that_pass_all_limits(sign, frame_limits):
    """Limits and extremes of the deflection but no bifurcation: the limits to the solver's tolerance."""
    case = frame(sign=sign, turn=pi)
    assert limits(case) == pytest.approx(np.array(frame_limits), rel=1e-6)


def test_extremes_of_the_displacement_are_counted():
    states = trace(frame()).states
    assert states[-1].displacement_extremes == 2
    for before, after in zip(states, states[1:], strict=False):
        if after.displacement_extremes > before.displacement_extremes:
            assert min(before.deflection, after.deflection) > 50 and max(before.deflection, after.deflection) < 62


@pytest.mark.slow
def test_current_stiffness_turns_back_at_an_extreme_of_the_displacement():
    """It passes the limit of the load, never the first extreme of the deflection (thesis, figure 4.2 b)."""
    states = trace(frame(25, sign="current stiffness", turn=pi)).states
    assert states[-1].step == 25
    behind = states[next(i for i, s in enumerate(states) if s.current_stiffness < 0):]
    assert min(s.load for s in behind) > 10000
    assert sum(s.load_increment > 0 for s in behind[1:]) > 4


@pytest.mark.parametrize("sign", SIGNS)
def test_signs_without_extremes_of_the_displacement(sign):
    """The shallow arch has two limits of the load and nothing else: all rules agree."""
    assert limits(shallow(sign=sign)) == pytest.approx(np.array(limits(shallow())), rel=1e-9)


@pytest.mark.slow
def test_determinant_turns_back_at_a_bifurcation():
    """The whole, higher arch bifurcates on its way down, at 32 mm; the determinant is positive again behind it."""
    case = arch.case(no_punch=True, elements=10, full=True, half_angle=12.0, to=45.0)
    step = case.control.step
    assert trace(case).states[-1].deflection >= 45
    until = replace(case.until, steps=60)
    states = trace(replace(case, control=ArcLength(step=step, sign="determinant", turn=pi), until=until)).states
    assert max(s.deflection for s in states) < 45
    assert sum(b.deflection < a.deflection for a, b in zip(states, states[1:], strict=False)) > 5


def test_counted_extremes_survive_an_interruption():
    """Resumed behind the first extreme, the path goes on as the uninterrupted one."""
    case = frame(sign=COUNTING, turn=pi)
    whole = trace(case).states
    middle = next(i for i, s in enumerate(whole) if s.displacement_extremes == 1) + 1
    resumed = trace(case, start=whole[:middle]).states
    assert [s.load for s in resumed] == pytest.approx([s.load for s in whole], rel=1e-7)


@pytest.mark.parametrize("shape", ["spherical", "elliptical"])
def test_shapes_trace_the_same_path(shape, frame_limits):
    assert limits(frame(shape=shape)) == pytest.approx(np.array(frame_limits), rel=1e-6)


def test_modified_newton_gives_the_same_states_with_one_factorisation_each():
    """Load steps to 88 % of the limit; the unloaded tangent is one factorisation more."""
    case = arch.case(no_punch=True, elements=10)
    records = {n: trace(replace(case, control=LoadControl(step=20.0, target=140.0, fixed=True, newton=n)))
               for n in ("full", "modified")}
    full, modified = (records[n].states for n in ("full", "modified"))
    assert [s.deflection for s in modified] == pytest.approx([s.deflection for s in full], rel=1e-6)
    assert [s.factorisations for s in modified] == [1] * len(modified)
    assert sum(s.iterations for s in modified) > 1.5 * sum(s.iterations for s in full)
    assert sum(s.factorisations for s in full) >= 3 * (len(full) - 1)


def test_modified_newton_passes_limits():
    """The tangent of the step's start serves behind limits too; the points are found by full Newton."""
    assert limits(shallow(newton="modified")) == pytest.approx(np.array(limits(shallow())), rel=1e-6)


def test_displacement_control_stops_where_the_displacement_turns_back():
    """Lee's frame: the first extreme of the deflection, 61.0 at a load of 11 940."""
    case = replace(frame(), control=DisplacementControl(step=1.0, turn=pi))
    with pytest.raises(PathFailure) as failure:
        trace(case)
    last = failure.value.record.states[-1]
    highest = max(s.deflection for s in trace(frame(steps=14)).states)
    assert highest - 0.2 < last.deflection < highest + 0.2


def test_control_of_another_displacement():
    """The increments of the rotation of the frame's corner are the steps."""
    case = frame()
    corner = Monitor(case.scene.parts[0].mesh, "corner", "rz")
    path = Path(case.scene, DisplacementControl(step=0.05, largest=1.0, monitor=corner), replace(case.until, steps=5))
    field, places = path.discretisation.monitored(corner)
    turns = [s.increment[places].sum() for s in path][1:]
    assert np.abs(turns) == pytest.approx(0.05, rel=1e-9)


@pytest.mark.parametrize(("make", "words"), [
    (lambda: ArcLength(sign="work"), "ArcLength: sign is 'work'.*projection, determinant, current stiffness"),
    (lambda: DisplacementControl(sign="up"), "DisplacementControl: sign is 'up'"),
    (lambda: ArcLength(shape="cubic"), "ArcLength: shape is 'cubic'.*cylindrical, spherical, elliptical"),
    (lambda: LoadControl(newton="quasi"), "LoadControl: newton is 'quasi'.*full, modified"),
    (lambda: ArcLength(turn=0.0), "ArcLength: turn is 0.0.*positive"),
])
def test_bad_rules_are_refused(make, words):
    with pytest.raises(ValueError, match=words):
        make()


def test_controlled_displacement_must_respond():
    """Along a straight cantilever nothing moves under an end moment, to the first order."""
    case = roll_up.case(turns=1)
    with pytest.raises(ValueError, match="does not respond to the load.*monitor"):
        trace(replace(case, control=DisplacementControl(monitor=Monitor(case.scene.parts[0].mesh, "tip", "x"))))


def test_pivots_that_other_values_have_made_zero_are_chosen_anew(monkeypatch):
    """The analysis of one matrix serves others of its pattern, but may have chosen pivots that are zero in them.

    So it was in a dome whose contacts had changed since: 75 pivots were zero, of a matrix that was not singular.
    """
    matrix = PETSc.Mat().createAIJ((2, 2), csr=([0, 2, 4], [0, 1, 0, 1], [2.0, 1.0, 1.0, -3.0]), comm=MPI.COMM_SELF)
    solver = DirectSolver(PETSc.KSP().create(MPI.COMM_SELF), matrix, symmetric=False)
    solver.factorise()
    zeros = iter([75, 0])
    monkeypatch.setattr(DirectSolver, "_null_pivots", lambda self: next(zeros))
    solver.factorise()
    right, solution = matrix.createVecs()
    right.array[:] = 3.0, -2.0
    solver.solve(right, solution)
    assert solution.array == pytest.approx([1.0, 1.0])
    assert solver.factorisations == 3
    monkeypatch.setattr(DirectSolver, "_null_pivots", lambda self: 1)
    with pytest.raises(SingularTangent):
        solver.factorise()


@pytest.mark.parametrize("package", ["mumps", "petsc"])
@pytest.mark.parametrize("symmetric", [True, False])
def test_sparse_forces_have_the_responses_of_dense_ones(package, symmetric):
    full = np.random.default_rng(1).normal(size=(40, 40))
    full = full + full.T + 20 * np.eye(40) if symmetric else full
    matrix, ksp = PETSc.Mat().createAIJ((40, 40), comm=MPI.COMM_SELF), PETSc.KSP().create(MPI.COMM_SELF)
    matrix.setUp()
    matrix.setValues(range(40), range(40), full)
    matrix.assemble()
    solver = DirectSolver(ksp, matrix, symmetric)
    ksp.getPC().setFactorSolverType(package)
    solver.factorise()
    rights = sparse_array(40, 6, density=0.1, rng=2, format="csc")
    wanted = np.linalg.solve(full, rights.toarray()).T
    assert solver.responses(rights) == pytest.approx(wanted, abs=1e-10)
    assert solver.responses(rights.toarray()) == pytest.approx(wanted, abs=1e-10)


def test_inertia_where_entries_have_got_other_places():
    """As where contact begins; PETSc makes a new factor then, whose inertia it did not tell."""
    def filled(rows, columns, values, matrix=None):
        made = compat.create_coo_matrix(MPI.COMM_SELF, 3, rows, columns, matrix)
        compat.set_coo_values(made, np.array(values))
        return made

    matrix = filled([0, 1, 2], [0, 1, 2], [1.0, -2.0, 3.0])
    solver = DirectSolver(PETSc.KSP().create(MPI.COMM_SELF), matrix, symmetric=True)
    solver.factorise()
    assert solver.negative_pivots() == 1
    filled([0, 1, 2, 0, 1], [0, 1, 2, 1, 0], [1.0, -2.0, -3.0, 0.5, 0.5], matrix)
    solver.factorise()
    assert solver.negative_pivots() == 2
    right, solution = matrix.createVecs()
    right.array[:] = 1.0, 0.0, 3.0
    solver.solve(right, solution)
    assert solution.array == pytest.approx([1 / 1.125, 0.25 / 1.125, -1.0])


def rolled(axis=(0.0, 1.0, 0.0), **run):
    """A straight beam in space, rolled up by a moment about an axis across it: the tip turns by M L / (E I) = 2."""
    mesh = fx.read(lambda: fx.meshes.frame({"base": (0, 0, 0), "tip": (1, 0, 0)}, {"b": ("base", "tip", 4)}), 3, 2)
    beam = fx.Beam(mesh, fx.Rectangle(0.1, 0.1), fx.Elastic(1.2e5), degree=3)
    scene = fx.Scene([beam], [fx.clamp(mesh, "base")], [fx.Moment(mesh, "tip", tuple(2.0 * c for c in axis))],
                     Monitor(mesh, "tip", "rz" if axis[2] else "ry", -1.0))
    return trace(fx.Case(scene, **run))


@pytest.mark.silent("f02")
@pytest.mark.parametrize("step", [0.5, 0.26, 0.1])
@pytest.mark.parametrize("axis", [(0.0, 1.0, 0.0), (0.0, 0.6, 0.8)])
@pytest.mark.slow(quick=1)
def test_monitored_rotation_in_space_is_an_angle(step, axis):
    """Whatever the steps; 4 cells are off by 4e-8."""
    record = rolled(axis, control=LoadControl(step, fixed=True))
    assert record.states[-1].deflection == pytest.approx(-2.0 * (axis[2] or 1.0), abs=1e-6)


@pytest.mark.silent("f02")
def test_rotation_in_space_is_controlled_by_its_angle():
    """Each step has the angle that is asked for, and the path ends at the bound."""
    record = rolled(control=DisplacementControl(0.7, largest=1.0), until=Until(steps=2))
    assert [s.deflection for s in record.states] == pytest.approx([0.0, -0.7, -1.4], abs=1e-6)
    assert record.states[-1].factor == pytest.approx(0.7, rel=1e-4)
    ended = rolled(control=LoadControl(0.45), until=Until(deflection=1.5)).states[-1]
    assert (ended.deflection, ended.factor) == (pytest.approx(-1.5, abs=1e-5), pytest.approx(0.75, rel=1e-4))
