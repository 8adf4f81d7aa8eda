"""Shear and torsion, which no fibre or layer checks, against their plastic values: told wherever they are above."""

from __future__ import annotations

import warnings
from math import pi, sqrt

import numpy as np
import pytest
from helpers import straight

import sheetfx as fx
from sheetfx.model.plasticity import Fibres, Layers

MATERIAL = fx.Plastic(2e5, 0.3, yield_stress=200.0)
SHEAR = 200.0 / sqrt(3)


def warned(law, strains):
    """Whether a state with these strains is told."""
    strains = np.array([strains], float)
    history = law.update(strains, np.zeros((1, law.remembered)))[2]
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        law.accepted(strains, history)
        law.accepted(strains, history)
    assert len(told) <= 1
    return bool(told)


def plastic_torque(section):
    """Of a tube 2 pi (R^3 - r^3) / 3, of a rectangle Nadai's heap of sand."""
    if isinstance(section, fx.Tube):
        outer, inner = section.diameter / 2, section.diameter / 2 - section.thickness
        return 2 * pi * SHEAR * (outer**3 - inner**3) / 3
    short, long = sorted((section.width, section.depth))
    return SHEAR * short**2 * (3 * long - short) / 6


SECTIONS = [fx.Tube(100.0, 4.0), fx.Tube(100.0, 30.0), fx.round_bar(20.0), fx.Rectangle(10.0, 10.0),
            fx.Rectangle(2.0, 50.0), fx.Rectangle(60.0, 20.0)]


@pytest.mark.silent("u02")
@pytest.mark.parametrize("section", SECTIONS, ids=lambda s: f"{type(s).__name__} {s.depth:g}")
def test_torque_beyond_the_plastic_one_is_told(section):
    """From 16 % beyond it at the latest, never below it."""
    law = Fibres(*section.fibres(), MATERIAL, section.stiffness(MATERIAL, 3))
    twist = plastic_torque(section) / (MATERIAL.shear_modulus * section.torsion)
    assert warned(law, [0, 0, 0, -1.16 * twist, 0, 0])
    law = Fibres(*section.fibres(), MATERIAL, section.stiffness(MATERIAL, 3))
    assert not warned(law, [0, 0, 0, 0.98 * twist, 0, 0])


@pytest.mark.parametrize("dimension", [2, 3])
def test_shear_force_beyond_the_plastic_one_is_told(dimension):
    section = fx.Rectangle(10.0, 30.0)
    stiffness = section.stiffness(MATERIAL, dimension)
    for factor in (1.01, 0.99):
        strain = factor * SHEAR * section.area / stiffness[1]
        law = Fibres(*section.fibres(), MATERIAL, stiffness)
        assert warned(law, [0, strain, 0] + [0, 0, 0] * (dimension - 2)) == (factor > 1)


@pytest.mark.parametrize("resultants", [False, True])
def test_shear_of_a_plate_beyond_the_plastic_one_is_told(resultants):
    """Of layers, and of sections that yield as a whole; a force across both axes."""
    plate = fx.Plate(5.0)
    for factor in (1.01, -1.01, 0.99):
        law = fx.Ilyushin(plate, MATERIAL) if resultants else Layers(
            *plate.layers(), MATERIAL, plate.stiffness(MATERIAL))
        strain = factor * SHEAR / MATERIAL.shear_modulus / (5 / 6)
        assert warned(law, [0, 0, 0, 0, 0, 0, 0.6 * strain, 0.8 * strain, 0]) == (abs(factor) > 1)


def test_forces_about_the_shear_centre():
    """A shear force on the shear centre is no torque, on the centroid it is."""
    places = ((-1.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.0, -1.0))
    section = fx.FibreList(places, (1.0,) * 4, torsion=0.1, shear_centre=(0.0, 3.0))
    stiffness = np.array(section.stiffness(MATERIAL, 3))
    for torque, told in ((-3.0, False), (0.0, True)):
        strains = np.zeros(6)
        strains[1:4] = np.linalg.solve(stiffness[1:4, 1:4], np.array([1.0, 0.0, torque]) * 0.9 * 4 * SHEAR)
        assert warned(Fibres(*section.fibres(), MATERIAL, stiffness), strains) == told


@pytest.mark.silent("u02")
def test_twisted_tube_is_told_once():
    """By a path whose fibres never yield."""
    mesh = straight(2, 1000.0, 3)
    beam = fx.Beam(mesh, fx.Tube(100.0, 4.0), MATERIAL)
    scene = fx.Scene([beam], [fx.clamp(mesh, "base")], [fx.PrescribedRotation(mesh, "tip", (0.2, 0.0, 0.0))],
                     fx.Monitor(mesh, "tip", "rx"))
    with pytest.warns(UserWarning, match="shear and torsion, elastic in this law, reach") as told:
        record = fx.trace(fx.Case(scene, fx.LoadControl(0.25, target=1.0)))
    assert record.plastic_share() == 0
    assert sum("reach" in str(w.message) for w in told) == 1
