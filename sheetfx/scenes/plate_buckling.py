"""Buckling of a rectangular plate in uniaxial compression, for several supports of its edges.

The stress before buckling is uniform. Theory is that of Kirchhoff's plate, solved with a sine in the direction
whose edges are simply supported and polynomials in the other (Timoshenko and Gere 1961, sections 9.2-9.4); at the
default slenderness transverse shear lowers the loads by about 1e-4 where an edge is free, by 1e-5 elsewhere.
"""

from __future__ import annotations

from math import inf, pi
from typing import Annotated

import numpy as np
from numpy.polynomial import Legendre
from scipy.linalg import eigh
from typer import Option

from ..case import Case
from ..checks import AT_LEAST_1, POSITIVE, Choice, Range
from ..critical.buckling import buckling
from ..model.loads import EdgeForce
from ..model.plate import Plate
from ..model.scene import Monitor, Scene
from ..model.section import Elastic
from ..model.shell import Shell
from ..model.supports import Support
from ..path import Until
from ..record import Record
from . import looked_at
from ._benchmark import Form, surface

SUPPORTED, CLAMPED, FREE = "supported", "clamped", "free"
EDGES = {
    "simply-supported": (SUPPORTED, SUPPORTED, SUPPORTED), "clamped-loaded": (CLAMPED, SUPPORTED, SUPPORTED),
    "clamped-unloaded": (SUPPORTED, CLAMPED, CLAMPED), "free": (SUPPORTED, SUPPORTED, FREE),
    "clamped-free": (SUPPORTED, CLAMPED, FREE),
}
WIDTH, MODULUS = 1000.0, 210000.0


@looked_at
def case(
    edges: Annotated[str, Choice(tuple(EDGES)),
                     Option(help=f"one of {', '.join(EDGES)}: unloaded edges unless it says loaded; `free` leaves one "
                                 "of them, `clamped-free` clamps the other")] = "simply-supported",
    aspect: Annotated[float, POSITIVE, Option(help="length along the load over width")] = 1.0,
    cells: Annotated[int, AT_LEAST_1, Option(help="cells across the width")] = 8,
    form: Form = "naghdi-q3",
    slenderness: Annotated[float, POSITIVE, Option(help="width over thickness")] = 1000.0,
    poisson: Annotated[float, Range(above=-1, most=0.5), Option(help="Poisson's ratio")] = 0.3,
    count: Annotated[int, AT_LEAST_1, Option(help="number of buckling loads")] = 6,
) -> Case:
    """Plate 1000 mm wide: factor k of its buckling load k pi^2 D / b^2, against theory."""
    mesh = surface(form, (max(1, round(cells * aspect)), cells), lambda x, y: (aspect * WIDTH * x, WIDTH * y, 0.0), {})
    thickness = WIDTH / slenderness
    shell = Shell(mesh, Plate(thickness), Elastic(MODULUS, poisson), form=form)
    loaded, south, north = EDGES[edges]
    kinds = {"west": loaded, "east": loaded, "south": south, "north": north}
    supports = [Support(mesh, edge, _fixed(kind, edge)) for edge, kind in kinds.items() if kind != FREE]
    euler = pi**2 * MODULUS * thickness**3 / 12 / (1 - poisson**2) / WIDTH**2
    return Case(
        scene=Scene(
            [shell], [*supports, Support(mesh, "south-west", "x y"), Support(mesh, "south-east", "y")],
            [EdgeForce(mesh, "west", (euler, 0.0, 0.0)), EdgeForce(mesh, "east", (-euler, 0.0, 0.0))],
            Monitor(mesh, "south-east", "x", -1.0)),
        until=Until(steps=0), buckling=lambda path, state: buckling(path, state, count),
        quantities=lambda record: quantities(record, edges, aspect, poisson),
        axes=("shortening (mm)", "load on both edges (N)"))


def _fixed(kind: str, edge: str) -> str:
    """No deflection and no rotation about the edge's normal; about the edge none where it is clamped."""
    return "z rx ry" if kind == CLAMPED else "z rx" if edge in ("west", "east") else "z ry"


def quantities(record: Record, edges: str, aspect: float, poisson: float) -> dict[str, float]:
    """Factor k, its theory and the difference in percent."""
    factor = min(b.factor for b in record.buckling() if b.factor > 0)
    theory = buckling_factor(edges, aspect, poisson)
    return {"factor": factor, "theory": theory, "difference_percent": 100 * (factor / theory - 1)}


def buckling_factor(edges: str, aspect: float, poisson: float, degree: int = 18) -> float:
    """Factor k of a Kirchhoff plate, the lowest over the number of half waves."""
    loaded, south, north = EDGES[edges]
    if loaded == CLAMPED:
        return _strip(CLAMPED, CLAMPED, aspect, pi, poisson, degree, along=True)
    lowest, waves = inf, 1
    while waves <= 2 + 3 * aspect:
        lowest = min(lowest, _strip(south, north, 1.0, waves * pi / aspect, poisson, degree, along=False))
        waves += 1
    return lowest


def _strip(start: str, end: str, length: float, wave: float, poisson: float, degree: int, along: bool) -> float:
    """Lowest k of deflections f(s) sin(wave t) on 0 < s < length, a unit width and the load along s or along t.

    Rayleigh-Ritz with polynomials f that satisfy the essential conditions at both ends.
    """
    order = {FREE: 0, SUPPORTED: 1, CLAMPED: 2}
    factor = Legendre.fromroots([0.0] * order[start] + [length] * order[end], domain=[0, length])
    basis = [factor * Legendre.basis(n, domain=[0, length]) for n in range(degree)]
    points, weights = np.polynomial.legendre.leggauss(degree + 6)
    points, weights = length * (points + 1) / 2, length * weights / 2
    f, slope, bend = (np.array([b.deriv(n)(points) if n else b(points) for b in basis]) for n in range(3))

    def integral(one, other):
        return (one * weights) @ other.T

    energy = integral(bend, bend) + wave**4 * integral(f, f) + 2 * (1 - poisson) * wave**2 * integral(slope, slope)
    energy -= poisson * wave**2 * (integral(f, bend) + integral(bend, f))
    work = integral(slope, slope) if along else wave**2 * integral(f, f)
    return float(eigh(energy, work, eigvals_only=True, subset_by_index=[0, 0])[0]) / pi**2
