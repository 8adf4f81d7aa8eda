"""Contact of points with surfaces as a contribution to the system."""

from __future__ import annotations

import numpy as np

from .. import forms
from .closest_point import ClosestPoint
from .pair_work import PairWork
from .point_law import EVERY, PointLaw
from .surface_partners import SECOND, SurfacePartners


class SurfaceLaw(PointLaw):
    """Law of contact in gap and slips, which are functions of z: the displacement of the points, and of the surface's
    with its derivatives, at the partners.

    Parameters
    ----------
    law : as `forms.contact.mohr_coulomb`
    partners : SurfacePartners
    points, distances : places in the reference configuration, and distances from the surface at which they touch
    history, table : as `PairWork` gives them to the law
    weights : of the points
    rubs : whether there are tractions
    """

    def __init__(self, law, partners: SurfacePartners, points: np.ndarray, distances: np.ndarray, history: np.ndarray,
                 table: np.ndarray, weights: np.ndarray, rubs: bool):
        slips, held = 2 * rubs, []

        def strains(values, data, factor):
            held[:] = data
            return forms.contact.strains_of([values[0][i] for i in range(3)], data[0], rubs)

        def resultants(strains):
            return forms.contact.resultants_of(law, strains, held[1], slips)

        self._partners, self._points, self._distances, self._slips = partners, points, distances, slips
        super().__init__(strains, resultants, [3], [history, table], len(points), lambda: 0.0, weights)

    def _closest(self, z: np.ndarray, points: np.ndarray | slice = EVERY) -> ClosestPoint:
        """Points and their partners, of all or of some."""
        rows = self._partners.undeformed(2).transpose(1, 0, 2) + z[:, 3:].reshape(-1, 6, 3)
        apart, curvatures = self._points + z[:, :3] - rows[:, 0], rows[:, SECOND]
        return ClosestPoint(apart[points], rows[points, 1:3], curvatures[points], self._partners.third()[points])

    def _kinematics(self, closest: ClosestPoint) -> np.ndarray:
        """Gaps and slips; points without a partner are as far off as the edge of the surface."""
        gap = self._partners.side * closest.distance - self._distances
        return np.column_stack((np.where(self._partners.on, gap, closest.length), self._partners.travelled))

    def _slopes(self, closest: ClosestPoint, points: np.ndarray | slice = EVERY) -> np.ndarray:
        gap = self._partners.side[points, None] * closest.of_distance()
        slips = np.einsum("nid,and->nia", self._partners.axes[points], self._partners.undeformed(1)[1:, points])
        return np.concatenate([gap[:, None], slips @ closest.moves], axis=1)

    def slopes(self, z):
        return self._slopes(self._closest(z))

    def strains(self, z):
        return super().strains(self._kinematics(self._closest(z)))

    def resultants(self, z):
        return super().resultants(self._kinematics(self._closest(z)))

    def forces(self, z):
        closest = self._closest(z)
        return np.einsum("ni,niz->nz", super().forces(self._kinematics(closest)), self._slopes(closest))

    def stiffness(self, z, points=EVERY):
        strains, closest = self._kinematics(self._closest(z)), self._closest(z, points)
        forces, slopes = super().forces(strains)[points], self._slopes(closest, points)
        found = slopes.transpose(0, 2, 1) @ super().stiffness(strains, points) @ slopes
        found += (forces[:, 0] * self._partners.side[points])[:, None, None] * closest.second_of_distance()
        if self._slips:
            rows = self._partners.undeformed(2)[:, points]
            along = np.einsum("ni,nid->nd", forces[:, 1:], self._partners.axes[points])
            found += closest.second_of_coordinates(np.einsum("nd,and->na", along, rows[1:3]))
            bent = np.einsum("nd,abnd->nab", along, rows[SECOND])
            found += closest.moves.transpose(0, 2, 1) @ bent @ closest.moves
        return found


class SurfaceWork(PairWork):
    """Virtual work of pressures and tractions between points and the surfaces that they slide along.

    `Pairs.gap` are the distances at which they touch; arms and axes of pairs do not count. Slips belong to the
    partners along the undeformed surface, on axes of their own.

    Where pressures are augmented each step ends with a high stiffness, so that the tangent has no flexibility of its
    own, and without friction begins with the one that the last step has ended with: few augmentations are needed then.
    Where that does not converge, it begins with the low one that is given, with which points that touch go on touching
    while Newton's iteration moves them.
    """

    _partners: SurfacePartners
    _slack = 1e-5
    _least = 3

    def _law_of(self, sizes):
        pairs, self._data_of_history = self.pairs, 0
        return SurfaceLaw(self.contact.law, self._partners, pairs.points, pairs.gap, self._history, pairs.table(),
                          pairs.weights, pairs.rubs)

    def _begin(self):
        self._partners.begin(self.pairs.points)

    def _find(self, values):
        return self._partners.follow(self.pairs.points + values[:, :3])

    def _slip(self, strains):
        return self._partners.travelled

    def _give_places(self):
        """The law asks the partners itself."""
