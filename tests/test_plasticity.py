"""Plastic section laws against closed forms: return mapping, moments and curvatures, residual stress."""

from __future__ import annotations

from math import pi, sqrt

import numpy as np
import pytest
from scipy.optimize import brentq

from sheetfx.model.plasticity import Fibres, Layers, Plastic
from sheetfx.model.plate import Plate
from sheetfx.model.return_mapping import REMEMBERED
from sheetfx.model.section import FibreList, Flanged, Rectangle, Tube, round_bar

STEEL = Plastic(200e3, 0.3, yield_stress=200.0)
HARDENING = Plastic(200e3, 0.3, yield_stress=200.0, hardening=5e3, kinematic=8e3)


def layers(material, points=5, rule="gauss", thickness=1.0):
    plate = Plate(thickness, points=points, rule=rule)
    return Layers(*plate.layers(), material, plate.stiffness(material))


def fibres(section, material, dimension=2):
    return Fibres(*section.fibres(), material, section.stiffness(material, dimension))


def driven(law, path):
    """Resultants, moduli and history along a path of strains, from rest."""
    history = np.zeros((1, law.remembered))
    for strains in path:
        resultants, moduli, history = law.update(np.atleast_2d(strains), history)
    return resultants[0], moduli[0], history


def moment(law, curvature, place, others=()):
    """Moment at a curvature, other strains being those without resultants."""
    count = law.update(np.zeros((1, 9 if isinstance(law, Layers) else 3)), np.zeros((1, law.remembered)))[0].shape[1]
    strains = np.zeros(count)
    strains[place] = curvature
    for _ in range(30):
        resultants, moduli, _ = driven(law, [strains])
        free = list(others)
        if not free or np.abs(resultants[free]).max() < 1e-12 * np.abs(resultants).max():
            break
        strains[free] -= np.linalg.solve(moduli[np.ix_(free, free)], resultants[free])
    return resultants[place]


@pytest.mark.parametrize("material", [STEEL, HARDENING], ids=["perfect", "hardening"])
@pytest.mark.parametrize("kind", ["layers", "fibres in space", "fibres in the plane"])
def test_moduli_are_the_derivatives_of_the_resultants(material, kind):
    """Central differences, after a path that has yielded to another side; and symmetric.

    Fibres that flow perfectly keep a millionth of their elastic moduli.
    """
    law = {"layers": layers(material), "fibres in space": fibres(Rectangle(1.0, 2.0), material, 3),
           "fibres in the plane": fibres(Tube(2.0, 0.2), material)}[kind]
    count = law.update(np.zeros((1, 9)), np.zeros((1, law.remembered)))[0].shape[1] if kind == "layers" else (
        6 if "space" in kind else 3)
    generator = np.random.default_rng(3)
    first, strains = generator.uniform(-4e-3, 4e-3, (2, count))
    _, _, history = driven(law, [first])
    _, moduli, after = law.update(strains[None], history)
    assert np.abs(after - history).max() > 1e-4
    differences = np.column_stack([(law.update((strains + e)[None], history)[0][0]
                                    - law.update((strains - e)[None], history)[0][0]) / 2e-8
                                   for e in 1e-8 * np.eye(count)])
    elastic = law.update(np.zeros((1, count)), np.zeros((1, law.remembered)))[1]
    assert moduli[0] == pytest.approx(differences, rel=1e-5, abs=2e-6 * np.abs(elastic).max())
    assert np.abs(moduli[0] - moduli[0].T).max() < 1e-12 * np.abs(moduli).max()


def test_stress_stays_on_the_yield_surface_and_flow_is_normal_to_it():
    law, z = layers(HARDENING, 2), Plate(1.0, points=2).layers()[0]
    strains = np.array([3e-3, -1e-3, 2e-3, 0, 0, 0, 0, 0, 0.0])
    resultants, _, history = driven(law, [strains])
    values = history[0].reshape(2, REMEMBERED)
    assert values[0] == pytest.approx(values[1]) and len(z) == 2
    plastic, back, hardened = values[0, :3], values[0, 3:6], values[0, 6]
    x, y, s = resultants[:3] - back
    assert sqrt(x * x - x * y + y * y + 3 * s * s) == pytest.approx(200 + 5e3 * hardened, rel=1e-12)
    normal = np.array([2 * x - y, 2 * y - x, 6 * s])
    assert np.cross(plastic, normal) == pytest.approx(np.zeros(3), abs=1e-12 * np.abs(normal).max())
    assert hardened == pytest.approx(sqrt(4 / 3 * (plastic[0]**2 + plastic[1]**2 + plastic[0] * plastic[1]
                                                   + plastic[2]**2 / 4)), rel=1e-12)


