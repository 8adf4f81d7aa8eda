"""Equilibrium paths: an iterator over converged states.

```python
for state in Path(scene, ArcLength(), until=Until(deflection=40.0)):
    print(state.load, state.deflection, state.critical)
```
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from math import copysign, inf, pi
from typing import TYPE_CHECKING, Any

from .archive.scattered import ScatteredState
from .checks import require
from .continuation.control import ArcLength, DisplacementControl, LoadControl, StepRule
from .continuation.corner import LEAST, around_corner, change_ahead, up_to_bifurcation, up_to_change
from .continuation.failing import at_rest, explained_failure, several_modes
from .continuation.lapse import growth_by_history
from .continuation.linear import SingularTangent
from .continuation.problem import Problem
from .continuation.segment import Jump, Missed
from .continuation.state import CriticalPoint, State
from .continuation.tracer import Tracer
from .continuation.visited import VisitedStates
from .critical.flutter import Flutter
from .critical.koiter import postbuckling
from .critical.rest import unstable_at_rest
from .critical.snapping import Falling, SnapFailure
from .critical.verdict import searched
from .discrete.discretisation import discretised
from .events.event import Event, Hidden, end_at, occurrences
from .events.search import locate
from .events.turning import load_sense
from .events.until import AT_BOUND, Until
from .model.scene import Scene, Stage
from .notices import warn
from .rounding import SAME, same

if TYPE_CHECKING:
    from .critical.snap import Snap

THERE = 1e-6  # of the load, most that it changes up to where contact does, of a state that lies there
SHORT = 1 / 64  # of a step that fails and with half of its length does, length that gets past a corner close ahead
BEHIND = 1 / 8  # of such a step, from which the next one grows: what made both fail may lie further ahead


class PathFailure(ArithmeticError):
    """A path that cannot go on; says at which step, load and iteration, why, and what was kept.

    Attributes
    ----------
    record : Record of the path so far, where `trace` followed it
    cause : why, in a few words
    """

    record: Any = None
    cause = ""


class Path:
    """The equilibrium path of a scene, or of another problem; iterate over it once.

    Parameters
    ----------
    scene : Scene, or a Problem, as `fx.continuation` makes
    control : LoadControl, DisplacementControl or ArcLength
    until : end of the path
    start : states of an interrupted path to resume, of any number of processes; none: begin with the unloaded state
    events : what to look for beside limit points and bifurcations
    mixed_points : large-step tangent (see discrete.system.System)
    snaps : whether the structure falls where it has lost its stability, while the load is held, or the displacement of
        a DisplacementControl, and the path goes on from where it comes to rest, see `critical.snapping`; between falls
        it is followed by arc length
    prefix : of PETSc options for this path's SNES, KSP and PC

    Attributes
    ----------
    message : why the path ended
    start : states that it resumes from, as this process has them
    controls : of the load stages in turn
    critical_states : states of critical points that the search has had, and that have been asked for
    """

    def __init__(self, scene: Scene | Problem, control: StepRule | None = None, until: Until | None = None, *,
                 start: Sequence[State] = (), mixed_points: bool = True, prefix: str = "sheetfx_",
                 events: Sequence[Event] = (), snaps: bool = False):
        require("Path", snaps=(snaps, bool), control=(control, StepRule | None), until=(until, Until | None),
                events=(events, list[Event]))
        self.scene, self.until, last = scene, until or Until(), control or ArcLength()
        self._falling = Falling(last) if snaps else None
        if self._falling:
            last = self._falling.between
        self.controls = [*map(_preloading, scene.stages), last]
        self._ending = self.until.ending
        self.events = [*events, *([self._ending] if self._ending else [])]
        monitors = [getattr(scene, "monitor", None), *(getattr(one, "monitor", None) for one in self.controls)]
        monitors = [*filter(None, monitors)] if self.until.steps else []
        self.discretisation: Problem = discretised(scene, mixed_points, monitors)
        self.start, self._started = self._taken(start), time.process_time()
        self.tracer = Tracer(self.discretisation, self.controls[start[-1].stage if start else 0], prefix)
        self._others = [Flutter(self.tracer)] if Flutter.concerns(self.tracer) else []
        self.message, self._refusal, self._hidden, self._together = "", "", 0.0, 0
        self._at_corner: State | None = None
        self.critical_states: dict[CriticalPoint, State] = {}
        self._listeners: list[Callable[[State], None]] = []
        self._earlier = self.start[-2] if len(start) > 1 else None
        begun = self.start or [self.tracer.state]
        self._visited = None if self.tracer.system.smooth else VisitedStates(self.tracer, begun)
        if not start and self.tracer.state.unstable_modes:
            warn(unstable_at_rest(self.tracer))
        towards = self._falling.control if self._falling else self.control
        if start:
            self.tracer.back_to(towards.facing(self.start[-1]))
        else:
            self.tracer.state = towards.facing(self.tracer.state)
        self._bounds = [*self.until.bounds, *(self._falling.bounds(self.tracer.state) if self._falling else ())]

    def _taken(self, states: Sequence[State]) -> list[State]:
        """States as this process has them."""
        if any(isinstance(state, ScatteredState) for state in states):
            origins = self.discretisation.system.origins()
            states = [state.taken(origins) if isinstance(state, ScatteredState) else state for state in states]
        return [replace(state, scene=self.scene) for state in states]

    @property
    def control(self) -> StepRule:
        """How the present stage is followed."""
        return self.tracer.control

    @property
    def clock(self):
        return self.discretisation.clock

    @property
    def searched(self) -> list[str]:
        """What the present stage is searched for and what not, so that silence about the rest means absence."""
        return searched(self.discretisation, self.control, bool(self._others))

    @property
    def unknowns(self) -> int:
        return self.discretisation.system.size

    def subscribe(self, listener: Callable[[State], None]) -> None:
        """Have a function called with every state, before the iterator gives it out."""
        self._listeners.append(listener)

    def __iter__(self) -> Iterator[State]:
        state = self.tracer.state
        if not self.start:
            yield self._announce(state)
        while not (message := self._end(state)):
            if not state.length and (words := self.discretisation.unbalanced(self.tracer.load_vector())):
                raise ValueError(words)
            for after in self._onward(state):
                yield self._announce(after)
                state = after
        self.message = message

    def _onward(self, state: State) -> Iterable[State]:
        """The next state, or the last one before the structure falls, and that into which it does."""
        if self._stage_is_over(state):
            return [self._next_stage(state)]
        if self._falling is None or not self._in_last_stage(state):
            return [self._step(state)]
        return self._fallen(state, self._falling)

    def _fallen(self, before: State, falling: Falling) -> Iterator[State]:
        try:
            yield from falling.onward(self.tracer, before, self._step)
        except SnapFailure as failure:
            raise PathFailure(f"step {before.step + 1}, where stability is lost: {failure}. All states up to step "
                              f"{before.step} are kept.") from failure
        if falling.falls and falling.falls[-1].before.step > before.step:
            self._earlier = None
            self._visited = self._visited and VisitedStates(self.tracer, [self.tracer.state])

    @property
    def falls(self) -> list[Snap]:
        """Falls of a path with `snaps`, in their order."""
        return self._falling.falls if self._falling else []

    def _stage_is_over(self, state: State) -> bool:
        """Whether the loads of a stage before the last have their full size."""
        return state.stage + 1 < len(self.controls) and state.factor >= 1 - SAME

    def _next_stage(self, state: State) -> State:
        self._earlier = None
        return self.tracer.enter(state.stage + 1, self.controls[state.stage + 1])

    def _announce(self, state: State) -> State:
        self.clock.seconds["path"] = time.process_time() - self._started - self.clock.seconds["output"]
        with self.clock("output"):
            for listener in self._listeners:
                listener(state)
        return state

    def _end(self, state: State) -> str | None:
        if state.stage + 1 < len(self.controls):
            return self.until.stopped(state)
        if isinstance(self.control, LoadControl) and same(state.factor, self.control.target):
            return f"load factor {self.control.target:g} reached"
        return next((f"{bound.name} reached" for bound in self._bounds if bound.value(state) >= -bound.near),
                    None) or self.until.stopped(state)

    def _step(self, before: State) -> State:
        """One converged step, shortened as often as needed, with the critical points inside it."""
        length = wanted = self.control.clip(before.next_length or self.tracer.first, before.factor)
        largest, self._together = self.control.longest * self.tracer.usual, 0
        while (taken := self._try(before, length)) is None:
            shortest = length / 2 < self.control.smallest * self.tracer.shortest
            failure = self._failure(before, length / 2)
            if length == wanted / 2 and (taken := self._past_corner(before, wanted)):
                length = BEHIND * wanted
                break
            if shortest and (taken := self._around_corner(before, max(wanted, LEAST * self.tracer.usual), length)):
                length = taken[0].length
                break
            if length <= wanted / 2 and (taken := self._by_change(before, wanted, length)):
                break
            if shortest and (taken := self._whole(before) or self._up_to_bifurcation(before, length)):
                length = taken[0].length
                break
            if shortest:
                resting = at_rest(self.control, self.tracer, before)
                raise self._failure(before, length / 2, resting) if resting else failure
            length /= 2
        else:
            length = min(length, taken[0].length)
        after, points = taken
        growth = min(self.control.growth(after.hardest), growth_by_history(self.control, after))
        after = replace(after, next_length=min(largest, length * growth), critical=points,
                        load_sense=load_sense(self.tracer, before, after, points))
        self.tracer.state, self._earlier, self._hidden = after, before, max(0.0, self._hidden - after.length)
        if self._visited:
            self._visited.append(after)
        return after

    def _try(self, before: State, length: float) -> tuple[State, tuple[CriticalPoint, ...]] | None:
        """A step with its critical points; None and back to its start if it does not converge or leaves its branch."""
        after, self._refusal = self._to_bound(before, length) or self.tracer.attempt(length), ""
        if after is not None and self.tracer.enforcement.turns_round and self._leads_back(after):
            self.tracer.back_to(before)
            self.tracer.enforcement.turn_round()
            after = self.tracer.attempt(length)
        return None if after is None else self._searched(before, after, self._earlier, self.control.turn)

    def _past_corner(self, before: State, wanted: float) -> tuple[State, tuple[CriticalPoint, ...]] | None:
        """A short step past a corner close ahead; None where there has just been one, and where steps are short."""
        near = before.length <= 4 * SHORT * wanted or wanted < LEAST * self.tracer.usual
        if near or self.tracer.system.smooth or not self.control.guarded:
            return None
        return self._try(before, SHORT * wanted)

    def _by_change(self, before: State, wanted: float, failed: float) -> tuple[State, tuple[CriticalPoint, ...]] | None:
        """A step up to where contact changes within half of one that fails, or around it where the state lies there."""
        if self.tracer.system.smooth or not self.control.guarded:
            return None
        ahead = change_ahead(self.tracer, before, failed / 2)
        if ahead and abs(before.load_rate) * ahead <= THERE * abs(before.factor):
            if self._at_corner is before:
                return None
            self._at_corner = before
            return self._around_corner(before, wanted, failed)
        after = up_to_change(self.tracer, before, ahead) if ahead else None
        return None if after is None else self._searched(before, after, self._earlier, self.control.turn)

    def _around_corner(self, before: State, longest: float,
                       failed: float) -> tuple[State, tuple[CriticalPoint, ...]] | None:
        """A step around a corner of the path, before which loads say nothing of those behind it."""
        for after in around_corner(self.tracer, before, longest, failed, self._visited, self._earlier):
            if (taken := self._searched(before, after, None, pi, whole=True)) is not None:
                return taken
        return None

    def _up_to_bifurcation(self, before: State,
                           failed: float) -> tuple[State, tuple[CriticalPoint, ...]] | None:
        """A step up to where points begin to flow with which stability is lost."""
        found = up_to_bifurcation(self.tracer, before, failed)
        return found and (found[0], (found[1],))

    def _whole(self, before: State) -> tuple[State, tuple[CriticalPoint, ...]] | None:
        """A step up to where one was refused for an event that no shorter ones lead to; None where none was."""
        after = self.tracer.attempt(self._hidden) if self._hidden else None
        return None if after is None else self._searched(before, after, self._earlier, self.control.turn, whole=True)

    @property
    def _guards_corners(self) -> bool:
        return self.control.guarded and self.control.passes_limits

    def _leads_back(self, after: State) -> bool:
        """Whether a step leads back onto the path that has led here."""
        return bool(self._visited and self._guards_corners and self._visited.holds(after))

    def _searched(self, before: State, after: State, earlier: State | None,
                  largest_turn: float, whole: bool = False) -> tuple[State, tuple[CriticalPoint, ...]] | None:
        """A step, or its sound part, with critical points; None and back if it turns too far or leaves its branch.

        None also where shorter ones may find the state of an event in it, unless it has to be taken as a `whole`.
        """
        try:
            turn = self.tracer.turn(before, after)
            if self._leads_back(after):
                self._refusal = "it leads back onto the path that has led here"
            elif turn <= largest_turn:
                points = locate(self.tracer, earlier, before, after, postbuckling, self._others)
                return self._with_events(before, self.tracer.state, points, whole)
            else:
                self._refusal = f"it turns off the path by {turn:.2g} radians, more than {self.control.turn:g}"
        except Jump as jump:
            self._refusal = str(jump)
            if jump.sound is not None:
                return self._searched(before, jump.sound, earlier, largest_turn, whole)
        except Hidden:
            self._refusal, self._hidden = "states about an event do not converge", after.length
        except Missed:
            self._refusal = "it skips states in between"
        except SingularTangent:
            self._refusal = "the tangent is singular within it"
        if before.unstable_modes is not None and after.unstable_modes is not None:
            self._together = max(self._together, abs(after.unstable_modes - before.unstable_modes))
        self.tracer.back_to(before)
        return None

    def _to_bound(self, before: State, length: float) -> State | None:
        """A step that ends at a bound by prescribing it, where the step's tangent leads beyond it and it converges."""
        tracer, bounds = self.tracer, self.until.prescribed if self._in_last_stage(before) else []
        load_increment = self.control.predict(length, self.control.direction(before), tracer.tangent)
        for name, bound in bounds:
            now, rate = getattr(before, name), tracer.rate(name)
            ahead = copysign(bound, rate * load_increment) - now
            if rate and abs(now) < bound * (1 - AT_BOUND) and 0 < ahead / (rate * load_increment) <= 1:
                control = (DisplacementControl(sign=getattr(self.control, "sign", "projection")) if name == "deflection"
                           else LoadControl(target=copysign(inf, ahead / rate)))
                return tracer.attempt_by(control, abs(ahead if name == "deflection" else ahead / rate))
        return None

    def _in_last_stage(self, state: State) -> bool:
        return state.stage + 1 == len(self.controls)

    def _with_events(self, before: State, after: State, points: dict[CriticalPoint, State | None],
                     whole: bool) -> tuple[State, tuple[CriticalPoint, ...]]:
        """A step and its critical points with the events in it; the step ends at what ends the path."""
        bounds = self._bounds if self._in_last_stage(before) else []
        for occurrence in occurrences(self.tracer, before, after, [*self.events, *bounds], whole):
            point = occurrence.point
            if occurrence.event in self.events:
                points = points | {point: occurrence.state}
            if occurrence.event is self._ending or occurrence.event in bounds:
                after = end_at(self.tracer, after, occurrence)
                points = {p: state for p, state in points.items() if p.step < point.step or p.length <= point.length}
                break
        self.critical_states |= {p: state for p, state in points.items() if state is not None}
        return after, tuple(sorted(points, key=lambda p: (p.step, p.length)))

    def _failure(self, state: State, length: float, known: tuple[str, str] | None = None) -> PathFailure:
        history, shortest = self.tracer.stepper.history, f"even with a step of {length:.2g}"
        cause, details = f"does not converge {shortest}", (
            f"{self.tracer.reason()} after {len(history) - 1} iterations (relative residuals "
            f"{', '.join(f'{h:.1e}' for h in history[-4:])})")
        remedy = "try a smaller first step, another control or look at the structure at that state"
        details, remedy = known or explained_failure(
            self.control, self.tracer, self._earlier, state, 2 * length) or (details, remedy)
        if self._refusal and not known:
            cause, details = f"is refused {shortest}", f"it converges, but {self._refusal}"
            if self._together > 1:
                more, remedy = several_modes(self._together, state)
                details += more
        failure = PathFailure(
            f"step {state.step + 1} from load {state.load:.6g}, deflection {state.deflection:.6g} {cause}: {details}. "
            f"All states up to step {state.step} are kept; {remedy}.")
        failure.cause = cause
        return failure


def _preloading(stage: Stage) -> LoadControl:
    """The control of a stage before the last; its loads end at their full size exactly."""
    control = stage.control or LoadControl()
    if not isinstance(control, LoadControl) or control.target != 1.0:
        raise ValueError(f"Stage {stage.name!r}: control is {control}; it must be a LoadControl with the target 1, "
                         "which ends at the full loads")
    return control
