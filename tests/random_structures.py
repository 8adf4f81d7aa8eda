"""Random trusses in space and frames in the plane, for numpy and for sheetfx: the same discrete problem twice."""

from __future__ import annotations

from dataclasses import dataclass

import gmsh
import numpy as np

import sheetfx as fx

POISSON = 0.25


@dataclass(frozen=True)
class Structure:
    """A structure of bars in space, or of beams in the plane.

    Attributes
    ----------
    name : what it is and how it was made
    nodes : name -> coordinates
    members : first node, last node, class of stiffness
    sections : for each class EA of bars, or width and depth of beams of modulus 1
    supports : node -> components held
    loads : node -> force for a load factor of 1
    monitor : node, component and sign of the deflection
    deflection : at which the path ends
    elements : of each member of a frame
    """

    name: str
    nodes: dict[str, tuple[float, ...]]
    members: list[tuple[str, str, int]]
    sections: list
    supports: dict[str, str]
    loads: dict[str, tuple[float, ...]]
    monitor: tuple[str, str, float]
    deflection: float
    elements: int = 1

    @property
    def dimension(self) -> int:
        return len(next(iter(self.nodes.values())))

    @property
    def total(self) -> float:
        """Load for a load factor of 1, as sheetfx reports it."""
        return float(sum(np.linalg.norm(force) for force in self.loads.values()))


def scene(structure: Structure) -> fx.Scene:
    """The structure as sheetfx has it."""
    mesh = fx.read(lambda: _model(structure), structure.dimension)
    if structure.dimension == 3:
        parts = [fx.Bar(mesh, fx.Rectangle(area, 1.0), fx.Elastic(1.0), group=f"class {n}")
                 for n, area in enumerate(structure.sections)]
    else:
        parts = [fx.Beam(mesh, fx.Rectangle(*section), fx.Elastic(1.0, POISSON), group=f"class {n}")
                 for n, section in enumerate(structure.sections)]
    node, component, sign = structure.monitor
    return fx.Scene(parts, [fx.Support(mesh, name, held) for name, held in structure.supports.items()],
                    [fx.PointForce(mesh, name, tuple(force)) for name, force in structure.loads.items()],
                    fx.Monitor(mesh, node, component, sign))


def _model(structure: Structure) -> None:
    geo = gmsh.model.geo
    tags = {name: geo.addPoint(*x, *([0.0] * (3 - len(x)))) for name, x in structure.nodes.items()}
    classes: dict[int, list[int]] = {}
    for first, last, number in structure.members:
        line = geo.addLine(tags[first], tags[last])
        geo.mesh.setTransfiniteCurve(line, structure.elements + 1)
        classes.setdefault(number, []).append(line)
    geo.synchronize()
    for number, lines in classes.items():
        gmsh.model.addPhysicalGroup(1, lines, name=f"class {number}")
    for name, tag in tags.items():
        gmsh.model.addPhysicalGroup(0, [tag], name=name)


