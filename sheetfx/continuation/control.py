"""Controls: the equation that is added to equilibrium, one for each way to follow a path.

Each control gives the predictor's load increment and, for a bordered system solved with one
factor, the load correction that keeps the added equation true.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import copysign, pi, sqrt
from typing import Annotated, Any, ClassVar

from petsc4py import PETSc

from ..checks import Choice, Like, Unbounded
from ..discrete.functional import Functional
from .options import Options
from .state import State

SIGNS: dict[str, Callable[[State], Any]] = {
    "projection": lambda state: state.load_rate,
    "determinant": lambda state: state.determinant_sign,
    "current stiffness": lambda state: state.current_stiffness,
    "current stiffness with displacement extremes":
        lambda state: (-1.0) ** state.displacement_extremes * state.current_stiffness,
}
ACROSS = 0.1  # cosine of the angle of load responses with the step, below which the load goes on as it did


@dataclass(frozen=True)
class StepRule(Options):
    """How steps are taken, whatever they are measured in.

    Attributes
    ----------
    default : of the class, the first step where none is given
    passes_limits : of the class, whether a step can go through an extremum of the load
    """

    @property
    def first(self) -> float:
        """Length of the first step."""
        return self.default if self.step is None else self.step

    @property
    def iterations_allowed(self) -> int:
        """Iterations after which a step is cut."""
        return self.most_iterations or (20 if self.newton == "full" else 100)

    def usual(self, size: float) -> float:
        """Length of the first step for a structure of a size, where nothing asks for a shorter one."""
        return self.first

    @property
    def longest(self) -> float:
        """Longest step, as a multiple of the usual first one."""
        return self.largest

    def growth(self, iterations: int) -> float:
        """Factor on the next step's length after a step of so many iterations."""
        return min(2.0, max(0.5, sqrt(self.iterations / max(iterations, 1))))

    default: ClassVar[float]
    passes_limits = True

    @property
    def guarded(self) -> bool:
        """Whether steps that leave the smooth path are noticed and cut."""
        return self.turn < pi

    def predict(self, length: float, sign: float, tangent) -> float:
        """Increment of the load factor with which a step along the tangent has a length."""
        raise NotImplementedError

    def measure(self, tangent, increment, load_increment: float) -> float:
        """Length of a step with these increments of the unknowns and of the load factor."""
        raise NotImplementedError

    def gradient(self, tangent, increment, load_increment: float) -> tuple[PETSc.Vec | None, float]:
        """Derivatives of the control's equation by the unknowns (None: zero) and by the load factor, up to a factor."""
        raise NotImplementedError

    def correct(self, length: float, tangent, increment, load_increment: float, residual_part) -> tuple[float, float]:
        """Change of the load increment in an iteration, and the part of the residual's correction that goes with it."""
        raise NotImplementedError

    def clip(self, length: float, factor: float) -> float:
        """Shorten a step that would pass the control's end."""
        return length

    def direction(self, state: State) -> float:
        """Sign of the predictor's load increment."""
        return 1.0

    def facing(self, state: State) -> State:
        """A state that a path starts from, with its tangent in the sense in which it goes on."""
        return state


@dataclass(frozen=True)
class LoadControl(StepRule):
    """Prescribed increments of the load factor up or down to `target`; fails at the first limit point.

    `fixed` keeps all steps as long as the first, but after one that had to be cut, and takes them without looking for
    other paths in between.
    """

    target: Unbounded = 1.0
    fixed: bool = False
    default = 0.1
    passes_limits = False

    @property
    def guarded(self):
        return super().guarded and not self.fixed

    @property
    def longest(self):
        return 1.0 if self.fixed else super().longest

    def growth(self, iterations):
        return 2.0 if self.fixed else super().growth(iterations)

    def clip(self, length, factor):
        return min(length, abs(self.target - factor))

    def direction(self, state):
        return copysign(1.0, self.target - state.factor)

    def facing(self, state):
        return replace(state, load_rate=copysign(state.load_rate, self.target - state.factor))

    def measure(self, tangent, increment, load_increment):
        return abs(load_increment)

    def predict(self, length, sign, tangent):
        return sign * length

    def gradient(self, tangent, increment, load_increment):
        return None, 1.0

    def correct(self, length, tangent, increment, load_increment, residual_part):
        return copysign(length, load_increment) - load_increment, 1.0


@dataclass(frozen=True)
class TwoWayRule(StepRule):
    """Steps on which the load may rise or fall; a sign rule says which.

    Attributes
    ----------
    sign : of the predictor's load increment, as in section 4.4.2 of the thesis: that of the "projection" of the
        tangent on the increment before (4.33); of the "determinant" of the tangent stiffness (4.30), which turns
        back where bifurcations change it; of the "current stiffness" parameter (Bergan 1980; 4.31), which turns
        back where the displacement has an extreme; or "current stiffness with displacement extremes", which counts
        these (4.32)
    """

    sign: Annotated[str, Choice(tuple(SIGNS))] = "projection"

    def direction(self, state):
        if self.sign == "determinant" and state.determinant_sign is None:
            raise ValueError(f"{type(self).__name__}: sign 'determinant' needs a factor by MUMPS, which tells it; "
                             "choose 'projection'")
        return copysign(1.0, SIGNS[self.sign](state))


MONITORS = Like("a Monitor", lambda monitor: monitor is None or hasattr(monitor, "component"))


