"""Section laws with cases, as of bars that take tension only: kinks at rest, and those that a path comes to."""

from __future__ import annotations

from math import pi

import pytest
import ufl

import sheetfx as fx

AREA, MODULUS = 1e-4, 2e11
CONTROLS = [fx.ArcLength(), fx.ArcLength(0.01), fx.LoadControl(), fx.LoadControl(0.25), fx.LoadControl(0.25, turn=pi),
            fx.LoadControl(0.25, fixed=True)]


def tension_only(e, k):
    return ufl.as_vector([ufl.conditional(ufl.gt(e[0], 0), k[0] * e[0], 1e-6 * k[0] * e[0])])


def braced(storeys=1, force=1e4, law=tension_only):
    """A frame of hinged bars with two diagonals in each storey that take tension only; a force at its top."""
    nodes = {f"{side}{level}": (float(side == "r"), float(level)) for level in range(storeys + 1) for side in "lr"}
    columns = [(f"{s}{i}", f"{s}{i + 1}") for i in range(storeys) for s in "lr"]
    stiff = columns + [(f"l{i}", f"r{i}") for i in range(storeys + 1)]
    braces = [pair for i in range(storeys) for pair in ((f"l{i}", f"r{i + 1}"), (f"r{i}", f"l{i + 1}"))]
    mesh = fx.read(lambda: fx.meshes.frame(nodes, {"-".join(p): (*p, 1) for p in stiff + braces}), 2)
    bars = [fx.Bar(mesh, fx.Rectangle(0.1, 0.1), fx.Elastic(MODULUS), group="-".join(p)) for p in stiff]
    bars += [fx.Bar(mesh, fx.Rectangle(0.01, 0.01), fx.Elastic(MODULUS), group="-".join(p), law=law) for p in braces]
    top = f"l{storeys}"
    return fx.Scene(bars, [fx.pin(mesh, "l0"), fx.pin(mesh, "r0")], [fx.PointForce(mesh, top, (force, 0.0))],
                    fx.Monitor(mesh, top, "x"))


@pytest.mark.parametrize("control", CONTROLS, ids=lambda c: f"{type(c).__name__}-{c.step}-{c.turn:.2g}")
def test_slack_diagonals_at_rest(control):
    """Sway of the tight diagonal and the column below it, to first order 2 sqrt 2 P / (EA) + P / (EA of the column)."""
    record = fx.trace(fx.Case(braced(), control, fx.Until(load=1e4)))
    assert record.states[-1].load == pytest.approx(1e4)
    assert record.states[-1].deflection == pytest.approx(1.4257e-3, rel=1e-4)
    assert record.forces(record.case.scene.parts[4]).ravel()[0] == pytest.approx(14152, rel=1e-4)
    assert abs(record.forces(record.case.scene.parts[5]).ravel()[0]) < 0.1
    assert len(record.states) < 10 and not record.critical_points and not record.balance().broken
    if getattr(control, "fixed", False):
        assert [s.factor for s in record.states] == pytest.approx([0, 0.25, 0.5, 0.75, 1.0])


def test_to_and_fro():
    """The other diagonal takes the force backwards, and the frame is the same reflected."""
    scene = braced(force=1e4)
    there = fx.trace(fx.Case(scene, fx.LoadControl(0.25)))
    back = fx.trace(fx.Case(scene, fx.LoadControl(0.25, target=-1.0)), start=there.states)
    below = fx.trace(fx.Case(scene, fx.LoadControl(0.25, target=-1.0)))
    mirrored = fx.trace(fx.Case(braced(force=-1e4), fx.LoadControl(0.25)))
    ends = [record.states[-1].deflection for record in (back, below, mirrored)]
    assert ends == pytest.approx([ends[0]] * 3, rel=1e-7) and ends[0] < -1.3e-3


def test_frame_of_four_storeys_sways_by_its_tight_diagonals():
    """Beside the same with the slack ones left out, whose tight ones have the usual law."""
    def usual(e, k):
        return fx.forms.section.linear_elastic(e, k)

    one = fx.trace(fx.Case(braced(4), fx.ArcLength(), fx.Until(load=1e4)))
    scene = braced(4)
    tight = [p for p in scene.parts if p.law is tension_only and p.group[0] == "l"]
    soft = [p for p in scene.parts if p.law is tension_only and p.group[0] == "r"]
    other = fx.remade(scene, {**{p: fx.Bar(p.mesh, p.section, p.material, group=p.group) for p in tight},
                              **{p: fx.Bar(p.mesh, fx.Rectangle(1e-5, 1e-5), p.material, group=p.group) for p in soft}})
    two = fx.trace(fx.Case(other, fx.ArcLength(), fx.Until(load=1e4)))
    assert one.states[-1].deflection == pytest.approx(two.states[-1].deflection, rel=1e-5)


@pytest.mark.parametrize("control", CONTROLS[:4], ids=lambda c: f"{type(c).__name__}-{c.step}")
def test_prestressed_bar_goes_slack_on_the_way(control):
    """Two bars of 1 and 3 in a line, tight by N: u = P / k up to P = N (1 + 3), then with the first alone."""
    mesh = fx.read(lambda: fx.meshes.frame({"a": (0, 0), "m": (1.0, 0), "b": (4.0, 0)},
                                           {"l": ("a", "m", 1), "r": ("m", "b", 1)}), 2)
    stiff, tight = AREA * MODULUS, 1000.0
    bars = [fx.Bar(mesh, fx.Rectangle(0.01, 0.01), fx.Elastic(MODULUS), group=g, law=tension_only) for g in "lr"]
    scene = fx.Scene(bars, [fx.pin(mesh, "a"), fx.pin(mesh, "b"), fx.Support(mesh, "m", "y")],
                     [fx.PointForce(mesh, "m", (8 * tight, 0.0))], fx.Monitor(mesh, "m", "x"),
                     stages=[fx.Stage([fx.InitialStrain(bar, -tight / stiff) for bar in bars], at_once=True)])
    record = fx.trace(fx.Case(scene, control, fx.Until(load=8 * tight)))
    for state in record.states[1:]:
        load = state.factor * 8 * tight
        right = min(load / (stiff * 4 / 3), 3 * tight / stiff)
        right += max(load - 4 * tight, 0.0) / (stiff * (1 + 1e-6 / 3))
        assert abs(state.deflection - right) < 1e-7 * 4 * tight / stiff
    assert record.states[-1].factor == pytest.approx(1.0)


def test_what_has_cases():
    """Cases of strains do, those of places do not, nor does what is smooth."""
    from sheetfx.discrete.cases import has_cases
    from sheetfx.model.work import Term

    domain = braced().parts[0].mesh.domain.ufl_domain()
    field = ufl.Coefficient(ufl.FunctionSpace(domain, domain.ufl_coordinate_element()))
    strains, place = ufl.as_vector([ufl.grad(field)[0, 0]]), ufl.SpatialCoordinate(domain)[0]
    laws = {True: [tension_only, lambda e, k: ufl.as_vector([ufl.max_value(e[0], 0.0)]),
                   lambda e, k: ufl.as_vector([abs(e[0])])],
            False: [lambda e, k: ufl.as_vector([ufl.conditional(ufl.gt(place, 0.5), 2.0, 1.0) * e[0]]),
                    lambda e, k: ufl.as_vector([ufl.tanh(e[0])])]}
    for cases, given in laws.items():
        for law in given:
            assert has_cases(Term(strains, lambda e, law=law: law(e, [1.0]), None)) == cases
