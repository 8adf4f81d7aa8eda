"""How the load of a bifurcation changes with the structure.

The eigenvalue stays zero, and the load does no work along the mode phi (Reitinger and Ramm 1995). With the tangent K,
the load f, and the changes dR and dK of the forces out of balance and of the tangent at the same displacements,

    phi . (dK + K'(dx)) phi = 0,    d(phi . f) = 0,    dx = -K^-1 dR + dfactor K^-1 f + c phi.

K' phi are third variations of the energy. phi . dR is zero unless the change is an imperfection. Of k modes together
the first equation is one for a matrix, whose eigenvalues are the changes of k loads: the point splits, and its
derivatives are one-sided. dR and dK phi are differences of forces and tangents at the state that is known.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np
from petsc4py import PETSc

from .. import rounding
from ..continuation.bordered import BorderedSolver, pivots
from ..continuation.state import State
from ..continuation.tracer import Tracer
from ..discrete.discretisation import Discretisation
from ..discrete.free_motions import usual_stiffness
from ..events.determinant import orthonormal
from .changed import Change, Differences, Failure, Found, derivatives
from .koiter import Energy

IMPERFECT = 1e-5  # push along a mode over the root of the work across it times the mode's change of stiffness


class NoDerivative(ValueError):
    """A bifurcation has none: its load falls by a power below one as a number changes, or has no third variations."""


@dataclass(frozen=True)
class _Changed:
    """What a changed structure has at the state, or a difference of two.

    Attributes
    ----------
    vectors : forces out of balance, loads of a load factor of 1, and images of modes by the tangent, on this process
    total : total load, which may be a reaction
    """

    vectors: np.ndarray
    total: float

    def __sub__(self, other: _Changed) -> _Changed:
        return _Changed(self.vectors - other.vectors, self.total - other.total)

    def __truediv__(self, number: float) -> _Changed:
        return _Changed(self.vectors / number, self.total / number)


def require_perfect(title: str, pushed: float, work: float, rate: float) -> None:
    """Refuse a number that pushes along a mode.

    Parameters
    ----------
    pushed : forces along the modes
    work : of the forces across the modes
    rate : of the modes' stiffness, by the load factor

    Raises
    ------
    NoDerivative
    """
    if pushed > IMPERFECT * (work * rate) ** 0.5:
        raise NoDerivative(f"gradient: the number makes the structure imperfect, so that {title} has no derivative; "
                           "see imperfection_sensitivity")


class BifurcationGradient:
    """Derivatives of the load of a bifurcation, at whose state the tangent is factored once for all numbers together.

    Parameters
    ----------
    tracer : stays at its present state
    title : of the point, for messages
    state : of the point
    modes : null vectors there

    Raises
    ------
    ValueError
        If the load at a point of several modes is a reaction.
    """

    def __init__(self, tracer: Tracer, title: str, state: State, modes: Sequence[np.ndarray]):
        self._tracer, self._title, self._state, self._system = tracer, title, state, tracer.system
        self._discretisation = cast(Discretisation, tracer.discretisation)
        self._modes = orthonormal(self._system.weights, [self._system.create_vector(mode) for mode in modes])
        self._require()

    def _require(self) -> None:
        said = f"gradient: {self._title}"
        if self._discretisation.load_of_unit() is None and len(self._modes) > 1:
            raise ValueError(f"{said}: the load is a reaction to what is prescribed; give the load as forces")

    def _prepare(self) -> None:
        """The tangent's border, and the third variations along modes and path."""
        tracer, system = self._tracer, self._system
        tracer.back_to(self._state)
        self._load = tracer.load_vector()
        self._here = self._changed(self._discretisation)
        weighted = [system.weights * mode for mode in self._modes]
        self._bordered = BorderedSolver(tracer.stepper.linear, pivots(self._modes, system.weights),
                                        usual_stiffness(tracer.discretisation))
        self._bordered.border(weighted, weighted)
        energy, self._along = Energy(system), self._across(self._load)
        self._turning = energy.third(self._modes, self._along, 1.0)
        self._bent = [energy.third(self._modes, mode) for mode in self._modes]
        energy.leave()
        self._rates = np.array([[mode.dot(turning) for mode in self._modes] for turning in self._turning])

    def _across(self, right: PETSc.Vec) -> PETSc.Vec:
        """Solution off the modes."""
        (solution,), _ = self._bordered.solve([right], np.zeros((1, len(self._modes))))
        return solution

    def derivatives(self, changes: Iterable[Change]) -> Iterator[float | np.ndarray | Failure]:
        """Derivatives of the total load, or why there is none."""
        present = self._tracer.state
        try:
            self._prepare()
            for change in changes:
                yield from derivatives([change], self._state.load, self._differences)
        finally:
            self._tracer.back_to(present)

    def _differences(self, changes: Sequence[Change]) -> list[Found]:
        found: list[Found] = []
        for change in changes:
            try:
                more, less = map(self._changed, change.sides(self._state.fields))
                first = (more - less) / (2 * change.step)
                self._require_perfect(first.vectors[0], change.at)
                second = ((more - self._here) - (self._here - less)) / (2 * change.step)
                found.append(Differences(self._of_load(first), float(np.abs(self._of_load(second)).max())))
            except (ValueError, ArithmeticError) as failure:
                found.append(failure)
        return found

    def _of_load(self, change: _Changed) -> float | np.ndarray:
        """Change of the total load: the structure's own, and that by the factor and by displacements."""
        factor, moved = self._of_factor(change)
        if (unit := self._discretisation.load_of_unit()) is not None:
            return change.total + unit * factor
        step = rounding.DIFFERENCE / max(self._tracer.distance(0.0, moved.array), rounding.TINIEST)
        totals = []
        for way in (step, -step):
            self._system.configure(way * moved, self._state.factor + way * float(factor))
            totals.append(self._discretisation.total_load())
        return change.total + (totals[0] - totals[1]) / (2 * step)

    def _require_perfect(self, residual: np.ndarray, at: float) -> None:
        forces = self._system.create_vector(residual)
        if at and abs(at) * forces.norm() <= rounding.NONE * abs(self._state.factor) * self._load.norm():
            return
        pushed = max(abs(mode.dot(forces)) for mode in self._modes)
        work = abs(self._across(-1.0 * forces).dot(forces))
        require_perfect(self._title, pushed, work, float(np.abs(np.diag(self._rates)).max()))

    def _of_factor(self, change: _Changed) -> tuple[float | np.ndarray, PETSc.Vec]:
        """Changes of the load factor, and of displacements at a simple bifurcation."""
        (forces, loads, *images), along = map(self._system.create_vector, change.vectors), self._rates
        moved = self._across(-1.0 * forces)
        changed = np.array([[mode.dot(image) + bent.dot(moved) for mode, bent in zip(self._modes, row, strict=True)]
                            for image, row in zip(images, self._bent, strict=True)])
        if len(self._modes) > 1:
            return np.sort(np.linalg.eigvals(np.linalg.solve(along, -(changed + changed.T) / 2)).real), moved
        mode, turning, bent = self._modes[0], self._turning[0], self._bent[0][0]
        matrix = [[along[0, 0], mode.dot(bent)], [-self._along.dot(turning), -self._along.dot(bent)]]
        right = [-changed[0, 0], self._along.dot(images[0]) + turning.dot(moved) - mode.dot(loads)]
        factor, share = map(float, np.linalg.solve(matrix, right))
        return factor, moved + factor * self._along + share * mode

    def _changed(self, discretisation: Discretisation) -> _Changed:
        system = discretisation.system
        vectors = [system.create_vector() for _ in range(2 + len(self._modes))]
        system.configure(system.create_vector(), self._state.factor)
        system.residual(vectors[0])
        system.load(vectors[1])
        system.extrapolate_stress()
        matrix = system.tangent()
        for mode, image in zip(self._modes, vectors[2:], strict=True):
            matrix.mult(system.create_vector(mode.array), image)
        return _Changed(np.array([vector.array for vector in vectors]), discretisation.total_load())
