"""How the load of a critical point changes with the structure, without a path of the changed one.

With the null vector phi of the tangent K, forces out of balance R and the load f, the load factor of a limit point
changes by

    dfactor = phi . dR / phi . f,

where dR is the change of R by the structure at the same displacements (Wu and Arora 1988). At a bifurcation phi . f is
zero, and so is phi . dR unless the change is an imperfection. There the eigenvalue stays zero, and the load does no
work along the mode (Reitinger and Ramm 1995):

    phi . (dK + K'(dx)) phi = 0,    d(phi . f) = 0,    dx = -K^-1 dR + dfactor K^-1 f + c phi.

K' phi are third variations of the energy. Of k modes together the first equation is one for a matrix, whose eigenvalues
are the changes of k loads: the point splits, and its derivatives are one-sided. dR and dK phi are differences of forces
and tangents at the state that is known; central ones are exact to 1e-5 for numbers that enter smoothly.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np
from petsc4py import PETSc

from ..continuation.bordered import BorderedSolver, pivots
from ..continuation.state import CriticalPoint, State
from ..continuation.tracer import Tracer, tracer_of
from ..discrete.discretisation import Discretisation
from ..discrete.free_motions import usual_stiffness
from ..events.determinant import orthonormal
from ..model.scene import Scene
from .koiter import Energy

STEP = 1e-6  # of a number, of its differences: slender parts are strained by a change of their places
IMPERFECT = 1e-5  # push along a mode over the root of the work across it times the mode's change of stiffness


class NoDerivative(ValueError):
    """A number makes a bifurcation's structure imperfect, whose load falls by a power below one."""


@dataclass(frozen=True)
class _Changed:
    """What a changed structure has at the state, this process's parts.

    Attributes
    ----------
    residual, load : forces out of balance, and loads of a load factor of 1
    images : of modes by the tangent
    unit : total load for a factor of 1
    """

    residual: np.ndarray
    load: np.ndarray
    images: list[np.ndarray]
    unit: float


