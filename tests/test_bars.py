"""Pin-jointed bars in the plane and in space, alone and in everything that takes a structure."""

from __future__ import annotations

from math import hypot, sqrt

import numpy as np
import pytest
from helpers import distance, follow, move_at_random, tangents
from truss import Truss

import sheetfx as fx
from sheetfx.case import Case, trace
from sheetfx.continuation.control import ArcLength, LoadControl
from sheetfx.discrete.discretisation import Discretisation
from sheetfx.path import Path
from sheetfx.scenes import star_dome, von_mises_truss

STRAINS = {"engineering": fx.forms.bar.engineering, "green": fx.forms.bar.green}
SECTION, MATERIAL = fx.Rectangle(0.5, 2.0), fx.Elastic(3.0)


def two_bars(rise: float, strains=fx.forms.bar.engineering, dimension: int = 2, **loads) -> fx.Scene:
    """Half-span 1, axial stiffness 3; in space a third bar holds the apex sideways."""
    places = {"left": (-1.0, 0.0), "apex": (0.0, rise), "right": (1.0, 0.0), "behind": (0.0, rise, 1.0)}
    members = {"one": ("left", "apex", 1), "other": ("apex", "right", 1), "third": ("apex", "behind", 1)}
    pinned = ["left", "right", "behind"][:dimension]
    nodes = {name: places[name] for name in ["apex", *pinned]}
    mesh = fx.read(lambda: fx.meshes.frame(nodes, dict(list(members.items())[:dimension])), dimension)
    bars = fx.Bar(mesh, SECTION, MATERIAL, strains=strains)
    return fx.Scene([bars], [fx.pin(mesh, name) for name in pinned],
                    [fx.PointForce(mesh, "apex", (0.0, -1.0, 0.0)[:dimension])],
                    fx.Monitor(mesh, "apex", "y", -1.0))


@pytest.mark.parametrize("strains", STRAINS)
@pytest.mark.parametrize("dimension", [2, 3])
def test_tangent_is_the_derivative_of_the_residual(strains, dimension):
    discretisation = Discretisation(two_bars(0.5, STRAINS[strains], dimension))
    x = move_at_random(discretisation)
    assert distance(*tangents(discretisation.system, x)) < 1e-8


@pytest.mark.parametrize("strains, limit", [
    ("engineering", lambda rise, length: 6 * (length ** (2 / 3) - 1) ** 1.5 / length),
    ("green", lambda rise, length: 6 * rise**3 / (3 * sqrt(3) * length**3))])
def test_limit_load_of_two_bars(strains, limit):
    """With P = 2 EA h (1/l - 1/L), l^2 = 1 + h^2, and P = EA h (h0^2 - h^2) / L^3: the largest of each."""
    rise = 0.5
    points = follow(two_bars(rise, STRAINS[strains]), ArcLength(0.02), deflection=2.2 * rise).critical_points
    expected = limit(rise, hypot(1, rise))
    assert [p.load for p in points] == pytest.approx([expected, -expected], rel=1e-9)


def test_linear_buckling_of_two_bars():
    """Zeros of the stiffness sideways and along the load with the force -P L / (2 h) in each bar."""
    rise, length = 3.0, hypot(1, 3.0)
    path = Path(two_bars(rise))
    loads = fx.buckling(path, next(iter(path)), 2)
    assert [b.load for b in loads] == pytest.approx(
        [2 * 3.0 / (length * rise), 2 * 3.0 * rise**3 / length], rel=1e-9)


def test_dome_moves_as_an_independent_truss():
    """Under forces without symmetry, half as large as those that make it snap."""
    nodes, members = star_dome.dome()
    names = list(nodes)
    free = [n for n in names if not n.startswith("outer")]
    truss = Truss(np.array(list(nodes.values())), np.array([[names.index(n) for n in m] for m in members.values()]),
                  [names.index(n) for n in free], None)
    forces = 1e-4 * np.random.default_rng(3).uniform(-1, 1, (len(free), 3))
    mesh = fx.read(lambda: fx.meshes.frame(nodes, {name: (*m, 1) for name, m in members.items()}), 3)
    scene = fx.Scene([fx.Bar(mesh, fx.Rectangle(1.0, 1.0), fx.Elastic(1.0))],
                     [fx.pin(mesh, n) for n in names if n.startswith("outer")],
                     [fx.PointForce(mesh, n, tuple(f)) for n, f in zip(free, forces, strict=True)],
                     fx.Monitor(mesh, "apex", "z"))
    record = trace(Case(scene, LoadControl(0.5)))
    kinematics = record.path.discretisation.kinematics(mesh)
    moves = np.array([kinematics.displacement(mesh, n) for n in free])
    assert np.abs(moves).max() > 0.05
    assert moves == pytest.approx(truss.equilibrium(forces), rel=1e-7, abs=1e-9)


