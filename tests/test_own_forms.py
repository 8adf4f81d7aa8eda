"""Strain measures and section laws of one's own are refused, or accepted, before a compiler starts."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import numpy as np
import pytest
import ufl
from ufl import as_vector, dot

import sheetfx as fx
from sheetfx.forms.shell import ShellStrains, biot, naghdi


class Compiled(Exception):
    """A part has passed its checks and goes on to what needs a compiler."""


@pytest.fixture(autouse=True)
def no_compiler(monkeypatch):
    def refuse(*_, **__):
        raise Compiled

    for module in ("jit", "mesh.cellwise", "model.beam"):
        monkeypatch.setattr(f"sheetfx.{module}.compiled_expression", refuse)
    monkeypatch.setattr("sheetfx.jit.compiled_form", refuse)


def barrel(x):
    return np.column_stack((x[:, 0], 5 * np.sin(0.3 * x[:, 1]), 5 * np.cos(0.3 * x[:, 1])))


MESHES = {
    "plane": lambda: fx.read(lambda: fx.meshes.arc(10.0, 0.0, 0.2, 2, {"crown": 0.0}), 2, 2),
    "space": lambda: fx.read(lambda: fx.meshes.frame({"a": (0, 0, 0), "b": (1, 2, 0.5)}, {"m": ("a", "b", 1)}), 3),
    "quads": lambda: fx.read(lambda: fx.meshes.rectangle((1, 1)), 3, 2, place=barrel),
    "triangles": lambda: fx.read(lambda: fx.meshes.rectangle((1, 1), triangles=True), 3, 1, place=barrel),
}
STEEL = fx.Elastic(1e5, 0.3)
MAKE = {
    "plane": lambda mesh, **own: fx.Beam(mesh, fx.Rectangle(1.0, 0.1), STEEL, **own),
    "space": lambda mesh, **own: fx.Beam(mesh, fx.Rectangle(0.2, 0.1), STEEL, **own),
    "bar": lambda mesh, **own: fx.Bar(mesh, fx.Rectangle(0.2, 0.1), STEEL, **own),
    "quads": lambda mesh, **own: fx.Shell(mesh, fx.Plate(0.1), STEEL, form="naghdi-q2", **own),
    "triangles": lambda mesh, **own: fx.Shell(mesh, fx.Plate(0.1), STEEL, form="naghdi-t2", **own),
}


@pytest.fixture(scope="module")
def meshes():
    made = {kind: make() for kind, make in MESHES.items()}
    return made | {"bar": made["space"]}


def refused(meshes, kind, words, **own):
    with pytest.raises(ValueError, match=words) as caught:
        MAKE[kind](meshes[kind], **own)
    assert "\n" not in str(caught.value)


def exact(u, r, f):
    return [*fx.forms.beam.simo_reissner(u, r, f)]


def put(place, value):
    """The exact beam with another strain in a place."""
    def measure(u, r, f):
        strains = exact(u, r, f)
        strains[place] = value(u, r, f, strains[place])
        return as_vector(strains)
    return measure


BEAMS = {
    "number": (lambda u, r, f: as_vector(exact(u, r, f)[:2]), r"UFL of shape \(2,\); return a UFL vector of "),
    "list": (exact, "return a UFL vector of "),
    "None": (lambda u, r, f: None, "returns None; return a UFL vector of "),
    "attribute": (lambda u, r, f: f.tangents, "fails in line [0-9]+: 'CurveFrame' object has no attribute 'tangents'"),
    "arguments": (lambda u: u, "fails: .* takes 1 positional argument"),
    "zero": (put(1, lambda u, r, f, e: 0 * e), "shear.* is zero in all small motions"),
    "not zero": (put(0, lambda u, r, f, e: e + 1e-3), "axial is 0.001 at rest"),
    "sign": (put(1, lambda u, r, f, e: 2 * dot(f.along(u), f.normal) - e), "shear.* rigid rotation by an angle of 1"),
    "place": (put(0, lambda u, r, f, e: e + u[0]), "axial is .* in a rigid translation"),
    "root": (put(0, lambda u, r, f, e: e + ufl.sqrt(dot(u, u))), "axial is nan at rest in its derivative"),
    "logarithm": (put(0, lambda u, r, f, e: e + ufl.ln(u[0])), "axial is (-inf|nan) at rest"),
    "complex": (put(1, lambda u, r, f, e: 1j * e), "shear.* is complex"),
    "second": (put(1, lambda u, r, f, e: e + ufl.grad(ufl.grad(u))[0, 0, 0]), "second derivatives"),
    "index": (put(1, lambda u, r, f, e: e * u[5]), "fails in line [0-9]+: .*out of bounds"),
    "math": (put(1, lambda u, r, f, e: math.sin(e)), "fails in line [0-9]+: .*ufl.exp, not those of math"),
    "numpy": (put(1, lambda u, r, f, e: np.sin(e)), "fails in line [0-9]+: .*ufl.sin, not those of numpy"),
    "if": (put(1, lambda u, r, f, e: e if e > 0 else -e), "fails in line [0-9]+: .*use ufl.conditional, not if"),
}


@pytest.mark.parametrize("kind", ["plane", "space"])
@pytest.mark.parametrize("name", BEAMS)
def test_wrong_strains_of_beams(meshes, kind, name):
    function, words = BEAMS[name]
    refused(meshes, kind, f"Beam: its strains .*{words}", strains=function)


@pytest.mark.parametrize(("function", "words"), [
    (lambda u, r, f: dot(f.along(u), f.tangent), r"UFL of shape \(\); return a UFL vector of 1"),
    (lambda u, r, f: as_vector([dot(f.along(u), f.along(u))]), "axial is zero in all small motions"),
    (lambda u, r, f: as_vector([ufl.sqrt(dot(f.along(u), f.along(u)))]), "axial is nan at rest in its derivative"),
    (lambda u, r, f: as_vector([dot(f.along(u), as_vector([1.0, 0.0, 0.0]))]), "axial is .* in a rigid rotation"),
    (lambda u, r, f: as_vector([r.angle]), "fails in line [0-9]+: 'NoneType' object has no attribute 'angle'")])
def test_wrong_strains_of_bars(meshes, function, words):
    refused(meshes, "bar", f"Bar: its strains '<lambda>'.* ?{words}", strains=function)


def marguerre(u, rotation, frame, drill=1.0):
    """Shallow shell: on curved cells its bending changes with a rotation about the normal, as such theories have it."""
    t, n = frame.tangents, frame.director
    d, rate = rotation.rotate(n), [frame.along(u, a) for a in t]

    def symmetric(m):
        return as_vector([m(0, 0), m(1, 1), m(0, 1) + m(1, 0)])

    return ShellStrains(
        membrane=symmetric(lambda a, b: (dot(rate[a], t[b]) + dot(rate[b], t[a])) / 2
                           + dot(rate[a], n) * dot(rate[b], n) / 2),
        bending=symmetric(lambda a, b: dot(frame.along(d, t[b]) - frame.along(n, t[b]), t[a])),
        shear=as_vector([dot(rate[a], n) + dot(d, t[a]) for a in range(2)]),
        drilling=dot(rotation.rotate(t[1]), t[0]) + drill * (dot(rate[0], t[1]) - dot(rate[1], t[0])) / 2)


def with_(**parts):
    return lambda u, r, f: replace(s := marguerre(u, r, f), **{k: v(u, r, f, s) for k, v in parts.items()})


SHELLS = {
    "sign": (with_(shear=lambda u, r, f, s: as_vector(
        [dot(f.along(u, a), f.director) - dot(r.rotate(f.director), a) for a in f.tangents])), "shear .*rotation"),
    "no drilling": (with_(drilling=lambda *_: 0.0), "drilling is zero in all small motions"),
    "no shear": (with_(shear=lambda *_: as_vector([0.0, 0.0])), "shear 1 is zero in all small motions"),
    "length": (with_(membrane=lambda u, r, f, s: as_vector([s.membrane[0]] * 2)), r"membrane as UFL of shape \(2,\)"),
    "list": (with_(membrane=lambda u, r, f, s: [0, 0, 0]), r"membrane as \[0, 0, 0\]; return a UFL vector of 3"),
    "vector": (lambda u, r, f: marguerre(u, r, f).vector, r"UFL of shape \(9,\); return a forms.shell.ShellStrains"),
    "None": (lambda u, r, f: None, "returns None; return a forms.shell.ShellStrains"),
    "not zero": (with_(bending=lambda u, r, f, s: s.bending + as_vector([0, 0, 1e-3])), "bending 12 is 0.001 at rest"),
    "complex": (with_(drilling=lambda u, r, f, s: 1j * s.drilling), "drilling is complex"),
    "coordinate": (with_(drilling=lambda u, r, f, s: s.drilling * ufl.SpatialCoordinate(f.domain)[5]), "out of bounds"),
    "root": (with_(drilling=lambda u, r, f, s: s.drilling + ufl.sqrt(dot(u, u))), "drilling is nan at rest"),
    "second": (with_(drilling=lambda u, r, f, s: s.drilling + ufl.grad(ufl.grad(u))[0, 0, 0]), "second derivatives"),
}


@pytest.mark.parametrize("kind", ["quads", "triangles"])
@pytest.mark.parametrize("name", SHELLS)
def test_wrong_strains_of_shells(meshes, kind, name):
    function, words = SHELLS[name]
    refused(meshes, kind, f"Shell: its strains .*{words}", strains=function)


def test_drilling_against_the_surface_is_told(meshes):
    """It resists in-plane rotations alone, so that plates whose edges hold these have the same answers."""
    with pytest.warns(UserWarning, match="drilling is -2 in a rigid rotation about the normal"):
        accepted(meshes, "quads", strains=lambda u, r, f: marguerre(u, r, f, -1.0))


def coupled(extra):
    """The linear law with something added to its first resultant."""
    def law(s, k):
        linear = fx.forms.section.linear_elastic if isinstance(k, list) else fx.forms.section.linear_shell
        found = [*linear(s, k)]
        found[0] = found[0] + extra(s)
        return as_vector(found)
    return law


LAWS = {
    "coupling": (coupled(lambda s: s[2]), r"not the gradient of an energy: resultant 0 \(.*\) changes by .*, at rest"),
    "quadratic coupling": (coupled(lambda s: s[2] ** 2), "not the gradient of an energy: .* at strains of 0.001"),
    "negative": (lambda s, k: -coupled(lambda s: 0)(s, k), "negative stiffness at rest"),
    "none": (lambda s, k: 0 * coupled(lambda s: 0)(s, k), r"resultant 0 \(.*\) has no stiffness by its strain"),
    "root": (coupled(lambda s: s[0] ** 0.5), r"(resultant|stiffness) 0 \(.*\) is (nan|inf)"),
    "logarithm": (coupled(lambda s: ufl.ln(s[0])), r"resultant 0 \(.*\) is -inf at rest"),
    "complex": (coupled(lambda s: 1j * s[0]), "resultant is complex"),
    "short": (lambda s, k: as_vector([s[0], s[1]]), r"UFL of shape \(2,\); return a UFL vector of"),
    "scalar": (lambda s, k: dot(s, s), r"UFL of shape \(\); return a UFL vector of"),
    "None": (lambda s, k: None, "returns None; return a UFL vector of"),
    "numbers": (lambda s, k: np.zeros(9), "return a UFL vector of"),
    "math": (coupled(lambda s: math.exp(s[0])), "fails in line [0-9]+: .*ufl.exp, not those of math"),
    "if": (coupled(lambda s: s[0] if s[0] > 0 else 0), "fails in line [0-9]+: .*use ufl.conditional, not if"),
    "arguments": (lambda s: s, "fails: .* takes 1 positional argument"),
}


@pytest.mark.parametrize("kind", ["plane", "space", "quads"])
@pytest.mark.parametrize("name", LAWS)
def test_wrong_laws(meshes, kind, name):
    function, words = LAWS[name]
    refused(meshes, kind, f": its law .*{words}", law=function)


def accepted(meshes, kind, **own):
    try:
        MAKE[kind](meshes[kind], **own)
    except Compiled:
        pass


def slack(s, k):
    """Without stiffness in compression, and at rest by UFL's derivative."""
    return as_vector([ufl.conditional(ufl.gt(s[0], 0), k[0] * s[0], 0)])


