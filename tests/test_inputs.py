"""Wrong inputs: every attribute of all public dataclasses, every option of all scenes, arguments of functions.

The table of wrong inputs is made here, from the attributes and options that there are: a class, an option or a scene
that is added is tried without a line in this file, but for an example of each class. What is refused is refused by a
message that names what is wrong and its value; what is accepted is right, by a rule that says why.
"""

from __future__ import annotations

import dataclasses
import inspect
import re
from functools import cache
from math import inf, nan
from types import SimpleNamespace

import numpy as np
import pytest
from typer.testing import CliRunner

import sheetfx as fx
from sheetfx.cli import app, main
from sheetfx.scenes import load_case, option_of, scene_names

WRONG = [nan, inf, -inf, None, "", "wrong", 0, -1, True, (), (1.0,), (1.0, nan), (0.0, 0.0), (1.0,) * 7, object(),
         {"wrong": nan}]

# Classes whose objects the program makes and nobody else: what they hold has been computed, not given.
MADE_BY_THE_PROGRAM = {"Advice", "Branch", "BucklingLoad", "Critical", "CurvePoint", "Decision", "ErrorBar",
                       "FieldComponent", "ImperfectLoad", "LoadQuantile", "Meshes", "MeshesByKind", "MixedMesh",
                       "NamedMesh", "NodalShape", "Record", "Refined", "Snap", "Trace", "UnilateralBuckling",
                       "Vibration"}


def public_dataclasses() -> dict[str, type]:
    found = {name: getattr(fx, name) for name in dir(fx)}
    return {name: made for name, made in found.items() if inspect.isclass(made) and dataclasses.is_dataclass(made)
            and name not in MADE_BY_THE_PROGRAM}


def maker(name: str, made: type):
    """What makes an object where its attributes are looked at: a stiffness is when it is given to a shell."""
    return made if name != "ShellStiffness" else lambda **given: fx.GivenPlate(0.1, made(**given))


@cache
def parts():
    """Small meshes and parts; nothing is compiled or solved."""
    line = fx.read(lambda: fx.meshes.frame({"a": (0, 0), "b": (1, 0), "c": (1, 1)},
                                           {"one": ("a", "b", 1), "two": ("b", "c", 1)}), 2)
    space = fx.read(lambda: fx.meshes.frame({"a": (0, 0, 0), "b": (1, 0, 0)}, {"one": ("a", "b", 1)}), 3)
    beside = fx.read(lambda: fx.meshes.frame({"a": (0, 0, 0), "b": (0, 1, 0)}, {"one": ("a", "b", 1)}), 3)
    plate = fx.read(lambda: fx.meshes.rectangle((1, 1)), 3)
    lid = fx.read(lambda: fx.meshes.rectangle((1, 1)), 3, place=lambda x: x + (0.0, 0.0, 1.0))
    section, material = fx.Rectangle(0.1, 0.1), fx.Elastic(1e4)
    beam, shell = fx.Beam(line, section, material), fx.Shell(plate, fx.Plate(0.1), material, form="naghdi-q2")
    cylinder = fx.RigidCylinder(1.0, (0.0, 2.0), travel=(0.0, -1.0))
    force, support = fx.PointForce(line, "b", (0.0, 1.0)), fx.clamp(line, "a")
    scene = fx.Scene([beam], [support], [force], fx.Monitor(line, "b", "y"))
    stiffness = fx.Plate(0.1).stiffness(material)
    return SimpleNamespace(**locals())


