"""Sections by their outline or their constants, and sections that vary along a beam, against published values."""

from __future__ import annotations

import warnings
from math import cos, pi, sin, tanh

import numpy as np
import pytest
import ufl
from helpers import response, straight

import sheetfx as fx

MATERIAL = fx.Elastic(2.1e5, 0.3)


def regular(count, radius, turned=0.0):
    angles = turned + 2 * pi * np.arange(count) / count
    return tuple((radius * cos(a), radius * sin(a)) for a in angles)


def of_rectangle(depth, width):
    """A, I about the normal and the binormal, product, torsion (Timoshenko and Goodier 1970, eq. 170)."""
    ratio = max(depth, width) / min(depth, width)
    series = sum(tanh(n * pi * ratio / 2) / n**5 for n in range(1, 40, 2))
    torsion = max(depth, width) * min(depth, width) ** 3 / 3 * (1 - 192 / pi**5 / ratio * series)
    return depth * width, depth * width**3 / 12, width * depth**3 / 12, 0.0, torsion


def thin_channel(depth, width, t):
    """Distance of the shear centre from the web's middle (Vlasov 1961, table 2), and warping constant."""
    b, h = width - t / 2, depth - t
    return 3 * b**2 / (6 * b + h), t * b**3 * h**2 / 12 * (3 * b + 2 * h) / (6 * b + h)


# A, I about the normal and the binormal, product and torsion constant; shear centre from the centroid. Of profiles the
# first four are sums of rectangles and fillets, as in tables of EN 10365 (A, I); torsion constants and shear centres
# are those of sectionproperties 3 on fine meshes, as tables have them by formulas that differ by some percent.
SECTIONS = {
    "rectangle": (fx.PolygonSection(((0, 0), (0, 20), (50, 20), (50, 0))), of_rectangle(50.0, 20.0), (0, 0)),
    # Timoshenko and Goodier 1970, section 109: the root of 3 by 80 times the fourth power of a side
    "triangle": (fx.PolygonSection(regular(3, 1 / 3**0.5)),
                 (3**0.5 / 4, 3**0.5 / 96, 3**0.5 / 96, 0, 3**0.5 / 80), (0, 0)),
    # Roark, table 10.7: 0.1154 times the fourth power of the distance between opposite sides
    "hexagon": (fx.PolygonSection(regular(6, 1 / 3**0.5)), (3**0.5 / 2, 0.0601407, 0.0601407, 0, 0.1154), (0, 0)),
    "round tube": (fx.PolygonSection(regular(90, 50), (regular(90, 45),)),
                   (pi * 475, pi / 4 * (50**4 - 45**4), pi / 4 * (50**4 - 45**4), 0, pi / 2 * (50**4 - 45**4)), (0, 0)),
    # Timoshenko and Goodier 1970, sections 109 and 126: shear centre 8 / (5 pi) from the middle without contraction
    "half a disc": (fx.PolygonSection(tuple((sin(a), cos(a)) for a in np.linspace(0, pi, 91))),
                    (pi / 2, pi / 8, pi / 8 - 8 / (9 * pi), 0, 0.2976), (8 / (5 * pi) - 4 / (3 * pi), 0)),
    "IPE 300": (fx.ISection(300, 150, 7.1, 10.7, 15), (5381, 603.8e4, 8356e4, 0, 197.85e3), (0, 0)),
    "HE 200 B": (fx.ISection(200, 200, 9, 15, 18), (7808, 2003e4, 5696e4, 0, 596.66e3), (0, 0)),
    "UPE 200": (fx.CSection(200, 80, 6, 11, 13), (2901, 187.3e4, 1909e4, 0, 88.92e3), (0, -52.42)),
    "L 150 x 90 x 12": (fx.LSection(150, 90, 12, 12, 6), (2751.55, 170.843e4, 627.267e4, -187.539e4, 137.89e3),
                        (8.327 - 50.820, 6.211 - 21.159)),
    "Z": (fx.ZSection(200, 70, 5, 5), (1650, 102.719e4, 951.375e4, 221.8125e4, 13.7245e3), (0, 0)),
    "T": (fx.TSection(100, 100, 8, 8), (1536, 67.0592e4, 148.1725e4, 0, 32.738e3), (23.423, 0)),
    "box": (fx.Box(200, 100, 10, 15), (5427.2, 859.49e4, 2614.0e4, 0, 2161.56e4), (0, 0)),
    "unequal flanges": (fx.ISection(300, 100, 8, 10, 0, 180, 16), (6072, 862.1024e4, 8199.05387e4, 0, 316.19e3),
                        (-71.589, 0)),
}


@pytest.mark.parametrize("name", SECTIONS)
def test_constants_against_tables(name):
    """Half a percent; shear centres by half a percent of the depth."""
    section, (area, about_normal, about_binormal, product, torsion), centre = SECTIONS[name]
    assert section.area == pytest.approx(area, rel=5e-3)
    assert section.second_moments == pytest.approx((about_normal, about_binormal), rel=5e-3)
    assert section.product == pytest.approx(product, rel=5e-3, abs=1e-9 * about_normal)
    assert section.torsion == pytest.approx(torsion, rel=5e-3)
    assert section.shear_centre == pytest.approx(centre, abs=5e-3 * section.depth)
    places, areas = section.fibres()
    assert (areas @ places[:, 1]**2, areas @ places[:, 0]**2) == pytest.approx(section.second_moments)
    assert areas @ places == pytest.approx(np.zeros(2), abs=1e-9 * areas.sum() * section.depth)


