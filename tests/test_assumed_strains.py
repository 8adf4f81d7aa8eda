"""Shells call their law once at each point, with strains tied to the lower rule."""

from __future__ import annotations

import numpy as np
import pytest
import ufl
from dolfinx import fem
from helpers import distance, move_at_random, tangents
from test_shell_forms import every_form, shape, surface

from sheetfx.discrete.discretisation import Discretisation
from sheetfx.forms.section import linear_shell
from sheetfx.forms.shell import ShellStrains
from sheetfx.model.loads import PointForce
from sheetfx.model.plate import Plate
from sheetfx.model.scene import Monitor, Scene
from sheetfx.model.section import Elastic
from sheetfx.model.shell import FORMS, TRIANGLE, Shell
from sheetfx.model.supports import Support

THICKNESS = 0.1


def panel(form, place, **settings):
    mesh = surface(form, (2, 2), place)
    shell = Shell(mesh, Plate(THICKNESS), Elastic(1.0, 0.3), form=form, **settings)
    return Discretisation(Scene([shell], [Support(mesh, "south-west", "x y z")],
                                [PointForce(mesh, "north-east", (0.0, 0.0, 1e-3))], Monitor(mesh, "north-east", "z")))


def linear_in_the_nodes(u, rotation, frame):
    """Strains that are linear in nodal values, the quaternion's components included."""
    t, n = frame.tangents, frame.director
    vector = ufl.as_vector([rotation.quaternion[i] for i in range(1, 4)])
    rate = [frame.along(u, a) for a in t]
    turn = [ufl.as_vector([frame.along(rotation.quaternion, a)[i] for i in range(1, 4)]) for a in t]
    return ShellStrains(
        membrane=ufl.as_vector([ufl.dot(rate[0], t[0]), ufl.dot(rate[1], t[1]),
                                ufl.dot(rate[0], t[1]) + ufl.dot(rate[1], t[0])]),
        bending=ufl.as_vector([ufl.dot(turn[0], t[1]), ufl.dot(turn[1], t[0]), ufl.dot(turn[0], t[0])]),
        shear=ufl.as_vector([ufl.dot(rate[a], n) + 2 * ufl.dot(vector, ufl.cross(n, t[a])) for a in range(2)]),
        drilling=2 * ufl.dot(vector, n) - (ufl.dot(rate[0], t[1]) - ufl.dot(rate[1], t[0])) / 2)


@pytest.mark.parametrize("form", ["naghdi-q2", pytest.param("naghdi-q3", marks=pytest.mark.slow)])
@pytest.mark.slow
def test_energy_is_that_of_selective_reduced_integration_on_affine_cells(form):
    """(1 - share) of the low rule and the share of the full one, where strains have the degree of the full rule."""
    discretisation = panel(form, lambda x: x @ np.array([[1, 0.2, 0], [0.3, 0.8, 0], [0, 0, 0]]),
                           strains=linear_in_the_nodes)
    move_at_random(discretisation, size=0.1)
    (shell,) = discretisation.scene.parts
    k, discrete, frame = discretisation.kinematics(shell.mesh), shell.discrete, shell.frame()
    strains = linear_in_the_nodes(k.u, k.total_rotation, frame).vector
    share = discrete.share(frame.domain, THICKNESS)
    shares = ufl.as_vector([*3 * [share], *3 * [1.0], *3 * [share]])
    scaled = {}
    for rule, weights in (("low", [1 - shares[i] for i in range(9)]), ("full", [shares[i] for i in range(9)])):
        forces = linear_shell(strains, shell.section.stiffness(shell.material))
        density = sum(w * f * e for w, f, e in zip(weights, forces, strains, strict=True)) / 2
        measure = ufl.dx(metadata=getattr(discrete, rule).metadata)
        scaled[rule] = fem.assemble_scalar(fem.form(density * measure))
    assert scaled["low"] > 0.05 * scaled["full"] > 0
    assert discretisation.strain_energy(shell) == pytest.approx(sum(scaled.values()), rel=1e-12)


def seen_together(strains, stiffness):
    """A law of which every force depends on every strain, and moduli on the strains."""
    e = ufl.variable(strains)
    linear = ufl.dot(linear_shell(e, stiffness), e) / 2
    mixed = sum((1 + i) * e[i] for i in range(9))
    return ufl.diff(linear * (1 + 0.3 * mixed) + 0.1 * mixed**4, e)


@pytest.mark.slow
@pytest.mark.parametrize("form", ["naghdi-q2", "naghdi-t2"])
@pytest.mark.parametrize("mixed_points", [True, False])
def test_tangent_of_a_coupled_law_is_exact(form, mixed_points):
    mesh = surface(form, (1, 1), shape("curved"))
    shell = Shell(mesh, Plate(THICKNESS), Elastic(1.0, 0.3), form=form, law=seen_together)
    scene = Scene([shell], [Support(mesh, "south-west", "x y z")], [PointForce(mesh, "north-east", (0.0, 0.0, 1e-3))],
                  Monitor(mesh, "north-east", "z"))
    discretisation = Discretisation(scene, mixed_points)
    x = move_at_random(discretisation, size=0.05)
    assembled, differences = tangents(discretisation.system, x, step=1e-3)
    assert distance(assembled, assembled.T) < 1e-14
    assert distance(assembled + assembled.T, differences + differences.T) < 1e-7


@every_form
@pytest.mark.slow(quick=1)
def test_constant_strains_are_in_equilibrium_on_distorted_cells(form):
    """Patch test: a homogeneous stretch leaves no force inside, whatever the (straight) cells."""
    def hat(x):
        a, b = 2 * x[:, 0] - 1, 2 * x[:, 1] - 1
        if FORMS[form].cell == TRIANGLE:
            return 1 - np.max(np.abs([a, b, a + b]), axis=0)
        return (1 - np.abs(a)) * (1 - np.abs(b))

    discretisation = panel(form, lambda x: x + np.outer(np.maximum(hat(x), 0), (0.06, -0.08, 0.0)))
    field, _ = discretisation.unknowns.fields
    stretch = 1e-6 * np.array([[1.0, 0.4, 0.0], [0.4, -0.7, 0.0], [0.0, 0.0, 0.0]])
    field.value.interpolate(lambda x: stretch @ x)
    forces = discretisation.system._forces()
    discretisation.works_of_parts[0].residual(forces)
    found, places = forces.on(0), field.value.function_space.tabulate_dof_coordinates()
    inside = (np.abs(places[:, :2] - 0.5) < 0.49).all(axis=1)
    assert inside.any()
    assert np.abs(found[inside]).max() < 1e-8 * np.abs(found).max()