def examples() -> dict[str, dict]:
    """Right attributes of each class: those that must be given, and others that make sense with them."""
    p = parts()
    section = {"mesh": p.line, "section": p.section, "material": p.material}
    joined = {"mesh": p.space, "at": "one", "to": (p.plate, "south")}
    return {
        "ArcLength": {}, "DisplacementControl": {}, "LoadControl": {}, "LeftOut": {}, "Bar": section, "Beam": section,
        "Box": {"depth": 2.0, "width": 1.0, "thickness": 0.1},
        "CSection": {"depth": 2.0, "width": 1.0, "web": 0.1, "flange": 0.1},
        "ISection": {"depth": 2.0, "width": 1.0, "web": 0.1, "flange": 0.1},
        "LSection": {"depth": 2.0, "width": 1.5, "thickness": 0.1},
        "TSection": {"depth": 2.0, "width": 1.0, "web": 0.1, "flange": 0.1},
        "ZSection": {"depth": 2.0, "width": 1.0, "web": 0.1, "flange": 0.1},
        "Gravity": {"part": fx.Beam(p.line, p.section, fx.Elastic(1.0, 0.3, 1.0)), "acceleration": (0.0, -9.81)},
        "GivenSection": {"area": 1.0, "second_moments": (1.0, 2.0), "torsion": 1.0},
        "PolygonSection": {"corners": ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))},
        "Case": {"scene": p.scene}, "Cells": {}, "Joining": {"weld": 1.0},
        "Members": {"ends": [("a", "b")], "section": p.section, "material": p.material},
        "Sheets": {"corners": [("a", "b", "c")], "plate": fx.Plate(0.1), "material": p.material},
        "Structure": {"nodes": {"a": (0.0, 0.0, 0.0), "b": (1.0, 0.0, 0.0)}, "panels": {}, "supports": {"a": "x y z"},
                      "bars": {"bar": fx.Members([("a", "b")], p.section, p.material)},
                      "loads": {"b": (0.0, 0.0, 1.0)}, "monitor": ("b", "z", 1.0)},
        "Compatible": {"mesh": p.space, "to": p.plate},
        "Contact": {"beam": p.beam, "obstacle": p.cylinder},
        "Disc": {"at": "one", "radius": 1.0},
        "DistributingCoupling": {"mesh": p.space, "at": "b", "to": (p.plate, "south")},
        "EdgeFoundation": {"mesh": p.plate, "at": "east", "stiffness": (1.0, 1.0, 1.0)},
        "EdgeForce": {"mesh": p.plate, "at": "east", "force": (0.0, 0.0, 1.0)}, "Elastic": {"modulus": 1.0},
        "Event": {"name": "mine", "test": lambda state: 1.0},
        "FibreList": {"places": ((-1.0, 0.0), (1.0, 0.0)), "areas": (1.0, 1.0), "torsion": 1.0},
        "Flanged": {"bar": p.section, "width": 1.0, "thickness": 0.1},
        "FollowerForce": {"mesh": p.line, "at": "b", "force": (0.0, 1.0)},
        "Foundation": {"part": p.beam, "stiffness": (1.0, 1.0)},
        "GivenPlate": {"thickness": 0.1, "matrices": p.stiffness},
        "InitialStrain": {"part": p.beam, "strains": (1e-3, 0.0, 0.0)},
        "InitialStress": {"part": p.beam, "resultants": (1.0, 0.0, 0.0)},
        "Interface": joined | {"law": "x y z"}, "Laminate": {"plies": [fx.Ply(0.1, 0.0, 2.0, 1.0, 0.3, 0.5)]},
        "KinematicCoupling": {"mesh": p.space, "at": "b", "to": (p.plate, "south")},
        "LineForce": {"beam": p.beam, "force": (0.0, 1.0)}, "LinePressure": {"beam": p.beam, "pressure": 1.0},
        "Mass": {"mesh": p.line, "at": "b", "mass": 1.0},
        "Moment": {"mesh": p.line, "at": "b", "moment": 1.0}, "Monitor": {"on": p.line, "at": "b", "component": "y"},
        "ObstacleContact": {"mesh": p.line, "at": "b", "obstacle": p.cylinder},
        "ObstacleForce": {"obstacle": p.cylinder, "force": 1.0},
        "PairContact": {"mesh": p.plate, "at": "south", "to": (p.space, None), "toward": (0.0, 0.0, 1.0)},
        "Plastic": {"modulus": 1.0, "yield_stress": 1.0}, "Plate": {"thickness": 0.1},
        "Ply": {"thickness": 0.1, "angle": 0.0, "along": 2.0, "across": 1.0, "poisson": 0.3, "shear": 0.5},
        "PointForce": {"mesh": p.line, "at": "b", "force": (0.0, 1.0)},
        "PrescribedDisplacement": {"mesh": p.line, "at": "b", "component": "y", "distance": 1.0},
        "PrescribedRotation": {"mesh": p.line, "at": "b", "rotation": 1.0},
        "Pressure": {"shell": p.shell, "pressure": 1.0}, "Rectangle": {"width": 1.0, "depth": 1.0},
        "RigidCylinder": {"radius": 1.0, "centre": (0.0, 0.0)},
        "RigidPlane": {"point": (0.0, 0.0), "normal": (0.0, 1.0)},
        "RigidSphere": {"radius": 1.0, "centre": (0.0, 0.0)},
        "Scene": {"parts": [p.beam], "supports": [p.support], "loads": [p.force],
                  "monitor": fx.Monitor(p.line, "b", "y")},
        "Shell": {"mesh": p.plate, "section": fx.Plate(0.1), "material": p.material},
        "ShellForm": {f.name: getattr(p.shell.discrete, f.name) for f in dataclasses.fields(p.shell.discrete)},
        "ShellStiffness": {f.name: getattr(p.stiffness, f.name) for f in dataclasses.fields(p.stiffness)},
        "Spring": {"mesh": p.line, "at": "b", "component": "y", "stiffness": 1.0}, "Stage": {"loads": [p.force]},
        "Stretch": {"start": "a", "along": "one", "length": 0.5}, "Support": {"mesh": p.line, "at": "a", "fixed": "x"},
        "SurfaceContact": {"mesh": p.plate, "at": "south", "to": (p.lid, None)},
        "SurfaceForce": {"shell": p.shell, "force": (0.0, 0.0, 1.0)},
        "Temperature": {"part": p.beam, "change": 1.0, "expansion": 1e-5},
        "Tube": {"diameter": 1.0, "thickness": 0.1}, "Uniform": {"mesh": p.line, "at": "b", "component": "x"},
        "Until": {},
    }


