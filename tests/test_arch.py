"""The arch with and without punch against an independent semi-analytic solution and the thesis."""

from dataclasses import replace

import pytest

from sheetfx.case import trace
from sheetfx.continuation.control import DisplacementControl
from sheetfx.scenes.arch import case as arch_case
from sheetfx.scenes.arch import limit_without_contact, quantities

THICKNESS = 4.7625
CONVERGED = {0.2: 1.0000, 0.4: 1.0000, 0.6: 1.0219, 0.8: 1.1564, 1.0: 1.2920}
FORTY_ELEMENTS = {0.2: 1.0000, 0.4: 1.0000, 0.6: 1.0255, 0.8: 1.1729, 1.0: 1.3183}
COARSE = {"elements": 160, "layer": 2.7, "to": 20.0}


def arch(**parameters):
    case = arch_case(**parameters)
    record = trace(case)
    return record, quantities(record, parameters.get("thickness", THICKNESS))


def test_limit_loads_without_contact():
    """Half angle 7.338 degrees: 159.131 N at 9.767 mm and 66.700 N at 34.276 mm (0.02 %)."""
    _, values = arch(no_punch=True, elements=40)
    assert values["limit_load"] == pytest.approx(159.131, rel=2e-4)
    assert values["limit_deflection"] == pytest.approx(9.767, rel=2e-4)
    assert values["lowest_load"] == pytest.approx(66.700, rel=2e-4)
    assert values["lowest_deflection"] == pytest.approx(34.276, rel=2e-4)


def test_whole_arch_has_the_path_of_its_half():
    """Same mesh size, so the same discrete symmetric path; loads count on the whole structure."""
    _, half = arch(no_punch=True, elements=20)
    _, whole = arch(no_punch=True, elements=20, full=True)
    assert whole["limit_load"] == pytest.approx(half["limit_load"], rel=1e-6)
    assert whole["lowest_load"] == pytest.approx(half["lowest_load"], rel=1e-6)


def test_whole_arch_under_a_punch():
    """The half with the same contact layer (0.3 %: contact points of the halves lie differently)."""
    _, half = arch(ratio=1.0, **COARSE)
    _, whole = arch(ratio=1.0, full=True, **COARSE)
    assert whole["limit_load"] == pytest.approx(half["limit_load"], rel=3e-3)


def test_antisymmetric_imperfection_keeps_or_lowers_the_limit_load():
    _, perfect = arch(no_punch=True, elements=20, full=True)
    _, imperfect = arch(no_punch=True, elements=20, full=True, imperfection=1.0)
    assert imperfect["limit_load"] < perfect["limit_load"] * (1 - 1e-4)


@pytest.mark.parametrize("ratio", [0.6, 1.0])
@pytest.mark.slow(quick=1)
def test_punch_on_a_coarse_mesh(ratio):
    """160 elements and a layer five times the default's: 0.3 %, its measured error is below 0.1 %."""
    _, values = arch(ratio=ratio, **COARSE)
    assert values["limit_ratio"] == pytest.approx(CONVERGED[ratio], rel=3e-3)


@pytest.mark.parametrize("full", [False, True], ids=["half", "whole"])
@pytest.mark.slow(quick=1)
def test_ratio_of_a_higher_arch(full):
    """The limit without contact is followed as far as this arch needs: to 24 mm, beyond that of the default arch."""
    shape = {"half_angle": 12.0, "elements": 20, "full": full, "to": 40.0}
    _, without = arch(no_punch=True, **shape)
    _, values = arch(**shape)
    assert without["limit_deflection"] == pytest.approx(24.23, rel=1e-3)
    assert values["limit_ratio"] == pytest.approx(values["limit_load"] / without["limit_load"], rel=1e-6)
    assert values["limit_ratio"] == pytest.approx(1.340, rel=2e-3)


@pytest.mark.parametrize("full", [False, True], ids=["half", "whole"])
@pytest.mark.slow(quick=1)
def test_shallow_arch_has_no_ratio(full):
    """With a half angle of 3 degrees the load only grows, with and without punch."""
    record, values = arch(half_angle=3.0, elements=20, full=full, to=8.0)
    assert limit_without_contact(record) is None
    assert not {"limit_load", "limit_ratio"} & values.keys()


