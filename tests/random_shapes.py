"""Shapes of random structures: half of them regular under regular loads, the others out of shape by a random size."""

from __future__ import annotations

from dataclasses import replace
from math import cos, hypot, pi, sin

import numpy as np
from random_structures import Structure

OUT_OF_SHAPE = (0.0, 0.0, 0.0, 1e-3, 1e-2, 0.1)  # sizes over that of a member; equally likely


def truss(seed: int) -> Structure:
    """A random truss in space."""
    return _varied((dome, tower, apex, ridge)[seed % 4], seed)


def frame(seed: int) -> Structure:
    """A random frame in the plane."""
    return _varied((portal, arch, angle, gable)[seed % 4], seed)


def _varied(make, seed: int) -> Structure:
    """A shape with its free nodes moved, and its loads turned, by a random size."""
    random = np.random.default_rng(seed)
    structure, size = make(random), random.choice(OUT_OF_SHAPE)

    def off(vector, scale=1.0):
        return tuple(float(c) for c in np.array(vector) + size * scale * random.uniform(-1, 1, len(vector)))

    nodes = {name: x if name in structure.supports else off(x) for name, x in structure.nodes.items()}
    loads = {name: off(force, np.linalg.norm(force)) for name, force in structure.loads.items()}
    return replace(structure, name=f"{make.__name__} {seed}, out of shape by {size:g}", nodes=nodes, loads=loads)


def _polygon(count: int, radius: float, height: float, turned: float, name: str) -> dict[str, tuple[float, ...]]:
    return {f"{name}{i}": (radius * cos(2 * pi * (i + turned) / count), radius * sin(2 * pi * (i + turned) / count),
                           height) for i in range(count)}


def _stiffness(random, count: int) -> list[float]:
    return [float(s) for s in 10 ** random.uniform(-1, 0, count)]


def dome(random) -> Structure:
    """Rings about an apex, pinned at the outermost, under forces at the apex and on the first ring."""
    sides, rings = int(random.integers(3, 7)), int(random.integers(1, 3))
    rise, curvature = random.uniform(0.15, 0.6), random.uniform(0.6, 1.0)
    nodes: dict[str, tuple[float, ...]] = {"apex": (0.0, 0.0, rise)}
    members = []
    for k in range(1, rings + 2):
        height = rise * (1 - curvature * (k / (rings + 1)) ** 2) if k <= rings else 0.0
        nodes |= _polygon(sides, float(k), height, k / 2, f"ring{k} ")
        for i in range(sides):
            if k == 1:
                members.append(("apex", f"ring1 {i}", 0))
            else:
                members += [(f"ring{k - 1} {i}", f"ring{k} {j % sides}", 2) for j in (i, i - 1)]
            if k <= rings:
                members.append((f"ring{k} {i}", f"ring{k} {(i + 1) % sides}", 1))
    share = random.choice([0.0, 0.5, 1.0])
    loads = {"apex": (0.0, 0.0, -1.0)} | {f"ring1 {i}": (0.0, 0.0, -share) for i in range(sides) if share}
    supports = {f"ring{rings + 1} {i}": "x y z" for i in range(sides)}
    return Structure("", nodes, members, _stiffness(random, 3), supports, loads, ("apex", "z", -1.0), 2.2 * rise)


def tower(random) -> Structure:
    """A mast of three or four legs with braced faces, pressed down at its head."""
    sides, storeys = int(random.integers(3, 5)), int(random.integers(2, 5))
    height, taper = random.uniform(0.7, 1.6), random.uniform(0.0, 0.1)
    both = bool(random.integers(2))
    nodes, members = {}, []
    for k in range(storeys + 1):
        nodes |= _polygon(sides, 0.6 * (1 - taper * k), height * k, 0.0, f"level{k} ")
        for i in range(sides):
            here, after = f"level{k} {i}", f"level{k} {(i + 1) % sides}"
            if k:
                members += [(here, after, 1), (f"level{k - 1} {i}", here, 0), (f"level{k - 1} {i}", after, 2)]
                if both:
                    members.append((f"level{k - 1} {(i + 1) % sides}", here, 2))
        if k and sides == 4:
            members.append((f"level{k} 0", f"level{k} 2", 1))
    supports = {f"level0 {i}": "x y z" for i in range(sides)}
    loads = {f"level{storeys} {i}": (0.0, 0.0, -1.0) for i in range(sides)}
    return Structure("", nodes, members, _stiffness(random, 3), supports, loads, (f"level{storeys} 0", "z", -1.0),
                     0.25 * height * storeys)


def apex(random) -> Structure:
    """One node on legs, held sideways by long bars: von Mises's truss in space."""
    legs, rise = int(random.integers(2, 6)), 10 ** random.uniform(-0.6, 0.6)
    nodes: dict[str, tuple[float, ...]] = {"apex": (0.0, 0.0, rise)} | _polygon(legs, 1.0, 0.0, 0.0, "foot")
    members = [("apex", f"foot{i}", 0) for i in range(legs)]
    ties = ((4.0, 0.0), (0.0, 4.0)) if legs == 2 or random.integers(2) else ()
    for i, (x, y) in enumerate(ties):
        nodes |= {f"tie{i}": (x, y, rise), f"tie{i} opposite": (-x, -y, rise)}
        members += [("apex", f"tie{i}", 1 + i), ("apex", f"tie{i} opposite", 1 + i)]
    stiffness = [1.0, *(float(s) for s in 10 ** random.uniform(-2, -0.5, 2))][:1 + len(ties)]
    supports = {name: "x y z" for name in nodes if name != "apex"}
    return Structure("", nodes, members, stiffness, supports, {"apex": (0.0, 0.0, -1.0)}, ("apex", "z", -1.0),
                     2.2 * rise)