def refusal(make, **given) -> str | None:
    """What an input is refused by, None if it is accepted; errors of other kinds and libraries go through."""
    try:
        make(**given)
    except ValueError as error:
        return str(error)
    return None


@dataclasses.dataclass(frozen=True)
class Right:
    """A rule for what is accepted: pairs of a class (or function, or scene) and its attribute, and values."""

    reason: str
    values: tuple
    where: str

    def holds(self, owner: str, attribute: str, value) -> bool:
        names = self.where.split()
        return (f"{owner}.{attribute}" in names or f"*.{attribute}" in names) and any(
            value is v or (type(value) is type(v) and value == v) for v in self.values)


LEGITIMATE = [
    Right("a switch can be on", (True,), "*.rotations *.follower *.fixed *.moving *.facets *.mixed_points *.triangles "
          "arch.no-punch *.full *.at_once LeftOut.contact LeftOut.friction LeftOut.plasticity "
          "*.eccentric bend.plain-tangent bend.polar deep-arch.hinged *.elastic "
          "*.line-load roll-up.spatial Case.error Case.snaps"),
    Right("without friction, hardening, an offset or the like", (0,), "*.friction *.cohesion *.strength *.gap *.reach "
          "*.screws *.after *.slide *.root *.toe *.inertia *.inner *.warping Box.radius GivenSection.product "
          "*.hardening *.kinematic *.poisson *.near *.layer *.distance *.overhang *.offset *.angle *.own *.panels "
          "*.adjust Temperature.change Temperature.gradient "
          "random_field.seed imperfect.amplitude dome.offset star-dome.ring arch.imperfection"),
    Right("either side or sign has a sense of its own: contraction in plies, which way a thing lies, acts or turns; "
          "springs and moments that push away", (-1,), "Ply.poisson *.offset *.angle *.side *.way Monitor.sign "
          "Moment.moment ObstacleForce.force Pressure.pressure LinePressure.pressure LoadControl.target "
          "PrescribedDisplacement.distance PrescribedRotation.rotation Spring.stiffness *.load *.force *.ring "
          "Temperature.change Temperature.expansion Temperature.gradient "
          "GivenSection.product imperfect.amplitude arc.start arc.end"),
    Right("no direction is told apart", (0,), "Event.way Contact.side"),
    Right("one of several loads; where all are zero the path says so", (0, (0.0, 0.0)), "Moment.moment "
          "ObstacleForce.force Pressure.pressure LinePressure.pressure FollowerForce.force LineForce.force "
          "PointForce.force"),
    Right("at the centroid; nothing expands", ((0.0, 0.0),), "*.shear_centre Ply.expansion"),
    Right("held where it is", (0,), "PrescribedDisplacement.distance PrescribedRotation.rotation"),
    Right("nothing resists", (0, (0.0, 0.0)), "Foundation.stiffness Spring.stiffness ShellStiffness.drilling"),
    Right("down from a loaded state", (0,), "LoadControl.target"),
    Right("until a bound of the path", (inf, -inf), "LoadControl.target"),
    Right("only the unloaded state", (0,), "Until.steps *.steps"),
    Right("cells as they are", (0,), "read.halvings"),
    Right("by default from the cells along the other side", (0,), "slit-annulus.across"),
    Right("an angle like any other", (0,), "arc.start arc.end"),
    Right("the origin", ((0.0, 0.0),), "RigidCylinder.centre RigidPlane.point RigidSphere.centre "
          "Stretch.start"),
    Right("a name, free or of what is looked for later", ("wrong",), "Event.name *.name Disc.at Stretch.start "
          "Stretch.along Stretch.end"),
    Right("none of these", ((),), "PolygonSection.holes "
          "Case.events Case.pictures Scene.supports Scene.contacts Scene.joints Scene.stages frame.releases"),
    Right("a sequence may have any length", ((1.0,), (1.0,) * 7), "Contact.approach"),
    Right("one amplitude for one shape", ((1.0,),), "imperfect.amplitude"),
    Right("nothing is held", ("",), "Support.fixed"),
    Right("all cells, or wherever parts are", (None,), "*.group SurfaceContact.at ObstacleContact.at "
          "Compatible.at"),
]


