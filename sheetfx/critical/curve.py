"""Curves of critical points: how the load of a limit point or bifurcation goes with a number of the structure.

The equations of a critical point (`critical.defining`) with one number more among the unknowns have a curve of
solutions, which is regular where the number turns back, as at cusps (Govaerts 2000, chapters 3 and 4). It is followed
by arc length in state and number (Keller 1977), with the number's influence by differences of forces and tangents.
Along it change sign

- at a cusp, where two limit points meet, the third variation of the energy along the null vector;
- where a further eigenvalue of the tangent passes zero, that eigenvalue: a limit point and a bifurcation meet there,
  or two bifurcations do;
- where a curve of bifurcations turns back, the rate of the number.

Between two points of the curve such a zero is found by Brent's method.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path

import numpy as np
from petsc4py import PETSc
from scipy.optimize import brentq

from ..checks import Count, require
from ..continuation.bordered import BorderedSolver
from ..continuation.control import ArcLength
from ..continuation.linear import DirectSolver, SingularTangent
from ..continuation.spectrum import diagonal, nearest_to_zero
from ..continuation.state import CriticalPoint, State, write_arrays
from ..discrete.discretisation import Discretisation
from ..discrete.system import System
from ..events.determinant import orthonormal
from ..model.scene import Scene
from ..rounding import DIFFERENCE, TINIEST
from .augmented import ITERATIONS, KINDS
from .bifurcation_gradient import IMPERFECT
from .changed import changed_structure
from .defining import DefiningSystem, Influence, Linearised, combined, without_third_variations

SHORTEST = 1e-3  # step over the longest, below which the curve is given up


class CurveEnds(ArithmeticError):
    """Newton's method finds no further point of a curve."""


ARRAYS = "fields", "modes", "rate", "turn"  # of a place, which are not among the numbers of its file
FAILURES = CurveEnds, SingularTangent, np.linalg.LinAlgError  # of Newton's method for a place


@dataclass(frozen=True)
class CurvePoint:
    """A critical point of the structure with some value of the number.

    Attributes
    ----------
    number : value
    load, deflection : of the point
    kind : "limit" or "bifurcation"
    name : "cusp", "limit meets bifurcation", "bifurcations meet" or "turn" where the curve has such a point; else ""
    modes : null vectors, this process's part
    fields : values of all fields on this process
    """

    number: float
    load: float
    deflection: float
    kind: str
    name: str = ""
    modes: tuple[np.ndarray, ...] = field(default=(), repr=False)
    fields: dict[str, np.ndarray] = field(default_factory=dict, repr=False)

    def __str__(self) -> str:
        return f"{self.name or self.kind} at {self.number:.8g}: load {self.load:.8g}, deflection {self.deflection:.6g}"


@dataclass(frozen=True)
class _Place:
    """A point of the curve with what goes on from there.

    Attributes
    ----------
    modes : of the border, those that are sought first
    rate : of the state, the load factor and the number along the curve, of unit length
    bend : third variation along the mode, over its length cubed
    beside : of the further eigenvalues the one next to zero
    loaded : whether the response to the load lies along its mode
    negative : number of negative eigenvalues, those that are sought aside
    iterations : that it took
    turn : change of the rate by a unit of length on the way to it
    pushed : what the number pushes with along the mode as it goes through its range, over the load's size
    """

    number: float
    factor: float
    load: float
    deflection: float
    fields: dict[str, np.ndarray]
    modes: list[np.ndarray]
    rate: tuple[np.ndarray, float, float]
    bend: float
    beside: float
    loaded: bool
    negative: int
    iterations: int
    pushed: float
    turn: tuple[np.ndarray, float, float]


