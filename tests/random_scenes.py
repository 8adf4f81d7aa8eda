"""Random structures with pairs of features, each described in ways that must agree: turned, in halves, in stages."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import pi

import numpy as np
import ufl
from scipy.spatial.transform import Rotation

import sheetfx as fx
from sheetfx.model.reported import FACTOR, FORCE, LINE_PRESSURE, MOMENT, PRESSURE, counted

NONE = 1e-9  # of forces and energies of structures of a length and a stiffness of about 1
NEVER = 1e9  # yield stress over Young's modulus of what never yields
DOWN = {"bars": 1, "plane": 1, "space": 2, "shell": 2, "stiffened": 2}  # component along which structures bend
KINDS = tuple(DOWN)
SHARES = {"bars": 5, "plane": 6, "space": 4, "shell": 4, "stiffened": 1}  # of structures; the last ones cost most
FEATURES = {
    "bars": ("strains", "heat", "spring", "second load", "prescribed", "stage", "path", "foundation", "joint"),
    "plane": ("section", "strains", "offset", "heat", "spring", "foundation", "second load", "pressure", "moment",
              "prescribed", "imperfect", "obstacle", "stage", "path", "joint", "shear"),
    "space": ("section", "offset", "heat", "spring", "foundation", "second load", "moment", "prescribed", "imperfect",
              "obstacle", "stage", "path", "joint"),
    "shell": ("section", "strains", "offset", "spring", "foundation", "second load", "pressure", "prescribed",
              "imperfect", "obstacle", "stage", "path", "joint", "cells"),
    "stiffened": ("section", "offset", "spring", "second load", "pressure", "prescribed", "imperfect", "stage", "path"),
}
UNFIT = {"groups": ("joint",), "compatible": ("joint",), "weld": ("joint",), "half": ("joint",),
         "stages": ("stage", "obstacle"), "plastic": ("heat",),
         "processes": ("obstacle", "joint")}  # features that relations do without; on two processes these are refused
SAME_CELLS = "rotated", "mirrored", "units"  # relations of views whose cells and points are the same
RELATIONS = ("half", "groups", "compatible", "weld", "rotated", "mirrored", "units", "stages", "processes", "plastic",
             "restart", "balance")


@dataclass(frozen=True)
class View:
    """How a structure is described; it is always the same.

    Attributes
    ----------
    turn : orthogonal matrix that takes its places to those of the description
    length, force : units of the structure in those of the description
    half : the right half of it, with symmetry
    parts : "": one part; "groups", "compatible", "weld", "link", "penalty" or "hinge": two halves and what joins them
    staged : whether the first load comes in a stage before the others
    plastic : of a material that would yield, but never does
    """

    turn: np.ndarray = field(default_factory=lambda: np.eye(3))
    length: float = 1.0
    force: float = 1.0
    half: bool = False
    parts: str = ""
    staged: bool = False
    plastic: bool = False

    @property
    def side(self) -> float:
        """-1 where left and right are exchanged."""
        return round(float(np.linalg.det(self.turn)))

    @property
    def along_axes(self) -> bool:
        return bool(np.isin(np.abs(self.turn), (0.0, 1.0)).all())


@dataclass(frozen=True)
class Structure:
    """A strip from a (x = -1) over m (x = 0) to b (x = 1), as a beam, bars or a shell; see `draw`."""

    number: int
    kind: str
    relation: str
    features: tuple[str, ...]
    rise: float = 0.0
    tilt: float = 0.0
    width: float = 0.6
    up: tuple[float, float, float] = (0.0, 0.0, 1.0)
    cells: int = 2
    form: str = "naghdi-q2"
    ends: tuple[str, str] = ("clamp", "clamp")
    section: object = None
    poisson: float = 0.3
    shear_rigidity: float = 1.0
    offset: object = 0.0
    strains: object = None
    loads: tuple = ()
    spring: float = 0.0
    foundation: float = 0.0
    gap: float | None = None
    imperfect: tuple = ()
    joint: str = ""
    path: tuple = ("load", 1.0)
    extra: str = ""

    @property
    def dimension(self) -> int:
        return 2 if self.kind == "plane" else 3

    @property
    def surface(self) -> bool:
        return self.kind in ("shell", "stiffened")

    @property
    def symmetric(self) -> bool:
        return self.relation == "half"

    def __str__(self) -> str:
        return f"{self.number}: {self.kind}, {self.relation}, {' and '.join(self.features)}"


def draw(number: int) -> Structure:
    """The structure of a number: its relation by turns, all else at random."""
    random = np.random.default_rng(number)
    relation = RELATIONS[number % len(RELATIONS)]
    unfit = {"weld": ("bars", "stiffened"), "compatible": ("stiffened",)}.get(relation, ())
    kinds = [kind for kind in KINDS if kind not in unfit]
    shares = np.array([SHARES[k] for k in kinds])
    kind = str(random.choice(kinds, p=shares / shares.sum()))
    barred = UNFIT.get(relation, ())
    if (relation, kind) == ("weld", "shell"):
        barred += ("obstacle",)
    if relation == "plastic" and kind == "stiffened":
        barred += ("section",)
    pair = tuple(map(str, random.choice([f for f in FEATURES[kind] if f not in barred], 2, replace=False)))
    if relation == "stages" and not {"second load", "pressure", "moment", "heat"} & set(pair):
        pair = (*pair, "second load")
    return _drawn(Structure(number, kind, relation, pair), random)


def _drawn(s: Structure, random) -> Structure:
    down, has = np.eye(3)[DOWN[s.kind]], set(s.features)
    within = 1.0 - np.eye(3)[2] if s.kind == "plane" else np.ones(3)
    upright = within * (np.array((0.0, 1.0, 1.0)) if s.symmetric else 1.0)
    flat = random.uniform() < 0.3 and s.kind != "bars"
    s = replace(s, rise=0.0 if flat else random.uniform(0.15, 0.4), cells=int(random.integers(1, 3)),
                tilt=0.0 if s.symmetric or flat else random.uniform(-0.1, 0.1), poisson=random.uniform(0.0, 0.4),
                up=tuple(random.normal(size=3) * (0.3 * upright) + (0.0, 0.0, 1.0)), ends=_ends(s, random),
                section=_plain(s, random), extra=str(random.choice(6 * [""] + ["buckling", "frequencies"])))
    size = 0.02 if s.kind == "bars" else 0.15 if "free" in s.ends else 1.0
    loads = [("point", size * (random.uniform(0.3, 0.6) * -down + 0.1 * random.normal(size=3) * upright))]
    if "second load" in has:
        loads.append(("spread", size * random.normal(size=3) * 0.3 * upright))
    if "pressure" in has:
        loads.append(("pressure", size * random.uniform(-0.5, 0.5)))
    if "moment" in has:
        loads.append(("moment", 0.1 * size * random.normal(size=3) * (upright if s.kind != "plane" else 1 - within)))
    if "heat" in has:
        loads.append(("heat", random.uniform(-1e-3, 1e-3)))
    if "prescribed" in has:
        loads[0] = ("prescribed", random.uniform(-0.08, -0.02))
    fixed = has & {"prescribed", "obstacle", "second load"} or s.relation == "stages" or (flat and "heat" in has)
    if len(loads) > 1 and not fixed and random.uniform() < 0.5:
        del loads[0]  # what is reported is no force then
    if "section" in has:
        s = replace(s, section=_special(s, random))
    if "strains" in has:
        s = replace(s, strains={"bars": fx.forms.bar.green, "plane": reissner, "shell": fx.forms.shell.biot}[s.kind])
    if "offset" in has:
        s = replace(s, offset=tuple(random.uniform(-0.1, 0.1, 2)) if s.kind == "space" else random.uniform(-0.1, 0.1))
    if "spring" in has:
        s = replace(s, spring=random.uniform(0.5, 5.0) * size)
    if "foundation" in has:
        s = replace(s, foundation=random.uniform(0.5, 5.0) * size)
    if "shear" in has:
        s = replace(s, shear_rigidity=random.uniform(1.0, 30.0))
    if "imperfect" in has:
        s = replace(s, imperfect=(str(random.choice(("vector", "normal"))), random.uniform(0.005, 0.02)))
    if "joint" in has:
        s = replace(s, joint="hinge" if s.kind == "bars" else str(random.choice(("compatible", "weld"))))
    if "cells" in has and not {"section", "offset", "strains"} & has:
        s = replace(s, form="naghdi-q3" if s.symmetric else str(random.choice(("naghdi-q3", "naghdi-t2"))))
    if "obstacle" in has:
        loads = [("spread", -3 * size * down), *loads[1:]]
        s = replace(s, gap=random.uniform(0.003, 0.01))
    free = s.kind != "bars" or "prescribed" not in has  # bars have no node but m, and a stage must move something
    if "stage" in has and len(loads) == 1 and free:
        loads.insert(0, ("spread", size * random.normal(size=3) * 0.3 * upright))
    if "path" in has and s.gap is None:
        s = replace(s, path=(str(random.choice(("arc", "displacement"))), random.uniform(0.02, 0.06)))
        if s.kind == "bars" and loads[0][0] == "point":
            s = replace(s, path=("arc", random.uniform(0.3, 0.5)))
        if s.kind == "stiffened" or loads[0][0] != "point":
            s = replace(s, path=("arc", 0.1 * s.path[1]))
    if s.relation in ("restart", "balance") and s.path[0] == "load":
        s = replace(s, path=("load", 0.4))
    if s.symmetric or s.relation == "stages" or s.gap is not None:
        s = replace(s, extra="")
    return replace(s, loads=tuple(loads))


def _ends(s: Structure, random) -> tuple[str, str]:
    if s.kind == "bars":
        return "pin", "pin"
    pairs = [("clamp", "clamp"), ("pin", "pin")]
    if not s.symmetric:
        pairs += [("clamp", "pin"), ("clamp", "free"), ("clamp", "roller"), ("pin", "clamp")]
    if s.relation in ("rotated", "mirrored") and s.kind == "plane":
        pairs = [pair for pair in pairs if "roller" not in pair]
    if {"obstacle", "heat", "prescribed"} & set(s.features):
        pairs = [pair for pair in pairs if not {"free", "roller"} & set(pair)]
    if "moment" in s.features:
        pairs = [pair for pair in pairs if pair != ("clamp", "clamp")]
    return pairs[random.integers(len(pairs))]


def _plain(s: Structure, random):
    """A section as most have."""
    if s.surface:
        return fx.Plate(random.uniform(0.02, 0.08))
    return fx.Rectangle(random.uniform(0.05, 0.1), random.uniform(0.05, 0.15))


def _special(s: Structure, random):
    """A section of another kind; of a stiffened shell that of its rib."""
    plain = fx.Rectangle(*random.uniform(0.03, 0.1, 2))
    if s.kind == "shell":
        if s.relation == "plastic":
            return fx.Plate(0.05, rule="simpson", drilling=random.uniform(0.2, 1.0))
        angles = (0.0, 90.0) if s.symmetric else random.uniform(-90, 90, 2)
        return fx.Laminate([fx.Ply(t, a, *random.uniform((5.0, 1.0), (20.0, 2.0)), 0.2, *random.uniform(0.4, 0.8, 1))
                            for a, t in zip(angles, random.uniform(0.01, 0.03, len(angles)), strict=True)])
    name = random.choice(("tube", "flanged", "fibres"))
    if name == "tube":
        return fx.Tube(0.1, random.uniform(0.005, 0.04))
    if name == "flanged":
        return fx.Flanged(plain, *random.uniform(0.02, 0.1, 2), random.uniform(-0.1, 0.1))
    places, areas = 0.05 * random.normal(size=(5, 2)), random.uniform(1e-4, 1e-3, 5)
    places -= areas @ places / areas.sum()
    return _fibres(places, areas, areas @ (places**2).sum(axis=1), random.uniform(-0.02, 0.02, 2))


def _fibres(places, areas, torsion, centre):
    return fx.FibreList(tuple(map(tuple, places)), tuple(areas), torsion, shear_centre=tuple(centre))


def reissner(u, rotation, frame):
    """The built-in strains, written by a user."""
    stretch = rotation.pull_back(frame.tangent + frame.along(u)) - frame.tangent
    return ufl.as_vector([ufl.dot(stretch, a) for a in frame.axes] + rotation.bending(frame))


class Heat(fx.Load):
    """An initial strain along beams or bars."""

    def __init__(self, part, force):
        self.part, self.force = part, force

    def work(self, fields):
        part = self.part
        e = part.strains(fields.displacement(part.mesh), fields.rotation(part.mesh), part.frame())
        return fields.factor * self.force * fields.vary(e[0]) * part.measure()


class Builder:
    """A structure as a view has it."""

    def __init__(self, structure: Structure, view: View):
        self.s, self.v = structure, view
        self.joint = view.parts or structure.joint
        self.meshes, self.ribs = self._meshes()
        self.left, self.right = self.meshes[0], self.meshes[-1]
        self.parts, self.bars = self._parts(), self._ribs()

    # Quantities of the structure as the view has them.

    def vector(self, x, size: float = 1.0) -> tuple[float, ...]:
        return tuple(map(float, (size * self.v.turn @ np.asarray(x))[:self.s.dimension]))

    def axial(self, x, size: float = 1.0):
        turned = self.v.side * size * self.v.turn @ np.asarray(x)
        return float(turned[2]) if self.s.dimension == 2 else tuple(map(float, turned))

    def component(self, name: str) -> tuple[str, float]:
        """A component of the structure, and its sign."""
        if name == "rz" and self.s.dimension == 2:
            return name, self.v.side
        turned = self.v.turn @ np.eye(3)["xyz".index(name[-1])]
        at = int(np.abs(turned).argmax())
        return name[:-1] + "xyz"[at], float(np.sign(turned[at])) * (self.v.side if name.startswith("r") else 1.0)

    # Meshes.

    @property
    def places(self) -> np.ndarray:
        """Of a, m and b."""
        return self._place(np.array([(-1.0, 0.0, 0.0), (0.0, 0.0, 0.0), (1.0, 0.0, 0.0)]))

    def _place(self, x):
        s, v = self.s, self.v
        y, across = s.rise * (1 - x[:, 0] ** 2) + s.tilt * x[:, 0] * (1 + x[:, 1]), s.width * x[:, 1]
        places = np.column_stack((x[:, 0], y, 0 * y) if s.kind in ("bars", "plane") else (x[:, 0], across, y))
        if s.kind == "space":
            places[:, 1] = 0.3 * s.rise * (1 - x[:, 0] ** 2)
        if s.kind == "bars":
            places[:, 2] = 0.2 * x[:, 1] + s.tilt * x[:, 0]
        return v.length * places @ v.turn.T

    def _meshes(self):
        if self.v.half:
            return self._mesh(("right",))
        if self.joint in ("", "groups"):
            return self._mesh(("left", "right"))
        return [self._mesh((side,))[0][0] for side in ("left", "right")], None

    def _mesh(self, sides):
        s = self.s
        order = 1 if s.kind == "bars" else 2  # also of what is straight, which needs no kernels of its own then
        if s.surface:
            nodes = {"a": (-1, 0, 0), "m": (0, 0, 0), "b": (1, 0, 0), "B": (1, 1, 0), "M": (0, 1, 0), "A": (-1, 1, 0)}
            faces = {side: {"left": "amMA", "right": "mbBM"}[side] for side in sides}
            triangles = s.form.startswith("naghdi-t")

            def source():
                fx.meshes.panels(nodes, faces, s.cells, triangles)
        else:
            nodes = {"a": (-1, 0, 0), "m": (0, 0, 0), "b": (1, 0, 0)}
            cells = 1 if s.kind == "bars" else 2 * s.cells
            members = {side: (*{"left": "am", "right": "mb"}[side], cells) for side in sides}
            if s.kind == "bars" and "left" in sides and not s.symmetric:
                nodes |= {"c": (0.0, -1.0, 0), "d": (0.0, 2.0, 0)}
                members |= {"third": ("c", "m", 1), "fourth": ("d", "m", 1)}

            def source():
                used = {n: x for n, x in nodes.items() if any(n in ends for ends in members.values())}
                fx.meshes.frame(used, members)
        if s.kind == "stiffened":
            ribs = [{"left": "a-m", "right": "m-b"}[side] for side in sides]
            mixed = self._imperfect(fx.read_mixed(source, ribs, order, self._place))
            return [mixed.surfaces], mixed.curves
        return [self._imperfect(fx.read(source, s.dimension, order, self._place))], None

    def _imperfect(self, mesh):
        s, v = self.s, self.v
        if not s.imperfect:
            return mesh
        kind, size = s.imperfect

        def along(x):
            x = np.pad(x, [(0, 0), (0, 3 - x.shape[1])]) @ v.turn / v.length
            return np.cos(pi * x[:, 0] / 2) + 0.2 * x[:, 0] ** 2

        def vector(x):
            return np.outer(along(x), np.array((0.0, 1.0, float(s.dimension == 3))) @ v.turn.T)[:, :s.dimension]

        if kind == "normal" and s.kind in ("plane", "shell"):
            return fx.imperfect(mesh, along, v.side * size * v.length)
        return fx.imperfect(mesh, vector, size * v.length)

    # Parts.

    def _material(self, modulus: float):
        v = self.v
        density = v.force / v.length**4 if self.s.extra == "frequencies" else None
        own = (modulus * v.force / v.length**2, self.s.poisson, density)
        return fx.Plastic(*own, yield_stress=NEVER * own[0]) if v.plastic else fx.Elastic(*own)

    def _section(self, section):
        v, L = self.v, self.v.length
        along, across = (v.side, 1.0) if self.s.kind == "plane" else (1.0, v.side)
        if isinstance(section, fx.Rectangle):
            return fx.Rectangle(L * section.width, L * section.depth)
        if isinstance(section, fx.Tube):
            return fx.Tube(L * section.diameter, L * section.thickness)
        if isinstance(section, fx.Flanged):
            return fx.Flanged(self._section(section.bar), L * section.width, L * section.thickness,
                              along * L * section.offset)
        if isinstance(section, fx.FibreList):
            places, areas = section.fibres()
            sides = L * np.array((along, across))
            return _fibres(places * sides, L**2 * areas, L**4 * section.torsion, sides * section.shear_centre)
        if isinstance(section, fx.Plate):
            return replace(section, thickness=L * section.thickness)
        moduli = v.force / L**2
        plies = [replace(p, thickness=L * p.thickness, along=moduli * p.along, across=moduli * p.across,
                         shear=moduli * p.shear) for p in section.plies]
        return fx.Laminate(plies[::int(v.side)])

    def _groups(self):
        """Meshes of the parts and their groups."""
        if self.joint == "groups":
            return [(self.meshes[0], name) for name in self.meshes[0].cells]
        return [(mesh, None) for mesh in self.meshes]

    def _parts(self):
        s, v = self.s, self.v
        strains = {} if s.strains is None else {"strains": s.strains}
        made = []
        for mesh, group in self._groups():
            if s.surface:
                plate = s.section if isinstance(s.section, fx.Plate | fx.Laminate) else fx.Plate(0.04)
                axis = {} if isinstance(plate, fx.Plate) else {"axis": self.vector((1.0, 0.3 * (not s.symmetric), 0.0))}
                scale = 1.0 / sum(t.thickness**3 for t in plate.plies) if axis else 0.0
                modulus = 12.0 / plate.thickness**3
                if axis:
                    plate = fx.Laminate([replace(p, along=scale * p.along, across=scale * p.across,
                                                 shear=scale * p.shear) for p in plate.plies])
                offset = 0.0 if s.kind == "stiffened" else v.side * v.length * s.offset
                made.append(fx.Shell(mesh, self._section(plate), self._material(modulus), s.form, group=group,
                                     offset=offset, **axis, **strains))
            elif s.kind == "bars":
                area = s.section.area
                made.append(fx.Bar(mesh, self._section(s.section), self._material(1.0 / area), group=group, **strains))
            else:
                made.append(self._beam(mesh, s.section, group, strains))
        return made

    def _beam(self, mesh, section, group=None, strains=()):
        s, v = self.s, self.v
        offset = s.offset
        if s.kind == "plane":
            offset = v.side * v.length * offset
        elif np.any(offset):
            along, across = offset if s.kind == "space" else (offset, 0.0)
            offset = (v.length * along, v.length * v.side * across)
        return fx.Beam(mesh, self._section(section), self._material(1.0 / min(section.second_moments)), group=group,
                       up=tuple(map(float, v.turn @ s.up)), shear_rigidity=s.shear_rigidity, offset=offset,
                       **dict(strains))

    def _ribs(self):
        if self.ribs is None:
            return []
        section = fx.Rectangle(0.05, 0.1) if isinstance(self.s.section, fx.Plate) else self.s.section
        return [self._beam(self.ribs, section)]

    # What holds and loads it.

    def _at(self, name: str) -> str:
        """A point of curves, or the edge of surfaces there."""
        if not self.s.surface:
            return name
        return {"a": "A-a", "m": "m-M" if "m-M" in self.right.edges else "M-m", "b": "b-B"}[name]

    def _support(self, mesh, name: str, kind: str):
        s = self.s
        fixed = {"clamp": "x y z rx ry rz", "pin": "x y z rx" if s.kind == "space" else "x y z",
                 "roller": "y z rx" if s.kind == "space" else "y z"}[kind]
        if s.kind == "bars":
            fixed = "x y z"
        if s.dimension == 2:
            fixed = " ".join(self.component(c)[0] for c in fixed.split() if c in ("x", "y", "rz"))
        turned = s.dimension == 3 and not np.array_equal(self.v.turn, np.eye(3))
        return fx.Support(mesh, name, fixed, self.v.turn.T if turned else None)

    def _supports(self):
        s, left, right = self.s, self.left, self.right
        held = [self._support(right, self._at("b"), s.ends[1])] if s.ends[1] != "free" else []
        if self.v.half:
            held.append(fx.Support(right, "m", "x z") if s.kind == "bars" else fx.symmetry(right, self._at("m")))
            if s.kind == "stiffened":
                held.append(fx.symmetry(self.ribs, "m"))
        elif s.ends[0] != "free":
            held.insert(0, self._support(left, self._at("a"), s.ends[0]))
        if s.kind == "bars" and not self.v.half:
            held += [fx.Support(left, "m", "z")] if s.symmetric else [self._support(left, name, "pin") for name in "cd"]
        return held

    def _load(self, name: str, size) -> list[fx.Load]:
        s, v, right, m = self.s, self.v, self.right, self._at("m")
        share, extent = 0.5 if v.half else 1.0, v.length ** (2 if s.surface else 1)
        if name == "point":
            acting, per = (fx.EdgeForce, v.length) if s.surface else (fx.PointForce, 1.0)
            return [acting(right, m, self.vector(size, share * v.force / per))]
        if name == "spread":
            acting = fx.SurfaceForce if s.surface else fx.LineForce
            return [acting(part, self.vector(size, v.force / extent)) for part in self.parts]
        if name == "pressure":
            acting = fx.Pressure if s.surface else fx.LinePressure
            return [acting(part, v.side * size * v.force / extent) for part in self.parts]
        if name == "moment":
            mirrored = {"b": (self.right, size), "a": (self.left, np.array((1.0, -1.0, -1.0)) * size)}
            return [fx.Moment(mesh, at, self.axial(moment, v.force * v.length))
                    for at, (mesh, moment) in mirrored.items()
                    if s.ends["ab".index(at)] != "clamp" and not (v.half and at == "a")]
        if name == "heat":
            return [Heat(part, size * part.material.modulus * part.section.area) for part in self.parts]
        component, sign = self.component("xyz"[DOWN[s.kind]])
        return [fx.PrescribedDisplacement(right, m, component, sign * size * v.length)]

    def _joints(self):
        s, v, made = self.s, self.v, []
        share = 0.5 if v.half else 1.0
        if self.ribs is not None:
            made.append(fx.Compatible(self.ribs, self.right))
        if self.left is not self.right:
            made.append(self._joined())
        if s.spring:
            made += [fx.Spring(self.right, self._at("m"), c, share * s.spring * v.force / v.length)
                     for c in "xyz"[:s.dimension]]
        if s.foundation:
            size = s.foundation * v.force / v.length ** (3 if s.surface else 2)
            made += [fx.Foundation(part, (size,) * s.dimension) for part in self.parts]
        if s.gap is not None:
            down = np.eye(3)[DOWN[s.kind]]
            plane = fx.RigidPlane(self.vector((s.rise - s.gap) * down, v.length), self.vector(down))
            made.append(fx.ObstacleContact(self.right, self._at("m"), plane, distance=0.0))
        return made

    def _joined(self):
        at, to = "m-M" if self.s.surface else "m", (self.right, self._at("m"))
        if self.joint == "compatible":
            return fx.Compatible(self.left, self.right)
        if self.joint == "hinge":
            return fx.hinge(self.left, at, to)
        if self.joint == "link":
            return fx.link(self.left, at, to, reach=0.1 * self.v.length)
        return fx.weld(self.left, at, to, enforcement="penalty" if self.joint == "penalty" else "multiplier")

    def scene(self) -> fx.Scene:
        s, v = self.s, self.v
        loads = [self._load(*one) for one in s.loads]
        component, sign = self.component("xyz"[DOWN[s.kind]])
        stages = []
        if v.staged or (len(loads) > 1 and "stage" in s.features):
            stages, loads = [fx.Stage(loads[0], control=fx.LoadControl(1.0, fixed=True))], loads[1:]
        return fx.Scene([*self.parts, *self.bars], self._supports(), [one for group in loads for one in group],
                        fx.Monitor(self.right, "m", component, -sign), symmetry_factor=2 if v.half else 1,
                        joints=self._joints(), stages=stages)

    def case(self) -> fx.Case:
        kind, size = self.s.path
        if self.s.relation == "stages":
            kind, size = "load", 1.0
        if kind == "load":
            return fx.Case(self.scene(), fx.LoadControl(size))
        control = fx.ArcLength() if kind == "arc" else fx.DisplacementControl(size / 2 * self.v.length)
        return fx.Case(self.scene(), control, fx.Until(deflection=size * self.v.length))


def measures(builder: Builder, record=None) -> dict[str, np.ndarray]:
    """What the last state of a path is, and critical points, as the structure has them; or that it has stopped."""
    s, v = builder.s, builder.v
    try:
        record = record or fx.trace(builder.case())
    except fx.PathFailure:
        return {"stopped": np.ones(1)}
    state = record.states[-1]
    record.show(state)
    meshes = {"a": builder.left, "m": builder.right, "b": builder.right}
    size = {FORCE: v.force, MOMENT: v.force * v.length, PRESSURE: v.force / v.length**2,
            LINE_PRESSURE: v.force / v.length, FACTOR: 1.0}[counted(record.case.scene.loads)[0]]
    turn = v.turn[:s.dimension, :s.dimension]
    found = {"u deflection": state.deflection / v.length} if v.along_axes else {}
    if not v.staged and s.relation != "stages":
        found["load"] = state.load / size
    found |= {f"u {at}": turn.T @ record.displacement(at, mesh) / v.length
              for at, mesh in meshes.items() if not (v.half and at == "a")}
    for support in record.case.scene.supports:
        if support.at == builder._at("b") and support.mesh is builder.right:
            held = record.reactions(support)
            moment = v.side * (turn.T @ held.moment[-1] if s.dimension == 3 else held.moment[-1])
            found["reaction b"] = np.concatenate((turn.T @ held.force[-1], moment / v.length)) / v.force
    if s.relation in SAME_CELLS:
        found |= _resultants(builder, record)
    if s.relation != "plastic":
        found["energy"] = sum(record.energies()) * (2 if v.half else 1) / v.force / v.length
    points = [p.load / size for p in record.critical_points if not s.symmetric or p.kind == "limit"]
    found["critical"] = np.array(points)
    if s.extra == "buckling":
        found["buckling"] = _least_buckling(record)
    if s.extra == "frequencies":
        found["frequency"] = record.frequencies(state, 1)[0].frequency
    return {name: np.atleast_1d(np.asarray(value, float)) for name, value in found.items()}


def _least_buckling(record) -> float:
    """The least factor in size; infinite where no load of this kind makes the structure buckle."""
    try:
        return abs(record.buckling(record.states[0], count=1)[0].factor)
    except ValueError as error:
        if "no load of this kind" not in str(error):
            raise
        return np.inf


def _resultants(builder: Builder, record) -> dict[str, np.ndarray]:
    """Sizes of forces and moments of the first part, at each point of each cell; signs go by the axes."""
    v, forces = builder.v, np.abs(record.forces(builder.parts[0]))
    count = forces.shape[-1]
    bending = {1: (), 3: (2,), 6: (3, 4, 5), 9: (3, 4, 5)}[count]
    size = np.full(count, v.force / v.length) if count == 9 else np.full(count, v.force)
    size[list(bending)] *= v.length
    moments = np.isin(np.arange(count), bending)
    return {name: (forces / size)[..., chosen] for name, chosen in (("forces", ~moments), ("moments", moments))
            if chosen.any()}


def turned(structure: Structure, mirrored: bool) -> View:
    """A view of a structure from another side; along the axes where components are named."""
    random = np.random.default_rng(structure.number + 10**6)
    along_axes = (structure.path[0] != "load" or "prescribed" in structure.features or random.uniform() < 0.5)
    if structure.kind == "plane":
        angle = random.integers(1, 4) * pi / 2 if along_axes else random.uniform(0, 2 * pi)
        turn = Rotation.from_euler("z", angle).as_matrix() @ np.diag((1.0 - 2 * mirrored, 1.0, 1.0))
    elif along_axes:
        turn = np.eye(3)[random.permutation(3)] * random.choice((-1.0, 1.0), 3)
        turn[0] *= np.linalg.det(turn) * (1 - 2 * mirrored)
    else:
        turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
        turn *= np.linalg.det(turn) * (1 - 2 * mirrored)
    return View(turn=np.round(turn) + 0.0 if along_axes else turn)


def off(one: dict, other: dict) -> dict[str, float]:
    """Relative differences of measures that are more than rounding; of displacements over the largest one."""
    largest = max((np.abs(value).max() for name, value in one.items() if name[0] == "u"), default=0.0)
    found = {name: np.inf for name in one.keys() ^ other.keys() if "stopped" in one | other}
    for name in one.keys() & other.keys():
        a, b = one[name], other[name]
        size = largest if name[0] == "u" else max(np.abs(a).max(initial=0.0), np.abs(b).max(initial=0.0), NONE)
        same = np.array_equal(a, b)  # infinite ones too
        found[name] = 0.0 if same else float(np.abs(a - b).max(initial=0.0) / size) if a.shape == b.shape else np.inf
    return found
