"""Places and weights of layers through a thickness, and of fibres over a cross-section."""

from __future__ import annotations

from math import ceil

import basix
import numpy as np

RULES = "gauss", "lobatto", "simpson"


def require_points(owner) -> None:
    """Refuse numbers of layers or fibres that cannot bend elastically as they should.

    Raises
    ------
    ValueError
        For fewer than 2 of Gauss's points, 3 of Lobatto's or Simpson's, or an even number of Simpson's.
    """
    name, rule = type(owner).__name__, getattr(owner, "rule", "gauss")
    if rule not in RULES:
        raise ValueError(f"{name}: rule is {rule!r}; it must be one of {', '.join(RULES)}")
    fewest = 2 if rule == "gauss" else 3
    if not isinstance(owner.points, int) or owner.points < fewest:
        raise ValueError(f"{name}: points is {owner.points}; bending needs at least {fewest} by the rule {rule!r}")
    if rule == "simpson" and owner.points % 2 == 0:
        raise ValueError(f"{name}: points is {owner.points}; Simpson's rule needs an odd number")


def along(length: float, points: int, rule: str = "gauss") -> tuple[np.ndarray, np.ndarray]:
    """Places from the middle of a length, in rising order, and weights that add up to it."""
    if rule == "simpson":
        places, weights = np.linspace(-1, 1, points), np.full(points, 2.0)
        weights[1::2], weights[[0, -1]] = 4.0, 1.0
        weights *= 2 / weights.sum()
    elif rule == "lobatto":
        found, weights = basix.make_quadrature(basix.CellType.interval, 2 * points - 3,
                                               basix.QuadratureType.gll)
        order = np.argsort(found[:, 0])
        places, weights = 2 * found[order, 0] - 1, 2 * weights[order]
    else:
        places, weights = np.polynomial.legendre.leggauss(points)
    return places * length / 2, weights * length / 2


def rectangle(width: float, depth: float, points: int) -> tuple[np.ndarray, np.ndarray]:
    """Fibres of a rectangle by as many of Gauss's points along both sides: places (normal, binormal) and areas."""
    (y, wy), (z, wz) = along(depth, points), along(width, points)
    return np.stack(np.meshgrid(y, z, indexing="ij"), axis=-1).reshape(-1, 2), np.outer(wy, wz).ravel()


def ring(diameter: float, thickness: float, points: int) -> tuple[np.ndarray, np.ndarray]:
    """Fibres of a round tube: `points` on each quarter of its circumference, and as dense through the wall."""
    through, weights = along(thickness, max(2, ceil(points * 2 * thickness / diameter)))
    radii, count = through + (diameter - thickness) / 2, 4 * points
    angles = 2 * np.pi * (np.arange(count) + 0.5) / count
    places = np.stack((np.outer(radii, np.cos(angles)), np.outer(radii, np.sin(angles))), axis=-1)
    return places.reshape(-1, 2), np.repeat(weights * radii * 2 * np.pi / count, count)
