"""Contact at the face of the cells that touch: their own thickness, at their own offset."""

from __future__ import annotations

import pytest

import sheetfx as fx


def strip(root, offset, height=0.0, flipped=False):
    """A strip of two thicknesses whose mid-surface is at a height, clamped at its thick end; tip 2 thick."""
    z = height + (offset if flipped else -offset)
    places = {"a": (0, 0, z), "b": (50, 0, z), "c": (100, 0, z), "d": (100, 10, z), "e": (50, 10, z), "f": (0, 10, z)}
    panels = {"root": ["a", "b", "e", "f"], "tip": ["b", "c", "d", "e"]}
    if flipped:
        panels = {name: corners[::-1] for name, corners in panels.items()}
    mesh = fx.read(lambda: fx.meshes.panels(places, panels, 3), 3, 2)
    return mesh, [fx.Shell(mesh, fx.Plate(t), fx.Elastic(2e5, 0.0), group=name, offset=offset)
                  for name, t in (("root", root), ("tip", 2.0))]


def stop(root, offset, flipped=False, distance=None):
    mesh, parts = strip(root, offset, flipped=flipped)
    tip, held = ("d-c", "a-f") if flipped else ("c-d", "f-a")
    contact = fx.ObstacleContact(mesh, tip, fx.RigidPlane((0.0, 0.0, -2.0), (0.0, 0.0, 1.0)), distance)
    scene = fx.Scene(parts, [fx.clamp(mesh, held)], [fx.EdgeForce(mesh, tip, (0.0, 0.0, -4.0))],
                     fx.Monitor(mesh, "c", "z", -1.0), joints=[contact])
    return fx.trace(fx.Case(scene, fx.LoadControl(1.0))).states[-1].deflection


@pytest.mark.silent("q03")
@pytest.mark.parametrize(("root", "offset", "flipped"), [
    (2.0, 0.0, False), (4.0, 0.0, False), (3.0, 0.5, False), (2.0, -0.5, False), (3.0, 0.5, True)])
@pytest.mark.slow(quick=1)
def test_strip_stops_at_its_own_face(root, offset, flipped):
    """A tip whose lower face is 1.0 above the plane goes down by that, whatever root and mesh are."""
    assert stop(root, offset, flipped) == pytest.approx(1.0, rel=1e-3)


def test_distance_is_from_the_mid_surface():
    assert stop(2.0, 0.5, distance=0.4) == pytest.approx(1.6, rel=1e-3)


def surface_stop(thick, offset, under):
    """The same above a clamped plate of one thickness whose mid-surface is 3 below, with an offset of its own."""
    mesh, parts = strip(thick, offset)
    z = -3.0 - under
    places = {"p": (60, -5, z), "q": (120, -5, z), "r": (120, 15, z), "s": (60, 15, z)}
    floor = fx.read(lambda: fx.meshes.panels(places, {"floor": ["p", "q", "r", "s"]}, 2), 3, 2)
    below = fx.Shell(floor, fx.Plate(2.0), fx.Elastic(2e8, 0.0), offset=under)
    contact = fx.SurfaceContact(mesh, "c-d", (floor, None))
    held = [fx.clamp(mesh, "f-a"), *(fx.clamp(floor, e) for e in ("p-q", "q-r", "r-s", "s-p"))]
    scene = fx.Scene([*parts, below], held, [fx.EdgeForce(mesh, "c-d", (0.0, 0.0, -4.0))],
                     fx.Monitor(mesh, "c", "z", -1.0), joints=[contact])
    return fx.trace(fx.Case(scene, fx.LoadControl(1.0))).states[-1].deflection


@pytest.mark.silent("q03")
@pytest.mark.parametrize(("thick", "offset", "under"), [(4.0, 0.0, 0.0), (3.0, 0.5, -0.25)])
@pytest.mark.slow(quick=1)
def test_two_parts_touch_at_their_faces(thick, offset, under):
    assert surface_stop(thick, offset, under) == pytest.approx(1.0, rel=1e-2)


def test_beams_beside_their_line_are_refused():
    mesh = fx.read(lambda: fx.meshes.frame({"a": (0, 0), "b": (1, 0)}, {"l": ("a", "b", 2)}), 2)
    beam = fx.Beam(mesh, fx.Rectangle(0.1, 0.1), fx.Elastic(1e5), offset=0.2)
    contact = fx.ObstacleContact(mesh, None, fx.RigidPlane((0.0, -1.0), (0.0, 1.0)))
    scene = fx.Scene([beam], [fx.clamp(mesh, "a")], [fx.PointForce(mesh, "b", (0.0, -1.0))], fx.Monitor(mesh, "b", "y"),
                     joints=[contact])
    with pytest.raises(ValueError, match="faces of the Beam on group 'all' are not alike"):
        fx.trace(fx.Case(scene, fx.LoadControl(1.0)))
