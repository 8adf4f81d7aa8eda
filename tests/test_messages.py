"""Messages that name the object, the value and the remedy, where they used to mislead."""

from __future__ import annotations

from math import inf, nan

import numpy as np
import pytest
import ufl
from helpers import hinged_column, shallow_arch

import sheetfx as fx
from sheetfx.continuation.linear import SingularTangent
from sheetfx.model.shell import first_axis

SECTION, MATERIAL = fx.Rectangle(0.1, 0.1), fx.Elastic(1e4)


def line(cells: int = 2, dimension: int = 3):
    """A line along x from the point a to b."""
    zeros = (0.0,) * (dimension - 1)
    return fx.read(lambda: fx.meshes.frame({"a": (0.0, *zeros), "b": (1.0, *zeros)}, {"line": ("a", "b", cells)}),
                   dimension)


@pytest.mark.parametrize("up", [(1.0, 0.0, 0.0), (-2.0, 1e-9, 0.0), (0.0, 0.0, 0.0)])
def test_beam_whose_depth_lies_along_it(up):
    with pytest.raises(ValueError, match=r"Beam: up is .*parallel to 2 cells of group 'all'; give a direction across"):
        fx.Beam(line(), SECTION, MATERIAL, up=up)


def test_bar_of_two_cells():
    nodes = {"a": (-1.0, 0.0), "b": (1.0, 0.0), "c": (0.0, 1.0)}
    mesh = fx.read(lambda: fx.meshes.frame(nodes, {"one": ("a", "c", 1), "two": ("b", "c", 2)}), 2)
    scene = fx.Scene([fx.Bar(mesh, SECTION, MATERIAL)], [fx.pin(mesh, "a"), fx.pin(mesh, "b")],
                     [fx.PointForce(mesh, "c", (0.0, 1.0))], fx.Monitor(mesh, "c", "y"))
    with pytest.raises(ValueError, match="1 nodes join two bars in line, which hinge there; mesh each bar with one"):
        fx.Path(scene)


@pytest.mark.parametrize(("make", "words"), [
    (lambda m: fx.Monitor(m, "b", "u"), "Monitor at 'b': no component 'u'; choose from x y z rx ry rz"),
    (lambda m: fx.Monitor(m, "c", "x"), "no point or edge named 'c'"),
    (lambda m: fx.Monitor(fx.RigidCylinder(1.0, (0.0, 2.0))), "Monitor: .*does not travel"),
    (lambda m: fx.RigidCylinder(inf, (0.0, 2.0)), "RigidCylinder: radius is inf; it must be finite"),
    (lambda m: fx.RigidPlane((0.0, nan), (0.0, 1.0)), r"RigidPlane: point is \(0.0, nan\); it must be finite"),
    (lambda m: fx.Contact(fx.Beam(m, SECTION, MATERIAL), fx.RigidCylinder(1.0, (0.0, 2.0)), layer=nan),
     "Contact: layer is nan; it must be finite"),
    (lambda m: fx.Contact(fx.Beam(m, SECTION, MATERIAL), fx.RigidCylinder(1.0, (0.0, 2.0)), scale=inf),
     "Contact: scale is inf; it must be finite"),
])
def test_wrong_values_are_named(make, words):
    with pytest.raises(ValueError, match=words):
        make(line())


def square(dimension: int = 3):
    return fx.read(lambda: fx.meshes.rectangle((1, 1)), dimension)


@pytest.mark.parametrize(("make", "words"), [
    (lambda: fx.Beam(square(), SECTION, MATERIAL),
     r"Beam: its mesh is one of surfaces \('shell'\); give a mesh of curves: read_mixed\(..., bars="),
    (lambda: fx.Bar(square(), SECTION, MATERIAL), "Bar: its mesh is one of surfaces"),
    (lambda: fx.Shell(line(), fx.Plate(0.1), MATERIAL),
     r"Shell: its mesh is one of curves \('line'\); give a mesh of surfaces"),
    (lambda: fx.Shell(square(2), fx.Plate(0.1), MATERIAL), "Shell: .* is one in the plane; read it in 3 dimensions"),
])
def test_parts_on_cells_of_another_dimension(make, words):
    with pytest.raises(ValueError, match=words):
        make()


@pytest.mark.parametrize(("supports", "component", "words"), [
    ([("a", "x y z rx", None)], "y", "'a'"), ([("a", "x y z rx", None)], "rx", "'a'"),
    ([("a", "x y z rx", None)], "ry", None), ([("b", "x y z", None)], "x", None),
    ([("a", "x", ((0.6, 0.8, 0), (-0.8, 0.6, 0), (0, 0, 1)))], "x", None),
    ([("a", "x y", ((0.6, 0.8, 0), (-0.8, 0.6, 0), (0, 0, 1)))], "x", "'a'"),
    ([("a", "x", ((0.6, 0.8, 0), (-0.8, 0.6, 0), (0, 0, 1))), ("a", "x z", None)], "y", "'a'"),
])
def test_monitor_of_what_supports_hold(supports, component, words):
    """Along the axes of space, along others, and by several together."""
    mesh = line()
    held = [fx.Support(mesh, at, fixed, axes) for at, fixed, axes in supports]

    scene = fx.Scene([fx.Beam(mesh, SECTION, MATERIAL)], held, [fx.PointForce(mesh, "b", (0, 0, 1.0))],
                     fx.Monitor(mesh, "a", component))
    if words is None:
        scene.require_free(scene.monitor)
        return
    with pytest.raises(ValueError, match=f"Monitor at 'a': its component {component} is held by the support at {words},"
                                         " so that it stays zero; monitor a component that moves"):
        fx.Path(scene)


