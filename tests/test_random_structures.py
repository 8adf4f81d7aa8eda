"""Random trusses and frames: all critical points as an independent dense continuation finds them, and no others."""

import numpy as np
import pytest
import random_shapes
from comparison import compare
from random_structures import dense

TRUSSES, FRAMES = 120, 80
DOUBTFUL = {
    "truss 72": "two pairs of points whose loads differ by 1.05e-6 are two double ones, or not, as steps fall",
}
UNDECIDED = 8  # structures whose dense continuation depends on its steps, at most


@pytest.mark.parametrize("make, seed", [("truss", 0), ("truss", 3), ("frame", 1), ("frame", 2)])
def test_dense_tangent_is_the_derivative_of_the_gradient(make, seed):
    problem = dense(getattr(random_shapes, make)(seed))
    size, step = len(problem.load), 1e-6
    q = 0.05 * np.random.default_rng(1).normal(size=size)
    differences = [(problem.derivatives(q + move)[0] - problem.derivatives(q - move)[0]) / (2 * step)
                   for move in step * np.eye(size)]
    hessian = problem.derivatives(q)[1]
    assert np.abs(np.array(differences) - hessian).max() < 1e-8 * np.abs(hessian).max()


@pytest.mark.parametrize("make, seed", [
    ("truss", 2), ("truss", 5), ("truss", 11), ("frame", 11), ("frame", 12),
    *(pytest.param("truss", seed, marks=pytest.mark.slow) for seed in (108, 118))])
@pytest.mark.slow(quick=1)
def test_a_few(make, seed):
    """A limit, close and double bifurcations, and a frame that sways; loops that a step may leave out (108, 118)."""
    found = compare(getattr(random_shapes, make)(seed))
    assert found.points and not found.undecided and not found.differences, str(found)


@pytest.mark.slow
def test_two_hundred():
    """None missed and none invented but for those that are listed; prints every difference."""
    differing, undecided = {}, []
    for make, count in (("truss", TRUSSES), ("frame", FRAMES)):
        for seed in range(count):
            found = compare(getattr(random_shapes, make)(seed))
            if found.undecided:
                undecided.append(str(found))
            elif found.differences:
                differing[f"{make} {seed}"] = str(found)
    print("\n".join([*differing.values(), *undecided]))
    assert len(undecided) <= UNDECIDED, undecided
    assert set(differing) <= set(DOUBTFUL), differing