def judge(rows) -> list[str]:
    """What is wrong in rows of owner, attribute, value, default and refusal."""
    wrong = []
    for owner, attribute, value, default, said in rows:
        if said is None:
            if value is None and default is None:
                continue  # what it says when nothing is given
            if not any(rule.holds(owner, attribute, value) for rule in LEGITIMATE):
                wrong.append(f"{owner}: {attribute} = {value!r} is accepted")
        elif attribute not in said and repr(value) not in said:
            wrong.append(f"{owner}: {attribute} = {value!r} is refused unclearly: {said}")
    return wrong


@cache
def attributes_with_wrong_values() -> list[tuple]:
    rows = []
    given = examples()
    for name, made in public_dataclasses().items():
        made(**given[name])
        for field in dataclasses.fields(made):
            for value in WRONG if field.init else ():
                rows.append((name, field.name, value, field.default,
                             refusal(maker(name, made), **given[name] | {field.name: value})))
    return rows


def test_wrong_attributes_are_refused_by_name():
    rows = attributes_with_wrong_values()
    assert judge(rows) == []
    assert all(owner in said for owner, *_, said in rows if said)
    assert len(rows) > 3000 and sum(said is not None for *_, said in rows) > 0.9 * len(rows)


@pytest.mark.slow
def test_rules_are_needed():
    """A rule that nothing needs is one that hides something later."""
    accepted = [(*row[:3],) for row in [*attributes_with_wrong_values(), *arguments_with_wrong_values(),
                                        *options_with_wrong_values(1)] if row[-1] is None]
    unused = [rule.reason for rule in LEGITIMATE if not any(rule.holds(*row) for row in accepted)]
    assert unused == []


def functions():
    """Public functions that take numbers and names, with right arguments."""
    p = parts()
    nodes = {"a": (0.0, 0.0, 0.0), "b": (1.0, 0.0, 0.0), "c": (0.0, 1.0, 0.0)}
    meshed = [(fx.meshes.arc, {"radius": 1.0, "start": 0.1, "end": 0.5, "elements": 2}),
              (fx.meshes.frame, {"nodes": nodes, "members": {"one": ("a", "b", 1), "two": ("b", "c", 1)}}),
              (fx.meshes.rectangle, {"cells": (1, 1)}),
              (fx.meshes.panels, {"nodes": nodes, "faces": {"one": "abc"}, "cells": 2}),
              (fx.meshes.profile, {"corners": {"a": (0.0, 0.0), "b": (1.0, 0.0)}, "walls": {"web": ("a", "b", 1)},
                                   "length": 1.0, "cells": 1})]
    plain = [(fx.effective_width, {"span": 1.0, "thickness": 0.1, "own": 0.1, "panels": 0.1}),
             (fx.round_bar, {"diameter": 1.0}), (fx.random_field, {"correlation_length": 1.0}),
             (fx.imperfect, {"mesh": p.plate, "displacement": lambda x: 0.0 * x}),
             (fx.clamp, {"mesh": p.line, "at": "a"}), (fx.pin, {"mesh": p.line, "at": "a"}),
             (fx.symmetry, {"mesh": p.plate, "at": "south"}),
             (fx.weld, {"mesh": p.space, "at": "one", "to": (p.plate, "south")}),
             (fx.hinge, {"mesh": p.space, "at": "one", "to": (p.plate, "south")}),
             (fx.bolt, {"mesh": p.space, "at": "one", "to": (p.plate, "south")}),
             (fx.link, {"mesh": p.space, "at": "one", "to": (p.plate, "south"), "reach": 0.1}),
             (fx.read, {"source": lambda: fx.meshes.rectangle((1, 1)), "dimension": 3})]

    def mesh_with(function):
        return lambda **given: fx.read(lambda: function(**given), 3)

    return [*((f.__name__, f, mesh_with(f), given) for f, given in meshed),
            *((f.__name__, f, f, given) for f, given in plain)]


