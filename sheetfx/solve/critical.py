"""Critical points between two converged states: found by sign changes, pinpointed by repeating the step."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import copysign, pi

import numpy as np
from scipy.interpolate import CubicHermiteSpline, KroghInterpolator
from scipy.optimize import brentq, minimize_scalar

from ..state import CriticalPoint, State
from .koiter import postbuckling
from .spectrum import diagonal, nearest_to_zero

SAME = 1e-6  # relative difference of loads of one multiple point
TURNING = 0.4  # radians between chord and tangents of a piece of path, from which its middle is looked at
UNEXPLAINED = 0.25  # of the load by the steeper tangent, likewise
SHORTEST = 1 / 64  # of a step, piece that must be explained
NOISE = 1e-6  # of the length of a piece of path, motion along a mode that does not count
STRAY = 0.3  # of the distance between its neighbours, by which a state may miss their interpolation


class Jump(ArithmeticError):
    """The states of a step do not lie on one smooth piece of path: the step is too long or has left its branch."""


class _Missed(ArithmeticError):
    """A step of a shorter length does not converge."""


class Stretch:
    """The piece of path from a state to another one, searched by repeating the step with other lengths.

    It is guarded against states off the path unless the control allows steps to turn back, or contact wavers.
    """

    def __init__(self, tracer, before: State, after: State):
        self.tracer, self.before, self.after = tracer, before, after
        self.guarded = tracer.control.turn < pi and not tracer.discretisation.contacts
        self.states = {0.0: before, after.length: after}
        self._spectra: dict[float, tuple[list[float], list]] = {}

    def __getitem__(self, length: float) -> State:
        """State at a length of the step.

        Raises
        ------
        Jump, _Missed
        """
        if length not in self.states:
            left, right = self.neighbours(length)
            guess = self._interpolated(left, right, length)
            self.tracer.back_to(self.before)
            state = self.tracer.attempt(length, guess) or self.tracer.attempt(length)
            if state is None:
                raise _Missed
            if self.guarded:
                self._compare(state, guess, left, right)
            self.states[length] = state
        return self.states[length]

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

    def _interpolated(self, left: float, right: float, length: float) -> tuple[float, np.ndarray]:
        """Increments at a length by Hermite's cubic with the tangents of two states, as fast as their distance asks."""
        rate = self.distance(left, right) / (right - left)
        values, slopes = ([np.append(x, load) for load, x in vectors] for vectors in (
            map(self._increments, (left, right)), (self.states[s].tangent for s in (left, right))))
        found = CubicHermiteSpline((left, right), values, rate * np.array(slopes))(length)
        return float(found[-1]), found[:-1]

    def distance(self, left: float, right: float) -> float:
        return self.tracer.distance(*self._chord(left, right))

    def _chord(self, left: float, right: float) -> tuple[float, np.ndarray]:
        (a, x), (b, y) = self._increments(left), self._increments(right)
        return b - a, y - x

    def along(self, mode: np.ndarray, left: float, right: float) -> tuple[float, float]:
        """Component along a mode of a piece, and of what its tangents make of it."""
        def component(increment):
            return self.tracer.inner((0.0, mode), (0.0, increment))

        rates = [component(self.states[s].tangent[1]) for s in (left, right)]
        return component(self._chord(left, right)[1]), self.distance(left, right) * sum(rates) / 2

    def explained(self, left: float, right: float) -> bool:
        """Whether the tangents at the ends of a piece lead along it, and their mean gives its load."""
        chord, states = self._chord(left, right), [self.states[s] for s in (left, right)]
        distance, rates = self.distance(left, right), [s.load_rate for s in states]
        error = abs(chord[0] - distance * sum(rates) / 2)
        return (error <= UNEXPLAINED * distance * max(map(abs, rates))
                and all(self.tracer.angle(chord, s.tangent) <= TURNING for s in states))

    def _compare(self, state: State, guess, left: float, right: float) -> None:
        off = self.tracer.distance(state.load_increment - guess[0], state.increment - guess[1])
        if off > STRAY * self.distance(left, right):
            raise Jump(f"a state within the step is {off / self.distance(left, right):.2g} of it off the path")

    def spectrum(self, length: float, count: int) -> tuple[list[float], list]:
        """Eigenvalues of the tangent nearest to zero, and modes, at a length."""
        found = self._spectra.get(length)
        if found is None or len(found[0]) < count:
            self.tracer.factor_at(self[length])
            weights = diagonal(self.tracer.system.weights)
            values, modes = nearest_to_zero(self.tracer.stepper.linear, weights, count)
            found = self._spectra[length] = values, [self.tracer.system.create_vector(m.array) for m in modes]
        return found

    def eigenvalue(self, length: float, number: int | None, count: int) -> float:
        """The eigenvalue of the tangent with so many below it, or an end of the `count` nearest to zero.

        Where they are not counted (None), the one nearest to zero with the sign of the determinant.
        """
        values = self.spectrum(length, count)[0]
        if number is None:
            return self[length].determinant * min(map(abs, values))
        place = number - self[length].unstable + sum(v < 0 for v in values)
        return values[place] if 0 <= place < len(values) else copysign(max(map(abs, values)), place)

    def root(self, function: Callable[[float], float], left: float, right: float, exact: float) -> dict[float, float]:
        """Values of a function of the state, at lengths that close in on its root between two others.

        Parameters
        ----------
        exact : relative error of the load at which to stop
        """
        known = {}

        def stopped(length):
            value = known[length] = function(length)
            slopes = [abs((known[s] - value) / (s - length)) for s in known if s not in (length, left, right)]
            slope = max(slopes, default=0.0)
            state = self.states[length]
            size = max(abs(state.factor), abs(self.after.load_increment))
            return 0.0 if slope and self._load_change(state, value / slope) < exact * size else value

        try:
            brentq(stopped, left, right, xtol=1e-12 * self.after.length, rtol=1e-14)
        except _Missed:
            pass
        return dict(sorted(known.items(), key=lambda item: abs(item[1])))

    def _load_change(self, state: State, length: float) -> float:
        """Change of the load factor within a small length, to the second order where the load is stationary."""
        rate = self.distance(0.0, self.after.length) / self.after.length * length
        bend = abs(self.after.load_rate - self.before.load_rate) / self.distance(0.0, self.after.length)
        return abs(state.load_rate * rate) + bend * rate**2