@dataclass(frozen=True)
class Kept:
    """What a curve goes on from: a place, the next length, and how lengths are measured."""

    place: _Place
    length: float
    begun: bool
    kind: str
    size: float
    moved: float
    ended: bool = False

    def save(self, file: Path, points: int) -> None:
        """Write to a NumPy archive, with the number of points so far; the file appears complete or not at all."""
        numbers = {f.name: getattr(self.place, f.name) for f in fields(_Place) if f.name not in ARRAYS}
        own = {f.name: getattr(self, f.name) for f in fields(self) if f.name != "place"}
        (increment, *rates), (turn, *turns) = self.place.rate, self.place.turn
        write_arrays(file, place=json.dumps(numbers, default=float), kept=json.dumps(own | {"points": points}),
                     modes=np.array(self.place.modes), increment=increment, turn=turn, rates=np.array([rates, turns]),
                     **{f"field {name}": values for name, values in self.place.fields.items()})

    @classmethod
    def load(cls, file: Path) -> tuple[Kept, int]:
        """Read what `save` wrote."""
        with np.load(file) as archive:
            own = json.loads(str(archive["kept"]))
            points = own.pop("points")
            arrays = {name.removeprefix("field "): archive[name] for name in archive.files if name.startswith("field ")}
            rates, turns = (map(float, row) for row in archive["rates"])
            place = _Place(**json.loads(str(archive["place"])), fields=arrays, modes=list(archive["modes"]),
                           rate=(archive["increment"], *rates), turn=(archive["turn"], *turns))
        return cls(place, **own), points


class _Differences:
    """Differences of forces, load and tangent between two structures, at one state.

    Parameters
    ----------
    ahead, behind : the structures, at the fields that increments count from
    x, factor : increments, this process's part, and load factor
    way : difference of the number
    """

    def __init__(self, ahead: Discretisation, behind: Discretisation, x: np.ndarray, factor: float, way: float):
        self._problems, self._way = (ahead, behind), way
        self._tangents: list[PETSc.Mat] = []
        forces = []
        for problem in self._problems:
            system = problem.system
            with system.additive_increments():
                residual, load = system.create_vector(), system.create_vector()
                system.configure(system.create_vector(x), factor)
                system.residual(residual)
                system.load(load)
                system.extrapolate_stress()
                self._tangents.append(system.tangent())
                forces.append((residual.array.copy(), load.array.copy()))
        self._forces = [(one - other) / way for one, other in zip(*forces, strict=True)]

    def on(self, system: System) -> Influence:
        """Influence of the number on a system with the same unknowns."""
        residual, load = (system.create_vector(values) for values in self._forces)
        return Influence(residual, load, self._images)

    def _images(self, vectors: Sequence[PETSc.Vec]) -> list[PETSc.Vec]:
        found = [vector.duplicate() for vector in vectors]
        for vector, image in zip(vectors, found, strict=True):
            one, other = (self._product(n, vector.array) for n in range(2))
            image.array[:] = (one - other) / self._way
        return found

    def _product(self, number: int, values: np.ndarray) -> np.ndarray:
        system = self._problems[number].system
        product = system.create_vector()
        self._tangents[number].mult(system.create_vector(values), product)
        return product.array.copy()


