"""Walls that meet at right angles: a folded strip bent and twisted, and the channel-section cantilever."""

from __future__ import annotations

from math import cos, cosh, pi, sin, sinh, sqrt

import pytest
from scipy.optimize import brentq

import sheetfx as fx
from sheetfx import meshes
from sheetfx.scenes import channel

LONG, WIDTH, HEIGHT, THICKNESS = 20.0, 1.0, 2.0, 0.05
CELLS = {"naghdi-q2": 2, "naghdi-t2": 4, "naghdi-t3": 2}


def bracket(form, force, component, branches=("top",)) -> float:
    """Tip of a strip along y, clamped at its start, at whose end a wall stands upright (and one hangs), per force.

    The force acts along the top of the wall (E = 1, no Poisson's effect).
    """
    heights = {"top": HEIGHT, "bottom": -HEIGHT}
    corners = {"start": (0.0, 0.0), "fold": (LONG, 0.0)} | {name: (LONG, heights[name]) for name in branches}
    cells = CELLS[form]
    walls = {"strip": ("start", "fold", 10 * cells)} | {f"to {name}": ("fold", name, cells) for name in branches}
    mesh = fx.read(lambda: meshes.profile(corners, walls, WIDTH, cells, form != "naghdi-q2"), 3)
    shell = fx.Shell(mesh, fx.Plate(THICKNESS), fx.Elastic(1.0, 0.0), form=form)
    scene = fx.Scene([shell], [fx.clamp(mesh, "start")], [fx.EdgeForce(mesh, "top", tuple(f / WIDTH for f in force))],
                     fx.Monitor(mesh, "top at start", component))
    path = fx.Path(scene)
    state = next(iter(path))
    _, places = path.discretisation.monitored(scene.monitor)
    return float(state.response[places].sum())


BENDING, SHEAR = THICKNESS**3 * WIDTH / 12, 5 / 12 * THICKNESS * WIDTH  # EI and k GA


@pytest.mark.parametrize("branches", [("top",), ("top", "bottom")], ids=["L", "T"])
@pytest.mark.parametrize("form", ["naghdi-q2", pytest.param("naghdi-t2", marks=pytest.mark.slow),
                                  pytest.param("naghdi-t3", marks=pytest.mark.slow)])
def test_fold_carries_bending(form, branches):
    """A force along y on the wall bends the strip by its moment: beam theory."""
    deflection = HEIGHT**2 * (HEIGHT / 3 + LONG) / BENDING + HEIGHT / SHEAR + LONG / THICKNESS / WIDTH
    assert bracket(form, (0.0, 1.0, 0.0), "y", branches) == pytest.approx(deflection, rel=1e-3)


@pytest.mark.parametrize("branches", [("top",), ("top", "bottom")], ids=["L", "T"])
def test_fold_carries_twist(branches):
    """A force along x on the wall twists the strip, and bends it and the wall in their planes: beam theory.

    1 %: both ends of the strip hold its warping along a fifth of its width, and 2 cells do not resolve the layer along
    free edges, half a thickness wide, in which it is softer.
    """
    inward, torsion = THICKNESS * WIDTH**3 / 12, THICKNESS**3 * WIDTH / 6
    sideways = HEIGHT**2 * LONG / torsion + (LONG**3 + HEIGHT**3) / 3 / inward + (LONG + HEIGHT) / SHEAR
    assert bracket("naghdi-q2", (1.0, 0.0, 0.0), "x", branches) == pytest.approx(sideways, rel=1e-2)


def channel_values(**parameters):
    case = channel.case(**parameters)
    return case.quantities(fx.trace(case))


def test_channel_on_a_coarse_mesh():
    """A limit point; 3 %: the mesh. The section changes its shape, so that the channel is softer than Vlasov's."""
    values = channel_values(cells=18, to=0.3)
    assert values["limit_load"] == pytest.approx(channel.LIMIT, rel=0.03)
    assert values["flexibility_over_theory"] == pytest.approx(1.0, abs=0.03)


@pytest.mark.slow
@pytest.mark.parametrize(("parameters", "tolerance"), [
    ({"cells": 36, "across": (12, 4)}, 2e-3), ({"cells": 36}, 2e-3),
    ({"cells": 36, "across": (9, 3), "form": "naghdi-t3"}, 0.025), ({"cells": 72, "form": "naghdi-t2"}, 0.025)])
def test_channel_converges(parameters, tolerance):
    """Quadrilaterals from above; triangles from below and slowly, as they are soft in twist beside free edges."""
    values = channel_values(to=0.4, **parameters)
    assert values["limit_load"] == pytest.approx(channel.LIMIT, rel=tolerance)
    assert values["last_load"] < 0.97 * values["limit_load"], "beyond the limit point"


def levy(ratio: float, waves: int) -> float:
    """Buckling factor k of a strip that is free along one edge and hinged along the others, without Poisson's effect.

    Timoshenko and Gere 1961, section 9.4: sigma = k pi^2 D / (b^2 t); ratio is that of its sides a / b.
    """
    wave = waves * pi / ratio

    def at_free_edge(k):
        along, across = sqrt(wave * pi * sqrt(k) + wave**2), sqrt(wave * pi * sqrt(k) - wave**2)
        return along**2 * sinh(along) * -across * (across**2 + 2 * wave**2) * cos(across) + (
            across**2 * sin(across) * along * (along**2 - 2 * wave**2) * cosh(along))

    torsion = 6 / pi**2 + (waves / ratio) ** 2  # of a strip that stays straight across, which is an upper bound
    return brentq(at_free_edge, 0.9 * torsion, 1.01 * torsion)


@pytest.mark.slow
@pytest.mark.parametrize("walls", [3, 4])
@pytest.mark.parametrize("form", ["naghdi-q2", "naghdi-q3", "naghdi-t2"])
def test_star_of_walls_twists_as_each_of_them_alone_would(form, walls):
    """A column of any number of equal walls about its axis, hinged at its ends: three modes, one, two and three waves.

    Tolerance: of the walls' thickness, a five-hundredth of their width; cells of a quarter of it.
    """
    length, thickness = 10.0, 2e-3
    corners = {"axis": (0.0, 0.0)} | {f"edge {i}": (cos(2 * pi * i / walls), sin(2 * pi * i / walls))
                                      for i in range(walls)}
    mesh = fx.read(lambda: meshes.profile(corners, {f"wall {i}": ("axis", f"edge {i}", 4) for i in range(walls)},
                                          length, 40, form == "naghdi-t2"), 3)
    shell = fx.Shell(mesh, fx.Plate(thickness), fx.Elastic(1.0, 0.0), form=form)
    ends = [(f"wall {i} at {end}", sign) for i in range(walls) for end, sign in (("start", 1.0), ("end", -1.0))]
    held = [*(fx.Support(mesh, end, "y z") for end, _ in ends), fx.Support(mesh, "axis at start", "x")]
    scene = fx.Scene([shell], held, [fx.EdgeForce(mesh, end, (sign * thickness, 0.0, 0.0)) for end, sign in ends],
                     fx.Monitor(mesh, "axis at end", "x"))
    path = fx.Path(scene)
    found = fx.buckling(path, next(iter(path)), 3)
    exact = [levy(length, waves) * pi**2 / 12 * thickness**2 for waves in (1, 2, 3)]
    assert [one.factor for one in found[:3]] == pytest.approx(exact, rel=2e-3)