def test_control_of_what_a_support_holds():
    scene = hinged_column()
    held = next(s for s in scene.supports if "y" in s.fixed.split())
    control = fx.DisplacementControl(monitor=fx.Monitor(held.mesh, held.at, "y"))
    with pytest.raises(ValueError, match=f"Monitor at '{held.at}': its component y is held by the support at "):
        fx.Path(scene, control)


@pytest.mark.parametrize("axis", [
    lambda x: ufl.as_vector([2.0, 0.0, 0.0]), lambda x: (1.0, 0.0, 0.0), lambda x: [1, 0 * x[0], 0],
    lambda x: np.array([1.0, 0.0, 0.0]), lambda x: ufl.as_vector([1.0 + x[1], 0.0, 0.0]), (3.0, 0.0, 0.0)])
def test_axis_of_a_shell_may_be_given_in_many_ways(axis):
    directions = first_axis(square(), axis).x.array
    assert list(directions) == pytest.approx([1.0, 0.0, 0.0])


@pytest.mark.parametrize("axis", [lambda x: 3.0, lambda x: (1.0, 0.0), lambda x: None, lambda x: ("x", 0, 0)])
def test_axis_of_a_shell_that_is_no_vector(axis):
    with pytest.raises(ValueError, match="Shell: axis .*; give a vector with three components"):
        fx.Shell(square(), fx.Plate(0.1), MATERIAL, axis=axis)


def test_refused_step_says_what_refuses_it():
    """Every step of a path that is allowed to turn by no more than a microradian."""
    with pytest.raises(fx.PathFailure, match=r"is refused even with a step of .*: it converges, but it turns off the "
                                             r"path by .* radians, more than 1e-09"):
        fx.trace(fx.Case(shallow_arch(10), fx.ArcLength(0.01, turn=1e-9, smallest=0.1), fx.Until(deflection=2.0)))


def test_load_control_unloads_too():
    """From a loaded state to a smaller load, on the same path; to the present load there is no step to take."""
    case = fx.Case(shallow_arch(10), fx.LoadControl(20.0, target=100.0))
    loaded = fx.trace(case).states
    back = fx.trace(fx.Case(case.scene, fx.LoadControl(20.0, target=0.0)), start=loaded)
    assert back.path.message == "load factor 0 reached" and back.states[-1].load == pytest.approx(0.0, abs=1e-12)
    assert back.states[-1].deflection == pytest.approx(0.0, abs=1e-9)
    loads = [s.load for s in back.states[len(loaded):]]
    assert len(loads) > 1 and loads == sorted(loads, reverse=True)
    there = fx.trace(case, start=loaded)
    assert len(there.states) == len(loaded) and there.path.message == "load factor 100 reached"


def test_a_run_says_what_it_has_searched_for():
    """Dead loads, a load that follows, contact without and with friction, and prescribed steps."""
    from helpers import ring_under_pressure

    from sheetfx.scenes import arch

    def said(scene, control=None):
        return " ".join(fx.Path(scene, control).searched)

    assert "inertia of the tangent" in said(shallow_arch(4)) and "steps that leave the smooth path are cut" in said(
        shallow_arch(4))
    assert "flutter: not looked for (a part has no density)" in said(ring_under_pressure())
    touching = said(arch.case(elements=40).scene)
    assert "at the ends of steps, and between where the load turns" in touching and "bends away" in touching
    assert "not looked for (friction of a Contact" in said(arch.case(elements=40, friction=0.2).scene)
    assert "steps are taken as they are" in said(shallow_arch(4), fx.LoadControl(fixed=True))


def unsymmetric(strains, stiffness):
    """A law whose shear force depends on the stretch, but not the axial force on the shear."""
    return ufl.as_vector([stiffness[0] * strains[0], stiffness[1] * (strains[1] + 0.1 * strains[0]),
                          stiffness[2] * strains[2]])


def test_law_that_is_no_gradient_is_refused():
    with pytest.raises(ValueError, match="Beam: its law 'unsymmetric' is not the gradient of an energy: resultant 0"):
        fx.Beam(line(dimension=2), SECTION, MATERIAL, law=unsymmetric)


def test_a_name_of_another_kind_is_told():
    """A group of curves is no edge that a support holds, but the mesh knows the name; this was not said."""
    mesh = line()
    group, = mesh.cells
    with pytest.raises(ValueError, match=f"no point or edge named '{group}' \\(it is a group of cells\\); it has "):
        fx.pin(mesh, group)


def test_a_tangent_that_is_singular_within_a_step_is_told(monkeypatch):
    """The search for critical points may come to states whose tangent cannot be factored: the step is cut there."""
    def singular(*_):
        raise SingularTangent

    monkeypatch.setattr("sheetfx.path.locate", singular)
    with pytest.raises(fx.PathFailure, match="it converges, but the tangent is singular within it"):
        list(fx.Path(hinged_column(), fx.LoadControl(step=1.0, target=2.0)))