def locate(tracer, earlier: State | None, before: State, after: State,
           most: int | None = None) -> tuple[CriticalPoint, ...]:
    """Critical points that the step from `before` to `after` brings to light; the tracer ends at `after`.

    A change of sign of the load rate is a limit point, which changes the number of unstable directions
    by one; any other change in that number means bifurcations. A step with more than `most` of them is too
    long. A step whose load does not follow from the
    tangents at its ends, or that turns, is also looked at in its middle.

    As a contact slides over contact points the load rate wavers about that of the smooth path, while
    the load itself hardly does. With contact a limit point is therefore a step in which the load
    turns, and is searched there and in the step before it, which starts at `earlier`.

    Raises
    ------
    Jump
        If the states of the step do not lie on one smooth piece of path.
    """
    stretch = Stretch(tracer, before, after)
    if stretch.guarded and most is not None and _hidden(before, after) > most:
        raise Jump(f"{_hidden(before, after)} bifurcations lie in one step")
    if tracer.discretisation.contacts:
        limits = _turning_loads(stretch, earlier)
    else:
        if stretch.guarded:
            _check(stretch)
        limits = [(stretch, next(iter(stretch.root(lambda s: stretch[s].load_rate, a, b, 1e-12))))
                  for a, b in stretch.pairs() if stretch[a].load_rate * stretch[b].load_rate < 0]
    points = [_limit(*found) for found in limits]
    crossings = _bifurcations(stretch, [length for s, length in limits if s is stretch])
    points += [_bifurcation(stretch, cluster) for cluster in _clusters(crossings)]
    if len(stretch.states) > 2 or points:
        tracer.back_to(after)
    return tuple(sorted(points, key=lambda p: (p.step, p.length)))