@cache
def arguments_with_wrong_values() -> list[tuple]:
    rows = []
    for name, function, call, given in functions():
        call(**given)
        for parameter in inspect.signature(function).parameters.values():
            for value in WRONG if parameter.kind is not parameter.VAR_KEYWORD and parameter.name != "comm" else ():
                rows.append((name, parameter.name, value, parameter.default,
                             refusal(call, **given | {parameter.name: value})))
    return rows


def test_wrong_arguments_are_refused_by_name():
    assert judge(arguments_with_wrong_values()) == []


@cache
def options_with_wrong_values(every: int) -> list[tuple]:
    """Each option of each scene with one of so many wrong values, by turns."""
    rows = []
    for scene in scene_names():
        function = load_case(scene)
        for n, parameter in enumerate(inspect.signature(function, eval_str=True).parameters.values()):
            for value in WRONG[n % every::every]:
                rows.append((scene, option_of(parameter).lstrip("-"), value, parameter.default,
                             refusal(function, **{parameter.name: value})))
    return rows


@pytest.mark.parametrize("every", [3, pytest.param(1, marks=pytest.mark.slow)])
def test_wrong_options_are_refused_by_name(every):
    """Before anything is meshed, or when the scene is made; none is solved."""
    rows = options_with_wrong_values(every)
    assert judge(rows) == []
    assert len(rows) > 2000 / every


@pytest.mark.parametrize("words", [
    ["run", "arch", "--step", "inf"], ["run", "arch", "--thickness", "inf"], ["run", "arch", "--to", "inf"],
    ["run", "arch", "--friction", "nan"], ["run", "arch", "--layer", "nan"],
    ["run", "plate-buckling", "--aspect", "inf"],
    ["diagram", "star-dome", "--max-load", "nan"], ["diagram", "star-dome", "--max-deflection", "inf"],
    ["map", "--limit", "nan"], ["study", "arch", "--vary", "step=0.01,inf"]])
