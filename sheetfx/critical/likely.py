"""Quantiles of critical loads of structures with random imperfections, by few of them.

The coefficients of shapes are independent and normal. A normal process through the loads that are known (`Kriging`)
tells the others, and how well it knows each. The next load that is looked for is the one of which it knows least on
which side of the quantile it lies: the least distance from the quantile over its standard deviation (Echard, Gayton and
Lemaire 2011; for quantiles Schoebi, Sudret and Marelli 2017). Draws of the process give the quantile's median and
interval.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import norm, qmc

from .kriging import Kriging

if TYPE_CHECKING:
    from .worst import ImperfectLoad

TAIL = 100  # places below the quantile, among those that loads are looked for at
FINER = 32  # times as many places that the mean is known at
DRAWS, DRAWN = 200, 800  # of the process, and places of each next to the quantile


@dataclass(frozen=True)
class LoadQuantile:
    """A load that critical loads are below with a given probability.

    Attributes
    ----------
    probability : that the load is less
    load : the likeliest value, a median
    interval : of the load, in which it lies with a probability of 95 %
    samples : what was looked at
    """

    probability: float
    load: float
    interval: tuple[float, float]
    samples: tuple[ImperfectLoad, ...]

    def __str__(self) -> str:
        low, high = self.interval
        return f"{100 * self.probability:g} % of loads are below {self.load:.6g} ({low:.6g} to {high:.6g})"


def load_quantile(at: Callable[[Sequence[float]], ImperfectLoad], count: int, probability: float, deviation: float,
                  samples: int, seed: int) -> LoadQuantile:
    """Load that critical loads are below with a probability.

    Parameters
    ----------
    at : function from coefficients to the load; one that is infinite counts as the largest
    count : of the coefficients
    deviation : standard deviation of each coefficient
    samples : number of loads that are looked for, of which one half are spread as the coefficients are
    seed : of the places

    Raises
    ------
    ValueError
        If no load is finite.
    """
    exponent = int(np.ceil(np.log2(max(TAIL / probability, samples))))
    sequence = qmc.Sobol(count, rng=np.random.default_rng(seed))
    places = norm.ppf(sequence.random_base2(exponent))
    which = list(range((samples + 1) // 2))
    found = [at(deviation * places[n]) for n in which]
    while len(which) < samples:
        process = Kriging(places[which], _finite(found))
        doubt = _doubt(process, places, process.mean(places), probability)
        doubt[which] = np.inf
        which.append(int(np.argmin(doubt)))
        found.append(at(deviation * places[which[-1]]))
    process = Kriging(places[which], loads := _finite(found))
    mean = process.mean(places)
    doubt = _doubt(process, places, mean, probability)
    finer = np.concatenate([process.mean(norm.ppf(part)) for part in
                            np.array_split(sequence.random((FINER - 1) * len(places)), FINER)])
    shift = np.quantile([*mean, *finer], probability) - np.quantile(mean, probability)
    mean[which], doubt[which] = loads, np.inf
    near = np.argsort(doubt)[:min(DRAWN, len(places) - len(which))]
    drawn = np.tile(mean, (DRAWS, 1))
    drawn[:, near] = process.draws(places[near], DRAWS, np.random.default_rng(seed))
    low, load, high = map(float, shift + np.quantile(np.quantile(drawn, probability, axis=1), (0.025, 0.5, 0.975)))
    return LoadQuantile(probability, load, (low, high), tuple(found))


def _doubt(process: Kriging, places: np.ndarray, mean: np.ndarray, probability: float) -> np.ndarray:
    """Distances of expected loads from their quantile, over their standard deviations."""
    return np.abs(mean - np.quantile(mean, probability)) / process.deviation(places)


def _finite(found: Sequence[ImperfectLoad]) -> np.ndarray:
    loads = np.array([one.load for one in found])
    if not (known := np.isfinite(loads)).any():
        raise ValueError(f"quantile: none of {len(loads)} imperfections has a critical point; let their paths go "
                         "further, or take other shapes")
    return np.where(known, loads, loads[known].max())