class CriticalCurve:
    """The curve of a critical point, an iterator over points from one value of a number to another.

    ```python
    found = fx.critical(scene(0.01), guess)
    for point in fx.CriticalCurve(found.point, found.state, found.modes, scene, 0.01, 1.0):
        print(point)
    ```

    It ends where the number arrives, or comes back to where it began. The bifurcation of a perfect structure goes on as
    the limit point of imperfect ones where the number makes them so.

    Parameters
    ----------
    point, state, modes : limit point or bifurcation of scene(at), its state and its null vectors
    scene : function from the number to the scene, of which only values change and nodes move
    at, to : first and last number
    steps : a step goes through the range of the number divided by this, twice as much at the most

    Attributes
    ----------
    factorisations : that it has taken
    kept : what the curve goes on from, after each point that has no name; one that was kept in another run, with the
        same arguments, goes on there

    Raises
    ------
    ValueError
        If both numbers are the same, the number changes the unknowns, or the structure with it has contact, history or
        forces without a potential.
    CurveEnds
        While iterating, where Newton's method finds no further point, however short the step.
    """

    def __init__(self, point: CriticalPoint, state: State, modes: Sequence[np.ndarray],
                 scene: Callable[[float], Scene], at: float, to: float, *, steps: int = 20):
        require("curve", at=(at, float), to=(to, float), steps=(steps, Count))
        if at == to:
            raise ValueError(f"curve: at and to are both {at:g}; give a range of the number")
        if point.kind not in KINDS or point.spread:
            raise ValueError(f"curve: {point.title} at load {point.load:.6g} is no single point where the tangent is "
                             "singular; give a limit point or a bifurcation")
        self._state, self._modes, self._scene, self._steps = state, list(modes), scene, steps
        self._at, self._to, self._given, self._count = at, to, point.kind, len(modes)
        self._exact, self.factorisations = ArcLength().exact, 0
        scene(to)
        self._first_problem = Discretisation(scene(at))
        self._measure = self._first_problem.system  # whose weights serve for all
        self._low, self._high = self._bounds()
        self.kept: Kept | None = None

    def __iter__(self) -> Iterator[CurvePoint]:
        longest = 1 / self._steps
        if self.kept is None:
            self._kind, self._size, self._moved = self._given, self._displacement(), 0.0
            here, length, begun = self._first(), longest, False
            self.kept = Kept(here, length, begun, self._kind, self._size, self._moved)
            yield self._point(here)
        else:
            here, length, begun = self.kept.place, self.kept.length, self.kept.begun
            self._kind, self._size, self._moved = self.kept.kind, self.kept.size, self.kept.moved
        first, turned, looked = here, False, False
        while not self.kept.ended:
            try:
                ahead = self._place(here, length)
                self._require_near(here, ahead)
                last = not self._within(ahead.number)
                if last and not begun and not turned:
                    here, length, turned = self._turned(first), longest, True
                    self._size, self._moved = self._displacement(), 0.0
                    continue
                if last:
                    ahead = self._last(here, ahead, length)
                if self._unseen(here, ahead):
                    if looked:
                        raise CurveEnds("more than one further eigenvalue passes zero")
                    here, looked = self._place(self._with_modes(here), 0.0), True
                    continue
                begun = begun or last or self._share(ahead.number) > self._exact**0.5
                between = list(self._between(here, ahead, length)) if begun else []
            except FAILURES as failure:
                length /= 2
                if length < SHORTEST * longest:
                    raise CurveEnds(f"curve: Newton's method finds no point beyond {self._point(here)} ({failure}); "
                                    "what is before it is right") from None
                continue
            looked = False
            yield from between
            here, length = self._measured(here, ahead, length)
            length *= min(2.0, 4 / max(1, here.iterations))
            if begun:
                self.kept = Kept(here, length, begun, self._kind, self._size, self._moved, last)
                yield self._point(here)

    def _displacement(self) -> float:
        """Linear displacement at the load of the first point, in the scaled norm."""
        norm2, work = self._state.reference
        return abs(self._state.factor) * norm2**0.5 if work else 1.0

    def _measured(self, here: _Place, ahead: _Place, length: float) -> tuple[_Place, float]:
        """The next place and the length as measured by what the state has moved so far, if that is more than before."""
        system = self._measure
        step = system.create_vector(length * here.rate[0])
        self._moved += (system.weights * step).dot(step) ** 0.5
        self._size = max(self._size, self._moved)
        rate, factor, number = ahead.rate
        unit = self._length(system, system.create_vector(rate), number)
        before, after = (np.array([*increment, *numbers]) for increment, *numbers in (here.rate, ahead.rate))
        *turn, turn_of_factor, turn_of_number = (after - before) / (length * unit**2)
        return replace(ahead, rate=(rate / unit, factor / unit, number / unit),
                       turn=(np.array(turn), turn_of_factor, turn_of_number)), length * unit

    def _within(self, number: float) -> bool:
        return -self._exact**0.5 <= self._share(number) <= 1

    def _share(self, number: float) -> float:
        """Of the range that a number is through."""
        return (number - self._at) / (self._to - self._at)

    def _last(self, here: _Place, ahead: _Place, length: float) -> _Place:
        """The place at the end of the range that a step goes past."""
        low, high = sorted((self._at, self._to))
        end = min(max(ahead.number, low), high)
        return self._place(here, (end - here.number) / (ahead.number - here.number) * length, end=end)

    def _point(self, place: _Place, name: str = "") -> CurvePoint:
        return CurvePoint(place.number, place.load, place.deflection, self._kind, name,
                          tuple(place.modes[:self._count]), place.fields)

    # From place to place

    def _first(self) -> _Place:
        """The first place; of a bifurcation that the number leaves imperfect as a limit point of what comes then."""
        state = self._state
        still = np.zeros_like(state.increment), 0.0, 0.0
        start = _Place(self._at, state.factor, state.load, state.deflection, state.fields, self._modes,
                       still, 0.0, 0.0, False, 0, 0, 0.0, still)
        try:
            place = self._place(start, 0.0, end=self._at)
        except FAILURES as failure:
            raise CurveEnds(f"curve: Newton's method does not find the first point again, at load {state.load:.6g} "
                            f"({failure}); give one of the structure that has the number {self._at:g}") from None
        if self._kind == "bifurcation" and len(self._modes) == 1 and place.pushed > IMPERFECT:
            self._kind = "limit"
            return self._place(start, 0.0, known=True)
        return place

    def _with_modes(self, place: _Place) -> _Place:
        """A place with one more mode in its border, its tangent's whose eigenvalue is next to zero."""
        problem = self._problem(place.number, place.fields)
        system, count = problem.system, self._count + 1
        system.extrapolate_stress()
        system.tangent()
        linear = self._solver(problem)
        linear.factorise()
        self.factorisations += 1
        _, modes = nearest_to_zero(linear, diagonal(system.weights), min(count, system.size))
        given = [system.create_vector(mode) for mode in place.modes[:self._count]]
        border = orthonormal(system.weights, [*given, *(system.create_vector(mode.array) for mode in modes)])[:count]
        return replace(place, modes=[mode.array.copy() for mode in border])

    def _turned(self, place: _Place) -> _Place:
        increment, factor, number = place.rate
        return replace(place, rate=(-increment, -factor, -number))  # the first one, which has no turn yet

    def _problem(self, number: float, fields: dict[str, np.ndarray]) -> Discretisation:
        problem = changed_structure("curve", self._scene(self._inside(number)), fields)
        if why := without_third_variations(problem.system):
            raise ValueError(f"curve: the structure has {why}; compare whole paths, as `sheetfx study --vary` does")
        return problem

    def _inside(self, number: float, by: float = 0.0) -> float:
        return min(max(number, self._low + by), self._high - by)

    def _bounds(self) -> tuple[float, float]:
        """The range, and beyond it the longest step where there are such structures."""
        low, high = sorted((self._at, self._to))
        way = 2 * (high - low) / self._steps

        def exists(number: float) -> bool:
            try:
                self._scene(number)
            except ValueError:
                return False
            return True

        return low - way * exists(low - way), high + way * exists(high + way)

    @staticmethod
    def _solver(problem: Discretisation) -> DirectSolver:
        return DirectSolver(PETSc.KSP().create(problem.system.comm), problem.system.matrix, True)

    def _place(self, base: _Place, length: float, end: float | None = None, least: int = 1,
               known: bool = False) -> _Place:
        """The place a length ahead of another, or that with the number `end`.

        Parameters
        ----------
        least : number of iterations, of which the last tells the eigenvalues
        known : whether the state is the place, which is only looked at

        Raises
        ------
        CurveEnds, SingularTangent, numpy.linalg.LinAlgError
        """
        (rate, rate_of_factor, rate_of_number), half = base.rate, length**2 / 2
        x = length * rate + half * base.turn[0]
        factor = base.factor + length * rate_of_factor + half * base.turn[1]
        number = base.number + length * rate_of_number + half * base.turn[2]
        if end is not None:
            number = end
        modes, count, sizes = base.modes, self._count, [0.0]
        for iteration in range(1, ITERATIONS + 1):
            problem = self._problem(number, base.fields)
            system = problem.system
            with system.additive_increments():
                at = system.create_vector(x)
                system.configure(at, factor)
                system.extrapolate_stress()
                system.tangent()
                linear = self._solver(problem)
                defining = DefiningSystem(problem, linear, [system.create_vector(mode) for mode in modes], count,
                                          self._kind)
                _relax(system, defining, at, factor, base.factor)
                influence = self._influence(base.fields, at.array.copy(), factor, number)
                own = influence.on(system)
                found = defining.linearise(at, factor, [own])
                self.factorisations += linear.factorisations
                if known:
                    return self._reached(base, problem, defining.bordered, found, own, (x, factor, number), modes, 0)
                row, rest = self._row(system, base, found, at, number, length, end)
                matrix = np.vstack((found.matrix, row))
                step, (change, more), forces = found.step(np.linalg.solve(matrix, [*found.right, rest]))
                sizes.append(self._length(system, step, more))
                system.retract(at, step)
                _settle(system, defining, at, float(factor + change), float(more) * own.residual, self._exact)
            x, factor, number = at.array.copy(), float(factor + change), float(number + more)
            order = [*found.sought, *(n for n in range(len(found.values)) if n not in found.sought)]
            modes = [defining.modes[n].array.copy() for n in order]
            rounds = iteration > 2 and not sizes[-1] < sizes[-2]
            ahead = min(sizes[-1] / sizes[-2], 1.0) if sizes[-2] else 1.0
            exact = ahead * abs(change) <= self._exact * abs(factor) and ahead * sizes[-1] <= self._exact
            small = abs(change) <= self._exact**0.75 * abs(factor) and sizes[-1] <= self._exact**0.5
            if (exact and iteration >= least) or (rounds and small):
                self._require_together(found, factor, number)
                self._require_perfect(system, found, forces, factor, number)
                return self._reached(base, problem, defining.bordered, found, own, (x, factor, number), modes,
                                     iteration)
            if rounds:
                raise CurveEnds(f"corrections grow to {sizes[-1]:.1e}")
        raise CurveEnds(f"no convergence in {ITERATIONS} iterations")

    def _require_together(self, found: Linearised, factor: float, number: float) -> None:
        """Refuse that the number parts the modes of a point of several ones, of which the mean is followed."""
        off = np.abs(found.values[found.sought]).max() / max(abs(found.rates[:, 0].mean()), TINIEST)
        if self._count > 1 and off > ArcLength().same_load * abs(factor):
            raise ValueError(f"curve: the number parts the {self._count} modes of the point, at {number:.6g} by "
                             f"{off / abs(factor):.1e} of its load; follow each of them from another value")

    def _require_perfect(self, system: System, found: Linearised, forces: np.ndarray, factor: float,
                         number: float) -> None:
        """Refuse a bifurcation that forces along its modes must hold, as an imperfection's do."""
        load = system.create_vector()
        system.load(load)
        held = combined([system.weights * mode for mode in found.modes], forces).norm() / (abs(factor) * load.norm())
        if self._kind == "bifurcation" and held > self._exact**0.5:
            raise ValueError(f"curve: the number makes the structure imperfect, at {number:.6g} by {held:.1e} of the "
                             "load; begin with a limit point of an imperfect structure")

    def _row(self, system, base: _Place, found: Linearised, at: PETSc.Vec, number: float, length: float,
             end: float | None) -> tuple[np.ndarray, float]:
        """The equation for the length along the curve, or for the number at its end."""
        row = np.zeros(len(found.directions))
        if end is not None:
            row[1] = 1.0
            return row, end - number
        rate, _, rate_of_number = base.rate
        weighted = system.weights * system.create_vector(rate) / self._size**2
        row[:] = [weighted.dot(direction) for direction in found.directions]
        scale = rate_of_number / (self._to - self._at)**2
        row[1] += scale
        return row, length - weighted.dot(at) - weighted.dot(found.left) - scale * (number - base.number)

    def _reached(self, base: _Place, problem: Discretisation, bordered: BorderedSolver, found: Linearised,
                 influence: Influence, at, modes, iterations: int) -> _Place:
        """The place that Newton's method has come to."""
        system, (increment, factor, number) = problem.system, at
        n = int(found.sought[0])
        others = [m for m in range(len(found.values)) if m not in found.sought]
        next_to_zero = min(others, key=lambda m: abs(found.values[m]), default=None)
        before = system.weights * system.create_vector(base.modes[0])
        same = 1.0 if before.dot(found.modes[n]) > 0 else -1.0
        modes[0] *= same
        negative = (bordered.negative() or 0) + sum(bool(found.values[m] < 0) for m in others)
        x = system.create_vector(increment)
        deflection = base.deflection + problem.functional().of(x)
        system.configure(x, factor)
        load = problem.total_load()
        system.history.update_history()
        system.history.commit()
        return _Place(
            number, factor, load, deflection, system.snapshot(), modes,
            self._rate(system, base, found),
            same * found.rates[0, len(found.responses) + n],
            0.0 if next_to_zero is None else float(found.values[next_to_zero]),
            next_to_zero is not None and _is_loaded(system, found, next_to_zero), negative, iterations,
            _pushed(system, found, influence, factor, self._to - self._at),
            (np.zeros_like(increment), 0.0, 0.0))

    def _rate(self, system, base: _Place, found: Linearised) -> tuple[np.ndarray, float, float]:
        """Unit tangent of the curve, that goes on in the direction of the last one; the first goes towards the end."""
        rest, towards = np.delete(found.matrix, 1, axis=1), self._to - self._at
        try:
            factor, *shares = np.linalg.solve(rest, -found.matrix[:, 1])
            along = np.array([factor, 1.0, *shares])
        except np.linalg.LinAlgError:  # the curve turns exactly here
            along = np.linalg.svd(found.matrix)[2][-1]
        vector = combined(found.directions, along)
        length = self._length(system, vector, along[1])
        before, _, number_before = base.rate
        sense = (system.weights * vector).dot(system.create_vector(before)) / self._size**2
        sense += along[1] * number_before / towards**2
        sign = np.sign(sense or along[1] * towards) or 1.0
        return sign * vector.array / length, sign * along[0] / length, sign * along[1] / length

    def _length(self, system, increment: PETSc.Vec, number: float) -> float:
        squared = (system.weights * increment).dot(increment) / self._size**2
        return (squared + (number / (self._to - self._at))**2) ** 0.5

    def _influence(self, fields: dict[str, np.ndarray], x: np.ndarray, factor: float, number: float) -> _Differences:
        """Differences by the number about it, within the range."""
        way = DIFFERENCE * abs(self._to - self._at)
        middle = self._inside(number, way)
        ahead, behind = (self._problem(middle + sign * way, fields) for sign in (1, -1))
        return _Differences(ahead, behind, x, factor, 2 * way)

    def _require_near(self, here: _Place, ahead: _Place) -> None:
        """Refuse a step over too much of the range, or that turns by more than 60 degrees."""
        if abs(ahead.number - here.number) * self._steps > 2 * abs(self._to - self._at):
            raise CurveEnds("the number changes by too much")
        system = self._measure
        one, other = (system.create_vector(place.rate[0]) for place in (here, ahead))
        cosine = (system.weights * one).dot(other) / self._size**2
        cosine += here.rate[2] * ahead.rate[2] / (self._to - self._at)**2
        if cosine < 0.5:
            raise CurveEnds("the curve turns sharply")

    # Between two places

    def _unseen(self, here: _Place, ahead: _Place) -> bool:
        """Whether an eigenvalue has passed zero that is not in the border."""
        return ahead.negative != here.negative and not here.beside * ahead.beside < 0

    def _between(self, here: _Place, ahead: _Place, length: float) -> Iterator[CurvePoint]:
        """Named points of a step, in their order."""
        tests: list[Callable[[_Place], float]] = [lambda place: place.beside]
        if self._kind == "bifurcation":
            tests.append(lambda place: place.rate[2])
        elif self._count == 1:
            tests.append(lambda place: place.bend)
        found = []
        for number, test in enumerate(tests):
            if test(here) * test(ahead) < 0 and (number or here.negative != ahead.negative):
                at, place = self._zero(here, ahead, length, test)
                found.append((at, place, self._named(place, number)))
        for _, place, name in sorted(found, key=lambda one: one[0]):
            yield self._point(place, name)

    def _named(self, place: _Place, number: int) -> str:
        if number:
            return "cusp" if self._kind == "limit" else "turn"
        return "limit meets bifurcation" if self._kind == "limit" or place.loaded else "bifurcations meet"

    def _zero(self, here: _Place, ahead: _Place, length: float,
              test: Callable[[_Place], float]) -> tuple[float, _Place]:
        """The length at which a test is zero, and the place there.

        Where a curve of bifurcations turns back the load does no work along the mode to tell places by, and the
        equations are singular: the nearest place counts that is found, from which the number differs in the second
        order.
        """
        known = {0.0: here, length: ahead}

        def value(at: float) -> float:
            if at not in known:
                known[at] = self._place(here, at, least=2)
            return test(known[at])

        try:
            root = brentq(value, 0.0, length, xtol=self._exact)
        except FAILURES:
            if self._kind == "limit" or len(known) == 2:
                raise
            root = min(known, key=lambda at: abs(test(known[at])))
        nearest = min(known, key=lambda at: abs(at - root))
        return nearest, known[nearest]


