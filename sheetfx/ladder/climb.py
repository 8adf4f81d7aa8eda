"""The least model of a scene that a critical load needs: climbed from below, each decision with its evidence.

The poorest model is followed up to its first critical point, on the coarsest mesh. A rung is climbed where its evidence
asks for it, and the mesh refined until the error of the load is small enough (Oden and Prudhomme 2002, of linear
problems; here each estimate is of the critical load itself).
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

from ..critical.verdict import doubts
from ..discrete.plastic import is_plastic
from ..notices import warn
from .decision import Advice, Decision, Estimate
from .first_point import FirstPoint
from .left_out import LeftOut
from .meshes import Meshes
from .models import Models
from .rung import Evidence, Rung
from .symmetry import Asymmetric, across, planes

SMALL = 1 / 4  # of the accuracy asked for, that each thing left out may be worth
LEAST = 1 / 2  # of the accuracy asked for, half of the narrowest interval: what is less was not looked at
DOUBLINGS = 2  # of layers and steps at most
FALLING, SECOND_ORDER = 1.5, 4.0  # ratios of changes by halved cells, from which on they count as falling, and most
CONVERGING = 1.25  # doubt of an error over it, by three meshes that converge (Roache 1998)


class Climb:
    """Finds the least model of a scene on meshes of several levels.

    Parameters
    ----------
    meshes : cases of the structure
    within : half of the interval of the load, over the load
    told : called with each decision
    """

    def __init__(self, meshes: Meshes, within: float, told: Callable[[Decision], None] = lambda decision: None):
        self._models, self._within, self._told = Models(meshes), within, told
        self._decisions: list[Decision] = []
        self._measured_at: dict[str, int] = {}
        self._lowest, self._highest = meshes.lowest, meshes.highest

    def advice(self) -> Advice:
        """The least model, and the load by it.

        Raises
        ------
        ValueError
            If the scene itself is refused.
        """
        begun, level, looked_across = time.process_time(), self._lowest, False
        coarser: tuple[FirstPoint, int, LeftOut, Estimate | None, float] | None = None
        left = LeftOut.all_of(self._models.scene(level))
        while True:
            left = self._enough(level, left)
            found = self._models.at(level, left)
            if found.failure:
                self._decide("path", "stopped", f"on {self._models.meshes.words(level)}, before a limit point or "
                             f"bifurcation, at load {found.load:.6g}: {found.failure}")
                return self._advice(*coarser, False, begun) if coarser else self._stopped(level, left, begun)
            if not looked_across:
                looked_across = True
                if self._buckles_across(found):
                    continue
            integration, unknown = self._of_integration(left)
            if integration and integration.doubt > self._within / 2 * abs(found.load) and (
                    self._models.doubled < DOUBLINGS):
                self._decide("layers and steps", "too few", integration.because, -integration.error / found.load)
                self._models.doubled += 1
                continue
            estimate = self._of_mesh(level, left)
            if estimate and integration:
                estimate += integration
            doubt = sum(map(abs, self._models.small.values())) * abs(found.load) + (estimate.doubt if estimate else 0.0)
            reached = estimate is not None and not unknown and doubt <= self._within * abs(found.load)
            if (reached or level == self._highest) and (name := self._not_small(level, left)):
                left = left.but(name)
                continue
            if reached or level == self._highest:
                return self._advice(found, level, left, estimate, doubt, reached, begun)
            coarser = found, level, left, estimate, doubt
            level += 1

    def _decide(self, about: str, decided: str, because: str, worth: float | None = None) -> None:
        decision = Decision(about, decided, because, worth)
        if decision not in self._decisions:
            self._decisions.append(decision)
            self._told(decision)

    def _enough(self, level: int, left: LeftOut) -> LeftOut:
        """What may be left out at a level: less than before, until the evidence for all of it holds."""
        while True:
            try:
                found = self._models.at(level, left)
            except ValueError as error:
                if not left.rungs:
                    raise
                name, evidence = left.rungs[0].name, Evidence(f"the structure without it is refused: {error}")
            else:
                if found.refuted:
                    name, evidence = next(iter(found.refuted.items()))
                elif doubtful := self._doubtful(left, found):
                    name, evidence = doubtful[0].name, self._measured(level, left, found, *doubtful)
                    if self._is_small(evidence, level, name):
                        continue
                else:
                    return left
            self._decide(name, "needed", evidence.because, evidence.worth)
            left = left.but(name)

    def _doubtful(self, left: LeftOut, found: FirstPoint) -> tuple[Rung, Evidence] | None:
        """A rung whose evidence does not allow to leave it out; None where all do, each then decided."""
        decided = {decision.about for decision in self._decisions}
        for rung in left.rungs:
            if rung.name in self._models.small:
                continue
            if found.failure:
                return rung, Evidence(f"the path without it stops: {found.failure}")
            evidence = rung.evidence(found.seen[rung.name])
            if evidence.worth is None or abs(evidence.worth) > SMALL * self._within:
                return rung, evidence
            if rung.name not in decided:
                self._decide(rung.name, "left out", evidence.because, evidence.worth)
        return None

    def _not_small(self, level: int, left: LeftOut) -> str:
        """Things left out that on the level below are worth more than on a coarser one, where they were measured."""
        level -= 1
        for name, measured in list(self._measured_at.items()):
            if measured >= level:
                continue
            rung = next(rung for rung in left.rungs if rung.name == name)
            evidence = self._measured(level, left, self._models.at(level, left), rung, Evidence("on finer cells"))
            del self._models.small[name], self._measured_at[name]
            if not self._is_small(evidence, level, name):
                self._decide(name, "needed", evidence.because, evidence.worth)
                return name
        return ""

    def _is_small(self, evidence: Evidence, level: int, name: str) -> bool:
        """Whether a measured worth is small, which is then kept."""
        if evidence.worth is None or abs(evidence.worth) > SMALL * self._within:
            return False
        self._models.small[name], self._measured_at[name] = evidence.worth, level
        self._decide(name, "left out", evidence.because, evidence.worth)
        return True

    def _measured(self, level: int, left: LeftOut, found: FirstPoint, rung: Rung, evidence: Evidence) -> Evidence:
        """What a rung is worth on this mesh, by the path of the richer model."""
        other = self._models.at(level, left.but(rung.name))
        if found.failure or other.failure or other.refuted or not found.load or bool(found.point) != bool(other.point):
            return Evidence(evidence.because)
        return Evidence(f"{evidence.because}: with it the load is {other.load:.6g} instead of {found.load:.6g} on "
                        f"{self._models.meshes.words(level)}", other.load / found.load - 1)

    def _buckles_across(self, found: FirstPoint) -> bool:
        """Whether modes across planes of symmetry become unstable before the first critical point; they then count."""
        record, state, scene = found.record, found.state, found.record.case.scene
        if 2 ** (count := len(planes(scene))) < scene.symmetry_factor:
            self._decide("symmetry", "kept", f"the part is one of {scene.symmetry_factor}, but its supports are on "
                         f"{count} planes of symmetry: modes that do not repeat in all parts are not all looked for")
        for modes in across(scene):
            if not record.path.discretisation.system.conservative:
                self._decide("symmetry", "kept", f"modes across {modes.name} are not looked for where forces have no "
                             "potential; model the whole")
                continue
            try:
                lowest = Asymmetric(modes)
            except ValueError as error:
                self._decide("symmetry", "kept", f"{error}: its modes are not looked for; model the whole")
                continue
            first, last = lowest(record.states[0]), lowest(state)
            if last < -SMALL * self._within * first:
                self._models.counts(modes.name)
                self._decide("symmetry", "broken", f"at load {state.load:.6g} of the symmetric structure a "
                             f"{lowest.name} is unstable already")
            else:
                self._decide("symmetry", "kept", f"at load {state.load:.6g} the lowest eigenvalue of a {lowest.name} "
                             f"is {last / first:.0%} of that of the unloaded structure", 0.0)
        return bool(self._models.across)

    def _of_mesh(self, level: int, left: LeftOut) -> Estimate | None:
        """Error by the mesh: by the level before where that is near enough, else by polynomials of one degree more."""
        found = self._models.at(level, left)
        by_cells = self._of_cells(level, left, found) if level > self._lowest else None
        if by_cells and by_cells.doubt <= self._within * abs(found.load):
            return by_cells
        if found.named:
            bar = found.bar()
            if bar.error is not None and not bar.reason:
                return Estimate(bar.error, abs(bar.error), f"{-bar.error / found.load:+.2%} by polynomials of one "
                                f"degree more than on {self._models.meshes.words(level)}")
            return by_cells and replace(
                by_cells, because=f"{by_cells.because} (no bar by a higher degree: {bar.reason})")
        return by_cells

    def _of_cells(self, level: int, left: LeftOut, found: FirstPoint) -> Estimate | None:
        """Error by the change from the level before: of second order, and doubted whole.

        Where the change before that was larger by a factor r, the error is the change over r - 1, and its doubt a
        quarter more (Roache 1998, grid convergence index); r counts as 4 at most, as of second order.
        """
        earlier = [self._models.at(n, left) for n in range(max(level - 2, self._lowest), level)]
        if any(one.failure or bool(one.point) != bool(found.point) for one in earlier):
            return None
        words, loads = self._models.meshes.words, [*(one.load for one in earlier), found.load]
        change = loads[-2] - loads[-1]
        said = f"{-change / found.load:+.2%} from {words(level - 1)} to {words(level)}"
        if len(loads) == 2 or not change or (ratio := (loads[0] - loads[1]) / change) < FALLING:
            return Estimate(change / 3, abs(change), said)
        error = change / (min(ratio, SECOND_ORDER) - 1)
        return Estimate(error, CONVERGING * abs(error), f"{said}, a change {ratio:.1f} times less than that before")

    def _of_integration(self, left: LeftOut) -> tuple[Estimate | None, bool]:
        """Error of a plastic load by layers, fibres and steps on the coarsest mesh, and whether that is unknown."""
        level = self._lowest
        if not any(map(is_plastic, left.scene(self._models.scene(level)).parts)):
            return None, False
        found, other = self._models.at(level, left), self._models.at(level, left, more=1)
        twice = f"twice as many layers or fibres and steps on {self._models.meshes.words(level)}"
        if found.failure or other.failure or other.refuted or bool(other.point) != bool(found.point):
            ends = other.failure or found.failure or (
                f"needs {', '.join(other.refuted)}" if other.refuted else
                f"has {'a' if other.point else 'no'} critical point, {'none' if other.point else 'one'} without")
            self._decide("layers and steps", "unknown", f"the path with {twice}: {ends}; the interval leaves them out")
            return None, True
        change = found.load - other.load
        return Estimate(change, abs(change), f"{-change / found.load:+.2%} by {twice}"), False

    def _advice(self, found: FirstPoint, level: int, left: LeftOut, estimate: Estimate | None, doubt: float,
                reached: bool, begun: float) -> Advice:
        mesh, load, half = self._models.meshes.words(level), found.load, abs(found.load)
        if estimate:
            load, half = found.load - estimate.error, max(doubt, LEAST * self._within * abs(found.load))
        worth = load / found.load - 1 if found.load else None
        self._decide("mesh", "enough" if reached else "too coarse",
                     estimate.because if estimate else f"{mesh} alone tells no error", worth)
        record, point = found.record, found.point
        for one in doubts(record.path.discretisation, record.states):
            warn(one)
        kind = (point.title if found.named else point.name) if point else (
            f"largest load, without a limit point or bifurcation up to the end ({record.path.message})")
        return Advice(load, (load - half, load + half), kind, reached, left, level, mesh, self._models.doubled,
                      tuple(self._decisions), time.process_time() - begun)

    def _stopped(self, level: int, left: LeftOut, begun: float) -> Advice:
        return Advice(None, None, "none", False, left, level, self._models.meshes.words(level), self._models.doubled,
                      tuple(self._decisions), time.process_time() - begun)
