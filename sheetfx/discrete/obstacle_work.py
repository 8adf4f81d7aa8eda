"""Contact of points with rigid obstacles as a contribution to the system."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .. import forms
from ..model.obstacles import way_of
from .number import NumberField
from .pair_work import PairWork
from .point_law import PointLaw

CLOSE, STEPS = 1e-6, 200  # of the tolerance, by which a free obstacle is moved past first touch, in so many steps
DISTANCE, BEFORE, SLIPPED = 1, 2, 3  # numbers of data of the law: where points touch, places and slips accepted last


class ObstacleWork(PairWork):
    """Virtual work of pressures and tractions between points and a rigid obstacle.

    `Pairs.gap` are the distances at which points touch; arms and axes do not count. Slips are the motions past the
    obstacle, in the plane that touches it, in the directions of space.
    """

    _without = 0
    _slack = 1e-5
    _least = 3

    def _law_of(self, sizes):
        pairs, obstacle, slips = self.pairs, self.contact.obstacle, self._slips
        self._before, self._slipped = pairs.points.copy(), np.zeros_like(pairs.points)
        data = [pairs.points, pairs.gap[:, None], pairs.points, np.zeros_like(pairs.points), self._history,
                pairs.table()]
        self._data_of_history, held = len(data) - 2, []

        def strains(values, data, factor):
            held[:] = data
            points, distance, before, slipped, history, _ = data
            travelled = values[1][0] if len(values) > 1 else 0.0
            shift = [travelled * c for c in padded(way_of(obstacle), pairs.dimension)]
            gap, *passed = forms.contact.on_obstacle(obstacle.gap, points + values[0], shift, before, slipped)
            return forms.contact.strains_of([gap - distance[0], *passed], history, bool(slips))

        def resultants(strains):
            return forms.contact.resultants_of(self.contact.law, strains, held[-1], slips)

        return PointLaw(strains, resultants, sizes, data, pairs.count, lambda: 0.0, pairs.weights)

    def adjust(self, most: float) -> None:
        """Let points that are inside the obstacle by so much at most touch where they are."""
        gaps = self.place()
        self.pairs.gap = self.pairs.gap + np.where(gaps >= -most, np.minimum(gaps, 0.0), 0.0)
        self._law.give(DISTANCE, self.pairs.gap[:, None])

    def first_touch(self, title: str) -> None:
        """Move an obstacle that may travel to where it touches first, as stiffly as at the end of a step.

        One that another part has been touched by already is moved back where it would be inside this one.

        Raises
        ------
        ValueError
            If points are inside the obstacle at the start, or it does not travel towards them.
        """
        gaps, tolerance, field = self.place(), self.pairs.tolerance, self._unknowns.fields[self._traces[-1].field]
        moved = isinstance(field, NumberField) and field.value.x.array[0] != 0
        if gaps.min(initial=0.0) < -tolerance and not moved:
            place = ", ".join(f"{x:.6g}" for x in self.pairs.points[gaps.argmin()])
            raise ValueError(f"{title}: the face at ({place}) starts {-gaps.min():.6g} inside the "
                             f"{type(self.contact.obstacle).__name__}; move one of them, give a smaller distance, or "
                             "adjust= where it is an imperfection")
        if isinstance(field, NumberField) and not (moved and gaps.min(initial=0.0) > 0):
            self._approach(field, title)
        self._mark()

    def _approach(self, field: NumberField, title: str) -> None:
        tolerance = self.pairs.tolerance
        for _ in range(STEPS):
            smallest = self.place().min()
            if -tolerance <= smallest < 0:
                break
            field.start(float(field.value.x.array[0]) + smallest + CLOSE * tolerance)
        else:
            raise ValueError(f"{title}: the {type(self.contact.obstacle).__name__} meets none of the part's samples as "
                             f"it travels along {tuple(self.contact.obstacle.travel)}; turn its travel, or take more "
                             "samples")
        if self.pairs.augmented:
            self._growth.times = self._least
            self.regularise(1.0)

    def _mark(self) -> None:
        """Take the present places, seen from the obstacle, for those that slips are counted from."""
        d, z = self.pairs.dimension, self.values()
        self._before = self.pairs.points + z[:, :d]
        if len(self._fields) > 1:
            self._before -= z[:, d:] * padded(way_of(self.contact.obstacle), d)
        self._since()

    def _since(self) -> None:
        """Count slips from the places and slips of the last accepted state."""
        for number, values in zip((BEFORE, SLIPPED), (self._before, self._slipped), strict=True):
            self._law.give(number, values)

    def commit(self):
        if self._slips:
            self._slipped = self._slip(self._law.strains(self.values()))
        super().commit()
        self._mark()

    def snapshot(self):
        return super().snapshot() | {f"{self._name} places": self._before.copy(),
                                     f"{self._name} slips": self._slipped.copy()}

    def restore(self, snapshot):
        self._before, self._slipped = (snapshot[f"{self._name} {what}"].copy() for what in ("places", "slips"))
        super().restore(snapshot)
        self._since()


def padded(vector: Sequence[float] | None, dimension: int) -> np.ndarray:
    """A vector with as many components as space has dimensions; None: zero."""
    found = np.zeros(dimension)
    if vector is not None:
        found[:len(vector)] = vector
    return found
