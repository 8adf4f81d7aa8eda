"""A piece of path between two converged states, searched by repeating the step with other lengths."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from math import inf

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from ..rounding import NONE, SAFETY, off_path, root
from .dense_output import DenseOutput
from .state import State

IN_BALANCE = 1e-6  # residual over the load of an interpolated state
STATIONARY = 6  # interpolations of the load, after which a stationary one is looked for without them
WITHIN = 0.5  # of the iterations of a step, those after which a shorter one within it is given up
CORNERED = 0.6  # the same with contact: the path may bend by a right angle between them


class Jump(ArithmeticError):
    """The states of a step do not lie on one smooth piece of path: the step is too long or has left its branch.

    Attributes
    ----------
    sound : a state within the step up to which they do; None: none is known
    """

    def __init__(self, reason: str, sound: State | None = None):
        super().__init__(reason)
        self.sound = sound


class Missed(ArithmeticError):
    """A step of a shorter length does not converge."""


class Segment:
    """The piece of path from a state to another one, searched by repeating the step with other lengths.

    It is guarded against states off the path where the control is, but for problems that are not smooth,
    with whose contacts tangents waver as soon as something touches.

    Attributes
    ----------
    nonsmooth : whether tangents waver
    flows : whether points that begin or cease to flow alone make them do so
    states : those that are known, by their lengths
    looked : pieces whose eigenvalues have been looked at
    clear : whether pieces have been found to lie on the curve that their ends make
    eigenvalues : nearest to zero, and their rates along the path, by lengths of states
    """

    def __init__(self, tracer, before: State, after: State):
        self.tracer, self.before, self.after = tracer, before, after
        self.nonsmooth = not (tracer.system.smooth or (before.apart and after.apart))
        self.guarded = tracer.control.guarded and not self.nonsmooth
        self.flows = self.nonsmooth and not tracer.system.rough
        self.states = {0.0: before, after.length: after}
        self.dense = DenseOutput(tracer, before, after)
        self._spectra: dict[float, tuple[list[float], list]] = {}
        self._missed: set[float] = set()
        self.looked: set[tuple[float, float]] = set()
        self.clear: dict[tuple[float, float], bool] = {}
        self.eigenvalues: dict[float, list[tuple[float, float]]] = {}
        last, found = tracer.softest
        if last is not None and last.response is before.response and last.load_rate == before.load_rate:
            self.eigenvalues[0.0] = found

    def __getitem__(self, length: float) -> State:
        """State at a length of the step.

        Raises
        ------
        Jump, Missed
        """
        return self._found(length)

    def _found(self, length: float, only_guessed: bool = False) -> State:
        if length in self._missed:
            raise Missed
        if length not in self.states:
            left, right = self.neighbours(length)
            guess = self.interpolated(left, right, length)
            guesses = not self.nonsmooth or (self.flows and only_guessed)
            start = self.dense.at(length, self.states) if guesses else None
            self.tracer.back_to(self.before)
            state = start and self.tracer.attempt(length, start)
            if state is None and not only_guessed:
                state = self.tracer.attempt(length, part=1.0 if self.nonsmooth else WITHIN)
            if state is None or (self.nonsmooth and self._strays(state, guess, left, right)):
                self._missed.add(length)
                raise Missed
            if self.guarded and self.clear.get((left, right), True):
                near = self._is_near(state, guess, self.distance(left, right))
                if near and (left, right) in self.clear:
                    self.clear |= {(left, length): True, (length, right): True}
            self.states[length] = state
        return self.states[length]

    def _is_near(self, state: State, guess: tuple[float, np.ndarray], distance: float) -> bool:
        """Whether a state is off the cubic of its piece by no more than the defect that is allowed.

        Raises
        ------
        Jump
            If it is off by SAFETY times that, and this is no rounding.
        """
        off, small = self._off(state, guess), self.tracer.control.defect * distance
        if off > SAFETY * small and off > off_path(self.tracer, state):
            raise Jump("a state within the step is off the curve that is known")
        return off <= small

    def reach(self, length: float, only_guessed: bool = False) -> bool:
        """Have the state at a length, if it converges, also from the start of the step unless it is `only_guessed`."""
        try:
            self._found(length, only_guessed)
        except Missed:
            return False
        return True

    def on_path(self, length: float) -> State:
        """State at a length by interpolation between the nearest ones, without equilibrium being sought.

        At a critical point rounding would decide where it is found. Where the interpolation is not in equilibrium, as
        with contact, it is sought nevertheless; the tracer ends at the state.

        Raises
        ------
        Jump, Missed
        """
        if self.nonsmooth or length in self.states:
            return self[length]
        load, x = self.dense.at(length, self.states)
        self.tracer.back_to(self.before)
        state = self.tracer.adopt(x, load, IN_BALANCE)
        if state is None:
            return self[length]
        self.states[length] = state
        return state

    def seen(self, length: float) -> tuple[float, float]:
        """Load and deflection where states and their tangents lead, without equilibrium being sought.

        The tracer ends where the step starts.
        """
        factor, x = self.dense.at(length, self.states)
        tracer, system, increment = self.tracer, self.tracer.system, self.tracer.system.create_vector(x)
        system.configure(increment, self.before.factor + factor)
        load, deflection = tracer.discretisation.total_load(), self.before.deflection + tracer.monitored(increment)
        tracer.back_to(self.before)
        return load, deflection

    def neighbours(self, length: float) -> tuple[float, float]:
        """Lengths of the nearest states on both sides."""
        return max(s for s in self.states if s < length), min(s for s in self.states if s > length)

    def pairs(self) -> list[tuple[float, float]]:
        """Lengths of neighbouring states."""
        lengths = sorted(self.states)
        return list(zip(lengths[:-1], lengths[1:], strict=True))

    def _increments(self, length: float) -> tuple[float, np.ndarray]:
        """Of load factor and unknowns since the step began."""
        state = self.states[length]
        return (0.0, np.zeros_like(state.increment)) if state is self.before else state.direction

    def interpolated(self, left: float, right: float, length: float) -> tuple[float, np.ndarray]:
        """Increments at a length by Hermite's cubic with the tangents of two states, as fast as their distance asks.

        Where tangents waver, on the chord.
        """
        if self.nonsmooth:
            (load, x), part = self.chord(left, right), (length - left) / (right - left)
            start_load, start_x = self._increments(left)
            return start_load + part * load, start_x + part * x
        found = self.curve(left, right)(length)
        return float(found[-1]), found[:-1]

    def curve(self, left: float, right: float) -> CubicHermiteSpline:
        """Increments between two lengths, the load factor's last, by their tangents."""
        pace = self.distance(left, right) / (right - left)
        values, slopes = ([np.append(x, load) for load, x in vectors] for vectors in (
            map(self._increments, (left, right)), map(self._tangent, (left, right))))
        return CubicHermiteSpline((left, right), values, pace * np.array(slopes))

    def _tangent(self, length: float) -> tuple[float, np.ndarray]:
        load, x = self.dense.tangent(length, self.states[length])
        size = self.tracer.distance(load, x)
        return load / size, x / size

    def distance(self, left: float, right: float) -> float:
        return self.tracer.distance(*self.chord(left, right))

    def chord(self, left: float, right: float) -> tuple[float, np.ndarray]:
        """Increments of load factor and unknowns between two lengths."""
        (a, x), (b, y) = self._increments(left), self._increments(right)
        return b - a, y - x

    def along(self, mode: np.ndarray, left: float, right: float) -> tuple[float, float]:
        """Component along a mode of a piece, and of what its tangents make of it."""
        def component(increment):
            return self.tracer.inner((0.0, mode), (0.0, increment))

        rates = [component(self._tangent(s)[1]) for s in (left, right)]
        return component(self.chord(left, right)[1]), self.distance(left, right) * sum(rates) / 2

    def _strays(self, state: State, guess: tuple[float, np.ndarray], left: float, right: float) -> bool:
        """Whether a state is further from the chord between its neighbours than a corner between them asks.

        Contact elsewhere changes the load more than the displacements.
        """
        most, rates = CORNERED * self.distance(left, right), [abs(self.states[s].load_rate) for s in (left, right)]
        if not self.flows and abs(state.load_increment - guess[0]) > most * max(rates):
            return True
        return self._off(state, guess) > most

    def _off(self, state: State, guess: tuple[float, np.ndarray]) -> float:
        """Distance of a state from where it was expected."""
        return self.tracer.distance(state.load_increment - guess[0], state.increment - guess[1])

    def forget(self, length: float, near: float) -> None:
        """Drop the states within a distance of a length, but for the ends: rounding decides where they lie."""
        ends = (0.0, self.after.length)
        self.states = {s: state for s, state in self.states.items() if s in ends or abs(s - length) > near}

    def spectrum(self, length: float, count: int, tolerance: float = 1e-12) -> tuple[list[float], list]:
        """Eigenvalues of the tangent nearest to zero, and modes, at a length; those that are known already serve."""
        found = self._spectra.get(length)
        if found is None or len(found[0]) < count:
            self.tracer.factorise_at(self[length])
            found = self._spectra[length] = self.tracer.spectrum(count, tolerance)
        return found

    def close_in(self, function: Callable[[float], float], left: float, right: float, exact: float) -> None:
        """Have states that close in on the root of a function of the length between two others.

        Parameters
        ----------
        exact : relative error of the load at which to stop

        Raises
        ------
        Missed
        """
        known = {}

        def stopped(length):
            value = known[length] = function(length)
            slopes = [abs((known[s] - value) / (s - length)) for s in known if s not in (length, left, right)]
            slope = max(slopes, default=0.0)
            state = self.states[length]
            return 0.0 if slope and self.load_change(state, value / slope) < exact * self._size(state) else value

        root(stopped, left, right)

    def stationary(self, left: float, right: float, exact: float) -> float:
        """Length of a state between two others, whose load rates have other signs, at which the load is stationary.

        Parameters
        ----------
        exact : relative error of the load at which to stop

        Raises
        ------
        Missed
            If states between them do not converge.
        """
        def rate(length):
            return self[length].load_rate

        ends, last = (left, right), inf
        for _ in range(STATIONARY):
            inside = [s for s in sorted(self.states) if left <= s <= right]
            left, right = next(pair for pair in pairwise(inside) if rate(pair[0]) * rate(pair[1]) <= 0)
            length = self.dense.turning(left, right, self.states)
            if length is None:
                break
            nearest = min((left, right), key=lambda s: abs(s - length))
            change = self.load_change(self[nearest], length - nearest) / self._size(self[nearest])
            if nearest not in ends and (change <= exact or last / 4 < change < NONE):
                return nearest
            last = change
            if not self.reach(length):
                break
        self.close_in(rate, left, right, exact)
        return min((s for s in self.states if left <= s <= right), key=lambda s: abs(rate(s)))

    def _size(self, state: State) -> float:
        """Load factor that errors of a state's are compared with."""
        return max(abs(state.factor), abs(self.after.load_increment))

    def load_change(self, state: State, length: float) -> float:
        """Change of the load factor within a small length, to the second order where the load is stationary."""
        rate = self.distance(0.0, self.after.length) / self.after.length * length
        bend = abs(self.after.load_rate - self.before.load_rate) / self.distance(0.0, self.after.length)
        return abs(state.load_rate * rate) + bend * rate**2
