"""Random stacks of leaves, and random arches, on rigid obstacles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import sheetfx as fx


@dataclass(frozen=True)
class Stack:
    """A structure, and the load that it is to bear."""

    scene: fx.Scene
    load: float

    def reached(self, control: fx.ArcLength | fx.LoadControl, steps: int = 400) -> fx.Record:
        """Its path up to the load."""
        return fx.trace(fx.Case(self.scene, control, fx.Until(load=self.load, steps=steps)))

    @property
    def load_control(self) -> fx.LoadControl:
        return fx.LoadControl(step=self.load / 20, target=self.load)


def stack(seed: int) -> Stack:
    """Leaves of even seeds, arches of odd ones.

    Raises
    ------
    ValueError
        If an arch starts inside its obstacle.
    """
    return (leaves, arch)[seed % 2](np.random.default_rng(seed))


def _chain(places: np.ndarray) -> fx.NamedMesh:
    nodes = {f"{n}": tuple(map(float, place)) for n, place in enumerate(places)}
    members = {f"part {n}": (f"{n}", f"{n + 1}", 1) for n in range(len(nodes) - 1)}
    return fx.read(lambda: fx.meshes.frame(nodes, members), 2)


def _parts(first: int, last: int) -> list[str]:
    return [f"part {n}" for n in range(first, last)]


def leaves(r: np.random.Generator) -> Stack:
    """Two to four leaves clamped at one end, with gaps or without, some above a rigid plane."""
    count, depth, modulus = int(r.integers(2, 5)), float(r.uniform(2, 8)), 2e5
    lengths, cells = r.uniform(300, 1000, count), r.integers(6, 20, count)
    gaps = r.choice([0.0, 1.0], count) * r.uniform(0, 6, count)
    heights = -np.cumsum(depth + gaps)
    meshes = [_chain(np.column_stack((np.linspace(0, length, n + 1), np.full(n + 1, height))))
              for length, n, height in zip(lengths, cells, heights, strict=True)]
    beams = [fx.Beam(mesh, fx.Rectangle(50.0, depth), fx.Elastic(modulus, 0.0)) for mesh in meshes]
    friction = float(r.choice([0.0, 0.0, 0.3]))
    joints: list = []
    for n in range(count - 1):
        shorter, longer, way = (n, n + 1, -1.0) if lengths[n] <= lengths[n + 1] else (n + 1, n, 1.0)
        joints.append(fx.PairContact(meshes[shorter], _parts(0, cells[shorter]), (meshes[longer], None),
                                     reach=4 * depth, friction=friction, toward=(0.0, way)))
    if r.random() < 0.5:
        plane = fx.RigidPlane((0.0, float(heights[-1] - depth / 2 - r.uniform(0, 10))), (0.0, 1.0))
        joints.append(fx.ObstacleContact(meshes[-1], None, plane, friction=friction))
    load = 3 * modulus * 50 * depth**3 / 12 / lengths[0] ** 3 * r.uniform(20, 100)
    tip = str(cells[0])
    return Stack(fx.Scene(beams, [fx.clamp(mesh, "0") for mesh in meshes], [fx.PointForce(meshes[0], tip, (0.0, -1.0))],
                          fx.Monitor(meshes[0], tip, "y", -1.0), joints=joints), float(load))


def arch(r: np.random.Generator) -> Stack:
    """A hinged arch that is a little skew, above a plane, a cylinder or a tilted plane."""
    count, length, rise, depth, modulus = int(r.integers(8, 24)), 1000.0, r.uniform(20, 120), r.uniform(3, 12), 7e4
    t = np.linspace(0, 1, count + 1)
    height = rise * np.sin(np.pi * t) + r.normal() * 2 * np.sin(2 * np.pi * t)
    mesh = _chain(np.column_stack((length * t, height)))
    loaded = str(r.integers(count // 4, 3 * count // 4 + 1))
    friction, enforcement = float(r.choice([0.0, 0.0, 0.3])), str(r.choice(["uzawa", "penalty"]))
    kind, top = r.integers(0, 3), r.uniform(0.2, 0.9) * rise - depth / 2
    if kind == 0:
        obstacle, at = fx.RigidPlane((0.0, float(top)), (0.0, 1.0)), _parts(count // 4, 3 * count // 4)
    elif kind == 1:
        radius = float(r.uniform(50, 300))
        obstacle, at = fx.RigidCylinder(radius, (float(r.uniform(300, 700)), float(top - radius))), None
    else:
        angle = r.uniform(-0.1, 0.1)
        normal = float(-np.sin(angle)), float(np.cos(angle))
        obstacle, at = fx.RigidPlane((500.0, float(top - 60)), normal), _parts(count // 3, 2 * count // 3)
    stiffness = None if enforcement == "uzawa" else modulus / 100 * float(r.uniform(0.1, 10))
    touch = fx.ObstacleContact(mesh, at, obstacle, friction=friction, enforcement=enforcement, stiffness=stiffness)
    load = modulus * 20 * depth**3 / 12 / length**3 * rise / depth * r.uniform(200, 4000)
    beam = fx.Beam(mesh, fx.Rectangle(20.0, float(depth)), fx.Elastic(modulus, 0.3))
    return Stack(fx.Scene([beam], [fx.pin(mesh, "0"), fx.pin(mesh, str(count))],
                          [fx.PointForce(mesh, loaded, (0.0, -1.0))], fx.Monitor(mesh, loaded, "y", -1.0),
                          joints=[touch]), float(load))
