"""The three-way dome: panels and bars that share their edges, bars with flanges, bars alone."""

from __future__ import annotations

import warnings
from dataclasses import replace
from math import pi

import numpy as np
import pytest
from helpers import on_two_processes

import sheetfx as fx
from sheetfx.model.assembled import flange_width
from sheetfx.scenes.dome import BAR, case, dome

SOFTER = 0.08  # our loads against those of an independent study that found its first load at 12 divisions


@pytest.mark.slow
def test_dome_on_two_processes():
    """Bars live where the panels are whose unknowns they share; the path is that of one process."""
    one = fx.trace(case(divisions=2, to=20.0))
    lines = on_two_processes('''
import sheetfx as fx
from sheetfx.scenes.dome import case
record = fx.trace(case(divisions=2, to=20.0))
print(record.path.unknowns)
for state in record.states:
    print(state.load, state.deflection, state.unstable_modes)
''')
    assert int(lines[0]) == one.path.unknowns == 1860
    found = np.array([[float(x) for x in line.split()] for line in lines[1:]])
    assert found == pytest.approx(np.array([[s.load, s.deflection, s.unstable_modes] for s in one.states]), rel=1e-8)
    assert 1 / one.states[0].reference[1] == pytest.approx(58.6e3, rel=0.03), "converged initial stiffness"


def test_flange_in_closed_form():
    """Tube 40 x 2 with a flange 160 x 10 whose middle is 25 above its axis."""
    section = fx.Flanged(BAR, 160.0, 10.0, 25.0)
    tube, flange = pi / 4 * (40**2 - 36**2), 1600.0
    centroid = 25 * flange / (tube + flange)
    about_binormal = pi / 64 * (40**4 - 36**4) + tube * centroid**2 + 160 * 10**3 / 12 + flange * (25 - centroid) ** 2
    assert section.centroid == pytest.approx(centroid)
    assert section.second_moments == pytest.approx((pi / 64 * (40**4 - 36**4) + 10 * 160**3 / 12, about_binormal))
    assert section.depth == 50.0
    structure = dome(fx.meshes.dome("hex"))
    widths = {flange_width(structure, kind, ends) for kind in structure.bars.values() for ends in kind.ends}
    assert widths == {160.0}, "own width and six thicknesses on each side"
    assert fx.effective_width(300.0, 10.0, 40.0, 500.0) == 100.0, "a third of the span"
    assert fx.effective_width(900.0, 10.0, 40.0, 50.0) == 90.0, "the panels themselves"


@pytest.mark.slow
def test_linear_buckling_beside_contact():
    """Friction and open pairs bring pivots that are put off, beyond the working space of a factor made once."""
    made = case(model="contact", divisions=2, to=0.2)
    found = made.quantities(fx.trace(made))
    assert found["linear_buckling_load"] > 0
    assert found["initial_stiffness"] == pytest.approx(55.4e3, rel=1e-2), "of the path to 4 mm"


@pytest.mark.parametrize("model", ["bars", "flange"])
@pytest.mark.slow(quick=1)
def test_cheap_models(model):
    """Four cells a bar give the skeleton's first bifurcation within 1 % of that of eight; flanges stiffen it.

    Two cells are 10 % off with flanges: the error falls with the fourth power of the length of cells.
    """
    points = [fx.trace(case(model=model, divisions=n, to=17.0 if model == "bars" else 5.5)).critical_points[0]
              for n in (4, 8)]
    assert [(p.kind, p.multiplicity) for p in points] == [("bifurcation", 2)] * 2
    assert points[0].load == pytest.approx(points[1].load, rel=1e-2)
    stiffness = [1 / fx.trace(case(model=m, divisions=2, to=1.0)).states[0].reference[1] for m in (model, "bars")]
    area = BAR.area + (1600.0 if model == "flange" else 0.0)
    assert stiffness[0] / stiffness[1] == pytest.approx(area / BAR.area, rel=0.1), "members carry by axial forces"