@pytest.mark.slow
def test_pictures_of_bars(tmp_path):
    for case in (von_mises_truss.case(rise=1.0), star_dome.case(to=1.0)):
        record = trace(case)
        folder = tmp_path / str(record.path.unknowns)
        folder.mkdir()
        for picture in case.pictures:
            picture(record, folder)
        assert (folder / "shape.png").stat().st_size > 1000
        assert (folder / "paraview" / "path.pvd").exists()


def test_own_weight_of_bars():
    """A line force of fixed direction: half of the weight of the bars hangs on the apex."""
    scene = two_bars(3.0)
    bars, mesh = scene.parts[0], scene.meshes[0]
    weighed = fx.Scene([bars], scene.supports, [fx.LineForce(bars, (0.0, -1e-4))], scene.monitor)
    pulled = fx.Scene([bars], scene.supports, [fx.PointForce(mesh, "apex", (0.0, -1e-4 * hypot(1, 3)))],
                      scene.monitor)
    one, other = (follow(s, LoadControl(1.0)).states[-1] for s in (weighed, pulled))
    assert one.deflection == pytest.approx(other.deflection, rel=1e-9)
    assert one.load == pytest.approx(2 * other.load, rel=1e-12), "half of the weight hangs on the supports"


def test_load_along_one_bar_as_a_function_of_place():
    """From 0 at its end to 1 at the apex, along its length of 5."""
    scene = two_bars(sqrt(24))
    mesh = scene.meshes[0]
    parts = [fx.Bar(mesh, SECTION, MATERIAL, group=name) for name in ("one", "other")]
    load = fx.LineForce(parts[0], lambda x: (0.0, -1e-4 * (x[0] + 1)))
    state = follow(fx.Scene(parts, scene.supports, [load], scene.monitor), LoadControl(1.0)).states[-1]
    assert state.load == pytest.approx(2.5e-4, rel=1e-9)


def test_bad_input_names_object_value_and_remedy():
    scene = two_bars(1.0)
    bars, mesh = scene.parts[0], scene.meshes[0]

    def other(**changes):
        return fx.Scene(**({n: getattr(scene, n) for n in ("parts", "supports", "loads", "monitor")} | changes))

    bad = {
        "Support at 'left': fixes rz.*pin": lambda: other(supports=[fx.clamp(mesh, "left")]),
        "Moment at 'apex'.*forces": lambda: other(loads=[fx.Moment(mesh, "apex", 1.0)]),
        "Monitor at 'apex'.*rz.*displacement": lambda: other(monitor=fx.Monitor(mesh, "apex", "rz")),
        "Bar and Beam of one mesh": lambda: other(parts=[bars, fx.Beam(mesh, SECTION, MATERIAL)]),
        r"PointForce at 'apex'.*\(1.0, 2.0, 3.0\) has 3 components; give 2":
            lambda: fx.PointForce(mesh, "apex", (1.0, 2.0, 3.0)),
        r"Moment at 'apex'.*has 3 components; give 1": lambda: fx.Moment(mesh, "apex", (0.0, 0.0, 1.0)),
        "LineForce.*follower": lambda: fx.LineForce(bars, (0.0, 1.0), follower=True),
        "Bar: the mesh has curved cells of degree 2": lambda: fx.Bar(
            fx.read(lambda: fx.meshes.arc(1.0, 0.0, 1.0, 2), 2, 2), SECTION, MATERIAL),
    }
    for message, make in bad.items():
        with pytest.raises(ValueError, match=message):
            make()


def test_bars_in_a_chain_can_move_freely():
    """Joints have no stiffness of their own, so that a bar of two cells is a mechanism."""
    nodes = {"base": (0.0, 0.0), "tip": (1.0, 0.0)}
    mesh = fx.read(lambda: fx.meshes.frame(nodes, {"bar": ("base", "tip", 2)}), 2)
    scene = fx.Scene([fx.Bar(mesh, SECTION, MATERIAL)], [fx.pin(mesh, "base"), fx.Support(mesh, "tip", "y")],
                     [fx.PointForce(mesh, "tip", (1.0, 0.0))], fx.Monitor(mesh, "tip", "x"))
    with pytest.raises(ValueError, match="move freely"):
        fx.Path(scene)
