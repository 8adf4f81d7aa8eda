"""Independent solutions for stiffened plates and T-beams: finite strips, Levy's two strips, Vlasov's beam."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, pi, sin, tanh

import numpy as np
from scipy.linalg import eigh
from scipy.optimize import brentq

GAUSS = [((point + 1) / 2, weight / 2) for point, weight in zip(*np.polynomial.legendre.leggauss(4), strict=True)]


def hermite(s: float, width: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Cubic functions of values and slopes at both ends of an interval, and their first and second derivatives."""
    value = [1 - 3 * s**2 + 2 * s**3, width * (s - 2 * s**2 + s**3), 3 * s**2 - 2 * s**3, width * (s**3 - s**2)]
    slope = [6 * s**2 - 6 * s, width * (1 - 4 * s + 3 * s**2), 6 * s - 6 * s**2, width * (3 * s**2 - 2 * s)]
    bend = [12 * s - 6, width * (6 * s - 4), 6 - 12 * s, width * (6 * s - 2)]
    return np.array(value), np.array(slope) / width, np.array(bend) / width**2


@dataclass(frozen=True)
class Strip:
    """A flat Kirchhoff plate between two lines of a section (Cheung 1976), divided into equal strips.

    Attributes
    ----------
    first, last : names of the lines
    thickness, cells : of it
    """

    first: str
    last: str
    thickness: float
    cells: int


@dataclass(frozen=True)
class Rib:
    """A Bernoulli beam along a line, its centroid above it (z) by an offset; lateral bending is left out.

    Attributes
    ----------
    at : name of the line
    """

    at: str
    area: float
    second_moment: float
    torsion: float
    offset: float


def finite_strips(lines: dict[str, tuple[float, float]], strips: Sequence[Strip], ribs: Sequence[Rib], length: float,
                  half_waves: int, modulus: float, poisson: float, held: dict[str, str]) -> np.ndarray:
    """Stresses of uniform compression at which a prismatic structure buckles, the ends being diaphragms.

    u = U(s) cos(kx), v = V(s) sin(kx), w = W(s) sin(kx): linear U, V and cubic W in each strip.

    Parameters
    ----------
    lines : name -> (y, z)
    held : name of a line -> components that are held there, any of u y z r
    """
    places, pieces = dict(enumerate(lines.values())), []
    numbers = {name: i for i, name in enumerate(lines)}
    for strip in strips:
        start, end = (np.array(lines[name]) for name in (strip.first, strip.last))
        chain = [numbers[strip.first]]
        for i in range(1, strip.cells):
            places[len(places)] = tuple(start + (end - start) * i / strip.cells)
            chain.append(len(places) - 1)
        chain.append(numbers[strip.last])
        pieces += [(a, b, strip.thickness) for a, b in zip(chain[:-1], chain[1:], strict=True)]
    stiffness, stress = np.zeros((2, 4 * len(places), 4 * len(places)))
    k = half_waves * pi / length
    for a, b, thickness in pieces:
        along = np.subtract(places[b], places[a])
        width = float(np.linalg.norm(along))
        turn = _turned(along / width)
        dofs = np.concatenate([4 * a + np.arange(4), 4 * b + np.arange(4)])
        for total, local in zip((stiffness, stress), _strip(width, thickness, k, modulus, poisson), strict=True):
            total[np.ix_(dofs, dofs)] += turn.T @ local @ turn
    for rib in ribs:
        dofs = 4 * numbers[rib.at] + np.arange(4)
        for total, local in zip((stiffness, stress), _rib(rib, k, modulus, poisson), strict=True):
            total[np.ix_(dofs, dofs)] += local
    fixed = [4 * numbers[name] + "uyzr".index(c) for name, components in held.items() for c in components.split()]
    free = np.setdiff1d(np.arange(len(stiffness)), fixed)
    inverse = eigh(stress[np.ix_(free, free)], stiffness[np.ix_(free, free)], eigvals_only=True)
    return np.sort(1 / inverse[inverse > 1e-12 * inverse.max()])


def _turned(direction: np.ndarray) -> np.ndarray:
    """From (u, y, z, rotation about x) of two lines to (u, v, w, w') on the axes of a strip."""
    c, s = direction
    one = np.array([[1, 0, 0, 0], [0, c, s, 0], [0, -s, c, 0], [0, 0, 0, 1]])
    return np.kron(np.eye(2), one)