def ridge(random) -> Structure:
    """A row of two to four apexes on two legs each, joined by a ridge and braced to their neighbours' feet."""
    count, rise = int(random.integers(2, 5)), random.uniform(0.2, 2.0)
    nodes, members, supports = {}, [], {}
    for i in range(-1, count + 1):
        end = i in (-1, count)
        nodes[f"top{i}"] = (float(i), 0.0, rise)
        if end:
            supports[f"top{i}"] = "x y z"
        else:
            for side, y in (("left", -1.0), ("right", 1.0)):
                nodes[f"{side}{i}"] = (float(i), y, 0.0)
                supports[f"{side}{i}"] = "x y z"
                members.append((f"top{i}", f"{side}{i}", 0))
        if i >= 0:
            members.append((f"top{i - 1}", f"top{i}", 1))
    for i in range(count - 1):
        members += [(f"top{i}", f"{side}{i + 1}", 2) for side in ("left", "right")]
        members += [(f"top{i + 1}", f"{side}{i}", 2) for side in ("left", "right")]
    loads = {f"top{i}": (0.0, 0.0, -1.0) for i in range(count)}
    return Structure("", nodes, members, _stiffness(random, 3), supports, loads, ("top0", "z", -1.0), 2.2 * rise)


def _depths(random, count: int) -> list[tuple[float, float]]:
    return [(1.0, float(d)) for d in 10 ** random.uniform(-1.7, -1.0, count)]


def portal(random) -> Structure:
    """Storeys and bays under forces on columns, or on the middles of the uppermost beams."""
    storeys, bays = int(random.integers(1, 3)), int(random.integers(1, 3))
    height, inside = random.uniform(0.7, 1.5), bool(random.integers(2))
    nodes, members, loads = {}, [], {}
    for k in range(storeys + 1):
        for i in range(bays + 1):
            nodes[f"joint{k} {i}"] = (float(i), height * k)
            if k:
                members.append((f"joint{k - 1} {i}", f"joint{k} {i}", 0))
                if i and k == storeys and inside:
                    nodes[f"middle{i}"] = (i - 0.5, height * k)
                    members += [(f"joint{k} {i - 1}", f"middle{i}", 1), (f"middle{i}", f"joint{k} {i}", 1)]
                    loads[f"middle{i}"] = (0.0, -1.0)
                elif i:
                    members.append((f"joint{k} {i - 1}", f"joint{k} {i}", 1))
    loads = loads or {f"joint{storeys} {i}": (0.0, -1.0) for i in range(bays + 1)}
    held = random.choice(["x y", "x y rz"])
    sections = _depths(random, 2)
    euler = pi**2 / 12 * sections[0][1] ** 2 * height * storeys
    return Structure("", nodes, members, sections, {f"joint0 {i}": held for i in range(bays + 1)}, loads,
                     (next(iter(loads)), "y", -1.0), 0.4 if inside else 3 * euler, elements=2)


def arch(random) -> Structure:
    """A polygon from support to support under forces at its corners."""
    pieces, half = int(random.integers(4, 8)), random.uniform(0.3, 1.3)
    spread = bool(random.integers(2))
    angles = np.linspace(-half, half, pieces + 1)
    nodes = {f"corner{i}": (float(np.sin(a)), float(np.cos(a) - np.cos(half))) for i, a in enumerate(angles)}
    members = [(f"corner{i}", f"corner{i + 1}", 0) for i in range(pieces)]
    crown = [pieces // 2] if pieces % 2 == 0 else [pieces // 2, pieces // 2 + 1]
    loads = {f"corner{i}": (0.0, -1.0) for i in (range(1, pieces) if spread else crown)}
    held = random.choice(["x y", "x y rz"])
    return Structure("", nodes, members, _depths(random, 1), {"corner0": held, f"corner{pieces}": held}, loads,
                     (f"corner{crown[0]}", "y", -1.0), 2.0 * float(1 - np.cos(half)), elements=2)


def angle(random) -> Structure:
    """A column and a beam in a corner, as of Roorda and Lee, under a force at the corner or on the beam."""
    height, place = random.uniform(0.6, 1.6), random.choice([0.0, 0.2, 0.5])
    nodes = {"foot": (0.0, 0.0), "corner": (0.0, height), "end": (1.0, height)}
    if place:
        nodes["on beam"] = (float(place), height)
        members = [("foot", "corner", 0), ("corner", "on beam", 1), ("on beam", "end", 1)]
    else:
        members = [("foot", "corner", 0), ("corner", "end", 1)]
    loaded = "on beam" if place else "corner"
    return Structure("", nodes, members, _depths(random, 2), {"foot": "x y", "end": "x y"}, {loaded: (0.0, -1.0)},
                     (loaded, "y", -1.0), 0.6, elements=2)


def gable(random) -> Structure:
    """Two columns and two rafters under forces at eaves and ridge."""
    height, rise, half = random.uniform(0.4, 1.2), random.uniform(0.1, 0.7), random.uniform(0.5, 1.0)
    nodes = {"left": (-half, 0.0), "left eave": (-half, height), "ridge": (0.0, height + rise),
             "right eave": (half, height), "right": (half, 0.0)}
    names = list(nodes)
    members = [(a, b, int(0 < i < 3)) for i, (a, b) in enumerate(zip(names[:-1], names[1:], strict=True))]
    share, held = random.choice([0.0, 0.5]), random.choice(["x y", "x y rz"])
    loads = {"ridge": (0.0, -1.0)} | {f"{side} eave": (0.0, -share) for side in ("left", "right") if share}
    return Structure("", nodes, members, _depths(random, 2), {"left": held, "right": held}, loads,
                     ("ridge", "y", -1.0), 0.5 * hypot(rise, half), elements=2)
