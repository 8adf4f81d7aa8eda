"""What is said of structures that cannot be solved: free motions, missing numbers, thin shells, limits, rounding."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np
import pytest
import ufl
from helpers import hinged_arch, shallow_arch, whole_arch

import sheetfx as fx
from sheetfx.forms.shell import naghdi

SECTION, MATERIAL = fx.Rectangle(0.1, 0.1), fx.Elastic(1e4)


def refusal(scene) -> str:
    with pytest.raises(ValueError, match=".") as caught:
        fx.Path(scene)
    return str(caught.value)


def frame(dimension: int, supports):
    """Two beams at right angles in one plane, loaded at their joint."""
    zeros = (0.0,) * (dimension - 2)
    nodes = {"a": (0, 0, *zeros), "b": (0, 1, *zeros), "c": (1, 1, *zeros)}
    mesh = fx.read(lambda: fx.meshes.frame(nodes, {"l": ("a", "b", 2), "m": ("b", "c", 2)}), dimension)
    return fx.Scene([fx.Beam(mesh, SECTION, MATERIAL)], [fx.Support(mesh, *s) for s in supports],
                    [fx.PointForce(mesh, "b", (1.0,) * dimension)], fx.Monitor(mesh, "b", "xxy"[dimension - 1]))


@pytest.mark.parametrize(("dimension", "supports", "words"), [
    (2, [("a", "x y")], "the structure can turn about (0, 0);"),
    (2, [("a", "y rz")], "the structure can move along x;"),
    (2, [("a", "y")], "the structure can move along x and can turn about (0, "),
    (3, [("a", "x y z")], "the structure can turn about every axis through (0, 0, 0);"),
    (3, [("a", "x y z"), ("c", "x y z")], "the structure can turn about (0.7071, 0.7071, 0) through "),
    (3, [("a", "rx ry rz"), ("c", "z")], "the structure can move along x and y;"),
])
def test_rigid_motion_of_a_frame(dimension, supports, words):
    assert words in refusal(frame(dimension, supports))


def plate(supports, thickness=0.1, size=1.0, **how):
    mesh = fx.read(lambda: fx.meshes.rectangle((3, 3), (size, size)), 3, 2)
    shell = fx.Shell(mesh, fx.Plate(thickness), MATERIAL, form="naghdi-q2", **how)
    return fx.Scene([shell], [fx.Support(mesh, *s) for s in supports],
                    [fx.PointForce(mesh, "south-east", (0.3, 0.5, 1.0))],
                    fx.Monitor(mesh, "south-east", "z"))


CLAMPED = [("west", "x y z rx ry rz")]


@pytest.mark.parametrize(("supports", "words"), [
    ([("west", "x y z")], "the structure can turn about y through (0, 0.5, 0);"),
    ([("west", "z"), ("north", "z")], "the structure can move along x and y and can turn about z through "),
])
def test_rigid_motion_of_a_shell(supports, words):
    assert words in refusal(plate(supports))


@pytest.fixture
def unchecked(monkeypatch):
    """Strain measures that nothing has looked at, as those that fail within a cell only."""
    monkeypatch.setattr("sheetfx.model.shell.require_strains", lambda part, function, count: count)


@pytest.mark.usefixtures("unchecked")
@pytest.mark.slow
def test_strains_without_drilling():
    def strains(u, rotation, frame):
        found = naghdi(u, rotation, frame)
        return replace(found, drilling=0 * found.drilling)

    text = refusal(plate(CLAMPED, strains=strains))
    assert "rotations of the Shell on shell about its normal have no stiffness" in text
    assert "check that the supports" not in text


@pytest.mark.usefixtures("unchecked")
@pytest.mark.slow
def test_strains_without_shear():
    def strains(u, rotation, frame):
        found = naghdi(u, rotation, frame)
        return replace(found, shear=0 * found.shear)

    assert "the Shell on shell moves most at" in refusal(plate(CLAMPED, strains=strains))


@pytest.mark.usefixtures("unchecked")
@pytest.mark.filterwarnings("ignore:invalid value")
@pytest.mark.slow
def test_tangent_without_numbers():
    def strains(u, rotation, frame):
        found = naghdi(u, rotation, frame)
        return replace(found, drilling=ufl.sqrt(found.drilling))

    assert refusal(plate(CLAMPED, strains=strains)).startswith(
        "Shell on shell: its tangent in the first state is not a finite number in 9 of 9 cells, first in cell 0 at (")


def locking(linear):
    """A law whose first resultant grows as its strain nears 0.005, and is no real number beyond."""
    def law(strains, stiffness):
        found = [*linear(strains, stiffness)]
        found[0] += 100.0 * (1 - ufl.sqrt(1 - 200 * strains[0])) - 1e4 * strains[0]
        return ufl.as_vector(found)
    return law


def pulled(kind):
    """A strip whose thin half locks under a tension of 100, before its load of 200 is reached."""
    if kind is fx.Shell:
        mesh = fx.read(lambda: fx.meshes.rectangle((2, 1)), 3, 2)
        part = fx.Shell(mesh, fx.Plate(0.1), MATERIAL, law=locking(fx.forms.section.linear_shell))
        return fx.Scene([part], [fx.Support(mesh, "west", "x y z rx ry rz")],
                        [fx.EdgeForce(mesh, "east", (200.0, 0.0, 0.0))], fx.Monitor(mesh, "south-east", "x"))
    mesh = fx.read(lambda: fx.meshes.frame({"a": (0, 0), "b": (1, 0), "c": (3, 0)},
                                           {"thick": ("a", "b", 1), "thin": ("b", "c", 2)}), 2)
    thick = fx.Beam(mesh, SECTION, fx.Elastic(1e7), group="thick")
    thin = fx.Beam(mesh, SECTION, fx.Elastic(1e6), group="thin", law=locking(fx.forms.section.linear_elastic))
    return fx.Scene([thick, thin], [fx.clamp(mesh, "a")], [fx.PointForce(mesh, "c", (200.0, 0.0))],
                    fx.Monitor(mesh, "c", "x"))


@pytest.mark.filterwarnings("ignore:invalid value")
@pytest.mark.parametrize(("kind", "words"), [
    (fx.Beam, r"Beam on thin: its tangent in step \d+ is not a finite number"),
    (fx.Shell, r"Shell on shell: its forces in step \d+ are not finite numbers")])
@pytest.mark.slow(quick=1)
def test_numbers_that_end_in_a_later_step(kind, words):
    with pytest.raises(fx.PathFailure, match=rf"{words} in [12] of 2 cells, first in cell \d at \(") as failure:
        fx.trace(fx.Case(pulled(kind), fx.LoadControl(0.1)))
    assert "look at the strains and the law of that part" in str(failure.value)
    states = failure.value.record.states
    assert states[-1].factor < 0.5 and len(states) > 2


@pytest.mark.parametrize("size", [1e-6, 1.0, 1e6])
def test_shell_too_thin_for_double_precision(size):
    text = refusal(plate(CLAMPED, 1e-9 * size, size))
    assert text.startswith(f"Shell on shell: thickness is {1e-9 * size:g}, 7.1e-10 of its size")


def two_beams(joints=lambda one, two: (), supports="x y"):
    one, two = (fx.read(lambda n=n, at=at: fx.meshes.frame({n[0]: (at, 0), n[1]: (at + 1, 0)}, {n: (*n, 2)}), 2)
                for n, at in (("ab", 0), ("bc", 1)))
    return fx.Scene([fx.Beam(one, SECTION, MATERIAL), fx.Beam(two, SECTION, MATERIAL)],
                    [fx.Support(one, "a", supports), fx.Support(two, "c", "x y")],
                    [fx.PointForce(one, "b", (0.0, 1.0))], fx.Monitor(one, "b", "y"), joints=joints(one, two))


def test_mechanism_of_two_beams():
    text = refusal(two_beams(lambda one, two: [fx.hinge(one, "b", (two, "b"))]))
    assert "the Beam on ab turns about (0, 0), the Beam on bc turns about (2, 0)" in text


@pytest.mark.filterwarnings("ignore:Scene. nothing joins")
def test_beam_that_hangs_on_nothing_else():
    text = refusal(two_beams(supports="x y rz"))
    assert "the Beam on bc, which nothing joins to the Beam on ab, can turn about (2, 0)" in text


@pytest.mark.parametrize("size", [1e-9, 1.0, 1e9])
def test_buckling_in_any_unit(size):
    """Square plate of steel on four edges: k = 4.00 (4.0013 with 6 cells to an edge)."""
    mesh = fx.read(lambda: fx.meshes.rectangle((6, 6), (size, size)), 3, 2)
    shell = fx.Shell(mesh, fx.Plate(size / 100), fx.Elastic(2e11, 0.3), form="naghdi-q2")
    unit = pi**2 * 2e11 * (size / 100) ** 3 / 12 / 0.91 / size**2
    supports = [*(fx.Support(mesh, e, "z rx") for e in ("west", "east")),
                *(fx.Support(mesh, e, "z ry") for e in ("south", "north")),
                fx.Support(mesh, "south-west", "x y"), fx.Support(mesh, "south-east", "y")]
    loads = [fx.EdgeForce(mesh, "west", (unit, 0.0, 0.0)), fx.EdgeForce(mesh, "east", (-unit, 0.0, 0.0))]
    record = fx.trace(fx.Case(fx.Scene([shell], supports, loads, fx.Monitor(mesh, "south-east", "x", -1.0)),
                              until=fx.Until(steps=0)))
    assert record.buckling(record.states[0], count=1)[0].factor == pytest.approx(4.0013, rel=1e-4)


def on_spring(stiffness, size=1.0):
    """A beam that is pinned at one end and stands on a spring at the other."""
    mesh = fx.read(lambda: fx.meshes.frame({"a": (0, 0), "b": (size, 0)}, {"l": ("a", "b", 4)}), 2)
    return fx.Scene([fx.Beam(mesh, fx.Rectangle(0.1 * size, 0.1 * size), fx.Elastic(1e9))], [fx.pin(mesh, "a")],
                    [fx.PointForce(mesh, "b", (0.0, stiffness * size))], fx.Monitor(mesh, "b", "y"),
                    joints=[fx.Spring(mesh, "b", "y", stiffness)])


@pytest.mark.parametrize("size", [1e-9, 1.0, 1e9])
@pytest.mark.parametrize("softness", [1e-4, 1e-10])
def test_soft_spring_holds(softness, size):
    path = fx.Path(on_spring(softness * 1e9 * size, size))
    assert path.tracer.rate("deflection") == pytest.approx(size, rel=1e-2)


def test_unstable_at_rest():
    with pytest.warns(UserWarning, match=r"unloaded structure is unstable in 1 mode \(the structure can turn about"):
        fx.Path(on_spring(-1.0))


@pytest.mark.parametrize("make", [lambda: shallow_arch(6), lambda: hinged_arch(whole_arch(6))])
def test_limit_point_under_load_control(make):
    """Limit loads as arc length finds them."""
    scene = make()
    limit = next(p.load for s in fx.Path(scene, fx.ArcLength()) for p in s.critical if p.kind == "limit")
    with pytest.raises(fx.PathFailure, match=r"limit point lies just ahead.*fx.ArcLength\(\).*record.snap") as caught:
        list(fx.Path(make(), fx.LoadControl(limit / 8, target=np.inf)))
    found = float(str(caught.value).split("a load of about ")[1].split(",")[0])
    assert found == pytest.approx(limit, rel=1e-5)


@pytest.mark.silent("q18")
@pytest.mark.parametrize("load", [1e-6, 1e-8, 1e-10, 1e-12])
def test_tiny_loads(load):
    """A cantilever bends by load / (3 E I) or the message says that its load is too small."""
    mesh = fx.read(lambda: fx.meshes.frame({"a": (0, 0, 0), "b": (1, 0, 0)}, {"l": ("a", "b", 4)}), 3)
    scene = fx.Scene([fx.Beam(mesh, fx.Rectangle(0.01, 0.01), fx.Elastic(1e9))], [fx.clamp(mesh, "a")],
                     [fx.PointForce(mesh, "b", (0.0, load, 0.0))], fx.Monitor(mesh, "b", "y"))
    states, text = [], ""
    try:
        states += fx.Path(scene, fx.LoadControl(1.0, fixed=True))
    except fx.PathFailure as failure:
        text = str(failure)
    told = "the residual is rounding" in text and "give a larger load and scale the results" in text
    assert told or states[-1].deflection == pytest.approx(load / (3 * 1e9 * 0.01**4 / 12), rel=1e-2)


@pytest.mark.silent("u04")
def test_rotation_prescribed_twice():
    """In a stage and as the load, which left the tangent singular."""
    mesh = fx.read(lambda: fx.meshes.frame({"a": (0, 0), "b": (1, 0)}, {"l": ("a", "b", 2)}), 2)
    with pytest.raises(ValueError, match="PrescribedRotation at 'b': the rotation is prescribed twice; keep one"):
        fx.Scene([fx.Beam(mesh, SECTION, MATERIAL)], [fx.clamp(mesh, "a")], [fx.PrescribedRotation(mesh, "b", -0.05)],
                 fx.Monitor(mesh, "b", "rz"), stages=[fx.Stage([fx.PrescribedRotation(mesh, "b", 0.1)], "bend")])
