"""Shell benchmarks: end values, published points, and paths that do not depend on the step."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sheetfx import forms
from sheetfx.case import trace
from sheetfx.scenes import (
    cantilever,
    diaphragm_cylinder,
    hemisphere,
    pinched_cylinder,
    pull_out,
    roll_up,
    roof,
    scordelis_lo,
    semi_cylinder,
    slit_annulus,
)
from sheetfx.scenes._benchmark import at_load


def run(module, **parameters):
    case = module.case(**parameters)
    record = trace(case)
    return record, case.quantities(record)


def largest_error(values, reference):
    return max(abs(values[name] / value - 1) for name, value in reference.items())


@pytest.mark.parametrize(("module", "parameters", "tolerance"), [
    (cantilever, {"cells": 4}, 1e-3),
    (slit_annulus, {"cells": 15}, 2e-3),
    (hemisphere, {"cells": 8}, 1e-2),
    (pull_out, {"cells": 8}, 1e-2),
    pytest.param(semi_cylinder, {"cells": 8}, 3e-3, marks=pytest.mark.slow),
    (roof, {"cells": 4}, 1e-3),
    (pinched_cylinder, {"cells": 12, "steps": 0}, 1e-2),
    (scordelis_lo, {"cells": 4, "steps": 0}, 1e-3),
])
@pytest.mark.slow(quick=3)
def test_end_values_on_a_coarse_mesh(module, parameters, tolerance):
    """Tolerance: a little more than the mesh error, measured against the references."""
    record, values = run(module, **parameters)
    assert record.states[0].unstable_modes == 0
    assert largest_error(values, module.REFERENCE) < tolerance


@pytest.mark.slow
@pytest.mark.parametrize(("thickness", "limits"), [(12.7, (2220.93, 505.68)), (6.35, (583.83, -384.66))])
def test_roof_keeps_its_path_for_steps_over_a_factor_of_16(thickness, limits):
    """Both limit points of two paths to 1e-5, and those of 16 cells to 1e-3; the thin roof snaps back."""
    found = []
    for step in (0.02, 0.00125):
        record, values = run(roof, cells=4, thickness=thickness, step=step)
        assert [p.kind for p in record.critical_points] == ["limit", "limit"]
        turns_back = min(np.diff([s.deflection for s in record.states])) < 0
        assert turns_back == (thickness == 6.35)
        found.append((values["limit_load"], values["lower_limit_load"]))
    assert found[0] == pytest.approx(found[1], rel=1e-5)
    assert found[0] == pytest.approx(limits, rel=1e-3)


@pytest.mark.parametrize(("module", "parameters", "tolerance"), [
    (cantilever, {"cells": 8, "steps": 20}, 1.5e-3),
    (slit_annulus, {"cells": 15, "steps": 20}, 5e-3),
    (hemisphere, {"cells": 8, "steps": 20}, 1.2e-2),
    pytest.param(pull_out, {"cells": 8, "steps": 20}, 1e-2, marks=pytest.mark.slow),
    pytest.param(semi_cylinder, {"cells": 8, "step": 0.01}, 1.5e-2, marks=pytest.mark.slow),
])
@pytest.mark.slow(quick=1)
def test_published_points_lie_on_the_path(module, parameters, tolerance):
    """All points of Sze, Liu and Lo (2004), within a part of the largest reading.

    Tolerance: their mesh error and that of these meshes.
    """
    record, _ = run(module, **parameters)
    table = np.array(module.PUBLISHED.rows)
    found = np.array([list(at_load(record, module.READINGS, fraction).values()) for fraction in table[:, 0]])
    difference = np.abs(found - table[:, 1:]).max(axis=0) / np.abs(table[:, 1:]).max(axis=0)
    assert difference.max() < tolerance


def test_roof_passes_through_the_published_points():
    """Loads between the states, by the length along the path: 1 % of the limit load."""
    record, _ = run(roof, cells=4, step=0.0005)
    table = np.array(roof.PUBLISHED[12.7].rows)
    states = record.states
    deflections, loads = [s.deflection for s in states], [s.load for s in states]
    assert (np.diff(deflections) > 0).all()
    rows = np.interp(table[:, 1], deflections, loads)
    assert rows == pytest.approx(3000 * table[:, 0], abs=22)


def test_hemisphere_under_small_forces():
    """MacNeal and Harder (1985): 0.0940; 0.09373 on fine meshes."""
    _, values = run(hemisphere, cells=16, steps=1, load=4.0)
    assert values["linear_u_A"] == pytest.approx(0.09373, rel=1e-3)


@pytest.mark.parametrize(("module", "cells", "limit"), [
    (scordelis_lo, 8, 0.3006), (pinched_cylinder, 32, 1.8248e-5)])
@pytest.mark.slow(quick=1)
def test_shear_rigid_limits(module, cells, limit):
    """Thin-shell theory without transverse shear, to the digits that are known: 0.05 %."""
    _, values = run(module, cells=cells, steps=0, shear_factor=200.0)
    assert values["deflection"] == pytest.approx(limit, rel=5e-4)


@pytest.mark.parametrize("form", ["naghdi-q2", pytest.param("naghdi-q3", marks=pytest.mark.slow)])
def test_shell_rolls_up_to_a_circle(form):
    """A full turn on 24 elements; the tip is back at the clamp to 0.2 % of the length, by interpolated rotations."""
    _, values = run(roll_up, form=form, turns=1, elements=24)
    assert values["tip_error"] < 2e-3


@pytest.mark.slow
@pytest.mark.parametrize(("module", "parameters"), [
    (cantilever, {"cells": 16}),
    (slit_annulus, {"cells": 30}),
    (hemisphere, {"cells": 16}),
    (pull_out, {"cells": 16}),
    (semi_cylinder, {"cells": 16}),
    (diaphragm_cylinder, {"cells": 24}),
    (roof, {"cells": 12}),
    (pinched_cylinder, {"cells": 32, "steps": 0}),
    (scordelis_lo, {"cells": 16, "steps": 0}),
])
def test_converged_meshes_are_within_1_percent(module, parameters):
    record, values = run(module, **parameters)
    assert record.states[0].unstable_modes == 0
    assert largest_error(values, module.REFERENCE) < 1e-2


@pytest.mark.slow
def test_diaphragm_cylinder_follows_the_published_path():
    """Its last published point: 84.1 and 35.6 on 24 x 24 cells against 83.10 and 34.27."""
    record, _ = run(diaphragm_cylinder, cells=24)
    values = at_load(record, diaphragm_cylinder.READINGS)
    assert values["w_A"] == pytest.approx(83.102, rel=2e-2)
    assert values["u_B"] == pytest.approx(34.272, rel=5e-2)


@pytest.mark.parametrize(("module", "parameters", "words"), [
    (hemisphere, {"form": "naghdi-q9"}, "naghdi-q9"), (roof, {"cells": 0}, "cells")])
def test_refusals_name_the_value(module, parameters, words):
    with pytest.raises(ValueError, match=words):
        module.case(**parameters)


@pytest.mark.slow
def test_strains_on_turned_axes_are_naghdis_where_they_are_small():
    """Of the pinched hemisphere, whose rotations are large and whose strains are some thousandths."""
    found = []
    for strains in (None, forms.shell.biot):
        made = hemisphere.case(cells=6, form="naghdi-q2")
        scene = replace(made.scene, parts=[replace(made.scene.parts[0], strains=strains)])
        found.append(trace(replace(made, scene=scene)).states[-1].deflection)
    assert found[1] == pytest.approx(found[0], rel=1e-3)