@pytest.mark.parametrize("isotropic", [0.0, 5e3])
@pytest.mark.parametrize("kinematic", [0.0, 8e3])
def test_tension_of_a_plate_and_of_a_fibre(isotropic, kinematic):
    """sigma = (sigma_y + H e) E / (E + H), and at reversal kinematic hardening yields earlier."""
    material = Plastic(200e3, 0.3, yield_stress=200.0, hardening=isotropic, kinematic=kinematic)
    total = isotropic + kinematic
    strain = 4e-3
    expected = (200 + total * strain) / (1 + total / 200e3)
    flow = strain - expected / 200e3
    bar = Fibres([(0.0, 0.0)], [1.0], material, [200e3])
    assert driven(bar, [[strain]])[0][0] == pytest.approx(expected, rel=1e-12)
    assert moment(layers(material), strain, 0, (1, 2)) == pytest.approx(expected, rel=1e-10)
    again = kinematic * flow - (200 + isotropic * flow)  # stress at which it yields back
    back = strain - (expected - again) / 200e3
    assert driven(bar, [[strain], [back + 1e-9]])[1][0, 0] == pytest.approx(200e3)
    assert driven(bar, [[strain], [back - 1e-9]])[1][0, 0] == pytest.approx(max(200e3 * total / (200e3 + total), 0.2))


def exact_rectangle(times):
    """Moment of a rectangle over its yield moment at a multiple of the yield curvature, perfect plasticity."""
    return 1.5 - 0.5 / times**2


def exact_tube(times):
    """Moment of a thin-walled tube over its yield moment, by integration: stress min(1, times |sin|) sign."""
    angle = np.arcsin(1 / times)
    return 4 / pi * (times * (angle / 2 - np.sin(2 * angle) / 4) + np.cos(angle))


@pytest.mark.parametrize(("rule", "points", "tolerance"), [
    ("gauss", 3, 0.18), ("gauss", 5, 0.06), ("gauss", 7, 0.04), ("gauss", 11, 0.02),
    ("lobatto", 5, 0.12), ("lobatto", 11, 0.03), ("simpson", 5, 0.13), ("simpson", 11, 0.04)])
def test_moment_and_curvature_of_a_rectangle(rule, points, tolerance):
    """Largest error up to ten times the yield curvature: with the layers it falls as their distance."""
    law = Fibres(np.column_stack((Plate(1.0, points=points, rule=rule).layers()[0], np.zeros(points))),
                 Plate(1.0, points=points, rule=rule).layers()[1], STEEL, [200e3, 1.0, 200e3 / 12])
    first, largest = 2 * 200 / 200e3, 200 / 6
    found = [moment(law, t * first, 2) / largest / exact_rectangle(t) - 1 for t in np.linspace(1.01, 10, 40)]
    assert np.abs(found).max() < tolerance
    assert moment(law, 0.5 * first, 2) == pytest.approx(0.5 * largest, rel=1e-12)


def test_moment_and_curvature_of_a_thin_tube():
    law = fibres(Tube(1.0, 1e-3), STEEL)
    middle = 0.4995
    first, largest = 200 / 200e3 / middle, pi * middle**2 * 1e-3 * 200
    for times in (1.5, 3.0, 8.0):
        assert moment(law, times * first, 2) / largest == pytest.approx(exact_tube(times), rel=1e-2)


