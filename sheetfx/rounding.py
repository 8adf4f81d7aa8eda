"""What double precision leaves open: of numbers, of residuals, and of states by the residual through the factor.

Every level of rounding is one of these; no other file has its own.
"""

from __future__ import annotations

from collections.abc import Callable
from math import isclose, sqrt

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc
from scipy.optimize import brentq

UNIT, TINIEST = float(np.finfo(float).eps), float(np.finfo(float).tiny)
SAFETY = 10  # multiples of what rounding is estimated at, up to which a difference may be rounding
NUDGE = 1e3  # last digits, by which noise is sampled: many, and so few that forces are linear in them
SAME = 1e-12  # relative difference of numbers that are the same but for some thousand roundings
NONE = 1e-10  # relative size of a component that is none but for a solution with the tangent
SPLIT = 1e-6  # imaginary part over the size of a double eigenvalue, which rounding splits by its root
DIFFERENCE = 1e-4  # of central differences of the tangent, in the scaled norm or of a length: 1e-8 of what they give


def same(one: float, other: float) -> bool:
    """Whether two numbers, of a size of 1 or more, differ by rounding only."""
    return isclose(one, other, rel_tol=SAME, abs_tol=SAME)


def is_real(value: complex, size: float | None = None) -> bool:
    """Whether an eigenvalue is real but for rounding; beside the size of the largest one, or its own."""
    return abs(value.imag) <= SPLIT * (abs(value) if size is None else size)


def root(function: Callable[[float], float], left: float, right: float) -> float:
    """The root of a function between two places, as exact as numbers of that distance are the same (Brent 1973)."""
    return float(brentq(function, left, right, xtol=SAME * abs(right - left), rtol=4 * UNIT))


def residual(system, x: PETSc.Vec) -> float:
    """Largest residual of equilibrium that is rounding: SAFETY times its noise at the increments x."""
    return SAFETY * noise(system, x).norm()


def noise(system, x: PETSc.Vec) -> PETSc.Vec:
    """A sample of the rounding of the residual at the increments x.

    Noise is what second differences of the residual show whose true part is far less (More and Wild 2011, eq. 2.2):
    of strains in their formula, and of the last digits of displacements, which places on both sides of x would round
    alike. The system is left at x.
    """
    moved, out, difference = (system.create_vector() for _ in range(3))
    for nudges, share in ((2, 1), (1, -2), (0, 1)):
        moved.array[:] = x.array + nudges * _nudge(system)
        moved.ghostUpdate(addv=PETSc.InsertMode.INSERT, mode=PETSc.ScatterMode.FORWARD)
        system.configure(moved, system.factor)
        system.residual(out)
        difference.axpy(share, out)
    difference.scale(1 / sqrt(6))
    return difference


def _nudge(system) -> np.ndarray:
    """Random increments, this process's part: NUDGE times the last digit of the structure's size, or of a radian."""
    weights = system.weights.array
    moving = weights > 0
    count = system.comm.allreduce(int(moving.sum()), op=MPI.SUM)
    random = np.random.default_rng(system.comm.rank).uniform(-1.0, 1.0, len(weights))
    return np.divide(NUDGE * UNIT * random, np.sqrt(weights * count), out=np.zeros_like(random), where=moving)


def last_digits(system, motion: float) -> float:
    """Largest force that is rounding: what it takes to move the stiffest unknown by the last digits of a motion."""
    return SAFETY * UNIT * motion * system.matrix.getDiagonal().norm(PETSc.NormType.INFINITY)


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
        for value, mode in zip(*tracer.spectrum(1), strict=True):
            distance += tracer.stepper.rounding * mode.norm() / abs(value)
    return SAFETY * distance
