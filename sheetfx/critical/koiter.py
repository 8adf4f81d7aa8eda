"""What follows a bifurcation, from the variations of the energy there (Koiter 1945).

With a null vector phi of the tangent the energy along the curve s phi + s^2 w, where w makes it stationary, is

    E(s) = A s^3 / 6 + C s^4 / 24 + ...,   w = -K^-1 (third variation phi phi) / 2 off the null vector,

and the tangent loses the stiffness B along phi with the load of the fundamental path. The other path is
load - critical load = -A s / (2 B) - C s^2 / (6 B) (Koiter 1945; Budiansky 1974). Third and
fourth variations are differences of the exact gradient and Hessian that the forms give: w is stationary, so that its
error counts in the second order only, and slender structures lose no digits.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from petsc4py import PETSc

from ..continuation.state import CriticalPoint, State
from ..discrete.system import System
from ..rounding import DIFFERENCE, TINIEST, UNIT, residual
from .modes import scaled

LONGEST = 0.1  # of differences of the gradient
AGREED = 1e-7  # relative change of a coefficient by shorter differences, from which it is good enough
RESOLVED = 1e-6  # amplitude, in the scaled norm, for a load changed by one per cent; less beside a limit point
NEGLIGIBLE = 1e-2  # share of the slope in a load changed by one per cent, of a symmetric bifurcation


class Energy:
    """Variations of the energy about a system's last converged state, as a function of the increments since then."""

    def __init__(self, system: System):
        self._system, self._factor = system, system.factor

    def length(self, x: PETSc.Vec) -> float:
        """Of increments, in the scaled inner product."""
        return (self._system.weights * x).dot(x) ** 0.5

    def gradient(self, x: PETSc.Vec) -> PETSc.Vec:
        out = x.duplicate()
        with self._system.additive_increments():
            self._system.configure(x, self._factor)
            self._system.residual(out)
        return out

    def hessian(self, x: PETSc.Vec, factor: float, modes: Sequence[PETSc.Vec]) -> list[PETSc.Vec]:
        """Its products with modes."""
        system, products = self._system, [x.duplicate() for _ in modes]
        with system.additive_increments():
            system.configure(x, factor)
            system.extrapolate_stress()
            matrix = system.tangent()
            for mode, product in zip(modes, products, strict=True):
                matrix.mult(mode, product)
        return products

    def third(self, modes: Sequence[PETSc.Vec], along: PETSc.Vec, load: float = 0.0,
              about: tuple[PETSc.Vec, float] | None = None) -> list[PETSc.Vec]:
        """Change of the Hessian's products with modes along an increment of unknowns and load factor.

        Parameters
        ----------
        about : increments since the state, and load factor, where it changes; None: the state's
        """
        step = DIFFERENCE / max(self.length(along), TINIEST)
        x, factor = about or (along.duplicate(), self._factor)
        ahead, behind = (self.hessian(x + sign * step * along, factor + sign * step * load, modes)
                         for sign in (1.0, -1.0))
        return [(one - other) / (2 * step) for one, other in zip(ahead, behind, strict=True)]

    def leave(self) -> None:
        """Put the fields back to the state."""
        self._system.configure(self._system.create_vector(), self._factor)


@dataclass(frozen=True)
class Expansion:
    """Energy about a simple bifurcation, off the fundamental path: B load s^2 / 2 + A s^3 / 6 + C s^4 / 24.

    Attributes
    ----------
    mode : null vector, of unit length in the scaled inner product, its largest displacement being positive
    size : largest displacement of the mode
    cubic, stiffness, quartic : A, B and C; what rounding may make, A or the sign of C, is zero
    """

    mode: PETSc.Vec
    size: float
    cubic: float
    stiffness: float
    quartic: float


def expansion(tracer, mode: PETSc.Vec, neighbours: Sequence[State]) -> Expansion:
    """Energy about the tracer's current state, a simple bifurcation whose tangent is factored.

    Parameters
    ----------
    mode : null vector, of unit length in the scaled inner product
    neighbours : states on the fundamental path, before and behind
    """
    unit = tracer.system.create_vector(scaled(tracer.discretisation, mode))
    size = 1 / tracer.distance(0.0, unit.array)
    mode = size * unit
    energy, solve = Energy(tracer.system), _Complement(tracer, mode)
    (third,) = energy.third([mode], mode)
    slope = solve(tracer.load_vector())
    stiffness, bend = (mode.dot(change) for change in energy.third([mode, slope], slope, 1.0))
    quartic_, error = (24 * number for number in quartic(energy, mode, solve(-0.5 * third)))
    cubic = _cubic(energy, mode, _blur(tracer, mode, abs(quartic_) + error))
    energy.leave()
    along = sum(tracer.inner((0.0, mode.array), (0.0, s.response)) for s in neighbours) / len(neighbours)
    stiffness += cubic * _fundamental(cubic, stiffness, bend, along)
    return Expansion(mode, size, cubic, stiffness, quartic_ if abs(quartic_) > error else 0.0)