def kinked(s, k):
    return ufl.conditional(ufl.gt(s[0], 0), 1.0, 0.5) * fx.forms.section.linear_elastic(s, k)


def bent_otherwise(u, r, f):
    """Curvature with the other sign: a convention, which a law without couplings does not see."""
    return replace(s := marguerre(u, r, f), bending=-s.bending)


@pytest.mark.parametrize(("kind", "own"), [
    *((kind, {"strains": lambda *given: fx.forms.beam.simo_reissner(*given)}) for kind in ("plane", "space")),
    *(("bar", {"strains": s}) for s in (fx.forms.bar.green, lambda *given: fx.forms.bar.engineering(*given))),
    *((kind, {"strains": s}) for kind in ("quads", "triangles") for s in (naghdi, biot, marguerre, bent_otherwise)),
    ("bar", {"law": slack}), ("plane", {"law": kinked}), ("space", {"law": coupled(lambda s: 1e9 * s[0] ** 3)}),
    ("quads", {"law": coupled(lambda s: s[0] ** 3)})])
def test_right_forms_are_accepted(meshes, kind, own):
    accepted(meshes, kind, **own)


def test_messages_name_the_function_and_its_line(meshes):
    def measure(u, rotation, frame):
        return u[7]
    line = measure.__code__.co_firstlineno + 1
    refused(meshes, "plane", re.escape(f"Beam: its strains 'measure' fails in line {line}: "), strains=measure)