@dataclass(frozen=True)
class DisplacementControl(TwoWayRule):
    """Prescribed increments of a displacement; fails where it turns back.

    Attributes
    ----------
    monitor : scene.Monitor, the displacement that is controlled; None: the one that the scene monitors
    default : of the class, over the size of the structure
    """

    monitor: Annotated[object, MONITORS] = None
    default = 0.01

    def usual(self, size):
        return self.first if self.step is not None else self.default * size

    def measure(self, tangent, increment, load_increment):
        return abs(tangent.functional.of(increment))

    def predict(self, length, sign, tangent):
        rate = abs(tangent.functional.rate(tangent.solution))
        if not rate:
            raise ValueError("DisplacementControl: the controlled displacement does not respond to the load; give the "
                             "control a `monitor` that does")
        return sign * length / rate

    def gradient(self, tangent, increment, load_increment):
        return tangent.functional.vector, 0.0

    def correct(self, length, tangent, increment, load_increment, residual_part):
        functional, made = tangent.functional, tangent.functional.of(increment)
        missing = copysign(length, made) - made - functional.rate(residual_part)
        return missing / functional.rate(tangent.solution), 1.0


@dataclass(frozen=True)
class ArcLength(TwoWayRule):
    """Prescribed length of the step in displacements and load (Crisfield 1981).

    |dx|^2 + psi^2 dlambda^2 = s^2 in the scaled inner product, with psi = 0 (cylindrical),
    psi^2 = |x_P|^2 (spherical) or psi^2 = S_p |x_P|^2 (elliptical), where x_P is the
    displacement by the unit load at the start of the path and S_p the current stiffness
    parameter (Bergan 1980; thesis section 4.4.1, with the reference displacement instead of the
    reference load so that both terms have one unit).

    Where the quadratic has no real root, only that part of the equilibrium correction is used
    for which it has one. Of two roots the one that leads on is taken; where the response to the load
    is at a right angle to the step, as where something meets an obstacle, the one with which the load
    goes on.

    Attributes
    ----------
    shape : "cylindrical", "spherical" or "elliptical"
    """

    shape: Annotated[str, Choice(("cylindrical", "spherical", "elliptical"))] = "cylindrical"
    default = 0.01

    def load_weight(self, tangent) -> float:
        """psi^2."""
        if self.shape == "cylindrical":
            return tangent.least_weight
        stiffness = abs(tangent.current_stiffness) if self.shape == "elliptical" else 1.0
        return stiffness * tangent.initial_norm2

    def measure(self, tangent, increment, load_increment):
        return sqrt(tangent.inner(increment, increment) + self.load_weight(tangent) * load_increment**2)

    def predict(self, length, sign, tangent):
        return sign * length / sqrt(tangent.norm2 + self.load_weight(tangent))

    def gradient(self, tangent, increment, load_increment):
        along = increment.duplicate()
        along.pointwiseMult(tangent.weights, increment)
        return along, self.load_weight(tangent) * load_increment

    def correct(self, length, tangent, increment, load_increment, residual_part):
        weight = self.load_weight(tangent)
        inner = tangent.inner
        a = inner(tangent.solution, tangent.solution) + weight
        xx, xr, rr = (inner(increment, increment), inner(increment, residual_part),
                      inner(residual_part, residual_part))
        xf, rf = inner(increment, tangent.solution), inner(residual_part, tangent.solution)
        base = xx + weight * load_increment**2 - length**2

        def coefficients(part):
            return xf + part * rf + weight * load_increment, base + 2 * part * xr + part**2 * rr

        part = 1.0
        b, c = coefficients(part)
        if b * b < a * c:
            part = _largest_part(rf**2 - a * rr, (xf + weight * load_increment) * rf - a * xr,
                                 (xf + weight * load_increment) ** 2 - a * base)
            b, c = coefficients(part)
        root = sqrt(max(b * b - a * c, 0.0))
        candidates = ((-b + root) / a, (-b - root) / a)
        along = xf + weight * load_increment
        if along**2 < ACROSS**2 * a * (xx + weight * load_increment**2):
            along = load_increment
        return max(candidates, key=lambda change: change * along), part


def weight_where_nothing_moves() -> float:
    """Weight of the load, psi^2, with which the first step by arc length is load control's."""
    return (ArcLength.default / LoadControl.default) ** 2


def _largest_part(a: float, b: float, c: float) -> float:
    """Largest part in [0, 1] with a part^2 + 2 b part + c >= 0, where c is not negative."""
    c = max(c, 0.0)
    root = sqrt(max(b * b - a * c, 0.0))
    roots = [(-b + root) / a, (-b - root) / a] if a else [-c / (2 * b)] if b else []
    inside = [r for r in roots if 0 <= r <= 1]
    return max(inside, default=0.0)


@dataclass
class LoadResponse:
    """Response of a state to a unit of load, and the measures of the controls.

    Attributes
    ----------
    solution : displacement by a unit of load with the current factor
    weights : diagonal of the inner product
    functional : the controlled displacement
    initial_norm2 : squared norm of the first state's solution
    least_weight : of the load in lengths, psi^2, where the first state does not move
    current_stiffness : Bergan's current stiffness parameter
    """

    solution: PETSc.Vec
    weights: PETSc.Vec
    functional: Functional
    initial_norm2: float = 1.0
    least_weight: float = 0.0
    current_stiffness: float = 1.0

    def __post_init__(self):
        self._work = self.weights.duplicate()

    def inner(self, a: PETSc.Vec, b: PETSc.Vec) -> float:
        self._work.pointwiseMult(self.weights, a)
        return self._work.dot(b)

    @property
    def norm2(self) -> float:
        return self.inner(self.solution, self.solution)