def test_command_lines_that_hung(words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(app, words)
    said = str(result.exception) + result.output
    flag = next(word for word in words if word.startswith("--"))
    assert result.exit_code and isinstance(result.exception, (ValueError, SystemExit)), said
    assert (flag if flag != "--vary" else "--step") in said and words[-1].split(",")[-1].split("=")[-1] in said
    assert not list(tmp_path.iterdir())


def test_force_on_an_edge_says_what_it_applies():
    """Three vertices of an edge, each with the force; the load that is reported is their sum."""
    mesh = fx.read(lambda: fx.meshes.rectangle((1, 2)), 3)
    assert fx.PointForce(mesh, "east", (0.0, 0.0, 2.0)).total(None) == 6.0


def test_monitor_on_an_edge_is_refused():
    with pytest.raises(ValueError, match="Monitor at 'east': has 2 vertices, of which .*; name a point"):
        fx.Monitor(parts().plate, "east", "z")


@pytest.mark.parametrize("factor", [0, -2, nan, 1.5])
def test_number_of_copies(factor):
    with pytest.raises(ValueError, match="Scene: symmetry_factor is .*; it must be"):
        fx.Scene(**examples()["Scene"], symmetry_factor=factor)


def test_same_part_twice_is_refused():
    p = parts()
    with pytest.raises(ValueError, match="Scene: parts has the same Beam twice; leave one out"):
        fx.Scene([p.beam, p.beam], [p.support], [p.force], fx.Monitor(p.line, "b", "y"))


@pytest.mark.parametrize(("what", "make", "words"), [
    ("supports", lambda m, b: fx.clamp(m, "a"), "Support at 'a'"),
    ("loads", lambda m, b: fx.PointForce(m, "a", (0.0, 1.0)), "PointForce at 'a'"),
    ("loads", lambda m, b: fx.LineForce(b, (0.0, 1.0)), "LineForce"),
    ("joints", lambda m, b: fx.Foundation(b, (0.0, 1.0)), "Foundation"),
    ("joints", lambda m, b: fx.Spring(parts().line, "b", "y", 1.0, (m, "b")), "Spring at 'b'"),
    ("joints", lambda m, b: fx.weld(parts().line, "b", (m, "b")), "Interface at 'b'"),
    ("contacts", lambda m, b: fx.Contact(b, parts().cylinder), "Contact"),
    ("monitor", lambda m, b: fx.Monitor(m, "b", "y"), "Monitor at 'b'")])
def test_what_is_on_a_mesh_of_no_part_is_refused(what, make, words):
    """As where a mesh is read twice: such a support held nothing, without a word; others ended in a KeyError."""
    other = fx.read(lambda: fx.meshes.frame({"a": (0, 0), "b": (1, 0)}, {"copy": ("a", "b", 1)}), 2)
    given = make(other, fx.Beam(other, parts().section, parts().material))
    right = examples()["Scene"]
    with pytest.raises(ValueError, match=f"{words}: is on a mesh of copy that no part of the scene has; give one"):
        fx.Scene(**right | {what: given if what == "monitor" else [*right.get(what, []), given]})


def test_what_is_asked_of_a_path_is_looked_at():
    scene = parts().scene
    for given in ({"control": 3}, {"until": 3}, {"events": [3]}):
        with pytest.raises(ValueError, match=f"Path: {next(iter(given))} is .*3.*; it must be"):
            fx.Path(scene, **given)
    record = fx.trace(fx.Case(scene, fx.LoadControl(1.0, fixed=True)))
    for count in (0, True):
        with pytest.raises(ValueError, match=f"buckling: count is {count}; it must be"):
            record.buckling(record.states[0], count=count)
    for accuracy in (0, -1.0, nan):
        with pytest.raises(ValueError, match=f"balance: accuracy is {accuracy}; it must be"):
            record.balance(accuracy)
    with pytest.raises(ValueError, match="pairs: PointForce is no contact of pairs of this scene"):
        record.pairs(scene.loads[0])


@pytest.mark.parametrize(("change", "words"), [
    ({"membrane": ((1.0, 0.5, 0.0), (0.2, 1.0, 0.0), (0.0, 0.0, 0.4))}, "membrane is .*; it must be symmetric"),
    ({"membrane": ((1.0, 2.0, 0.0), (2.0, 1.0, 0.0), (0.0, 0.0, 0.4))}, "membrane, coupling and bending are not posi"),
    ({"coupling": ((9.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))}, "membrane, coupling and bending are not posi"),
    ({"shear": ((1.0, 0.0), (0.0, -1.0))}, "shear are not positive"),
    ({"bending": ((1.0, 0.0), (0.0, 1.0))}, "bending is .*; it must be 3 rows of 3 finite numbers")])
def test_stiffness_without_an_energy_is_refused(change, words):
    with pytest.raises(ValueError, match=f"ShellStiffness: {words}"):
        fx.GivenPlate(0.1, dataclasses.replace(fx.Plate(0.1).stiffness(fx.Elastic(1.0, 0.3)), **change))


def test_load_control_goes_down_to_its_target():
    """The target -1 is a load in the other direction, not an error."""
    path = fx.trace(fx.Case(parts().scene, fx.LoadControl(0.5, target=-1.0, fixed=True)))
    loads = [s.load for s in path.states]
    assert loads[-1] == -1.0 and loads == sorted(loads, reverse=True)


def test_law_of_ones_own_needs_no_class():
    """Whatever has an `update` is a law with history, derived from ours or not."""
    class Mine:
        remembered = 0

        def update(self, strains, history):
            return strains, np.tile(np.eye(3), (len(strains), 1, 1)), history

    fx.Beam(**examples()["Beam"], law=Mine())


@pytest.mark.parametrize(("script", "words"), [
    ("import no_such_module\n", r"No module named 'no_such_module' .*mine.py, line 1\)"),
    ("def case():\n    return 1 / 0\n", r"line 2: ZeroDivisionError"),
    ("def case():\n    return float('x')\n", r"line 2: could not convert"),
    ("import sheetfx as fx\ndef case():\n    fx.Rectangle(1.0, -1.0)\n", r"line 3: Rectangle: depth is -1.0; it must"),
    ("def case():\n    return 42\n", r"case returns 42, an int; return a sheetfx.Case"),
    ("def scene():\n    pass\n", r"has no function `case`"),
    ("def case(size: float = 1.0):\n    return size\n", r"case returns 1.0"),
    ("raise SystemError('odd')\n", "line 1: SystemError: odd")])
def test_script_that_fails(script, words, tmp_path):
    file = tmp_path / "mine.py"
    file.write_text(script)
    with pytest.raises(ValueError, match=f"the script .*mine.py.*{words}"):
        load_case(str(file))()


def test_option_of_a_script_is_looked_at(tmp_path):
    file = tmp_path / "mine.py"
    file.write_text("def case(size: float = 1.0, half_way: int = 2):\n    return size\n")
    for value, option in ((nan, "size"), ("", "size"), (1.5, "half_way")):
        with pytest.raises(ValueError, match=f"mine: --{option.replace('_', '-')} is .*; it must be"):
            load_case(str(file))(**{option: value})


def test_one_line_or_a_traceback(tmp_path, monkeypatch, capsys):
    file = tmp_path / "mine.py"
    file.write_text("def case():\n    return 1 / 0\n")
    monkeypatch.setenv("SHEETFX_TRACEBACK", "")
    monkeypatch.setattr("sys.argv", ["sheetfx", "run", str(file)])
    with pytest.raises(SystemExit):
        main()
    said = capsys.readouterr().err
    assert re.fullmatch(r"sheetfx: error: the script .*mine.py, line 2: ZeroDivisionError: .*\n", said)
    monkeypatch.setattr("sys.argv", ["sheetfx", "--traceback", "run", str(file)])
    with pytest.raises(ValueError, match="ZeroDivisionError"):
        main()
    monkeypatch.setenv("SHEETFX_TRACEBACK", "")



class Own(fx.Load):
    """A load whose work is whatever it is given."""

    def __init__(self, work):
        self.returned = work

    def work(self, fields):
        return self.returned


def case_of(law=None, strains=None, load=None, **attributes):
    given = examples()["Beam"] | {name: f for name, f in (("law", law), ("strains", strains)) if f}
    beam = fx.Beam(**given)
    scene = fx.Scene([beam], [fx.clamp(beam.mesh, "a")], [load or parts().force], fx.Monitor(beam.mesh, "b", "y"))
    return fx.Case(scene, fx.LoadControl(0.1, target=0.1), **attributes)


@pytest.mark.parametrize(("make", "words"), [
    (lambda: case_of(law=lambda e, k: None), "Beam: its law '<lambda>' returns None; return a UFL vector of 3"),
    (lambda: case_of(law=lambda e, k: e[0]), r"Beam: its law '<lambda>' returns UFL of shape \(\); return"),
    (lambda: case_of(strains=lambda u, r, f: None), "Beam: its strains '<lambda>' returns None; return a UFL"),
    (lambda: case_of(strains=lambda u, r, f: u), r"Beam: its strains '<lambda>' returns UFL of shape \(2,\); return"),
    (lambda: case_of(load=Own(3.0)), "Own: work returns 3.0; return a UFL form, which is an expression"),
    (lambda: case_of(events=[fx.Event("mine", lambda state: None)]), "Event 'mine': what its test returns is None; it"),
    (lambda: case_of(quantities=lambda record: [1.0]), r"Case: what quantities returns is \[1.0\]; it must be")],
    ids=["law", "scalar law", "strains", "short strains", "load", "event", "quantities"])
def test_what_functions_return_is_looked_at(make, words, tmp_path):
    with pytest.raises(ValueError, match=words):
        fx.run(make(), "mine", {}, tmp_path / "out", False)
