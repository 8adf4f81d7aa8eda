"""Structures on which classical methods fail, from the scenes of sheetfx."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from sheetfx.case import Case
from sheetfx.model.loads import PrescribedDisplacement
from sheetfx.model.supports import Support
from sheetfx.scenes import (
    arch,
    column,
    cylinder_panel,
    deep_arch,
    lee_frame,
    roll_up,
    roof,
    roorda_frame,
    sinusoidal_arch,
    star_dome,
    von_mises_truss,
)

from .trap import STABLE, UNSTABLE, Expected, Trap, and_mirrored, bifurcation, limits


def _sinusoidal(alpha: float, *order: str, tolerance: float = 1e-3) -> tuple[Expected, ...]:
    """Points of the shallow sinusoidal arch by the closed forms of its scene; `order` of the first extremum's side."""
    height = {"limit": ((alpha**2 - 1) / 3) ** 0.5, "bifurcation": max(alpha**2 - 4, 0.0) ** 0.5}

    def point(kind, sign):
        b = sign * height[kind]
        load = alpha - b + b * (alpha**2 - b**2)
        name = ("maximum" if sign > 0 else "minimum") if kind == "limit" else None
        return Expected(kind, load, tolerance, name=name)

    return tuple(point(kind, 1) for kind in order) + tuple(point(kind, -1) for kind in reversed(order))


def _slender_arch(depth: float) -> Trap:
    """Sinusoidal arch of a depth over its span: the same path in units of the closed form."""
    name, points = f"slenderness-{depth:.0e}".replace("e-0", "e-"), _sinusoidal(2.8, "bifurcation", "limit")
    loads = {1e-1: (7.1402, 8.2825, -3.4896, -2.4748)}.get(depth)
    tolerance = 3e-3 if depth == 1e-2 else 1e-3
    points = tuple(replace(p, load=loads[n] if loads else p.load, tolerance=tolerance) for n, p in enumerate(points))
    return Trap(
        name, "Rounding of the axial strain grows with the square of slenderness: fixed tolerances are missed, and "
        "singular tangents and stable ones look alike.",
        partial(sinusoidal_arch.case, depth=100 * depth, elements=12), points,
        "32 elements" if loads else "closed forms of the scene sinusoidal-arch", slow=depth <= 1e-6)


def _under_motion(case: Case, at: str) -> Case:
    """A case under a prescribed displacement downwards instead of its loads."""
    return _with(case, loads=[PrescribedDisplacement(case.scene.meshes[0], at, "y", -1.0)])


def _with(case: Case, **changes) -> Case:
    """A case with another scene."""
    return replace(case, scene=replace(case.scene, **changes))


def _held_twice() -> Case:
    case = lee_frame.case(elements=10)
    mesh, supports = case.scene.meshes[0], case.scene.supports
    return _with(case, supports=[*supports, *supports, Support(mesh, "base", "x")])


def _distorted_roof() -> Case:
    """The roof with its mesh moved within the surface, by up to a third of a cell."""
    case = roof.case(cells=4)
    x = case.scene.meshes[0].domain.geometry.x
    s, t = x[:, 0] * 2 / roof.LENGTH, np.arctan2(x[:, 1], x[:, 2]) / roof.HALF_ANGLE
    shift = 0.08 * np.sin(2 * np.pi * s) * np.sin(2 * np.pi * t)
    angle = roof.HALF_ANGLE * (t - shift)
    x[:] = np.column_stack(((s + shift) * roof.LENGTH / 2, roof.RADIUS * np.sin(angle), roof.RADIUS * np.cos(angle)))
    return case