def state_at(tracer, before: State, after: State, point: CriticalPoint) -> State:
    """The state of a critical point of the step from `before` to `after`, again; the tracer ends there."""
    stretch = Stretch(tracer, before, after)
    if abs(point.length - after.length) <= 1e-12 * after.length:
        tracer.factor_at(after)
        return after
    try:
        state = stretch[point.length]
    except _Missed:
        raise ArithmeticError(f"the {point.kind} at load {point.load:.6g} in step {point.step} does not converge "
                              "again; resume the path with a shorter step before it") from None
    tracer.factor_at(state)
    return state


def _check(stretch: Stretch) -> None:
    """Look into the middle of pieces that turn, or whose load the tangents at their ends do not explain."""
    pieces = stretch.pairs()
    while pieces:
        left, right = pieces.pop()
        if not stretch.explained(left, right):
            if right - left < SHORTEST * stretch.after.length:
                raise Jump("tangents within the step do not explain its load")
            middle = (left + right) / 2
            try:
                stretch[middle]
            except _Missed:
                raise Jump("the middle of the step does not converge") from None
            pieces += [(left, middle), (middle, right)]


def _limit(stretch: Stretch, length: float) -> CriticalPoint:
    state = stretch.states[length]
    left = [s for s in stretch.states if s < length - 1e-5 * stretch.after.length]
    rising = stretch.states[max(left)].factor < state.factor if left else stretch.before.load_rate > 0
    return CriticalPoint("limit", state.load, state.deflection, state.step, float(length),
                         name="maximum" if rising else "minimum")


def _turning_loads(stretch: Stretch, earlier: State | None) -> list[tuple[Stretch, float]]:
    """The state of the highest (lowest) load where the load turns from one step to the next."""
    before, after = stretch.before, stretch.after
    if not before.load_increment * after.load_increment < 0:
        return []
    sign = 1.0 if before.load_increment > 0 else -1.0
    stretches = [stretch] if earlier is None else [Stretch(stretch.tracer, earlier, before), stretch]
    for one in stretches:

        def opposite_load(length, one=one):
            try:
                return -sign * one[length].factor
            except _Missed:
                return -sign * one.before.factor

        minimize_scalar(opposite_load, bounds=(0.0, one.after.length), method="bounded",
                        options={"xatol": 0.02 * one.after.length})
    return [max(((one, length) for one in stretches for length in one.states),
                key=lambda found: sign * found[0].states[found[1]].factor)]


@dataclass(frozen=True)
class _Crossing:
    """Where an eigenvalue of the tangent passes zero: the nearest state's length, and what is interpolated there."""

    length: float
    load: float
    deflection: float


def _bifurcations(stretch: Stretch, limits: list[float]) -> list[_Crossing]:
    """Where eigenvalues other than those of limit points pass zero, along the path.

    With contact, where eigenvalues waver, only the ends of the step are compared; with friction nothing is.
    """
    near, contacts = 1e-5 * stretch.after.length, stretch.tracer.discretisation.contacts
    if contacts and not stretch.tracer.system.symmetric:
        return []
    candidates = [0.0, stretch.after.length] if contacts else sorted(stretch.states)
    lengths = [s for s in candidates if all(abs(s - limit) > near for limit in limits)]
    found = [c for pair in zip(lengths[:-1], lengths[1:], strict=True) for c in _crossings(stretch, *pair, near)]
    return sorted(found, key=lambda c: c.length)


def _hidden(one: State, other: State) -> int:
    """Least number of bifurcations between two states: a limit point changes the unstable directions by one.

    Of unsymmetric tangents only the determinant is known, which simple bifurcations change.
    """
    if one.unstable is None:
        change = one.determinant != other.determinant
    else:
        change = abs(one.unstable - other.unstable)
    return abs(change - 1) if one.load_rate * other.load_rate < 0 else change


