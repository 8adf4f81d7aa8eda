"""Critical points found directly from a guess, against those that paths find."""

from __future__ import annotations

from math import cos, radians, sin

import numpy as np
import pytest
from failure_map.traps import TRAPS
from helpers import on_two_processes

import sheetfx as fx
from sheetfx.scenes import dome, lee_frame, roof, von_mises_truss


def below(case, share, number=0):
    """A critical point of a case's path, and a state at a share of its load on the way there."""
    states, found = [], []
    for state in fx.Path(case.scene, case.control, case.until):
        states.append(state)
        found += state.critical
        if len(found) > number:
            break
    point = found[number]
    start = [s for s in states if s.step < point.step and abs(s.load) <= share * abs(point.load)][-1]
    factor = share * point.load * states[1].factor / states[1].load
    *_, guess = fx.Path(case.scene, fx.LoadControl(step=abs(factor - start.factor), target=factor), start=[start])
    return point, guess


@pytest.mark.parametrize("case, most, tilt", [
    (lambda: von_mises_truss.case(), 4, 0.0), (lambda: von_mises_truss.case(), 4, 20.0),
    (lambda: roof.case(cells=4), 6, 0.0), (lambda: roof.case(cells=4), 6, 20.0),
    pytest.param(lambda: dome.case(divisions=4), 6, 0.0, marks=pytest.mark.slow),
    pytest.param(lambda: dome.case(divisions=4), 6, 20.0, marks=pytest.mark.slow)],
    ids=["truss", "truss-tilted", "roof", "roof-tilted", "dome", "dome-tilted"])
@pytest.mark.slow(quick=1)
def test_from_a_guess_5_percent_below(case, most, tilt):
    """The mode is given, exactly or 20 degrees off: the path's point within 1e-8, in few factorisations."""
    case = case()
    point, guess = below(case, 0.95)
    path = fx.Path(case.scene, start=[guess])
    one, other = modes_at(path, guess)
    found = fx.critical(path, guess, cos(radians(tilt)) * one + sin(radians(tilt)) * other)
    assert found.point.kind == point.kind and found.point.name == (point.name if point.kind == "bifurcation" else "")
    assert found.point.load == pytest.approx(point.load, rel=1e-8)
    assert found.point.deflection == pytest.approx(point.deflection, rel=1e-6)
    assert found.factorisations <= most
    assert found.unfolding < 1e-10


def modes_at(path, state):
    """The two modes nearest to zero at a state."""
    path.tracer.factorise_at(state)
    values, modes = path.tracer.spectrum(2)
    return [modes[k].array for k in np.argsort(np.abs(values))]


@pytest.mark.parametrize("name, number", [("augusti-0.1-percent", 0), ("close-modes-0.1-percent", 0), ("star-dome", 2)])
@pytest.mark.parametrize("tilt", [0.0, 20.0])
@pytest.mark.slow(quick=1)
def test_points_close_together(name, number, tilt):
    """Others lie within 0.1 %, or are the same: with their modes in the border, in at most 6 factorisations."""
    case = TRAPS[name].case()
    point, guess = below(case, 0.95, number)
    path = fx.Path(case.scene, start=[guess])
    one, other = modes_at(path, guess)
    mode = cos(radians(tilt)) * one + sin(radians(tilt)) * other if point.multiplicity == 1 else None
    found = fx.critical(path, guess, mode, multiplicity=point.multiplicity, beside=1)
    assert found.point.kind == point.kind and found.point.name == point.name
    assert found.point.multiplicity == point.multiplicity
    assert found.point.load == pytest.approx(point.load, rel=1e-8)
    assert found.factorisations <= 6


def test_a_mode_that_passes_zero_close_by_belongs_to_the_border():
    """It is taken there where no mode is given."""
    case = TRAPS["augusti-0.1-percent"].case()
    point, guess = below(case, 0.95)
    with pytest.raises(fx.NoCriticalPoint, match="more modes beside"):
        fx.critical(case.scene, guess, beside=0)
    found = fx.critical(case.scene, guess)
    assert found.point.load == pytest.approx(point.load, rel=1e-8) and found.point.multiplicity == 1


@pytest.mark.parametrize("name, number", [
    ("star-dome", 2), ("close-modes-exact", 0), ("whole-ring", 0)])
def test_a_double_point_that_is_asked_for_as_a_simple_one(name, number):
    """Its multiplicity is found: a second null vector left out would name it by one branch of several."""
    case = TRAPS[name].case()
    point, guess = below(case, 0.95, number)
    found = fx.critical(case.scene, guess)
    assert (found.point.multiplicity, found.point.name) == (2, "multiple") == (point.multiplicity, point.name)
    assert found.point.load == pytest.approx(point.load, rel=2e-8), "each is exact to 1e-8"


def test_points_that_are_asked_for_as_one_multiple_point():
    """Nothing is singular at the mean of two loads."""
    case = TRAPS["augusti-0.1-percent"].case()
    _, guess = below(case, 0.95)
    with pytest.raises(fx.NoCriticalPoint, match="the tangent has . null vectors and not 2.*ask for fewer"):
        fx.critical(case.scene, guess, multiplicity=2)


def test_convergence_is_quadratic():
    """Each correction is about the square of the one before, where no rounding is left."""
    _, guess = below(roof.case(cells=4), 0.95)
    sizes = [step.correction for step in fx.critical(roof.case(cells=4).scene, guess).iterations]
    orders = np.log(sizes[2:]) / np.log(sizes[1:-1])
    assert (orders > 1.6).all()
    assert sizes[-1] < 1e-8


def test_limit_points_of_a_frame():
    """Lee's frame: maximum and minimum from the state before each, 2 and 8 % off in load, 11 and 7 in deflection."""
    record = fx.trace(lee_frame.case())
    by_step = {state.step: state for state in record.states}
    points = [point for state in record.states for point in state.critical]
    for point in points[:2]:
        found = fx.critical(record.path, by_step[point.step - 1])
        assert found.point.kind == "limit"
        assert found.point.load == pytest.approx(point.load, rel=1e-8)
        assert found.point.deflection == pytest.approx(point.deflection, rel=1e-6)


def test_branches_start_at_a_point_found_directly():
    """State and mode are those that a path goes on with: a step along the mode raises no residual of first order."""
    case = von_mises_truss.case()
    point, guess = below(case, 0.9)
    found = fx.critical(case.scene, guess)
    assert found.state.load == found.point.load
    assert found.point.curvature == pytest.approx(point.curvature, rel=1e-6)


@pytest.mark.slow
def test_two_processes():
    lines = on_two_processes("""
import sheetfx as fx
from test_augmented import below
from sheetfx.scenes import roof
point, guess = below(roof.case(cells=4), 0.95)
print(point.load, fx.critical(roof.case(cells=4).scene, guess).point.load)
""")
    path, direct = map(float, lines[0].split())
    assert direct == pytest.approx(path, rel=1e-8)


def test_refusals():
    case = von_mises_truss.case()
    path = fx.Path(case.scene)
    states = [next(iter(path))]
    with pytest.raises(ValueError, match="critical: kind is 'fold'; it must be"):
        fx.critical(path, states[0], kind="fold")
    with pytest.raises(ValueError, match="critical: a mode has 3 increments and the structure"):
        fx.critical(path, states[0], np.ones(3))
    with pytest.raises(ValueError, match="critical: a mode has no free increments"):
        fx.critical(path, states[0], np.zeros(len(states[0].increment)))
