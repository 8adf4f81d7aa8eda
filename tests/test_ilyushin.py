"""Plasticity of shells by stress resultants against layers and closed forms."""

from __future__ import annotations

from math import sqrt

import numpy as np
import pytest
from test_plasticity import layers

import sheetfx as fx

PLATE = fx.Plate(2.0)
PERFECT = fx.Plastic(200e3, 0.3, yield_stress=200.0)
HARDENING = fx.Plastic(200e3, 0.3, yield_stress=200.0, hardening=5e3)


@pytest.mark.parametrize("material", [PERFECT, HARDENING], ids=["perfect", "hardening"])
def test_moduli_are_the_derivatives_of_the_resultants(material):
    """Central differences from states that have flowed to another side, on one surface and on the edge of both."""
    law, generator = fx.Ilyushin(PLATE, material), np.random.default_rng(3)
    strains = generator.uniform(-4e-3, 4e-3, (2, 200, 9))
    history = law.update(strains[0], np.zeros((200, law.remembered)))[2]
    _, moduli, after = law.update(strains[1], history)
    flows = after[:, 6] > history[:, 6]
    assert flows.mean() > 0.9
    differences = np.stack([(law.update(strains[1] + e, history)[0] - law.update(strains[1] - e, history)[0]) / 2e-8
                            for e in 1e-8 * np.eye(9)], axis=2)
    assert np.abs(moduli - differences).max() < 1e-7 * np.abs(moduli).max()
    assert np.abs(moduli - moduli.transpose(0, 2, 1)).max() < 1e-12 * np.abs(moduli).max()


@pytest.mark.parametrize("material", [PERFECT, HARDENING], ids=["perfect", "hardening"])
def test_a_membrane_flows_as_one_of_layers(material):
    strains = np.random.default_rng(4).uniform(-4e-3, 4e-3, (50, 9))
    strains[:, 3:6] = 0
    law, layered = fx.Ilyushin(PLATE, material), layers(material, thickness=2.0)
    (own, moduli, history), (other, others, _) = (
        the.update(strains, np.zeros((50, the.remembered))) for the in (law, layered))
    assert own == pytest.approx(other, rel=1e-11, abs=1e-9)
    assert moduli[:, :3, :3] == pytest.approx(others[:, :3, :3], abs=1e-11 * 200e3)
    assert np.abs(history[:, 3:6]).max() < 1e-14 * np.abs(history).max()


def test_resultants_stay_on_the_surface_with_the_hardening_of_their_work():
    """Both surfaces hold, one as an equation; plastic work is s_y (1 + H a / s_y) t da in a step from rest."""
    law = fx.Ilyushin(PLATE, HARDENING)
    strains = np.random.default_rng(5).uniform(-4e-3, 4e-3, (200, 9))
    strains[:40, :3], strains[40:80, 3:6] = 0, 0
    resultants, _, history = law.update(strains, np.zeros((200, 7)))
    norm = np.array([[1, -0.5, 0], [-0.5, 1, 0], [0, 0, 3]])
    n, m = resultants[:, :3] / 400, resultants[:, 3:6] / 200
    pure = np.einsum("qi,ij,qj->q", n, norm, n) + np.einsum("qi,ij,qj->q", m, norm, m)
    mixed = np.einsum("qi,ij,qj->q", n, norm, m) / sqrt(3)
    flows = history[:, 6] > 0
    size = (1 + 5e3 * history[:, 6] / 200) ** 2
    assert flows.mean() > 0.8
    assert (pure + np.abs(mixed))[flows] == pytest.approx(size[flows], rel=1e-11)
    assert ((pure + np.abs(mixed))[~flows] < 1).all()
    work = np.einsum("qi,qi->q", resultants[:, :6], history[:, :6])
    assert work[flows] == pytest.approx((200 * np.sqrt(size) * 2 * history[:, 6])[flows], rel=1e-10)


def test_fully_plastic_moment_and_unloading():
    """A plate bent to a cylinder carries 2 / sqrt(3) s_y t^2 / 4, and unloads elastically."""
    law, strains = fx.Ilyushin(PLATE, PERFECT), np.zeros((1, 9))
    strains[0, 3] = 1.0
    resultants, _, history = law.update(strains, np.zeros((1, 7)))
    assert resultants[0, 3] == pytest.approx(2 / sqrt(3) * 200, rel=1e-6)
    strains[0, 3] -= 1e-4
    again, moduli, kept = law.update(strains, history)
    assert again[0, 3] == pytest.approx(resultants[0, 3] - 1e-4 * 200e3 * 8 / 12 / 0.91, rel=1e-12)
    assert np.array_equal(kept, history)
    assert moduli[0, 3, 3] == pytest.approx(200e3 * 8 / 12 / 0.91, rel=1e-12)
    assert law.flowed(history)[0] == pytest.approx([1.0])
    assert law.elastic_utilisation(np.array([[1e-3, 0, 0, 0, 0, 0, 0, 0, 0]])) == pytest.approx(
        sqrt(1 - 0.3 + 0.09) / 0.91)


@pytest.mark.parametrize(("section", "material", "message"), [
    (PLATE, fx.Elastic(1.0), "Ilyushin: material is Elastic"),
    (fx.GivenPlate(1.0, PLATE.stiffness(PERFECT)), PERFECT, "Ilyushin: section is GivenPlate"),
    (PLATE, fx.Plastic(1.0, yield_stress=1.0, kinematic=0.1), "kinematic is 0.1, hardening 0.0; this law hardens"),
    (PLATE, fx.Plastic(1.0, yield_stress=1.0, hardening=-0.1), "kinematic is 0.0, hardening -0.1; this law hardens"),
])
def test_wrong_input_is_named(section, material, message):
    with pytest.raises(ValueError, match=message):
        fx.Ilyushin(section, material)