def _crossings(stretch: Stretch, left: float, right: float, near: float) -> list[_Crossing]:
    one, other = stretch[left], stretch[right]
    count = _hidden(one, other)
    if not count:
        return []
    if one.load_rate * other.load_rate < 0:
        middle = (left + right) / 2
        if right - left <= 3 * near:
            return [_Crossing(left, one.load, one.deflection)] * count
        try:
            stretch[middle]
        except _Missed:
            return []
        return _crossings(stretch, left, middle, near) + _crossings(stretch, middle, right, near)
    numbers = [None] if one.unstable is None else range(*sorted((one.unstable, other.unstable)))
    return [_crossing(stretch, number, count + 2, left, right) for number in numbers]


def _crossing(stretch: Stretch, number: int | None, count: int, left: float, right: float) -> _Crossing:
    """Zero of one eigenvalue, interpolated between states so far from it that rounding does not throw them off."""
    def value(length):
        return stretch.eigenvalue(length, number, count)

    values = stretch.root(value, left, right, 1e-3)
    middle, reach = next(iter(values)), 0.05 * (right - left)
    for length in (middle - reach, middle - reach / 2, middle + reach / 2, middle + reach):
        if left < length < right:
            try:
                values[length] = value(length)
            except _Missed:
                pass
    nearest = sorted((s for s in values if abs(s - middle) <= 1.01 * reach), key=lambda s: abs(values[s]))[:5]
    table = [(s, stretch[s].load, stretch[s].deflection) for s in nearest]
    found = _Crossing(*map(float, KroghInterpolator([values[s] for s in nearest], table)(0.0)))
    if not left < found.length < right:
        if stretch.guarded:
            raise Jump("an eigenvalue passes zero unsteadily")
        return _Crossing(*table[0])
    try:
        stretch[found.length]
    except _Missed:
        found = replace(found, length=nearest[0])
    if stretch.guarded:
        _compare_sides(stretch, found.length, reach, count)
    return found


def _compare_sides(stretch: Stretch, length: float, reach: float, count: int) -> None:
    """Refuse states on both sides of a bifurcation that the path does not lead through.

    Near the bifurcation of a slightly imperfect structure the path bends away along the mode; a step that goes
    straight on has jumped to another path, from which the mode deviates to the other side.
    """
    left = max((s for s in stretch.states if s <= length - reach / 2), default=None)
    right = min((s for s in stretch.states if s >= length + reach / 2), default=None)
    if left is None or right is None:
        return
    values, modes = stretch.spectrum(length, count)
    mode = modes[int(np.argmin(np.abs(values)))].array
    moved, led = stretch.along(mode, left, right)
    size = max(abs(moved), abs(led))
    if abs(moved - led) > size / 2 and size > NOISE * stretch.distance(left, right):
        raise Jump("the path bends away from a bifurcation that the step passes")


def _clusters(crossings: list[_Crossing]) -> list[list[_Crossing]]:
    """Crossings at equal loads together."""
    clusters: list[list[_Crossing]] = []
    for crossing in crossings:
        if clusters and abs(crossing.load - clusters[-1][-1].load) <= SAME * abs(crossing.load):
            clusters[-1].append(crossing)
        else:
            clusters.append([crossing])
    return clusters


def _bifurcation(stretch: Stretch, crossings: list[_Crossing]) -> CriticalPoint:
    """A simple or multiple bifurcation, classified."""
    first, count, tracer = crossings[0], len(crossings), stretch.tracer
    state = stretch[first.length]
    point = CriticalPoint("bifurcation", first.load, first.deflection, stretch.after.step, first.length, count)
    if tracer.discretisation.contacts or not tracer.system.symmetric:
        return point
    values, modes = stretch.spectrum(first.length, count)
    tracer.factor_at(state)
    null = [modes[i] for i in np.argsort(np.abs(values))[:count]]
    return postbuckling(tracer, state, null, point, [stretch.before, stretch.after])