@pytest.mark.parametrize("elements", [40, 80])
@pytest.mark.slow(quick=1)
def test_lower_limit_under_a_punch(elements):
    """Steps tried around it stay with the contact of the path; 88.357 with 320 elements."""
    _, values = arch(ratio=1.0, elements=elements)
    assert values["lowest_load"] == pytest.approx(88.357, rel=5e-4)


@pytest.mark.slow
@pytest.mark.parametrize("ratio", CONVERGED)
def test_punch_converged(ratio):
    """The default mesh: 0.1 % of the semi-analytic ratio, penetration below 1e-6 depths."""
    _, values = arch(ratio=ratio, to=20.0)
    assert values["limit_ratio"] == pytest.approx(CONVERGED[ratio], rel=1e-3)
    assert values["penetration_over_depth"] < 1e-6


@pytest.mark.parametrize("ratio", FORTY_ELEMENTS)
@pytest.mark.slow
def test_mesh_of_the_thesis(ratio):
    """40 elements of two nodes, exact contact at nodes: an independent program's sawtooth (0.4 %)."""
    _, values = arch(ratio=ratio, elements=40, degree=1, contact="nodes", to=18.0, step=0.0002)
    assert values["limit_ratio"] == pytest.approx(FORTY_ELEMENTS[ratio], rel=4e-3)
    assert values["penetration_over_depth"] < 1e-6


@pytest.mark.parametrize("ratio", [0.6, pytest.param(1.0, marks=pytest.mark.slow)])
@pytest.mark.slow
def test_friction_changes_little(ratio):
    """The thesis: friction changes the path very little; below 0.5 % of the limit load, but not nothing."""
    _, smooth = arch(ratio=ratio, **COARSE)
    _, rough = arch(ratio=ratio, friction=0.3, **COARSE)
    change = rough["limit_load"] / smooth["limit_load"] - 1
    assert 0 < abs(change) < 5e-3


@pytest.mark.parametrize("enforcement", ["penalty", "uzawa", "semismooth"])
@pytest.mark.slow
def test_enforcements_agree(enforcement):
    """Under displacement control all carry the same load at 4 mm; the soft penalty to 1 %."""
    loads = []
    for name in (enforcement, "semismooth"):
        case = arch_case(ratio=1.0, elements=20, degree=1, contact="nodes", enforcement=name, to=4.0)
        final = trace(replace(case, control=DisplacementControl(step=0.5, largest=1.0))).states[-1]
        assert final.deflection == pytest.approx(4.0, abs=1e-9)
        loads.append(final.load)
    assert loads[0] == pytest.approx(loads[1], rel=1e-2 if enforcement == "penalty" else 1e-4)


def test_punch_is_in_equilibrium_with_the_contact_pressure():
    """The vertical components of all contact forces add up to the load (solver tolerance)."""
    record, _ = arch(ratio=1.0, elements=80, layer=5.4, to=12.0)
    contact = record.path.discretisation.contacts[0]
    state = contact.evaluate()
    punch = contact.contact.obstacle
    travel = record.path.discretisation.system.unknowns.blocks[1].fields[0].value.x.array[0]
    centre = punch.centre[1] - travel
    upwards = (state.position[:, 1] - centre) / punch.radius
    total = 2 * -(state.pressure * state.weight * upwards).sum()
    assert total == pytest.approx(record.states[-1].load, rel=1e-6)


def test_bifurcation_behind_the_limit_point():
    """A higher arch tilts sideways on its way down: the same point for steps that differ by 4 (1e-5)."""
    found = []
    for step in (0.005, 0.00125):
        record, _ = arch(no_punch=True, elements=40, full=True, half_angle=12.0, to=45.0, step=step)
        assert [p.kind for p in record.critical_points] == ["limit", "bifurcation"]
        found.append(record.critical_points[1].load)
        assert record.states[-1].unstable_modes == 2
    assert found[0] == pytest.approx(found[1], rel=1e-5)
