"""Contact forces found exactly within each Newton iteration, on what else is linear there.

Where parts touch, forces change with motions far smaller than a step's, so that Newton's iteration on
all unknowns together would have to take tiny steps. But contact acts on few of them. With K dx + R = 0 the linear
problem of an iteration, F the forces of the contacts in R and k their part of K, the step that has contact exact is

    dx = K^-1 (-R - r),   r = F(x + dx) - F(x) - k dx,

where r has few entries: the problem is solved for these, at the price of as many back-substitutions. This is nonlinear
elimination (Lanzkron, Rose and Wilkes 1996), on the flexibility of the structure at the places where it touches.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from petsc4py import PETSc
from scipy.sparse import csc_matrix, csr_matrix

from ..discrete.system import System
from .linear import DirectSolver

ITERATIONS = 60  # Newton's, at each thickness
NEAR = 0.1  # error of a plain step over the load, below which no approach is needed
AGAIN = 1e-6  # relative difference of errors that are the same: the same points touch as before


class Elimination:
    """Corrects the steps of a Newton iteration so that contacts hold exactly in the linearised structure.

    Parameters
    ----------
    regularise : function of the multiple of the regularisation
    multiples : through which solutions are approached, the last one is 1

    Attributes
    ----------
    most : rows that are eliminated
    can_do_without : whether a step goes on as it is where there are more rows, as those after it may have fewer
    exact : largest error of contact forces over the load, from which one correction more is enough
    throughout : whether forces are found in all iterations of a step, which then tell how hard it is
    softened : multiples of the regularisation through which forces are approached that a first step does not find
        otherwise; later there may be several solutions, of which soft ones lead to another
    begins : whether the step is a first one, which may have as many rows as it takes where softer forces lead to it
    """

    most, exact, can_do_without, throughout = 300, 1e-5, False, False
    softened: Sequence[float] = ()
    begins = False
    _found = 0
    _responses: list[np.ndarray]

    def __init__(self, system: System, linear: DirectSolver, regularise, multiples: Sequence[float]):
        self._system, self._linear, self._regularise, self._multiples = system, linear, regularise, multiples
        self._trial, self._out, self._column = (system.create_vector() for _ in range(3))

    def correct(self, x: PETSc.Vec, factor: float, step: PETSc.Vec, unit: PETSc.Vec,
                normals: Sequence[tuple[PETSc.Vec | None, float]], size: float, exact: float) -> float:
        """Change a step in place so that the contacts hold after it; return the change of its load.

        Parameters
        ----------
        x, factor : increments and load factor that the step starts from, with the factor of the tangent there
        unit : response to a unit of load
        normals : gradients by unknowns and load factor of what is held meanwhile: the control's equation, and others
            for where forces are not found with that
        size : of forces
        exact : error of contact forces over that, from which one correction more is enough

        Raises
        ------
        ArithmeticError
            If the contact forces are not found.
        """
        system = self._system
        system.configure(x, factor)
        self._x, self._factor, self._base, self._size = x, factor, system.everywhere(step), size
        self._unit, self._exact = unit, exact
        self._linearise()
        self._moved = self._places(self._base[None])[0]
        for self._normal in normals:
            self._rows, self._loads, self._responses = np.empty(0, dtype=np.int64), np.empty(0), []
            self._flexibility = np.empty((0, len(self._moved)))
            if (forces := self._solve()) is not None or self._many:
                break
        system.configure(x, factor)
        if forces is None and self._many and self.can_do_without:
            return 0.0
        if forces is None:
            raise ArithmeticError("contact forces are not found")
        self._found += len(forces) > 0 and not self.throughout
        change = -float(self._loads @ forces)
        for part in self._responses:
            this, forces = np.split(forces, [len(part)])
            self._base -= this @ part
        step.array[:] = system.own(self._base)
        return change

    def found_since(self) -> int:
        """How often forces have been found that were not zero since this was last asked."""
        found, self._found = self._found, 0
        return found

    def _linearise(self) -> None:
        """Take forces and stiffness as they are."""
        self._before, self._stiff = self._forces(), self._system.tangent_of_steep()

    def _forces(self) -> np.ndarray:
        self._system.residual_of(self._system.steep, self._out)
        return self._system.everywhere(self._out)

    @property
    def _is_patient(self) -> bool:
        return self.begins and len(self.softened) > 0

    def _solve(self) -> np.ndarray | None:
        """Forces at the rows; None: not found."""
        off = self._off(np.zeros(0))
        if off is None:
            return None
        size = self._error(off) / self._size
        if size <= self._exact:
            return np.zeros(len(off))
        sequences = [self._multiples]
        if size < NEAR and len(self._multiples) > 1:
            sequences.insert(0, [1.0])
        if self._is_patient:
            sequences.append(self.softened)
        for multiples in sequences:
            forces = np.zeros(len(self._rows))
            for times in multiples:
                self._regularise(times)
                forces = self._converge(forces)
                if forces is None:
                    break
            self._regularise(1.0)
            if forces is not None:
                return forces
        return None

    def _converge(self, forces: np.ndarray) -> np.ndarray | None:
        """The remaining forces at one thickness by Newton's iteration; None: not found, as where errors come again.

        Where a panel peels off its bars each iteration opens a few points more, and errors rise and fall meanwhile.
        """
        errors: list[float] = []
        for _ in range(ITERATIONS):
            if (off := self._off(forces)) is None:
                return None
            forces = np.append(forces, np.zeros(len(off) - len(forces)))
            correction, error = self._correction(off), self._error(off)
            if correction is None or any(abs(error - other) <= AGAIN * other for other in errors):
                return None
            errors.append(error)
            forces = forces + correction
            if error <= self._exact * self._size:
                return forces
        return None

    def _error(self, off: np.ndarray) -> float:
        """How far forces are off what the laws say."""
        return float(np.linalg.norm(off))

    def _correction(self, off: np.ndarray) -> np.ndarray | None:
        """Newton's, of forces that are off by so much; it couples rows whose stiffness changes. None: there is none."""
        change = self._stiffened()[self._rows][:, self._rows].tocsr()
        change.eliminate_zeros()
        rows, correction = np.flatnonzero(np.diff(change.indptr)), off.copy()
        by_forces = change[rows] @ self._flexibility[:, self._rows].T
        correction[rows] = 0.0
        try:
            correction[rows] = np.linalg.solve(np.eye(len(rows)) + by_forces[:, rows],
                                               off[rows] - by_forces @ correction)
        except np.linalg.LinAlgError:
            return None
        return correction if np.isfinite(correction).all() else None

    def _off(self, forces: np.ndarray) -> np.ndarray | None:
        """What the contacts' laws say of the forces at rows, less these; None: these are too many.

        Rows are added where there are forces.
        """
        beyond = self._beyond(self._moved - forces @ self._flexibility[:len(forces)])
        new = np.setdiff1d(np.flatnonzero(beyond), self._rows)
        self._many = not self._is_patient and len(self._rows) + len(new) > self.most
        if self._many:
            return None
        if len(new):
            responses, loads = self._respond(self._units(new))
            self._responses.append(responses)
            self._loads = np.append(self._loads, loads)
            self._flexibility = np.vstack([self._flexibility, self._places(responses)])
            self._rows = np.concatenate([self._rows, new])
        off = beyond[self._rows]
        off[:len(forces)] -= forces
        return off

    def _places(self, responses: np.ndarray) -> np.ndarray:
        """Motions in responses, as rows, where contacts act."""
        return responses

    def _beyond(self, step: np.ndarray) -> np.ndarray:
        """Forces after a step beyond those that are linear in it, at all rows there are."""
        system, trial = self._system, self._trial
        self._x.copy(trial)
        self._column.array[:] = system.own(step)
        system.retract(trial, self._column)
        system.configure(trial, self._factor)
        return self._forces() - self._before - self._stiff @ step

    def _stiffened(self) -> csr_matrix:
        """Stiffness after the last step that was tried, less that before."""
        return self._system.tangent_of_steep() - self._stiff

    def _units(self, rows: np.ndarray) -> csc_matrix:
        """Unit forces at rows, as columns."""
        return csc_matrix((np.ones(len(rows)), (rows, np.arange(len(rows)))), shape=(len(self._base), len(rows)))

    def _respond(self, units: csc_matrix) -> tuple[np.ndarray, np.ndarray]:
        """Responses to forces that keep to the control's equation, as rows, and the changes of load in them."""
        (along, of_load), everywhere = self._normal, self._system.everywhere
        responses = self._linear.responses(units)
        if along is None:
            return responses, np.zeros(units.shape[1])
        loads = -(responses @ everywhere(along)) / (along.dot(self._unit) + of_load)
        responses += np.outer(loads, everywhere(self._unit))
        return responses, loads
