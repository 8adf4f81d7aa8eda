"""A normal process through values, against formulas and its own draws."""

import numpy as np
import pytest

from sheetfx.critical.kriging import Kriging


def smooth(x: np.ndarray) -> np.ndarray:
    return np.sin(x[:, 0]) + 0.3 * x[:, 1] ** 2


def test_values_are_met_and_what_lies_between_is_near():
    x = np.random.default_rng(0).uniform(-1.5, 1.5, (30, 2))
    process = Kriging(x, smooth(x))
    assert process.mean(x) == pytest.approx(smooth(x), abs=1e-4)
    between = np.random.default_rng(1).uniform(-1.0, 1.0, (200, 2))
    off = np.abs(process.mean(between) - smooth(between))
    assert off.max() < 0.01
    assert np.mean(off <= 1.96 * process.deviation(between) + 1e-6) > 0.85


def test_far_away_it_is_the_level_with_the_deviation_of_the_values():
    x = np.random.default_rng(0).standard_normal((40, 2))
    process = Kriging(x, smooth(x))
    far = np.full((1, 2), 1e3)
    assert process.deviation(far)[0] > process.deviation(x).max()
    assert process.mean(far) == pytest.approx(process.mean(-far))


def test_draws_have_mean_and_deviation():
    random = np.random.default_rng(2)
    x = random.uniform(-2.0, 2.0, (12, 1))
    process = Kriging(x, np.abs(x[:, 0]))
    places = np.linspace(-2.5, 2.5, 9)[:, None]
    drawn = process.draws(places, 4000, random)
    assert drawn.mean(axis=0) == pytest.approx(process.mean(places), abs=0.05)
    assert drawn.std(axis=0) == pytest.approx(process.deviation(places), rel=0.1)


def test_values_that_are_all_one_are_known():
    process = Kriging(np.eye(3), np.full(3, 2.0))
    assert process.mean(np.zeros((1, 3))) == pytest.approx(2.0)
    assert process.deviation(np.zeros((1, 3)))[0] < 1e-4