def postbuckling(tracer, state: State, modes: Sequence[PETSc.Vec], point: CriticalPoint,
                 neighbours: Sequence[State]) -> CriticalPoint:
    """A bifurcation with its name and, where it is simple, Koiter's a and b; none if the load leaves it singular.

    Parameters
    ----------
    tracer : at the state of the bifurcation, with its tangent factored
    modes : null vectors, of unit length in the scaled inner product
    neighbours : states on the fundamental path, before and behind
    """
    if len(modes) > 1:
        return replace(point, name="multiple")
    e = expansion(tracer, modes[0], neighbours)
    if not e.stiffness:
        return point
    first, second = -e.cubic / (2 * e.stiffness) / e.size, -e.quartic / (6 * e.stiffness) / e.size**2
    change = 0.01 * max(abs(state.factor), abs(neighbours[1].load_increment))
    reach = min((change / max(abs(second), TINIEST)) ** 0.5, e.size)  # of the curvature, in the size of the structure
    if abs(first) * reach > NEGLIGIBLE * change:
        return replace(point, name="asymmetric", slope=first / state.factor)
    if not e.quartic:
        return replace(point, slope=0.0)
    point = replace(point, name="stable symmetric" if e.quartic > 0 else "unstable symmetric", slope=0.0)
    return replace(point, curvature=second / state.factor) if reach > RESOLVED * e.size else point


def _blur(tracer, mode: PETSc.Vec, quartic: float) -> float:
    """Cubic coefficient that a symmetric structure may have at a state which is off along the mode.

    There the energy has the derivative C s^3 / 6 and A = C s. Where the derivative is rounding no state is better.
    """
    noise = residual(tracer.system, tracer.system.create_vector()) * mode.norm()
    return (6 * noise * quartic**2) ** (1 / 3)


def _fundamental(cubic: float, stiffness: float, bend: float, seen: float) -> float:
    """Component along the mode of the fundamental path by a unit of load.

    Both paths solve cubic k^2 + 2 stiffness k + bend = 0 (Keller 1977, algebraic bifurcation equation); the one
    closest to the one that is seen counts.
    """
    roots = np.roots([cubic, 2 * stiffness, bend]) if cubic or stiffness else np.zeros(1)
    return float(min(roots.real, key=lambda root: abs(root - seen)))


class _Complement:
    """Solutions of the singular tangent off its null vector."""

    def __init__(self, tracer, mode: PETSc.Vec):
        self._solver, self._mode = tracer.stepper.linear, mode
        self._weighted = tracer.system.weights * mode

    def __call__(self, right: PETSc.Vec) -> PETSc.Vec:
        solution = right.duplicate()
        self._solver.solve(right - right.dot(self._mode) * self._weighted, solution)
        return solution - solution.dot(self._weighted) * self._mode


def _cubic(energy: Energy, mode: PETSc.Vec, blur: float) -> float:
    """Coefficient A of s^3 / 6 in the energy along s mode; 0 where it is less than its blur.

    The even part of its derivative is r + A s^2 / 2 + d s^4, where r is what the state lacks of balance. Differences of
    the Hessian, which are taken over a shorter way, would make a symmetric bifurcation asymmetric by the rounding of
    stiff parts.
    """
    def even(length: float) -> float:
        return (energy.gradient(length * mode) + energy.gradient(-length * mode)).dot(mode) / 2

    cubic = 2 * _coefficient(even, (0, 2, 4), blur / 2)[0]
    return cubic if abs(cubic) >= blur else 0.0


def quartic(energy: Energy, mode: PETSc.Vec, bend: PETSc.Vec) -> tuple[float, float]:
    """Coefficient of s^4 in the energy along s mode + s^2 bend, and its error.

    The odd part of its derivative is c s + 4 quartic s^3 + d s^5. Where a branch keeps its load the error is as large
    as the value.
    """
    def odd(length: float) -> float:
        return (_slope(energy, mode, bend, length) - _slope(energy, mode, bend, -length)) / 2

    found, error = _coefficient(odd, (1, 3, 5))
    return found / 4, error / 4


def _coefficient(function: Callable[[float], float], powers: tuple[int, int, int],
                 none: float = 0.0) -> tuple[float, float]:
    """Coefficient of the middle one of three powers of an amplitude in a function, and its error.

    Three neighbours of a sequence of quartered amplitudes give the coefficient. Large ones suffer from higher terms,
    small ones from rounding, until it swallows the function: the value counts that differs least from those before and
    behind it, or the first one that with its error is less than `none`.
    """
    lengths, values, found = [LONGEST], [function(LONGEST)], []
    best, error = 0.0, np.inf
    while lengths[-1] > LONGEST * UNIT**0.75 and error > AGREED * abs(best) and error + abs(best) >= none:
        lengths.append(lengths[-1] / 4)
        values.append(function(lengths[-1]))
        if len(values) >= 3:
            s, scale = np.array(lengths[-3:]), lengths[-3]
            found.append(np.linalg.solve((s[:, None] / scale) ** np.array(powers), values[-3:])[1] / scale ** powers[1])
        if len(found) >= 3 and found[-2]:
            off = max(abs(found[-2] - other) for other in (found[-3], found[-1]))
            error, best = min((error, best), (off, found[-2]))
    return float(best), float(error) if best else 0.0


def _slope(energy: Energy, mode: PETSc.Vec, bend: PETSc.Vec, length: float) -> float:
    """Derivative of the energy along the curve."""
    return energy.gradient(length * mode + length**2 * bend).dot(mode + 2 * length * bend)