@pytest.mark.slow
def test_welds_that_are_short_for_their_cells_are_told():
    with pytest.warns(UserWarning, match="its length 100 is less than half of the cell of 1178 that"):
        case(model="contact", divisions=2, weld=100.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        case(model="contact", divisions=4, grading=4.0, weld=150.0)


def test_wrong_options_are_named():
    with pytest.raises(ValueError, match="Joining: faces is 'both', but shared edges of panels do not push"):
        case(model="contact", edges="shared", divisions=2)
    with pytest.raises(ValueError, match="dome: model is 'shell'; it must be one of coupled, contact, flange, bars"):
        case(model="shell")
    with pytest.raises(ValueError, match="no geometry 'round'; choose from arc, hex, plan"):
        case(geometry="round")
    with pytest.raises(ValueError, match="even, or the cells triangles"):
        case(divisions=3, form="naghdi-q2")
    with pytest.raises(ValueError, match="dome: to is -1"):
        case(to=-1.0)


@pytest.mark.slow
@pytest.mark.parametrize("divisions, step", [(5, None), (5, 0.004), (6, 0.004), (8, None)])
def test_double_points_of_the_dome_stay_double(divisions, step):
    """Six panels alike have pairs of modes, which rounding splits by some millionths, up the path and down.

    The nearer states are to a pair, the farther rounding parts it: in some steps both were named as simple ones.
    """
    record = fx.trace(case(divisions=divisions, to=45.0, form="naghdi-t2", step=step))
    found = [(p.kind, p.multiplicity) for p in record.critical_points]
    pair = [("bifurcation", 2)] if divisions < 8 else []  # behind the limit on fine cells
    assert found == [("bifurcation", 1), *pair, ("limit", 1), ("bifurcation", 2), *pair,
                     ("bifurcation", 1), ("limit", 1), ("bifurcation", 2)]


@pytest.mark.slow
def test_coupled_dome_bifurcates():
    """First a mode of the panels around the apex, before the limit of the path that keeps all symmetries.

    An independent study with second-order triangles found the first negative pivot at 1674 kN and 35.0 mm, and 62.3
    kN/mm in the beginning (12 divisions).
    """
    found = []
    for divisions in (4, 6):
        record = fx.trace(case(divisions=divisions, to=37.5))
        point = record.critical_points[0]
        assert (point.kind, point.multiplicity, point.name) == ("bifurcation", 1, "unstable symmetric")
        modes = record.critical_modes(point)
        shares = record.energy_shares(modes)
        assert sum(shares) == pytest.approx(1.0) and shares[0] < 0.05, "a mode of the panels"
        found.append(point.load)
    assert found[1] == pytest.approx(1674e3, rel=SOFTER)
    assert found[0] == pytest.approx(found[1], rel=0.02)


@pytest.mark.slow
def test_edges_that_lift_off_snap():
    """Twelve pairs open at once: the load falls from a corner by 11 kN, then rises again.

    Between larger steps the corner is not seen, and by default the path goes straight past it.
    """
    record = fx.trace(case(model="contact", divisions=4, to=6.5, step=0.001))
    found = [p.load for p in record.critical_points if p.kind == "limit"]
    assert found == pytest.approx((282.06e3, 271.23e3), rel=1e-3)
    assert sum(p.multiplicity for p in record.critical_points if p.kind == "bifurcation") == 10
    assert record.states[-1].deflection >= 6.5


@pytest.mark.slow
def test_edges_with_friction_by_both_enforcements():
    """By steps that do not grow: longer ones, which condensed forces allow, integrate friction apart by 2e-4."""
    made = [case(model="contact", divisions=4, friction=0.2, to=6.5, enforcement=enforcement)
            for enforcement in ("condensed", "penalty")]
    ends = [fx.trace(replace(one, control=fx.ArcLength(0.001, largest=1.0))).states[-1].load for one in made]
    assert ends[0] == pytest.approx(ends[1], rel=1e-4)


@pytest.mark.slow
def test_edges_that_have_slid_up_to_bars_stick_there():
    """The path goes on where edges first touch: what would slip on there finds no state ahead, what sticks does.

    With the flexibility at the twelve pairs, rigid ones that stick make a stiffness of 32.36 kN/mm for 7.12, and need a
    friction of 0.144. A step and elastic slip may take 5 % of it.
    """
    butt = case(model="contact", divisions=4, faces="butt", weld=100.0, tie="hinge", friction=0.2)
    path = fx.Path(butt.scene, replace(butt.control, largest=0.2), butt.until)
    far, soft = [], 0.0
    for state in path:
        if state.contact_points:
            break
        far, soft = [*far, state], path.tracer.rate("load") / path.tracer.rate("deflection")
    before = replace(far[-1], next_length=far[-1].next_length / 10)  # a whole step brings 24 pairs more together
    path = fx.Path(butt.scene, butt.control, butt.until, start=[*far[:-1], before])
    last = next(iter(path))
    stiff = path.tracer.rate("load") / path.tracer.rate("deflection")
    assert last.contact_points == 12 and not last.unstable_modes
    assert soft == pytest.approx(7.12e3, rel=0.05) and stiff == pytest.approx(32.36e3, rel=0.05)
    beyond = before.load + soft * (last.deflection - before.deflection) - last.load
    corner = last.load + stiff * beyond / (stiff - soft)  # where the tangents at both ends meet
    assert corner == pytest.approx(151.57e3, rel=1e-4)


@pytest.mark.slow
def test_the_load_falls_where_a_step_has_passed_a_corner_by_a_hair():
    """Panels that lie on the bars, with short welds, lift at 185.88 kN, and six modes become unstable at once.

    A step ended 1e-8 of the load behind this corner. The falling path, which turns back sharply, was taken for the
    rising one, on which no mode is unstable. Which of the falling paths is followed steps decide: that with six
    unstable modes, or since steps end at corners one with two. The highest state is beside the corner.
    """
    seat = case(model="contact", divisions=6, grading=4.0, faces="seat", weld=100.0, friction=0.2)
    record = fx.trace(replace(seat, until=fx.Until(deflection=20.0, steps=16)))
    highest = max(record.states, key=lambda state: state.load)
    assert highest.load == pytest.approx(185.88e3, rel=5e-4)
    falling = next(s for s in record.states[record.states.index(highest):] if s.load < 0.95 * highest.load)
    assert falling.deflection < highest.deflection and falling.unstable_modes in (2, 6)
    corner, = (p for p in record.critical_points if p.kind == "bifurcation" and p.name == "corner")
    assert corner.multiplicity >= falling.unstable_modes


@pytest.mark.slow
@pytest.mark.parametrize("enforcement", ["condensed", "penalty"])
def test_modes_that_come_and_go_within_a_step_are_found(enforcement):
    """Six modes become unstable at a corner and five of them stable again within one step of the default enforcement.

    The numbers at its ends differ by the one of the limit alone; states between them, at which the limit was searched,
    know more.
    """
    record = fx.trace(case(model="contact", divisions=4, to=6.0, enforcement=enforcement))
    maximum, = (p for p in record.critical_points if p.name == "maximum")
    assert maximum.load == pytest.approx(282.0e3, rel=1e-3)
    found = [(p.load, p.multiplicity) for p in record.critical_points if p.kind == "bifurcation"]
    assert [count for _, count in found] == [5, 1, 2, 2]
    assert [load for load, _ in found] == pytest.approx([282.09e3, 281.70e3, 278.86e3, 275.03e3], rel=1e-3)