def test_thin_channel_against_vlasov():
    """Shear centre and warping constant by thin walls."""
    section = fx.CSection(200, 80, 2, 2)
    distance, warping = thin_channel(200, 80, 2)
    assert section.shear_centre[1] + section.centroid[1] - 1 == pytest.approx(-distance, rel=5e-3)
    assert section.warping == pytest.approx(warping, rel=5e-3)


@pytest.mark.parametrize("name", ["UPE 200", "L 150 x 90 x 12", "Z", "box"])
@pytest.mark.slow
def test_a_section_turned_with_its_depth_is_the_same(name):
    """Displacements by a skew force of a cantilever whose section and `up` turn by 90 degrees against each other.

    Torsion constant and shear centre of the turned outline are those of another mesh; given constants are the same.
    """
    section, found = SECTIONS[name][0], []
    (y, z), shear, length = section.shear_centre, section.shear, 40 * section.area**0.5
    turned = fx.GivenSection(section.area, section.second_moments[::-1], section.torsion, -section.product,
                             tuple(np.diag(shear)[::-1]), (z, -y))
    if shear[0, 1]:
        length = 400 * section.area**0.5  # so long that the coupling of shear does not matter
    outline, *holes = (tuple((float(c), -float(a)) for a, c in ring) for ring in section.rings)
    for made, up in ((section, (0.0, 0.0, 1.0)), (turned, (0.0, -1.0, 0.0)),
                     (fx.PolygonSection(outline, holes), (0.0, -1.0, 0.0))):
        mesh = straight(4, length, dimension=3)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            beam = fx.Beam(mesh, made, MATERIAL, up=up)
        force = tuple(1e-4 * MATERIAL.modulus * min(section.second_moments) / length**2 * np.array([0.0, 1.0, 0.5]))
        scene = [fx.Scene([beam], [fx.clamp(mesh, "base")], [fx.PointForce(mesh, "tip", force)],
                          fx.Monitor(mesh, "tip", c)) for c in "yz"]
        found.append([response(s) for s in scene])
    assert found[1] == pytest.approx(found[0], rel=1e-4)
    assert found[2] == pytest.approx(found[0], rel=3e-3)


def test_open_sections_warn_of_warping():
    mesh = straight(1, 3000.0, dimension=3)
    for section in (fx.ISection(300, 150, 7.1, 10.7), fx.CSection(200, 80, 6, 11), fx.ZSection(200, 70, 5, 5),
                    fx.GivenSection(5381, (603.8e4, 8356e4), 20.12e4, warping=125.9e9, depth=300.0)):
        with pytest.warns(UserWarning, match="do not model warping"):
            fx.Beam(mesh, section, MATERIAL)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for section in (fx.Box(200, 100, 5), fx.LSection(100, 100, 10), fx.Rectangle(10, 100), fx.Tube(100, 5)):
            fx.Beam(mesh, section, MATERIAL)


@pytest.mark.parametrize(("given", "said"), [
    (lambda: fx.PolygonSection(((0, 0), (1, 1), (1, 0), (0, 2))), "edges that cross"),
    (lambda: fx.PolygonSection(((0, 0), (1, 0), (2, 0))), "no area"),
    (lambda: fx.PolygonSection(((0, 0), (1, 0), (1, 0), (0, 1))), "twice"),
    (lambda: fx.PolygonSection(((0, 0), (1, 0), (0, 1)), (((2, 2), (3, 2), (2, 3)),)), "not inside"),
    (lambda: fx.ISection(20, 150, 7, 10.7), "leaves no web"), (lambda: fx.Box(20, 10, 5), "leaves no hole"),
    (lambda: fx.GivenSection(1.0, (1.0, 1.0), 1.0, product=1.0), "product")])
def test_outlines_that_are_none(given, said):
    with pytest.raises(ValueError, match=said):
        given()


# --- functions of the place

def factor(part, mesh, force, at):
    scene = fx.Scene([part], [fx.clamp(mesh, "base" if at == "tip" else "west")], [force], fx.Monitor(mesh, at, "x"))
    record = fx.trace(fx.Case(scene, until=fx.Until(steps=0)))
    return abs(record.buckling(record.states[0], count=1)[0].factor)


