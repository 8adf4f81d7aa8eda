"""Critical loads of imperfect structures by the energy of a few modes about a critical point (Koiter 1945).

With amplitudes a of modes phi, a change d of the load factor and coefficients c of imperfections, the state is

    x = a_i phi_i + a_i a_j w_ij + d y + c_m z_m,

where w, y and z make the energy stationary off the modes. The rest is equilibrium along these, the
`AmplitudeEquations`, whose paths take milliseconds. Third variations are differences of the Hessian, the quartic form
is fitted to its values along many directions. Far from the critical point the energy has further terms. The forces
along the null vector that equilibrium lacks at the state found tell by how much the load is off, to the first order.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import combinations_with_replacement
from math import factorial

import numpy as np
from petsc4py import PETSc

from .. import rounding
from ..continuation.bordered import BorderedSolver, pivots
from ..continuation.control import ArcLength
from ..continuation.linear import SingularTangent
from ..continuation.state import State
from ..continuation.tracer import Tracer, tracer_of
from ..discrete.discretisation import Discretisation
from ..discrete.free_motions import usual_stiffness
from ..events.determinant import orthonormal
from ..model.scene import Scene
from .amplitude_equations import AmplitudeEquations, StableEnd
from .bifurcation_gradient import NoDerivative
from .changed import changed_structure
from .defining import DefiningSystem, combined, without_third_variations
from .koiter import Energy, quartic
from .worst import NONE, ImperfectLoad, LoadsByShape

SECANT = 0.1  # of the critical load factor, difference that tells how the push of imperfections goes with it
ITERATIONS = 12  # of corrections off the modes
SETTLED = 0.01  # of an error, its last change
PUSHED = 1e-6  # of the load's share along the modes, that along the null vector at a bifurcation


class ReducedEnergy(LoadsByShape):
    """Critical loads by the energy of a few modes about the first critical point of the perfect structure.

    Parameters
    ----------
    path : Path or Tracer of the perfect structure, which stays at its present state
    state : of its first critical point
    modes : as `softest_modes` gives them, this process's part
    scene : function from coefficients to the imperfect structure, such as `Imperfections.scene`
    count : number of coefficients
    size : of imperfections, for differences by coefficients

    Raises
    ------
    ValueError
        With contact, history or forces without a potential.
    """

    def __init__(self, path, state: State, modes: Sequence[np.ndarray], scene: Callable[[Sequence[float]], Scene],
                 count: int, size: float):
        self._tracer, self._state, self._scene, self.count = tracer_of(path), state, scene, count
        system = self._tracer.system
        if why := without_third_variations(system):
            raise ValueError(f"ReducedEnergy: the structure has {why}, and its load is no value of an energy alone; "
                             "follow paths, by Imperfections")
        unit = self._tracer.discretisation.load_of_unit()
        if unit is None:
            raise ValueError("ReducedEnergy: the load is a reaction to what is prescribed; give the load as forces")
        self._unit = unit
        self._modes = orthonormal(system.weights, [system.create_vector(mode) for mode in modes])
        present = self._tracer.state
        try:
            self._expand(size)
        finally:
            self._tracer.back_to(present)

    def _expand(self, size: float) -> None:
        tracer, system, modes = self._tracer, self._tracer.system, self._modes
        images = self._factorise()
        load, energy = tracer.load_vector(), Energy(system)
        self._response, thirds = self._across(load), [energy.third(modes, mode) for mode in modes]
        cubic = np.array([_table(modes, row) for row in thirds])
        self._bends = [[self._across(-0.5 * one) for one in row] for row in thirds]
        softening = _table(modes, energy.third(modes, self._response, 1.0))
        fourth = _fitted(len(modes), lambda way: quartic(energy, combined(modes, way), self._bend(way))[0])
        energy.leave()
        found = [self._push(n, size) for n in range(self.count)]
        self._responses = [one[0] for one in found]
        self.equations = AmplitudeEquations(
            self._state.factor, _table(modes, images), np.array([mode.dot(load) for mode in modes]), softening,
            sum(cubic.transpose(order) for order in ((0, 1, 2), (1, 2, 0), (2, 0, 1))) / 3, fourth,
            *(np.array([one[n] for one in found]) for n in (1, 2, 3)))

    def _factorise(self) -> list[PETSc.Vec]:
        """Factor the tangent at the critical point, bordered with the modes; its products with these."""
        tracer, system, modes = self._tracer, self._tracer.system, self._modes
        tracer.back_to(self._state)
        system.extrapolate_stress()
        system.tangent()
        images = [self._product(mode) for mode in modes]
        weighted = [system.weights * mode for mode in modes]
        self._bordered = BorderedSolver(tracer.stepper.linear, pivots(modes, system.weights),
                                        usual_stiffness(tracer.discretisation))
        self._bordered.border(weighted, weighted)
        return images

    def _push(self, number: int, step: float) -> tuple[PETSc.Vec, np.ndarray, np.ndarray, np.ndarray]:
        """Of one imperfection: response off the modes, forces along them, their change with the load, and stiffness."""
        coefficients = step * np.eye(self.count)[number]
        pair = [changed_structure("ReducedEnergy", self._scene(sign * coefficients), self._state.fields)
                for sign in (1.0, -1.0)]
        system, zero = self._tracer.system, self._tracer.system.create_vector()
        factor = self._state.factor
        forces, _ = self._difference(pair, zero, zero, factor, 2 * step)
        response = self._across(-1.0 * forces)
        part = -SECANT * factor
        lower, _ = self._difference(pair, part * self._response, step * response, factor + part, 2 * step)
        here, images = self._difference(pair, zero, step * response, factor, 2 * step, self._modes)
        along = [np.array([mode.dot(one) for mode in self._modes]) for one in (here, lower)]
        changes = _table(self._modes, [system.create_vector(image) for image in images])
        return response, along[0], (along[1] - along[0]) / part, (changes + changes.T) / 2

    def _difference(self, pair: Sequence[Discretisation], about: PETSc.Vec, way: PETSc.Vec, factor: float, size: float,
                    modes: Sequence[PETSc.Vec] = ()) -> tuple[PETSc.Vec, list[np.ndarray]]:
        """Of forces out of balance and of the tangent's products with modes, over a size."""
        forces, images = [], []
        for problem, sign in zip(pair, (1.0, -1.0), strict=True):
            system = problem.system
            with system.additive_increments():
                residual = system.create_vector()
                system.configure(system.create_vector((about + sign * way).array), factor)
                system.residual(residual)
                forces.append(residual.array.copy())
                if modes:
                    system.extrapolate_stress()
                    matrix, products = system.tangent(), [residual.duplicate() for _ in modes]
                    for mode, product in zip(modes, products, strict=True):
                        matrix.mult(system.create_vector(mode.array), product)
                    images.append([product.array.copy() for product in products])
        found = self._tracer.system.create_vector((forces[0] - forces[1]) / size)
        return found, [(one - other) / size for one, other in zip(*images, strict=True)] if modes else []

    def _product(self, mode: PETSc.Vec) -> PETSc.Vec:
        found = mode.duplicate()
        self._tracer.stepper.linear.matrix.mult(mode, found)
        return found

    def _across(self, right: PETSc.Vec) -> PETSc.Vec:
        """Solution off the modes, from which rounding of stiff parts is kept out."""
        weighted = [self._tracer.system.weights * mode for mode in self._modes]
        held = right - combined(weighted, [mode.dot(right) for mode in self._modes])
        (solution,), _ = self._bordered.solve([held], np.zeros((1, len(self._modes))))
        return solution - combined(self._modes, [one.dot(solution) for one in weighted])

    def _bend(self, amplitudes: np.ndarray) -> PETSc.Vec:
        """Change of the state in the second order, off the modes."""
        return combined([one for row in self._bends for one in row], np.outer(amplitudes, amplitudes).ravel())

    def at(self, coefficients: Sequence[float]) -> ImperfectLoad:
        if (end := self.equations.end(self._given(coefficients))) is None:
            return ImperfectLoad(tuple(map(float, coefficients)), np.inf, NONE)
        by_load = self.equations.by_load(end.amplitudes, end.coefficients)
        kind = "limit" if abs(end.null @ by_load) > PUSHED * np.linalg.norm(by_load) else "bifurcation"
        return ImperfectLoad(tuple(map(float, coefficients)), self._unit * (self._state.factor + end.change), kind)

    def gradient(self, coefficients: Sequence[float]) -> np.ndarray:
        end = self._ended(coefficients)
        by_load = self.equations.by_load(end.amplitudes, end.coefficients)
        if abs(end.null @ by_load) <= PUSHED * np.linalg.norm(by_load):
            raise NoDerivative("ReducedEnergy: a shape makes a bifurcation a limit point there; turn the imperfection")
        along = self.equations.by_shapes(end.amplitudes, end.change)
        return -self._unit * (along @ end.null) / (end.null @ by_load)

    def _given(self, coefficients: Sequence[float]) -> np.ndarray:
        c = np.asarray(coefficients, dtype=float)
        if c.shape != (self.count,):
            raise ValueError(f"ReducedEnergy: {c.size} coefficients for {self.count} shapes; give one each")
        return c

    def _ended(self, coefficients: Sequence[float]) -> StableEnd:
        if (end := self.equations.end(self._given(coefficients))) is None:
            raise ValueError("ReducedEnergy: with these coefficients the structure keeps its stability; take others")
        return end

    def error(self, coefficients: Sequence[float]) -> float:
        """By how much the load is too high, by what equilibrium of the imperfect structure lacks along the null vector.

        The state is corrected off the modes first, by Newton's method. Of the first order: where it is more than some
        per cent of the load, the reduced energy is out of its range; infinite where the corrections do not converge.
        """
        end = self._ended(coefficients)
        a, c, factor = end.amplitudes, end.coefficients, self._state.factor + end.change
        start = combined(self._modes, a) + self._bend(a) + end.change * self._response + combined(self._responses, c)
        problem = Discretisation(self._scene(c))
        system, linear = problem.system, Tracer(problem, ArcLength(), "sheetfx_").stepper.linear
        system.restore(dict(self._state.fields))
        x, *modes = (system.create_vector(one.array) for one in (start, *self._modes))
        defining = DefiningSystem(problem, linear, modes, len(modes), None)
        null, residual, found = combined(modes, end.null), system.create_vector(), np.inf
        with system.additive_increments():
            for _ in range(ITERATIONS):
                system.configure(x, factor)
                system.residual(residual)
                before, found = found, self._unit * null.dot(residual) / (end.null @ self.equations.by_load(a, c))
                if abs(found - before) <= SETTLED * (abs(found) + rounding.NONE * abs(self._unit * factor)):
                    return float(found)
                system.extrapolate_stress()
                try:
                    defining.factorise()
                    x += defining.off_modes(x, factor)
                except (SingularTangent, np.linalg.LinAlgError):
                    break
        return np.inf


def _table(modes: Sequence[PETSc.Vec], images: Sequence[PETSc.Vec]) -> np.ndarray:
    return np.array([[mode.dot(image) for image in images] for mode in modes])


def _fitted(count: int, value: Callable[[np.ndarray], float]) -> np.ndarray:
    """The symmetric tensor C of a form of fourth order, C_ijkl a_i a_j a_k a_l / 24, by its values along directions."""
    terms = list(combinations_with_replacement(range(count), 4))
    ways = np.random.default_rng(0).standard_normal((max(2 * len(terms), 1), count))
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    products = np.array([[np.prod(way[list(term)]) for term in terms] for way in ways])
    factors = np.linalg.lstsq(products, np.array([value(way) for way in ways]), rcond=None)[0]
    tensor = np.zeros((count,) * 4)
    for term, factor in zip(terms, factors, strict=True):
        alike = np.prod([factorial(term.count(n)) for n in set(term)])
        for place in {tuple(np.array(term)[list(order)]) for order in _ORDERS}:
            tensor[place] = alike * factor
    return tensor


_ORDERS = [order for order in np.ndindex(4, 4, 4, 4) if len(set(order)) == 4]