class Discrete:
    """Unknowns of a structure, those that supports hold left out.

    Attributes
    ----------
    free : numbers of the free unknowns among all
    load : on the free unknowns for a load factor of 1
    """

    def __init__(self, structure: Structure, components: tuple[str, ...], count: int):
        self.names, self.components = list(structure.nodes), components
        width = len(components)
        held = [self.number(name, c) for name, fixed in structure.supports.items() for c in fixed.split()]
        self.size = width * count
        self.free = np.setdiff1d(np.arange(self.size), held)
        load = np.zeros(self.size)
        for name, force in structure.loads.items():
            for component, value in zip(components, force, strict=False):
                load[self.number(name, component)] += value
        self.load = load[self.free]

    def assembled(self, rows: np.ndarray, forces: np.ndarray, blocks: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Sum of gradients and Hessians of elements, on the free unknowns.

        Parameters
        ----------
        rows, forces : shape (elements, n), the numbers of their unknowns and the gradients
        blocks : shape (elements, n, n)
        """
        gradient = np.bincount(rows.ravel(), forces.ravel(), self.size)
        places = (rows[:, :, None] * self.size + rows[:, None, :]).ravel()
        hessian = np.bincount(places, blocks.ravel(), self.size**2).reshape(self.size, self.size)
        return gradient[self.free], hessian[np.ix_(self.free, self.free)]

    def number(self, name: str, component: str) -> int:
        return self.names.index(name) * len(self.components) + self.components.index(component)

    def displacement(self, q: np.ndarray, dimension: int) -> np.ndarray:
        """Displacements of the named nodes, one in each row."""
        whole = np.zeros(self.size)
        whole[self.free] = q
        return whole.reshape(-1, len(self.components))[:len(self.names), :dimension]


class DenseTruss(Discrete):
    """Bars with engineering strain: energy sum EA (l - L)^2 / (2 L)."""

    def __init__(self, structure: Structure):
        super().__init__(structure, ("x", "y", "z"), len(structure.nodes))
        self.places = np.array(list(structure.nodes.values()), dtype=float)
        ends = np.array([[self.names.index(a), self.names.index(b)] for a, b, _ in structure.members])
        self.stiffness = np.array([structure.sections[c] for *_, c in structure.members])
        self.ends, self.rows = ends, (3 * ends[:, :, None] + np.arange(3)).reshape(-1, 6)
        self.lengths = np.linalg.norm(self.places[ends[:, 1]] - self.places[ends[:, 0]], axis=1)

    def derivatives(self, q):
        x = self.places + self.displacement(q, 3)
        chord = x[self.ends[:, 1]] - x[self.ends[:, 0]]
        length = np.linalg.norm(chord, axis=1)
        along = chord / length[:, None]
        force = self.stiffness * (length - self.lengths) / self.lengths
        outer = along[:, :, None] * along[:, None, :]
        block = ((self.stiffness / self.lengths)[:, None, None] * outer
                 + (force / length)[:, None, None] * (np.eye(3) - outer))
        pull = force[:, None] * along
        return self.assembled(self.rows, np.hstack([-pull, pull]), np.block([[block, -block], [-block, block]]))


class DenseFrame(Discrete):
    """Reissner's beam (1972) in the plane: quadratic displacements and rotation, two Gauss points in each element."""

    def __init__(self, structure: Structure):
        elements = structure.elements
        x = [np.array(place, dtype=float) for place in structure.nodes.values()]
        names, cells, stiffness = list(structure.nodes), [], []
        for first, last, number in structure.members:
            a, b = names.index(first), names.index(last)
            inner = list(range(len(x), len(x) + 2 * elements - 1))
            x += [x[a] + (x[b] - x[a]) * (k + 1) / (2 * elements) for k in range(len(inner))]
            chain = [a, *inner, b]
            cells += [chain[2 * e:2 * e + 3] for e in range(elements)]
            width, depth = structure.sections[number]
            shear = 5 / 6 * width * depth / (2 * (1 + POISSON))
            stiffness += elements * [[width * depth, shear, width * depth**3 / 12]]
        super().__init__(structure, ("x", "y", "rz"), len(x))
        x, cells, stiffness = np.array(x), np.array(cells), np.array(stiffness)
        chords = x[cells[:, 2]] - x[cells[:, 0]]
        lengths = np.linalg.norm(chords, axis=1)
        points = np.array([-1.0, 1.0]) / 3**0.5
        shape = np.stack([points * (points - 1) / 2, 1 - points**2, points * (points + 1) / 2], axis=1)
        rate = np.stack([points - 0.5, -2 * points, points + 0.5], axis=1)
        self.weight, self.stiffness = np.repeat(lengths / 2, 2), np.repeat(stiffness, 2, axis=0)
        self.angle = np.repeat(np.arctan2(chords[:, 1], chords[:, 0]), 2)
        self.rows = (3 * cells[:, :, None] + np.arange(3)).reshape(-1, 9)
        slopes = (rate[None] * 2 / lengths[:, None, None]).reshape(-1, 3)
        self.shape = np.zeros((2 * len(cells), 4, 9))  # slopes of both displacements, the rotation and its slope
        self.shape[:, 0, 0::3] = self.shape[:, 1, 1::3] = self.shape[:, 3, 2::3] = slopes
        self.shape[:, 2, 2::3] = np.tile(shape, (len(cells), 1))

    def derivatives(self, q):
        whole = np.zeros(self.size)
        whole[self.free] = q
        u, v, turn, bend = (self.shape @ whole[np.repeat(self.rows, 2, axis=0)][:, :, None])[:, :, 0].T
        one = np.zeros_like(u)
        slope = np.stack([np.cos(self.angle) + u, np.sin(self.angle) + v], axis=1)
        a = np.stack([np.cos(self.angle + turn), np.sin(self.angle + turn)], axis=1)
        b = np.stack([-a[:, 1], a[:, 0]], axis=1)
        along, across = (slope * a).sum(axis=1), (slope * b).sum(axis=1)
        strains = np.stack([along - 1, across, bend], axis=1)
        forces = self.stiffness * strains
        first = np.stack([np.stack([a[:, 0], a[:, 1], across, one], axis=1),
                          np.stack([b[:, 0], b[:, 1], -along, one], axis=1),
                          np.stack([one, one, one, one + 1], axis=1)], axis=1)
        second = np.zeros((len(u), 4, 4))
        mixed = forces[:, 0, None] * b - forces[:, 1, None] * a
        second[:, :2, 2] = second[:, 2, :2] = mixed
        second[:, 2, 2] = -forces[:, 0] * along - forces[:, 1] * across
        inner = first.transpose(0, 2, 1) @ (self.stiffness[:, :, None] * first) + second
        pulled = (first.transpose(0, 2, 1) @ forces[:, :, None])[:, :, 0] * self.weight[:, None]
        across_shape = self.shape.transpose(0, 2, 1)
        gradients = (across_shape @ pulled[:, :, None])[:, :, 0]
        blocks = across_shape @ (inner * self.weight[:, None, None]) @ self.shape
        return self.assembled(self.rows, gradients.reshape(-1, 2, 9).sum(axis=1),
                              blocks.reshape(-1, 2, 9, 9).sum(axis=1))


def dense(structure: Structure) -> Discrete:
    return DenseTruss(structure) if structure.dimension == 3 else DenseFrame(structure)