@pytest.mark.slow
def test_tapered_column_and_plate():
    """A cantilever whose depth falls to one half buckles at 2227.378 N (shooting of E I(x) y'' + P y = 0)."""
    depth = lambda x: 0.01 * (1 - 0.5 * x[0])  # noqa: E731
    material = fx.Elastic(2e11, 0.0)
    for dimension in (2, 3):
        mesh = straight(8, 1.0, dimension=dimension)
        force = fx.PointForce(mesh, "tip", (-1.0, 0.0, 0.0)[:dimension])
        beam = fx.Beam(mesh, fx.Rectangle(0.1, depth), material)
        assert factor(beam, mesh, force, "tip") == pytest.approx(2227.378, rel=2e-4)
    for form in ("naghdi-q2", "naghdi-t2"):
        mesh = fx.read(lambda t=form[-2] == "t": fx.meshes.rectangle((8, 1), (1.0, 0.1), triangles=t), 3)
        shell = fx.Shell(mesh, fx.Plate(depth), material, form=form)
        assert factor(shell, mesh, fx.EdgeForce(mesh, "east", (-10.0, 0.0, 0.0)), "south-east") == pytest.approx(
            2227.378, rel=1e-3)


def test_steps_of_a_measure_are_those_of_groups():
    """A stepped column: a function that jumps between two cells, and a beam for each group."""
    found = []
    for grouped in (True, False):
        mesh = fx.read(lambda: fx.meshes.frame({"base": (0, 0), "mid": (1, 0), "tip": (2, 0)},
                                               {"one": ("base", "mid", 4), "two": ("mid", "tip", 4)}), 2)
        step = lambda x: ufl.conditional(ufl.lt(x[0], 1.0), 0.02, 0.01)  # noqa: E731
        parts = ([fx.Beam(mesh, fx.Rectangle(0.1, d), MATERIAL, group=g) for g, d in (("one", 0.02), ("two", 0.01))]
                 if grouped else [fx.Beam(mesh, fx.Rectangle(0.1, step), MATERIAL)])
        found.append(response(fx.Scene(parts, [fx.clamp(mesh, "base")], [fx.PointForce(mesh, "tip", (0.0, 1e-4))],
                                       fx.Monitor(mesh, "tip", "y"))))
    assert found[0] == pytest.approx(found[1], rel=1e-9)


@pytest.mark.slow
def test_pretwisted_beam():
    """MacNeal and Harder's beam, twisted by 90 degrees (Zupan and Saje 2004)."""
    angle = lambda x: x[0] / 12 * pi / 2  # noqa: E731
    mesh = straight(12, 12.0, dimension=3)
    beam = fx.Beam(mesh, fx.Rectangle(0.32, 1.1), fx.Elastic(29e6, 0.22),
                   up=lambda x: ufl.as_vector([0, ufl.cos(angle(x)), ufl.sin(angle(x))]))
    for component, right in (("z", 5.4245e-3), ("y", 1.7532e-3)):
        force = (0.0, 1e-3 * (component == "y"), 1e-3 * (component == "z"))
        scene = fx.Scene([beam], [fx.clamp(mesh, "base")], [fx.PointForce(mesh, "tip", force)],
                         fx.Monitor(mesh, "tip", component))
        assert response(scene) * 1e3 == pytest.approx(right, rel=5e-3)


@pytest.mark.slow
def test_frequencies_of_a_tapered_wedge():
    """A wedge that is clamped at its base: omega L^2 = 5.315 root(E I_0 / (rho A_0)) (Kirchhoff 1879; Mabie 1964)."""
    mesh = straight(16, 1.0, dimension=3)
    material = fx.Elastic(2e11, 0.3, density=7850.0)
    beam = fx.Beam(mesh, fx.Rectangle(0.1, lambda x: 0.01 * (1 - x[0])), material)
    path = fx.Path(fx.Scene([beam], [fx.clamp(mesh, "base")], [fx.PointForce(mesh, "tip", (0.0, 0.0, 1e-9))],
                            fx.Monitor(mesh, "tip", "z")))
    lowest = fx.frequencies(path, next(iter(path)), 1)[0].frequency
    assert 2 * pi * lowest == pytest.approx(5.315 * (2e11 / 7850 * 0.01**2 / 12)**0.5, rel=3e-3)


@pytest.mark.parametrize(("made", "said"), [
    (lambda mesh: fx.Flanged(fx.Rectangle(0.1, lambda x: x[0]), 1.0, 0.1), "Flanged: depth of its bar"),
    (lambda mesh: fx.Beam(mesh, fx.Rectangle(0.1, lambda x: 0.5 - x[0]), MATERIAL), "at the place .* depth is"),
    (lambda mesh: fx.Beam(mesh, fx.Rectangle(0.1, lambda x: x), MATERIAL), "one number"),
    (lambda mesh: fx.Beam(mesh, fx.Rectangle(0.1, 0.1), MATERIAL, up=lambda x: (1.0, 0.0, 0.0)), "up is parallel"),
    (lambda mesh: fx.Beam(mesh, fx.Rectangle(0.1, 0.1), MATERIAL, up=lambda x: (1.0, 0.0)), "up gives"),
    (lambda mesh: fx.Beam(mesh, fx.Rectangle(0.1, lambda x: 1 + x[0]), fx.Plastic(1.0, yield_stress=1.0)), "depth")])
def test_functions_that_give_no_section(made, said):
    with pytest.raises(ValueError, match=said):
        made(straight(2, 1.0, dimension=3))