CLASSICAL = (
    Trap("lee-frame",
         "Displacement control fails: the loaded point moves back while the load falls.",
         partial(lee_frame.case, elements=10), limits(18556.7, -9414.4, tolerance=2e-4),
         "shear-rigid limits of the scene lee-frame, converged"),
    Trap("deep-arch-215",
         "Load control stops at the first limit, behind which the arch sways to its hinged side.",
         partial(deep_arch.case, elements=30), limits(11.21600, -0.91309, tolerance=5e-4),
         "DaDeppo and Schmidt 1975: 8.9728 EI/R^2 = 11.2160; the minimum from 160 elements"),
    Trap("deep-arch-180",
         "The path winds with ever larger loads of alternating sign: arc lengths that count the load shrink, and "
         "displacement control fails at each turn.",
         partial(deep_arch.case, 180.0, True, elements=40),
         limits(12.6879, -33.686, 73.887, -123.578, 192.143, tolerance=5e-4),
         "elastica: 10.150, -26.949, 59.11, -98.86 and 153.7 EI/R^2, where EI/R^2 is 1.25"),
    Trap("roof-12.7",
         "Load control jumps from the first limit to a distant state; a predictor whose sign follows the last load "
         "increment turns back behind it.",
         partial(roof.case, cells=2), limits(2220.93, 505.68, tolerance=1e-3),
         "16 x 16 cells; Sze, Liu and Lo 2004: 2226 and 519 as tabulated"),
    Trap("roof-6.35",
         "Displacement control jumps where the crown moves back, load control at both limits.",
         partial(roof.case, cells=2, thickness=6.35), limits(583.83, -384.66, tolerance=3e-3),
         "16 x 16 cells; Sze, Liu and Lo 2004: 585.9 and -386.4 as tabulated"),
    Trap("punch-arch",
         "Contact is gained and lost within a step, so tangents waver and signs of pivots mean little.",
         partial(arch.case, elements=40), limits(205.60, 88.35, tolerance=2e-3),
         "160 elements: 205.60; 1.292 times the limit load of the arch under a point load"),
    Trap("punch-arch-friction",
         "With friction the tangent is not symmetric, its factor counts no negative pivots, and the state at the "
         "limit depends on the path that led to it.",
         partial(arch.case, elements=40, friction=0.3), limits(206.10, 88.86, tolerance=5e-3),
         "80 elements"),
    Trap("punch-first-touch",
         "Contact begins with a gap of zero at one point, where a set of active points may alternate.",
         partial(arch.case, elements=40, ratio=0.2), limits(159.137, 66.705, tolerance=5e-4),
         "the same arch under a point load, since a sharp punch keeps touching the crown alone"),
    Trap("von-mises-truss",
         "Bifurcations before and behind the limits, some within one step of a limit: a method that watches the load "
         "or the sign of the determinant alone misses pairs of them.",
         von_mises_truss.case,
         and_mirrored(bifurcation(0.24776384332, UNSTABLE, 1e-7), *limits(0.78448392444, tolerance=1e-7),
                       bifurcation(0.75461835122, STABLE, 1e-7)),
         "closed form: l^3 = L l^2 - L b^2 sideways and l^3 = b^2 L at limits, for half-span b and bars L"),
    Trap("apex-moved",
         "The apex is moved instead of loaded: extremes of the load are no critical points, and the reaction's "
         "multiplier adds a negative pivot.",
         lambda: _under_motion(von_mises_truss.case(), "apex"),
         and_mirrored(bifurcation(0.24776384332, None, 1e-7), bifurcation(0.75461835122, None, 1e-7)),
         "closed form, as for von-mises-truss"),
    Trap("sinusoidal-arch-before",
         "The arch sways sideways before its limit, by a mode that symmetric loads do not show.",
         partial(sinusoidal_arch.case, 2.8), _sinusoidal(2.8, "bifurcation", "limit", tolerance=2e-4),
         "closed forms of the scene; Fung and Kaplan 1952"),
    Trap("sinusoidal-arch-at",
         "Bifurcation and limit fall together, nearly: two eigenvalues vanish within a ten-millionth of the load.",
         partial(sinusoidal_arch.case, 2.3453), _sinusoidal(2.3453, "bifurcation", "limit", tolerance=2e-4),
         "closed forms of the scene; both points would be one for alpha^2 = 5.5"),
    Trap("sinusoidal-arch-after",
         "The bifurcation lies behind the limit, where one direction is unstable already and the load falls.",
         partial(sinusoidal_arch.case, 2.2), _sinusoidal(2.2, "limit", "bifurcation", tolerance=2e-4),
         "closed forms of the scene; Fung and Kaplan 1952"),
    Trap("column",
         "The path stays straight through every bifurcation: iterations and loads show nothing.",
         column.case, tuple(bifurcation(n * n, STABLE, 1.5e-3) for n in (1, 2, 3)), "Euler: n^2"),
    Trap("roorda-frame",
         "Asymmetric bifurcation: the load falls on one side, so that the slightest error decides where a step goes.",
         partial(roorda_frame.case, elements=80), (bifurcation(2 * 1.40694, "asymmetric", 1e-3),),
         "Koiter 1967; u^2 / (u cot u - 1) = 3 gives u^2 / pi^2 = 1.40694, on the corner and on the strut"),
    Trap("star-dome",
         "Double bifurcations change the number of negative pivots by two, so that the determinant keeps its sign, and "
         "bifurcations and limits lie within 2 % of the load.",
         star_dome.case,
         and_mirrored(
             *limits(3.0847498020e-4, -2.8141909272e-4, tolerance=1e-7), bifurcation(0.015556518, "multiple", 1e-7),
             bifurcation(0.0165747546, UNSTABLE, 1e-6), *limits(0.0166969955077, tolerance=1e-7),
             bifurcation(0.016507004, "multiple", 1e-6), replace(limits(0.0, -6.88384113e-3)[1], tolerance=1e-7)),
         "an independent truss, tests/truss.py; geometry of Hangai and Kawamata 1973"),
    Trap("star-dome-all-nodes",
         "As star-dome, with bifurcations and the limit closer together: a cluster within 1 %.",
         partial(star_dome.case, 1.0),
         and_mirrored(
             *limits(7 * 4.5698172314e-4, -7 * 2.2567584241e-4, tolerance=1e-7),
             bifurcation(7 * 2.7269263e-3, "multiple", 1e-6), bifurcation(7 * 2.9734492e-3, UNSTABLE, 1e-6),
             *limits(7 * 2.9903485158e-3, tolerance=1e-7), bifurcation(7 * 2.978977972e-3, "multiple", 1e-6),
             replace(limits(0.0, -7 * 3.8351423263e-3)[1], tolerance=1e-7)),
         "an independent truss, tests/truss.py"),
    Trap("cylinder-panel",
         "Modes with different numbers of waves buckle within 0.4 % of the load.",
         partial(cylinder_panel.case, cells=(8, 4)),
         tuple(bifurcation(load, UNSTABLE, 1e-3) for load in (0.82968, 0.83311, 0.88286)), "14 x 9 cells"),
    Trap("roll-up",
         "Rotations pass 2 pi twice: rotation vectors that are added up are singular there.",
         partial(roll_up.case, turns=2), (), "exact circle; the tangent stays definite"),
    Trap("roll-up-in-space",
         "Rotations pass 2 pi twice about an axis in space.",
         partial(roll_up.case, turns=2, spatial=True), (), "exact circle; the tangent stays definite"),
    *(_slender_arch(10.0**-n) for n in range(1, 7)),
    Trap("distorted-mesh",
         "Cells with corners far from right angles: elements that lock or are singular on them move the limits.",
         _distorted_roof, limits(2220.93, 505.68, tolerance=3e-3), "16 x 16 cells without distortion"),
    Trap("redundant-supports",
         "Components are fixed by several supports: multipliers for each would make the tangent singular.",
         _held_twice, limits(18556.7, -9414.4, tolerance=2e-4), "as lee-frame"),
)