class LoadGradient:
    """Derivatives of the load of a critical point, at whose state the tangent is factored once.

    Parameters
    ----------
    path : Path or Tracer, which stays at its present state
    point, state : the critical point and its state
    modes : null vectors there

    Raises
    ------
    ValueError
        Where the formulas do not hold: laws with history, forces without a potential, at bifurcations contact.
    """

    def __init__(self, path, point: CriticalPoint, state: State, modes: Sequence[np.ndarray]):
        self._tracer: Tracer = tracer_of(path)
        self.point, self._state, self._system = point, state, self._tracer.system
        self._require()
        self._modes = orthonormal(self._system.weights, [self._system.create_vector(mode) for mode in modes])
        present = self._tracer.state
        try:
            self._prepare()
        finally:
            self._tracer.back_to(present)

    def _require(self) -> None:
        system, said = self._system, f"gradient: {self.point.title} at load {self.point.load:.6g}"
        if self.point.kind not in ("limit", "bifurcation") or self.point.spread:
            raise ValueError(f"{said} is no single point where the tangent is singular; give a limit point or a "
                             "bifurcation")
        if not isinstance(self._tracer.discretisation, Discretisation):
            raise ValueError(f"{said}: a plain form has no scene to change; compare whole paths")
        if any(contribution.remembers for contribution in system.contributions):
            raise ValueError(f"{said}: what laws remember depends on the way; compare whole paths")
        if not system.conservative:
            raise ValueError(f"{said}: forces have no potential, so that the tangent is not symmetric; compare whole "
                             "paths")
        if not (system.smooth or self.point.kind == "limit"):
            raise ValueError(f"{said}: with contact there are gradients of limit points only; compare whole paths")

    def _prepare(self) -> None:
        """The tangent's border, and at bifurcations the third variations along modes and path."""
        tracer, system = self._tracer, self._system
        tracer.back_to(self._state)
        self._load = tracer.load_vector()
        self._unit = self._unit_of(cast(Discretisation, tracer.discretisation))
        system.extrapolate_stress()
        system.tangent()
        weighted = [system.weights * mode for mode in self._modes]
        self._bordered = BorderedSolver(tracer.stepper.linear, pivots(self._modes, system.weights),
                                        usual_stiffness(tracer.discretisation))
        self._bordered.border(weighted, weighted)
        if self.point.kind == "limit":
            return
        energy, self._along = Energy(system), self._across(self._load)
        self._turning = energy.third(self._modes, self._along, 1.0)
        self._bent = [energy.third(self._modes, mode) for mode in self._modes]
        energy.leave()

    def _across(self, right: PETSc.Vec) -> PETSc.Vec:
        """Solution off the modes."""
        (solution,), _ = self._bordered.solve([right], np.zeros((1, len(self._modes))))
        return solution

    def derivative(self, scene: Callable[[float], Scene], at: float, step: float | None = None) -> float | np.ndarray:
        """Derivative of the total load by a number.

        Parameters
        ----------
        scene : function from the number to the scene, of which only values change and nodes move
        at : the number as it is
        step : of differences; None: a millionth of the number

        Returns
        -------
        Of several modes in ascending order as many, one for each load that the point splits into as the number grows.

        Raises
        ------
        ValueError
            If the number changes the unknowns.
        NoDerivative
            If the number makes the structure imperfect.
        """
        step = step or STEP * abs(at)
        if not step:
            raise ValueError("gradient: at is 0, which tells no size of a step; give step")
        ahead, behind = (self._changed(scene(at + sign * step)) for sign in (1, -1))
        vector, unit = self._system.create_vector, (ahead.unit - behind.unit) / (2 * step)
        forces = vector((ahead.residual - behind.residual) / (2 * step))
        if self.point.kind == "limit":
            mode = self._modes[0]
            return self._unit * mode.dot(forces) / mode.dot(self._load) + self._state.factor * unit
        images = [vector((a - b) / (2 * step)) for a, b in zip(ahead.images, behind.images, strict=True)]
        found = self._of_bifurcation(forces, images, vector((ahead.load - behind.load) / (2 * step)))
        return self._unit * found + self._state.factor * unit

    def _of_bifurcation(self, forces: PETSc.Vec, images: list[PETSc.Vec], loads: PETSc.Vec) -> float | np.ndarray:
        """Derivatives of the load factor."""
        moved = self._across(-1.0 * forces)
        along = np.array([[mode.dot(turning) for mode in self._modes] for turning in self._turning])
        pushed = max(abs(mode.dot(forces)) for mode in self._modes)
        if pushed > IMPERFECT * (abs(moved.dot(forces)) * np.abs(np.diag(along)).max()) ** 0.5:
            raise NoDerivative(f"gradient: the number makes the structure imperfect, so that {self.point.title} at "
                               f"load {self.point.load:.6g} has no derivative; see imperfection_sensitivity")
        changed = np.array([[mode.dot(image) + bent.dot(moved) for mode, bent in zip(self._modes, row, strict=True)]
                            for image, row in zip(images, self._bent, strict=True)])
        if len(self._modes) > 1:
            return np.sort(np.linalg.eigvals(np.linalg.solve(along, -(changed + changed.T) / 2)).real)
        mode, turning, bent = self._modes[0], self._turning[0], self._bent[0][0]
        matrix = [[along[0, 0], mode.dot(bent)], [-self._along.dot(turning), -self._along.dot(bent)]]
        right = [-changed[0, 0], self._along.dot(images[0]) + turning.dot(moved) - mode.dot(loads)]
        return float(np.linalg.solve(matrix, right)[0])

    def _changed(self, scene: Scene) -> _Changed:
        discretisation = changed_structure("gradient", scene, self._state.fields)
        system = discretisation.system
        residual, load = system.create_vector(), system.create_vector()
        system.configure(system.create_vector(), self._state.factor)
        system.residual(residual)
        system.load(load)
        images = []
        if self.point.kind == "bifurcation":
            system.extrapolate_stress()
            matrix = system.tangent()
            for mode in self._modes:
                image = system.create_vector(mode.array)
                matrix.mult(system.create_vector(mode.array), image)
                images.append(image.array.copy())
        return _Changed(residual.array.copy(), load.array.copy(), images, self._unit_of(discretisation))

    def _unit_of(self, discretisation: Discretisation) -> float:
        unit = discretisation.load_of_unit()
        if unit is None:
            raise ValueError("gradient: the load is a reaction to what is prescribed; give the load as forces")
        return unit


def changed_structure(said: str, scene: Scene, fields: Mapping[str, np.ndarray]) -> Discretisation:
    """A structure that a number has changed, at the fields of a state of the one before.

    Raises
    ------
    ValueError
        If it has other unknowns.
    """
    changed = Discretisation(scene)
    known = changed.system.snapshot()
    if {name: values.shape for name, values in known.items()} != {name: v.shape for name, v in fields.items()}:
        raise ValueError(f"{said}: the number changes the unknowns of the structure; give one that changes values and "
                         "places only")
    changed.system.restore(dict(fields))
    return changed
