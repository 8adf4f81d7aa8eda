"""What double precision leaves open: of numbers, of residuals, and of states by the residual through the factor.

Every level of rounding is one of these; no other file has its own.
"""

from __future__ import annotations

from collections.abc import Callable
from math import isclose

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc
from scipy.optimize import brentq

UNIT, TINIEST = float(np.finfo(float).eps), float(np.finfo(float).tiny)
SAFETY = 10  # multiples of what rounding is estimated at, up to which a difference may be rounding
SAME = 1e-12  # relative difference of numbers that are the same but for some thousand roundings
NONE = 1e-10  # relative size of a component that is none but for a solution with the tangent
SPLIT = 1e-6  # imaginary part over the size of a double eigenvalue, which rounding splits by its root


def same(one: float, other: float) -> bool:
    """Whether two numbers, of a size of 1 or more, differ by rounding only."""
    return isclose(one, other, rel_tol=SAME, abs_tol=SAME)


def is_real(value: complex, size: float | None = None) -> bool:
    """Whether an eigenvalue is real but for rounding; beside the size of the largest one, or its own."""
    return abs(value.imag) <= SPLIT * (abs(value) if size is None else size)


def root(function: Callable[[float], float], left: float, right: float) -> float:
    """The root of a function between two places, as exact as numbers of that distance are the same (Brent 1973)."""
    return float(brentq(function, left, right, xtol=SAME * abs(right - left), rtol=4 * UNIT))


def residual(system, motion: float | None = None) -> float:
    """Largest residual of equilibrium that is rounding: the last digits of displacements move the stiffest unknown.

    Parameters
    ----------
    motion : largest displacement; None: that of the present configuration
    """
    stiffest = system.matrix.getDiagonal().norm(PETSc.NormType.INFINITY)
    return SAFETY * UNIT * stiffest * (_largest_motion(system) if motion is None else motion)


def _largest_motion(system) -> float:
    """Largest displacement; rotations count as displacements of the structure's size by them."""
    fields = [f for f in system.unknowns.fields if np.isfinite(f.scale) and not f.curved]
    moved = max(np.abs(f.value.x.array).max(initial=0.0) / f.scale for f in fields)
    return system.comm.allreduce(float(moved), op=MPI.MAX) * max(f.scale for f in fields)


def off_path(tracer, state) -> float:
    """Distance by which rounding may have a state off the path: its residual, taken through the factor of its tangent.

    A residual that rounding kept from falling may lie along the softest mode.
    """
    system = tracer.system
    tracer.factorise_at(state)
    left, correction = system.create_vector(), system.create_vector()
    system.residual(left)
    tracer.stepper.linear.solve(left, correction)
    distance = tracer.distance(0.0, correction.array)
    if tracer.stepper.rounding:
        (value, *_), (mode, *_) = tracer.spectrum(1)
        distance += tracer.stepper.rounding * mode.norm() / abs(value)
    return SAFETY * distance