def _strip(width, thickness, k, modulus, poisson):
    """Stiffness, and the matrix of a unit of compressive stress."""
    stiffness, stress = np.zeros((2, 8, 8))
    plane = modulus / (1 - poisson**2)
    membrane = plane * thickness * np.array([[1, poisson, 0], [poisson, 1, 0], [0, 0, (1 - poisson) / 2]])
    bending = membrane * thickness**2 / 12
    for s, weight in GAUSS:
        weight *= width
        linear, slope = np.array([1 - s, s]), np.array([-1, 1]) / width
        cubic, first, second = hermite(s, width)
        u, v, w = [0, 4], [1, 5], [2, 3, 6, 7]
        e, c, moved = np.zeros((3, 8)), np.zeros((3, 8)), np.zeros((2, 8))
        e[0, u], e[1, v], e[2, u], e[2, v] = -k * linear, slope, slope, k * linear
        c[0, w], c[1, w], c[2, w] = k**2 * cubic, -second, -2 * k * first
        moved[0, v], moved[1, w] = linear, cubic
        stiffness += weight * (e.T @ membrane @ e + c.T @ bending @ c)
        stress += weight * thickness * k**2 * moved.T @ moved
    return stiffness, stress


def _rib(rib: Rib, k, modulus, poisson):
    """The same of a rib: its centroid moves by z, by -offset times the rotation, and by u - offset z'."""
    axial = np.array([[-k, 0, k**2 * rib.offset, 0]])
    bend, twist = np.array([[0, 0, k**2, 0]]), np.array([[0, 0, 0, k]])
    moved = np.array([[0, 1, 0, -rib.offset], [0, 0, 1, 0]])
    stiffness = modulus * (rib.area * axial.T @ axial + rib.second_moment * bend.T @ bend)
    stiffness += modulus / 2 / (1 + poisson) * rib.torsion * twist.T @ twist
    return stiffness, rib.area * k**2 * moved.T @ moved


def rib_in_the_middle(aspect: float, gamma: float, delta: float, half_waves: int = 1) -> float:
    """Factor k of the buckling load k pi^2 D / b^2 of a plate with a concentric rib without torsional stiffness.

    The plate is simply supported and bends with the rib (Timoshenko and Gere 1961, section 9.11), solved without
    approximation: f = A sinh(alpha y) + B sin(beta y) on a half, f' = 0 at the rib, and 2 D f''' = (EI k^4 - P k^2) f.

    Parameters
    ----------
    gamma, delta : EI / (b D) and A / (b h)
    """
    wave = half_waves * pi / aspect

    def unbalanced(factor):
        root = wave * pi * factor**0.5
        alpha, beta = (wave**2 + root) ** 0.5, (root - wave**2) ** 0.5
        slope = beta * cos(beta / 2)
        rib = gamma * wave**4 - factor * pi**2 * delta * wave**2
        return 2 * (alpha**2 + beta**2) * slope + rib * (sin(beta / 2) - slope * tanh(alpha / 2) / alpha)

    lowest = (wave / pi) ** 2 * (1 + 1e-9)
    factors = np.linspace(lowest, 60.0, 4000)
    values = np.array([unbalanced(f) for f in factors])
    change = int(np.flatnonzero(values[:-1] * values[1:] < 0)[0])
    return brentq(unbalanced, factors[change], factors[change + 1], xtol=1e-12)


def lateral_buckling(length: float, lateral: float, torsion: float, warping: float, wagner: float) -> float:
    """Force at the tip of a cantilever, in its shear centre, at which it buckles sideways (Vlasov 1961, chapter 5).

    Stationary: EI u''^2 + GJ phi'^2 + EI_w phi''^2 + 2 M phi u'' + M beta phi'^2 with M = P (L - x), u'' = -M phi / EI,
    by cubic elements; the clamp does not hold the warping.

    Parameters
    ----------
    lateral, torsion, warping : EI, GJ, EI_w
    wagner : beta, the integral of stress times squared distance from the shear centre over the moment
    """
    nodes = np.linspace(0, length, 41)
    elastic, by_force, by_square = np.zeros((3, 2 * len(nodes), 2 * len(nodes)))
    for i, width in enumerate(np.diff(nodes)):
        dofs = np.arange(2 * i, 2 * i + 4)
        for s, weight in GAUSS:
            phi, slope, bend = hermite(s, width)
            arm, weight = length - nodes[i] - s * width, weight * width
            elastic[np.ix_(dofs, dofs)] += weight * (torsion * np.outer(slope, slope) + warping * np.outer(bend, bend))
            by_force[np.ix_(dofs, dofs)] += weight * arm * wagner * np.outer(slope, slope)
            by_square[np.ix_(dofs, dofs)] += weight * arm**2 / lateral * np.outer(phi, phi)
    elastic, by_force, by_square = (m[1:, 1:] for m in (elastic, by_force, by_square))

    def lowest(force):
        return eigh(elastic + force * by_force - force**2 * by_square, elastic, eigvals_only=True,
                    subset_by_index=[0, 0])[0]

    scale = 4.0126 * (lateral * torsion) ** 0.5 / length**2
    return brentq(lowest, 1e-3 * scale, 5 * scale, xtol=1e-12 * scale)
