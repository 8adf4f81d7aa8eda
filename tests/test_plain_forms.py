"""Paths of residual forms in DOLFINx: published folds, bifurcations in closed form, and what is refused by name."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import basix.ufl
import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from helpers import on_two_processes
from mpi4py import MPI
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.special import ellipk

import sheetfx as fx

BRATU = 3.513830719125162  # 8 (t / cosh t)^2 with t tanh t = 1 (Ascher, Mattheij and Russell 1995, p. 89)
BRATU_SQUARE = 6.808124423  # Mohsen 2014, table 1
SOURCES = {"exp": 0, "sin": 1, "u": 2, "u^2": 3, "u^3": 4}


def at_ends(space):
    return fem.locate_dofs_geometrical(space, lambda x: np.isclose(x[0] * (1 - x[0]), 0))


class Line:
    """k (-u'' + wind u') = k unit f(u) load factor on the unit interval, u(0) = u(1) = 0; f is a sum of sources."""

    def __init__(self, cells=20, degree=2, held=True, stiffness=1.0, unit=1.0, wind=0.0, weight=0.0, **sources):
        domain = mesh.create_unit_interval(MPI.COMM_WORLD, cells)
        space = fem.functionspace(domain, ("Lagrange", degree))
        factors = np.zeros(5)
        for name, factor in sources.items():
            factors[SOURCES[name.replace("_", "^")]] = factor
        numbers = fem.Constant(domain, np.array([stiffness, unit, wind, weight, *factors]))
        self.u, self.load, v = fem.Function(space), fem.Constant(domain, 0.0), ufl.TestFunction(space)
        u, k, (x,) = self.u, numbers, ufl.SpatialCoordinate(domain)
        source = sum(k[4 + n] * f for n, f in enumerate((ufl.exp(u), ufl.sin(u), u, u**2, u**3)))
        self.form = k[0] * ufl.exp(k[3] * x) * (
            u.dx(0) * v.dx(0) + k[2] * u.dx(0) * v - self.load * k[1] * source * v) * ufl.dx
        self.bcs = [fem.dirichletbc(0.0, at_ends(space), space)] if held else []

    def path(self, until, **options):
        return fx.continuation(self.form, self.u, self.load, self.bcs, until=until, **options)

    def trace(self, until, **options):
        return fx.trace(self.path(until, **options))


def fold(cells, degree=2, **given):
    (point,) = Line(cells, degree, **({"exp": 1.0} | given)).trace(fx.Until(deflection=1.2)).critical_points
    assert (point.kind, point.name) == ("limit", "maximum")
    return point.load


@pytest.mark.parametrize(("degree", "cells", "exact"), [(2, 16, 1e-5), (3, 16, 1e-8)])
@pytest.mark.slow(quick=1)
def test_bratu_on_a_line(degree, cells, exact):
    """Cells of half the length leave 4^-p of the error, which is then no more than 1.1 of the change by halving."""
    coarse, fine = (fold(n, degree) for n in (cells // 2, cells))
    assert abs(fine - BRATU) < exact and (coarse - BRATU) / (fine - BRATU) == pytest.approx(4**degree, rel=0.1)


def test_bratu_on_a_square():
    def limit(cells):
        square = mesh.create_unit_square(MPI.COMM_WORLD, cells, cells)
        space = fem.functionspace(square, ("Lagrange", 3))
        u, v, load = fem.Function(space), ufl.TestFunction(space), fem.Constant(square, 0.0)
        square.topology.create_connectivity(1, 2)
        edges = fem.locate_dofs_topological(space, 1, mesh.exterior_facet_indices(square.topology))
        form = (ufl.dot(ufl.grad(u), ufl.grad(v)) - load * ufl.exp(u) * v) * ufl.dx
        path = fx.continuation(form, u, load, [fem.dirichletbc(0.0, edges, space)], until=fx.Until(deflection=1.0))
        (point,) = fx.trace(path).critical_points
        return point.load

    coarse, fine = limit(4), limit(8)
    assert abs(fine - BRATU_SQUARE) < min(abs(fine - coarse), 1e-5)


@pytest.mark.parametrize(("sources", "name", "slopes", "curvatures"), [
    ({"sin": 1.0}, "stable symmetric", (0, 0), 1 / 8),                   # Euler's elastica
    ({"u": 1.0, "u_3": -1.0}, "stable symmetric", (0, 0), 3 / 4),        # Chafee and Infante
    ({"u": 1.0, "u_3": 1.0}, "unstable symmetric", (0, 0), -3 / 4),
    ({"u": 1.0, "u_2": -1.0}, "asymmetric", (8 / (3 * np.pi), 0), 5 / 6),  # Fisher
])
@pytest.mark.slow(quick=1)
def test_bifurcations_from_the_trivial_solution(sources, name, slopes, curvatures):
    """At (n pi)^2, with Koiter's coefficients by hand: a of the first mode, b of one that is symmetric."""
    record = Line(degree=3, **sources).trace(fx.Until(load=50.0))
    first, second = record.critical_points
    assert [p.load for p in (first, second)] == pytest.approx([np.pi**2, 4 * np.pi**2], rel=1e-6)
    assert first.name == name and [s.unstable_modes for s in record.states][-1] == 2
    assert (first.slope, second.slope) == pytest.approx(slopes, abs=1e-5)
    assert second.curvature == pytest.approx(curvatures, rel=1e-4)


def test_branch_of_the_elastica():
    """load = (2 K(sin(a / 2)))^2 with the largest angle a."""
    line = Line(degree=3, sin=1.0)
    path = line.path(fx.Until(load=15.0))
    record = fx.trace(path)
    (point,) = record.critical_points
    one, other = record.branches(point)
    assert one.start.load == pytest.approx(other.start.load) and one.start.unstable_modes == 0
    for state in fx.Path(path.scene, until=fx.Until(load=30.0), start=[one.start]):
        exact = (2 * ellipk(np.sin(abs(line.u.x.array).max() / 2) ** 2)) ** 2
        assert state.load == line.load.value == pytest.approx(exact, rel=1e-5)
    assert state.load == pytest.approx(30.0) and not state.critical


def test_paths_do_not_depend_on_units():
    one, other = fold(20), fold(20, stiffness=1e-9, unit=1e-6)
    assert other == pytest.approx(1e6 * one, rel=1e-9)
    loads = [Line(sin=1.0, stiffness=k, unit=1 / k).trace(fx.Until(load=15.0 * k)).critical_points[0].load / k
             for k in (1e-9, 1e9)]
    assert loads == pytest.approx([np.pi**2] * 2, rel=1e-5)


def test_lengths_may_count_the_load():
    record = Line(exp=1.0).trace(fx.Until(deflection=1.0), load_scale=3.0, scale=2.0)
    assert [p.load for p in record.critical_points] == pytest.approx([BRATU], rel=1e-6)


def test_unsymmetric_forms():
    """-u'' + 2 u' has the eigenvalues (n pi)^2 + 1, and times exp(-2 x) it is symmetric with the same solutions."""
    with pytest.warns(UserWarning, match="dF/du is not symmetric, so that F is no gradient"):
        record = Line(wind=2.0, u=1.0, u_3=-1.0).trace(fx.Until(load=50.0))
    assert [p.load for p in record.critical_points] == pytest.approx([np.pi**2 + 1, 4 * np.pi**2 + 1], rel=1e-4)
    assert {p.name for p in record.critical_points} == {""}
    assert any("by the real eigenvalues that pass zero" in words for words in record.path.searched)
    with pytest.warns(UserWarning, match="not symmetric"):
        unsymmetric = fold(16, 3, wind=2.0)
    assert unsymmetric == pytest.approx(fold(16, 3, weight=-2.0), rel=1e-7)


def test_loads_without_a_potential_are_seen_in_any_unit():
    domain = mesh.create_unit_interval(MPI.COMM_WORLD, 8)
    space = fem.functionspace(domain, ("Lagrange", 1))
    u, v, load = fem.Function(space), ufl.TestFunction(space), fem.Constant(domain, 0.0)
    form = (1e11 * u.dx(0) * v.dx(0) - load * (u + u.dx(0)) * v) * ufl.dx
    with pytest.warns(UserWarning, match="not symmetric"):
        fx.continuation(form, u, load, [fem.dirichletbc(0.0, at_ends(space), space)])


def test_block_of_rubber():
    """A strip in plane strain under a force at its end buckles near Euler's load, and the load rises from there on."""
    length, modulus, ratio = 20.0, 1.0, 0.3
    domain = mesh.create_rectangle(MPI.COMM_WORLD, [(0, 0), (length, 1)], [20, 2], mesh.CellType.quadrilateral)
    space = fem.functionspace(domain, ("Lagrange", 2, (2,)))
    u, v, load = fem.Function(space), ufl.TestFunction(space), fem.Constant(domain, 0.0)
    gradient = ufl.variable(ufl.Identity(2) + ufl.grad(u))
    shear, bulk = modulus / (2 * (1 + ratio)), modulus * ratio / ((1 + ratio) * (1 - 2 * ratio))
    log = ufl.ln(ufl.det(gradient))
    energy = shear / 2 * (ufl.inner(gradient, gradient) - 2) - shear * log + bulk / 2 * log**2
    end = mesh.locate_entities_boundary(domain, 1, lambda x: np.isclose(x[0], length))
    ends = ufl.Measure("ds", subdomain_data=mesh.meshtags(domain, 1, end, np.full(len(end), 7, dtype=np.int32)))
    degree = {"quadrature_degree": 4}
    form = (ufl.inner(ufl.diff(energy, gradient), ufl.grad(v)) * ufl.dx(metadata=degree) + load * v[0] * ends(7))
    held = fem.locate_dofs_geometrical(space, lambda x: np.isclose(x[0], 0))
    euler = np.pi**2 * modulus / (1 - ratio**2) / 12 / (2 * length) ** 2
    path = fx.continuation(form, u, load, [fem.dirichletbc(np.zeros(2), held, space)], monitor=u[1] * ends(7),
                           until=fx.Until(load=1.5 * euler))
    (point,) = fx.trace(path).critical_points
    assert (point.name, point.load) == ("stable symmetric", pytest.approx(euler, rel=0.01))


@pytest.mark.slow
def test_two_unknowns_of_a_mixed_space():
    """Both buckle together, into a circle of solutions."""
    domain = mesh.create_unit_interval(MPI.COMM_WORLD, 12)
    line = basix.ufl.element("Lagrange", "interval", 2)
    space = fem.functionspace(domain, basix.ufl.mixed_element([line, line]))
    w, load = fem.Function(space), fem.Constant(domain, 0.0)
    square = w[0] ** 2 + w[1] ** 2
    energy = (ufl.inner(ufl.grad(w), ufl.grad(w)) - load * (square - square**2 / 2)) / 2 * ufl.dx
    bcs = [fem.dirichletbc(fem.Function(part), at_ends_of(space.sub(i), part), space.sub(i))
           for i, part in enumerate(space.sub(i).collapse()[0] for i in (0, 1))]
    path = fx.continuation(ufl.derivative(energy, w, ufl.TestFunction(space)), w, load, bcs, until=fx.Until(load=15.0))
    record = fx.trace(path)
    (point,) = record.critical_points
    assert (point.multiplicity, point.load) == (2, pytest.approx(np.pi**2, rel=1e-4))
    assert [branch.family for branch in record.branches(point)] == [True]


def test_the_demo_has_fifteen_lines():
    lines = (Path(__file__).parents[1] / "demos" / "bratu.py").read_text().splitlines()
    assert sum(bool(line) and not line.startswith("#") for line in lines) <= 15


def at_ends_of(part, collapsed):
    return fem.locate_dofs_geometrical((part, collapsed), lambda x: np.isclose(x[0] * (1 - x[0]), 0))


def test_first_state_is_solved_for_and_monitored():
    line = Line(exp=1.0)
    line.load.value = 1.0
    states = list(line.path(fx.Until(steps=2), monitor=line.u * ufl.dx))
    t = brentq(lambda t: 8 * (t / np.cosh(t)) ** 2 - 1, 0.1, 1.0)
    mean = quad(lambda x: -2 * np.log(np.cosh(t * (1 - 2 * x)) / np.cosh(t)), 0.0, 1.0)[0]
    assert states[0].load == 1.0 and states[0].deflection == pytest.approx(mean, rel=1e-5)
    assert states[2].deflection == pytest.approx(fem.assemble_scalar(fem.form(line.u * ufl.dx)), rel=1e-10)


def test_load_factor_may_be_a_function_and_controls_others():
    domain = mesh.create_unit_interval(MPI.COMM_WORLD, 20)
    space, constants = fem.functionspace(domain, ("Lagrange", 2)), fem.functionspace(domain, ("DG", 0))
    u, v, load = fem.Function(space), ufl.TestFunction(space), fem.Function(constants)
    form = (u.dx(0) * v.dx(0) - load * ufl.exp(u) * v) * ufl.dx
    record = fx.trace(fx.continuation(
        form, u, load, [fem.dirichletbc(0.0, at_ends(space), space)], monitor=u * ufl.dx,
        control=fx.DisplacementControl(step=0.1), until=fx.Until(deflection=1.0)))
    assert [p.load for p in record.critical_points] == pytest.approx([BRATU], rel=1e-6)
    assert np.ptp(load.x.array) == 0 and load.x.array[0] == record.states[-1].load


def test_records_and_resumed_paths(tmp_path):
    line = Line(exp=1.0)
    record = line.trace(fx.Until(deflection=1.0))
    (point,) = record.critical_points
    record.show(record.state_at(point))
    assert line.load.value == pytest.approx(BRATU, rel=1e-6) and len(record.critical_modes(point)) == 1
    assert record.curve(tmp_path / "curve.png") is not None and (tmp_path / "curve.png").exists()
    record.states[5].save(tmp_path / "state.npz")
    start = type(record.states[5]).load_from(tmp_path / "state.npz")
    *_, last = fx.Path(record.path.scene, until=fx.Until(deflection=1.0), start=[start])
    assert last.load == pytest.approx(record.states[-1].load, rel=1e-6)
    with pytest.raises(AttributeError, match="a plain form has no parts: only a scene has parts"):
        record.energies()


def test_constant_modes_of_a_free_end():
    """Chafee and Infante's problem with free ends, unstable from the first state on, where u = 0 and the load is 1."""
    line = Line(held=False, u=1.0, u_3=-1.0)
    with pytest.raises(ValueError, match="the tangent dF/du is singular at the first load factor, 0"):
        line.path(None)
    line.load.value = 1.0
    with pytest.warns(UserWarning, match="has 1 negative eigenvalue in the first state"):
        record = line.trace(fx.Until(load=15.0))
    assert [p.load for p in record.critical_points] == pytest.approx([np.pi**2], rel=1e-5)
    line.u.x.array[:], line.load.value = 1.0, 1.0
    with pytest.raises(ValueError, match="u does not respond to load_factor; give load_scale"):
        line.path(None)
    assert not line.trace(fx.Until(load=15.0), load_scale=10.0).critical_points


def test_same_path_on_two_processes():
    lines = on_two_processes("""
import sheetfx as fx
from test_plain_forms import Line
for sources, until in (({"exp": 1.0}, fx.Until(deflection=1.0)), ({"sin": 1.0}, fx.Until(load=15.0))):
    record = Line(**sources).trace(until)
    for state in record.states:
        print(state.load, state.deflection, state.unstable_modes)
    print(*[(p.kind, p.name, round(p.load, 7)) for p in record.critical_points])""")
    expected = []
    for sources, until in (({"exp": 1.0}, fx.Until(deflection=1.0)), ({"sin": 1.0}, fx.Until(load=15.0))):
        record = Line(**sources).trace(until)
        expected += [(s.load, s.deflection, s.unstable_modes) for s in record.states]
        assert " ".join(map(str, [(p.kind, p.name, round(p.load, 7)) for p in record.critical_points])) in lines
    found = [[float(n) for n in line.split()] for line in lines if "(" not in line]
    assert len(found) == len(expected) and np.allclose(found, expected, rtol=1e-6, atol=1e-9)


def wrong(case, line):
    """Arguments of `fx.continuation` of which one is wrong."""
    u, load, form, bcs, options = line.u, line.load, line.form, line.bcs, {}
    other = Line(exp=1.0)
    if case == "energy":
        form = ufl.inner(u, u) * load * ufl.dx
    elif case == "matrix":
        form = ufl.derivative(form, u)
    elif case == "no form":
        form = u
    elif case == "other u":
        u = fem.Function(u.function_space, name="other")
    elif case == "other space":
        form = u * load * ufl.TestFunction(fem.functionspace(u.function_space.mesh, ("Lagrange", 1))) * ufl.dx
    elif case == "no load":
        load = other.load
    elif case == "number":
        load = 0.0
    elif case == "vector":
        load = fem.Constant(u.function_space.mesh, (0.0, 0.0))
    elif case == "nan":
        load.value = np.nan
    elif case == "other bc":
        bcs = other.bcs
    elif case == "no bc":
        bcs = [at_ends(u.function_space)]
    elif case == "moving bc":
        bcs = [fem.dirichletbc(load, at_ends(u.function_space), u.function_space)]
    elif case == "monitor":
        options = {"monitor": ufl.TestFunction(u.function_space) * u * ufl.dx}
    elif case == "scale":
        options = {"scale": -1.0}
    elif case == "far":
        load.value = 5.0
    elif case == "no numbers":
        u.x.array[:] = 1e3
    elif case == "control":
        options = {"control": fx.DisplacementControl(monitor=ARCH)}
    return partial(fx.continuation, form, u, load, bcs, **options)


class ARCH:
    component = "y"


@pytest.mark.parametrize(("case", "message"), [
    ("energy", r"F has 0 arguments and must have one, the test function; give its derivative, ufl.derivative\(F, u\)"),
    ("matrix", "F has 2 arguments and must have one, the test function; give the residual, not its derivative"),
    ("no form", "F is .*; give a UFL form, the residual"),
    ("other u", r"F has no u \(other\) in it; write it in the Function that is given as u"),
    ("other space", "the test function of F is of another space than u; make it by ufl.TestFunction"),
    ("no load", "load_factor does not occur in F; write F with it, or give the one that does"),
    ("number", "load_factor is 0.0; give a scalar Constant of DOLFINx"),
    ("vector", "load_factor is .*; give a scalar Constant of DOLFINx"),
    ("nan", "load_factor has values from nan to nan; give a Constant, or a Function that is uniform and finite"),
    ("other bc", r"bcs\[0\] is of another space than u; make it with the space of u, or a sub-space of it"),
    ("no bc", r"bcs\[0\] is .*; give what fem.dirichletbc returns"),
    ("moving bc", r"the value of bcs\[0\] is the load factor, and must be fixed: write u \+ load_factor \* g for u"),
    ("monitor", "monitor is no UFL form of rank 0 in u; give an integral, such as u"),
    ("scale", "scale is -1.0"),
    ("far", "Newton's method finds no solution of F = 0 near the u given, at the load factor 5: after 25 iterations"),
    ("no numbers", "F is not a finite number in the first state"),
    ("control", "DisplacementControl: monitor is .*; a plain form is controlled by the value that it monitors"),
])
def test_wrong_input_is_named(case, message):
    with pytest.raises(ValueError, match=message) as refused:
        wrong(case, Line(exp=1.0))()
    assert "\n" not in str(refused.value)
