"""Contact of two deformable parts at pairs of points as a contribution to the system, with what it remembers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from mpi4py import MPI
from scipy.sparse import csr_matrix

from .. import forms
from ..communicators import lasting
from ..rounding import SAME
from .contact import OPEN, SLIP, STICK
from .contribution import Contribution
from .growth import Growth
from .layout import Layout
from .pairs import Pairs, PairState
from .partners import Partners, turned
from .point_law import PointLaw
from .points import PointWork, Trace
from .unknowns import Unknowns

SPARE = 0.2  # of all pairs, those with the smallest gaps that the pattern of the tangent has beside those that act
LITTLE = 1e-4  # of the largest displacement in a step, or change of a pressure, penetration that augmenting leaves
STICKING = 1e3  # coefficient of friction with which pairs stick
BEYOND = 1e-7  # of the bound, by which tractions that slip are kept beyond it, so that they slip on in the next tangent


class PairWork(PointWork):
    """Virtual work of pressures and tractions between pairs of points.

    Parameters
    ----------
    unknowns : Unknowns
    first : traces of the first part: displacement and, where it has one, rotation
    second : trace of the second part's displacement, or partners that follow the first part's points; None: an obstacle
        without unknowns
    pairs : Pairs
    contact : PairContact, which has the law
    name : of its history in snapshots
    """

    called, detours = "contact", (1e2, 1e1)
    _without = 1  # directions along which no slip is counted: that out of the first part's face
    _least = 0  # how often the stiffness grows within a step at least, see `Growth`
    _slack = 0.0  # part of the bound of friction by which tractions may be off where they slip
    _apart: np.ndarray  # gaps where a step starts

    def __init__(self, unknowns: Unknowns, first: Sequence[Trace], second: Trace | Partners | None, pairs: Pairs,
                 contact, name: str):
        self.contact, self._first, self.pairs, self._name = contact, list(first), pairs, name
        n = self._directions = pairs.dimension - self._without
        self._partners = None if second is None or isinstance(second, Trace) else second
        if self._partners:
            self._begin()
        traces = [*first, *(self._partners.traces() if self._partners else [second] if second else [])]
        self._slips, self._history = n if pairs.rubs else 0, np.zeros((pairs.count, 1 + 2 * n))
        points = self._law_of([unknowns.fields[t.field].components for t in traces])
        super().__init__(unknowns, traces, points, smooth=False, conservative=not self._slips)
        self._growth = Growth(self._least if pairs.augmented else 0, pairs.rubs)
        self.rubs = pairs.rubs
        self.augments = pairs.augmented
        self._slip_left = pairs.tolerance * pairs.parameters[0] / pairs.parameters[1]
        self.tolerance = (self._slip_left if self.rubs else pairs.tolerance) if pairs.augmented else 0.0
        self.sticks = contact.law is forms.contact.mohr_coulomb
        self._committed, self._elastic = self._history.copy(), np.zeros((pairs.count, 1 + self._slips))
        self._partners_committed = self._partners.history() if self._partners else None
        self._pattern_nodes = self._seen = None
        self._table, self._left_open = pairs.table(), np.zeros(pairs.count, dtype=bool)
        self._law.weigh(pairs.weights * self._here)

    def _begin(self) -> None:
        """Bring the partners to where they are opposite before anything moves."""
        self._partners.begin(self.pairs.points, self.pairs.axes[:, 1])

    def _law_of(self, sizes: Sequence[int]) -> PointLaw:
        """Forces at the pairs, from so many components of each trace."""
        pairs, law, slips, split = self.pairs, self.contact.law, self._slips, len(self._first)
        moving = self._partners is not None
        geometry = self._geometry() if moving else [pairs.arms]
        self._arms = geometry[0]
        data = [*geometry, pairs.axes.reshape(pairs.count, -1), self._start(), self._history, pairs.table()]
        self._data_of_start, self._data_of_history = len(data) - 3, len(data) - 2

        def strains(values, data, factor):
            self._parameters = data[-1]
            if moving:
                kinematics = forms.contact.on_moving_partner(values[:split], values[split:], *data[:5])
            else:
                kinematics = forms.contact.on_fixed_partner(values[:split], values[split:], data[0], data[1],
                                                            data[2][0])
            return forms.contact.strains_of(kinematics, data[-2], bool(slips))

        def resultants(strains):
            return forms.contact.resultants_of(law, strains, self._parameters, slips)

        return PointLaw(strains, resultants, sizes, data, pairs.count, lambda: 0.0, pairs.weights)

    def _geometry(self) -> list[np.ndarray]:
        place, *derivatives = self._partners.geometry()
        return [place - self.pairs.points, *derivatives]

    def _start(self) -> np.ndarray:
        if self._partners is None:
            return self.pairs.gap[:, None]
        places = np.einsum("nij,nj->ni", self.pairs.axes, self._arms)
        return np.column_stack((self.pairs.gap, places, self._partners.travelled))

    def _followed(self) -> np.ndarray:
        """Values of the traces, the partners having been brought to where they are opposite now."""
        values = super().values()
        if self._partners and self._find(values):
            self._renew()
            return super().values()
        return values

    def _find(self, values: np.ndarray) -> bool:
        """Find partners for values of the traces; whether any has changed."""
        along = self.pairs.axes[:, 1]
        along = turned(values[:, self._parts[1]], along) if len(self._first) > 1 else along
        return self._partners.follow(self.pairs.points + values[:, :self.pairs.dimension], along)

    def _renew(self) -> None:
        """Take rows and places of the partners as they are now."""
        self._traces[len(self._first):] = self._partners.traces()
        self._give_places()
        self._law.weigh(self.pairs.weights * self._partners.on)

    def _give_places(self) -> None:
        for number, array in enumerate(self._geometry()):
            self._law.give(number, array)
        self._law.give(self._data_of_start, self._start())

    def values(self) -> np.ndarray:
        tables = [f.table for f in self._fields[:len(self._first) + 1]]
        if self._seen is None or not all(map(np.array_equal, tables, self._seen[0])):
            self._seen = [table.copy() for table in tables], self._followed()
        return self._seen[1]

    def extrapolate_stress(self) -> None:
        """Pressures have no linear change to be extrapolated by."""

    def pattern(self, layout: Layout):
        """Entries of pairs that act or may do so next, and of those that share theirs, on the same unknowns."""
        self._layout = layout
        acting, gap = self._acting()
        near = np.argsort(np.where(acting, -np.inf, gap), kind="stable")
        alike = np.unique(self._numbers(layout), axis=0, return_inverse=True)[1].ravel()
        self._stiff = np.flatnonzero(np.isin(alike, alike[near[:acting.sum() + int(SPARE * len(near)) + 1]]))
        self._pattern_nodes = [t.nodes for t in self._traces]
        return super().pattern(layout)

    @property
    def moved(self) -> bool:
        """Whether pairs act that the pattern does not have, or has with other partners."""
        if self._pattern_nodes is None:
            return False
        acting, kept = self._acting()[0], np.zeros(self.pairs.count, dtype=bool)
        kept[self._stiff] = True
        return bool(np.any(acting & ~kept)) or any((t.nodes[acting] != nodes[acting]).any() for t, nodes in zip(
            self._traces, self._pattern_nodes, strict=True))

    def _acting(self) -> tuple[np.ndarray, np.ndarray]:
        """Whether pairs touch or have forces, and their gaps."""
        z = self.values()
        gap = self._law.strains(z)[:, 0]
        return (gap <= 0) | self._forces(z).any(axis=1), gap

    def _linearised(self, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        pairs = np.arange(self.pairs.count)[self._stiff]
        acting, stiffness = self._acting()[0] & ~self._left_open, np.zeros((len(pairs), z.shape[1], z.shape[1]))
        acting = acting[pairs]
        stiffness[acting] = self._law.stiffness(z, pairs[acting])
        return self._forces(z), stiffness

    def motions(self) -> csr_matrix:
        """Derivatives of gaps and slips by the increments of all processes, pair by pair."""
        matrix = self._law.slopes(self.values())[:, :1 + self._slips] @ self._derivatives()
        columns = np.broadcast_to(self._numbers(self._layout)[:, None, :], matrix.shape)
        free = columns >= 0
        ends = np.append(0, np.cumsum(free.sum(axis=2)))
        return csr_matrix((matrix[free], columns[free], ends), shape=(len(ends) - 1, self._layout.global_size))

    def across(self) -> tuple[csr_matrix, np.ndarray]:
        """Derivatives of gaps, as in `motions`, and the stiffnesses across them at the end of a step."""
        stiffness = self.pairs.table()[:, 0] * self._growth.reached * self.pairs.weights * self._here
        return self.motions()[::1 + self._slips], stiffness

    def leave_open(self, pairs: np.ndarray) -> None:
        """Leave the stiffness of some pairs out of tangents.

        Parameters
        ----------
        pairs : whether to, for each
        """
        self._left_open = pairs

    def _put_history(self, history: np.ndarray) -> None:
        self._history = history
        self._law.give(self._data_of_history, history)

    def _now(self) -> tuple[np.ndarray, np.ndarray]:
        """Strains and resultants now."""
        z = self.values()
        return self._law.strains(z), self._law.resultants(z)

    def _updated(self, pressures: bool, slips: bool) -> np.ndarray:
        """The memory of now: pressures that are augmented, tractions, and slips that these belong to."""
        strains, resultants = self._now()
        history, n = self._history.copy(), self._slips
        if pressures:
            history[:, 0] = -resultants[:, 0]
        if n:
            history[:, 1:1 + n] = resultants[:, 1:1 + n]
            if slips:
                kept = self._kept_slips(strains)
                history[:, 1 + n:1 + 2 * n] += strains[:, 1:1 + n] - kept
                history[:, 1:1 + n] -= self._table[:, 1:2] * kept
        return history

    def _kept_slips(self, strains: np.ndarray) -> np.ndarray:
        """Slips of pairs that stick, which augmentation takes back: they would add up to creeping from step to step."""
        slips = strains[:, 1:1 + self._slips]
        if not self.augments:
            return np.zeros_like(slips)
        return np.where((self.evaluate().status == STICK)[:, None], slips, 0.0)

    def update_history(self, pressures: bool = False) -> bool:
        history, slipping = self._updated(pressures, slips=True), self.evaluate().status == SLIP
        history[slipping, 1:1 + self._slips] *= 1 + BEYOND
        self._put_history(history)
        return bool(self._slips and slipping.any())

    def commit(self) -> None:
        self.update_history(self.augments)
        self._growth.commit()
        self._committed = self._history.copy()
        if self.augments:
            strains, pressed = self._law.strains(self.values()), self._history[:, 0] > 0
            self._elastic = strains[:, :1 + self._slips] * np.where(np.arange(1 + self._slips), -1.0, 1.0)
            self._elastic[~pressed, 0] = self._committed[~pressed, 0] = 0.0
            self._committed[:, 1:1 + self._slips] -= self._table[:, 1:2] * self._elastic[:, 1:]
        self.regularise(1.0)
        self._put_history(self._begun())
        if self._partners:
            self._partners.commit()
            self._partners_committed = self._partners.history()

    def snapshot(self) -> dict[str, np.ndarray]:
        kept = {self._name: np.column_stack((self._committed, self._elastic))}
        if self._partners:
            kept[f"{self._name} partners"] = self._partners_committed.copy()
        if self.augments:
            kept[f"{self._name} stiffness"] = np.array(self._growth.kept)
        return kept

    def origins(self) -> dict[str, np.ndarray]:
        return {name: np.arange(len(rows)) for name, rows in self.snapshot().items()}

    @property
    def retreats(self) -> bool:  # type: ignore[override]
        return self._growth.retreats

    def retreat(self) -> None:
        self._growth.retreat()

    @property
    def turns_round(self) -> bool:  # type: ignore[override]
        return self._growth.turns_round

    def turn_round(self) -> None:
        self._growth.turn_round()

    def restore(self, snapshot: dict[str, np.ndarray]) -> None:
        self._committed, self._elastic = np.hsplit(snapshot[self._name], [self._history.shape[1]])
        if self._partners:
            self._partners_committed = snapshot[f"{self._name} partners"].copy()
        if self.augments:
            self._growth.restore(*map(int, snapshot[f"{self._name} stiffness"]))
        self.rewind()

    def rewind(self) -> None:
        self._growth.rewind()
        self.regularise(1.0)
        self._put_history(self._begun())
        self._return_partners()

    def _begun(self) -> np.ndarray:
        """History that a step begins with: the last accepted state's at present stiffnesses."""
        history, normal_and_along = self._committed.copy(), np.arange(1 + self._slips).clip(max=1)
        history[:, :1 + self._slips] += self._table[:, normal_and_along] * self._elastic
        return history

    def _return_partners(self) -> None:
        """Have the partners of the last accepted state."""
        if self._partners:
            self._partners.restore(self._partners_committed)
            self._renew()
            self._seen = None

    def regularise(self, times: float) -> None:
        """Make all pairs softer: where parts touch along a line without a gap, all pairs close or open at once."""
        self._table = self.pairs.table()
        self._table[:, :2] *= self._growth.factor / times
        self._law.give(self._data_of_history + 1, self._table)

    def foresee(self, ahead: bool) -> None:
        """Let open pairs slip from where they will touch, which lies on the line to where the tangent leads."""
        (strains, resultants), n = self._now(), self._slips
        if not ahead:
            self._apart = np.where(resultants[:, 0] == 0.0, strains[:, 0], 0.0)  # tension may hold pairs that gape
            return
        apart, closing, history = self._apart, self._apart - strains[:, 0], self._history.copy()
        part = np.divide(apart, closing, out=np.ones_like(apart), where=closing > np.maximum(apart, 0.0))
        part[apart <= self.pairs.tolerance] = 0.0
        history[:, 1 + n:1 + 2 * n] += part[:, None] * strains[:, 1:1 + n]
        self._return_partners()
        self._put_history(history)

    def stick(self) -> None:
        held = self._table.copy()
        held[:, 2:4] *= STICKING
        self._law.give(self._data_of_history, self._updated(False, slips=True))
        self._law.give(self._data_of_history + 1, held)

    def release(self) -> None:
        self._law.give(self._data_of_history, self._history)
        self._law.give(self._data_of_history + 1, self._table)

    def augment(self) -> bool:
        if not self.augments:
            return True
        strains, resultants = self._now()
        gap, pressed, sticks = strains[:, 0], resultants[:, 0] < 0, self.evaluate().status == STICK
        slips = np.linalg.norm(strains[sticks, 1:1 + self._slips], axis=1).max(initial=0.0)
        deepest = max(-gap.min(initial=0.0), gap[pressed].max(initial=0.0))
        fine = deepest <= self.pairs.tolerance and slips <= self._slip_left and self._growth.suffices
        if fine and self._is_little(deepest, -resultants[:, 0]):
            return True
        self._put_history(self._updated(True, slips=False))
        self._growth.go_on(deepest)
        self.regularise(1.0)
        return False

    def _is_little(self, deepest: float, pressures: np.ndarray) -> bool:
        """Whether penetrations are little beside motions of the step, or what they stand for beside changed pressures.

        Otherwise parts that hardly move do so as softly as penetrations make them, and back when these are taken away.
        """
        numbers = dict.fromkeys(t.field for t in (self._traces[0], *self._traces[len(self._first):]))
        fields = [self._unknowns.fields[number] for number in numbers]
        moved = max(lasting(f.index_map.comm).allreduce(
            float(np.abs(f.value.x.array - f.previous.x.array).max(initial=0.0)), op=MPI.MAX) for f in fields)
        changed = np.abs(pressures - self._committed[:, 0]).max(initial=0.0)
        little = max(LITTLE * moved, SAME * fields[0].scale)
        return deepest <= little or self._table[0, 0] * deepest <= LITTLE * changed

    def energy(self) -> float | None:
        """Energy of pressures and of tractions that stick; what is augmented is as good as rigid, and stores none."""
        if (now := self.touch()) is None:
            return None
        return float((self.pairs.weights * self._here) @ self.pairs.stored(now))

    def place(self) -> np.ndarray:
        """Gaps now."""
        return self._law.strains(self.values())[:, 0]

    def gaps(self) -> np.ndarray:
        """Distances now; of augmented pairs those at which the trial pressure would be zero, which change sign too."""
        if not self.augments:
            return np.where(self._here, self.place(), np.nan)
        found = self.touch()
        return np.empty(0) if found is None else np.where(self._here, -found[:, 1] / self._table[:, 0], np.nan)

    def smallest_gap(self) -> float:
        """Smallest gap of the pairs that have a partner; infinite where none has."""
        return float(self.place()[self._here].min(initial=np.inf))

    def touch(self) -> np.ndarray | None:
        """Gaps, trial pressures, tractions and slips in the columns; None for laws whose work is not known."""
        if self.contact.law is not forms.contact.mohr_coulomb:
            return None
        (strains, resultants), n = self._now(), self._slips
        trial = self._history[:, 0] - self._table[:, 0] * strains[:, 0]
        return np.column_stack((strains[:, 0], trial, resultants[:, 1:1 + n], self._slip(strains)[:, :n]))

    def work_between(self, start: np.ndarray, end: np.ndarray) -> float:
        return float((self.pairs.weights * self._here) @ self.pairs.work(start, end, self._growth.reached, self._slack))

    def apart(self) -> bool:
        return not (self._acting()[0] & self._here).any()

    def touching(self) -> tuple[int, float]:
        state = self.evaluate()
        return int((state.status != OPEN).sum()), float(-state.gap[self._here].min(initial=0.0))

    @property
    def _here(self) -> np.ndarray:
        """Pairs that have a partner."""
        return self._partners.on if self._partners else np.ones(self.pairs.count, dtype=bool)

    def evaluate(self) -> PairState:
        """State of the pairs in the current configuration."""
        z, d, n = self.values(), self.pairs.dimension, self._slips
        strains, resultants = self._law.strains(z), self._law.resultants(z)
        pressure = np.where(self._here, -resultants[:, 0], 0.0)
        traction = resultants[:, 1:1 + n] * self._here[:, None] if n else np.zeros((len(z), self._directions))
        return self.pairs.state(z[:, :d], strains[:, 0], pressure, traction, self._slip(strains), self._here,
                                self._slack)

    def _slip(self, strains: np.ndarray) -> np.ndarray:
        """Slip since the beginning; without friction it is not known."""
        n = self._slips
        return strains[:, 1:1 + n] + self._history[:, 1 + n:] if n else np.zeros((len(strains), self._directions))


def pairs_of(contributions: Sequence[Contribution]) -> list[PairWork]:
    """The contacts between deformable parts among contributions."""
    return [c for c in contributions if isinstance(c, PairWork)]