def test_fully_plastic_moments_of_sections():
    """Limits at large curvature: b d^2 / 4, d^3 / 6, 4 R^2 t, and a tee about its plastic axis (closed forms)."""
    assert moment(fibres(Rectangle(1.0, 2.0, points=20), STEEL), 1e3, 2) == pytest.approx(200.0, rel=2e-2)
    assert moment(fibres(round_bar(1.0, 20), STEEL), 1e3, 2) == pytest.approx(200 / 6, rel=2e-2)
    tee = Flanged(Rectangle(1.0, 8.0, points=40), 8.0, 1.0, 4.5)  # equal areas: the plastic axis is between them
    law = fibres(tee, STEEL)
    axial = brentq(lambda e: driven(law, [[e, 0.0, 1e3]])[0][0], -1e4, 1e4)
    assert driven(law, [[axial, 0.0, 1e3]])[0][2] == pytest.approx(200 * (8 * 4 + 8 * 0.5), rel=2e-2)
    two = FibreList(((1.0, 0.0), (-1.0, 0.0)), (1.0, 1.0), torsion=1.0)
    assert moment(fibres(two, STEEL), 1e3, 2) == pytest.approx(400.0, rel=1e-12)


def test_plate_bends_to_a_cylinder():
    """No lateral curvature: stiffness E / (1 - nu^2), and in the limit a stress of 2 / sqrt(3) of the yield stress."""
    law = layers(STEEL, 20)
    bending = 200e3 / 12 / 0.91
    assert moment(law, 1e-3, 3) == pytest.approx(1e-3 * bending, rel=1e-12)
    assert moment(law, 1.0, 3) == pytest.approx(2 / sqrt(3) * 200 / 4, rel=1e-2)


def test_residual_stress_after_unloading():
    """Rectangle bent to 3 times its yield curvature and let go: k - M / EI stays, and stresses that balance."""
    law = fibres(Rectangle(1.0, 1.0, points=40), STEEL)
    first, stiffness = 2 * 200 / 200e3, 200e3 / 12
    largest = moment(law, 3 * first, 2)
    left = 3 * first - largest / stiffness
    resultants, moduli, history = driven(law, [[0, 0, 3 * first], [0, 0, left]])
    assert abs(resultants[2]) < 1e-10 * largest
    assert moduli[2, 2] == pytest.approx(stiffness, rel=1e-12)
    assert left / first == pytest.approx(3 - exact_rectangle(3.0), rel=5e-3)
    plastic, y = history.reshape(-1, 3)[:, 0], law._arms[:, 2]
    stress = 200e3 * (y * left - plastic)
    outer = np.argmax(np.abs(y))
    assert stress[outer] * np.sign(y[outer]) == pytest.approx(
        200 - 2 * abs(y[outer]) * 200 * exact_rectangle(3.0), rel=2e-2)


@pytest.mark.parametrize("points", [3, 5])
def test_points_that_never_yield_are_elastic(points):
    law = layers(STEEL, points)
    strains = np.array([2e-4, -1e-4, 1e-4, 5e-4, 0, 0, 1e-3, 0, 1e-4])
    resultants, moduli, history = driven(law, [strains])
    assert not history.any()
    elastic = law.update(np.zeros((1, 9)), history)[1][0]
    assert np.array_equal(moduli, elastic)
    assert np.array_equal(resultants, elastic @ strains)


@pytest.mark.parametrize(("build", "message"), [
    (lambda: Plastic(1.0, 0.3), "Plastic: yield_stress is 0.0; it must be positive"),
    (lambda: Plastic(1.0, 0.3, yield_stress=1.0, hardening=-1.0), "at or below minus the modulus 1.0"),
    (lambda: Plastic(1.0, 0.3, yield_stress=1.0, kinematic=-0.1), "kinematic is -0.1; it must be zero or positive"),
    (lambda: Plate(1.0, points=1), "Plate: points is 1; bending needs at least 2 by the rule 'gauss'"),
    (lambda: Plate(1.0, points=4, rule="simpson"), "Simpson's rule needs an odd number"),
    (lambda: Plate(1.0, rule="midpoint"), "Plate: rule is 'midpoint'; it must be one of gauss, lobatto, simpson"),
    (lambda: Rectangle(1.0, 1.0, points=1), "Rectangle: points is 1; bending needs at least 2"),
    (lambda: layers(Plastic(1.0, 0.3, yield_stress=1.0, hardening=-0.1)), "layers of a shell need 0 or more"),
    (lambda: FibreList(((1.0, 0.0),), (1.0,), 1.0), "FibreList: the centroid of its fibres is"),
])
def test_wrong_input_is_named_with_a_remedy(build, message):
    with pytest.raises(ValueError, match=message):
        build()