def _relax(system: System, defining: DefiningSystem, at: PETSc.Vec, factor: float, before: float) -> None:
    """Correct a state off the modes if it strains stiff parts so that its residual is more than the load.

    The tangent has the stresses of the last state with their linear change.
    """
    if not defining.is_strained(at, factor):
        return
    step = at.copy()
    system.configure(system.create_vector(), before)
    system.extrapolate_stress(step)
    system.configure(at, factor)
    defining.factorise()
    _settle(system, defining, at, factor, None, 0.0)


def _settle(system: System, defining: DefiningSystem, at: PETSc.Vec, factor: float, more: PETSc.Vec | None,
            exact: float) -> None:
    """Correct a state off the modes with the factor that there is, while each correction is less than half the last.

    Parameters
    ----------
    more : change of the residual by the number since the structure that the system is of
    """
    before = np.inf
    for _ in range(ITERATIONS):
        step = defining.off_modes(at, factor, more)
        size = (system.weights * step).dot(step) ** 0.5
        if not size < before / 2:
            break
        system.retract(at, step)
        before = size
        if size <= exact:
            break


def _pushed(system: System, found: Linearised, influence: Influence, factor: float, way: float) -> float:
    """Work along the sought mode of the number's forces by its whole range, over the work of the load's size."""
    mode, load = found.modes[int(found.sought[0])], system.create_vector()
    system.load(load)
    return abs(way * mode.dot(influence.residual)) / (abs(factor) * load.norm() * mode.norm())


def _is_loaded(system, found: Linearised, n: int) -> bool:
    """Whether the response to the load lies along a mode for the greater part."""
    mode, response = found.modes[n], found.responses[0]
    share = found.pushed[0, n] / found.values[n] if found.values[n] else np.inf
    return bool(share**2 * (system.weights * mode).dot(mode) > (system.weights * response).dot(response))

