"""Whether forces have a potential, found by their own tangent."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from petsc4py import PETSc

from .contribution import Contribution
from .layout import Layout
from .load_factors import LoadFactors
from .system import System
from .timing import Stopwatch
from .unknowns import Unknowns

MOVED = 0.1  # of the scales of the fields, random increments at which tangents are looked at
SYMMETRIC = 1e-9  # relative difference of a tangent and its transpose that is rounding


def look_for_potentials(loads: Iterable[tuple[Any, Sequence[Contribution]]], unknowns: Unknowns, layout: Layout,
                        factors: LoadFactors, clock: Stopwatch) -> dict[Any, bool]:
    """Of loads that follow the structure whether their forces have a potential as the structure is supported.

    Parameters
    ----------
    loads : with their contributions, which are told
    """
    found = {}
    for load, works in loads:
        works = [work for work in works if not work.conservative]
        if load is not None and works:
            found[load] = have_potential(unknowns, works, layout, factors, clock)
            for work in works:
                work.conservative = found[load]
    return found


def have_potential(unknowns: Unknowns, contributions: Sequence[Contribution], layout: Layout, factors: LoadFactors,
                   clock: Stopwatch) -> bool:
    """Whether the tangent of some contributions is symmetric where all that is free has moved by random amounts.

    Forces have a potential in the motions that the supports leave if and only if their derivative is symmetric
    everywhere (the boundary terms of a pressure vanish where the boundary is held, Bufler 1984; a moment of fixed
    direction has a potential where it can turn about its own axis alone, Ziegler 1968). One state without any symmetry
    stands for all of them; rotations are followed by Rodrigues vectors, whose increments add. The fields come back to
    where they were, and the first stage begins.
    """
    system = System(unknowns, contributions, layout, factors, clock)
    stage = contributions[0].stage
    factors.enter(0 if stage is None else stage, 1.0)
    with system.additive_increments():
        tangent = moved(system, layout, MOVED, 1.0)
        found = asymmetry(tangent) <= SYMMETRIC * tangent.norm()
    system.configure(system.create_vector(), 0.0)
    factors.enter(0, 0.0)
    return found


def moved(system: System, layout: Layout, share: float, factor: float) -> PETSc.Mat:
    """The tangent where all that is free has moved by random amounts, a share of the scales of the fields."""
    arrays, random = layout.zeros(), np.random.default_rng(layout.comm.rank)
    for field, array in layout.fields(arrays):
        if np.isfinite(field.scale):
            array[field.dofs] = share * field.scale * random.uniform(-1, 1, len(field.dofs))
    increments = layout.create_vector()
    layout.put(arrays, increments)
    increments.array[layout.fixed] = 0
    system.configure(increments, factor)
    return system.tangent()


def asymmetry(tangent: PETSc.Mat) -> float:
    """Norm of the difference of a tangent and its transpose; NaN: it has no numbers."""
    difference = tangent.transpose(PETSc.Mat())
    difference.axpy(-1.0, tangent)
    return difference.norm()
