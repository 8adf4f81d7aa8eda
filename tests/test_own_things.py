"""Loads, laws, joints, contributions and scenes of one's own, each in one script that touches no other file."""

from __future__ import annotations

import json
import subprocess
import sys

import numpy as np
import pytest
import ufl

import sheetfx as fx


class Hydrostatic(fx.Load):
    """Pressure of a fluid up to a level: it acts along the current normal and grows with the current depth."""

    conservative = False

    def __init__(self, shell, weight, level):
        self.shell, self.weight, self.level = shell, weight, level

    def work(self, fields):
        u = fields.displacement(self.shell.mesh)
        depth = self.level - ufl.SpatialCoordinate(self.shell.mesh.domain)[2] - u[2]
        pressure = -fields.factor * self.weight * ufl.max_value(depth, 0.0)
        return fx.forms.load.pressure(pressure, u, self.shell.frame(), fields.vary) * self.shell.measure()


def test_load_of_ones_own():
    """Deep under water a plate bends as under a uniform pressure; the deeper it sinks the more it is pressed."""
    def deflection(load):
        mesh = fx.read(lambda: fx.meshes.rectangle((2, 2)), 3)
        shell = fx.Shell(mesh, fx.Plate(0.05), fx.Elastic(1e4, 0.3), form="naghdi-q2")
        scene = fx.Scene([shell], [fx.Support(mesh, edge, "x y z") for edge in ("west", "east")], [load(shell)],
                         fx.Monitor(mesh, "south-east", "ry"))
        return fx.trace(fx.Case(scene, fx.LoadControl(1.0))).states[-1]

    weight, level = 1e-3, 100.0
    uniform = deflection(lambda shell: fx.Pressure(shell, -weight * level)).deflection
    water = deflection(lambda shell: Hydrostatic(shell, weight, level))
    assert abs(uniform) > 1e-3
    assert water.deflection == pytest.approx(uniform, rel=1e-3)
    assert water.deflection != pytest.approx(uniform, rel=1e-9)
    assert water.load == 1.0, "a load without a size of its own reports the load factor"
    assert water.unstable_modes == 0, "counted from state to state, since its tangent is not symmetric"


def stiffening(strains, stiffness):
    """Linear, but for an axial stiffness that grows with the stretch."""
    linear = fx.forms.section.linear_elastic(strains, stiffness)
    return ufl.as_vector([linear[0] * (1 + 1e6 * strains[0] ** 2), *(linear[i] for i in range(1, 3))])


def test_section_law_of_ones_own():
    """A cantilever pulled by N: EA e (1 + c e^2) = N."""
    mesh = fx.read(lambda: fx.meshes.frame({"base": (0.0, 0.0), "tip": (1.0, 0.0)}, {"beam": ("base", "tip", 2)}), 2)
    beam = fx.Beam(mesh, fx.Rectangle(1.0, 0.1), fx.Elastic(10.0), law=stiffening)
    scene = fx.Scene([beam], [fx.clamp(mesh, "base")], [fx.PointForce(mesh, "tip", (2e-3, 0.0))],
                     fx.Monitor(mesh, "tip", "x"))
    e = fx.trace(fx.Case(scene, fx.LoadControl(0.5))).states[-1].deflection
    assert e * (1 + 1e6 * e**2) == pytest.approx(2e-3, rel=1e-8) and 1e6 * e**2 > 0.5


def test_scene_of_ones_own(tmp_path):
    """A script with a function `case` whose parameters are options of the command."""
    script = tmp_path / "strut.py"
    script.write_text('''
import sheetfx as fx


def case(length: float = 1.0, steps: int = 4) -> fx.Case:
    """A cantilever under an end force."""
    nodes = {"base": (0.0, 0.0), "tip": (length, 0.0)}
    mesh = fx.read(lambda: fx.meshes.frame(nodes, {"beam": ("base", "tip", 2)}), 2)
    scene = fx.Scene([fx.Beam(mesh, fx.Rectangle(0.1, 0.1), fx.Elastic(1e4))], [fx.clamp(mesh, "base")],
                     [fx.PointForce(mesh, "tip", (0.0, 1e-3))], fx.Monitor(mesh, "tip", "y"))
    return fx.Case(scene, fx.LoadControl(1 / steps, fixed=True))
''')
    command = [sys.executable, "-m", "sheetfx", "run", str(script), "--length", "2", "--no-pictures",
               "-o", str(tmp_path / "out")]
    result = subprocess.run(command, capture_output=True, text=True, timeout=100)
    assert result.returncode == 0, result.stderr
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["parameters"] == {"length": 2.0, "steps": 4} and summary["steps"] == 4


class Grounded(fx.Contribution):
    """Spring to the ground at each node, written without any help: pattern, residual, tangent and history.

    It remembers how often a state was accepted, and moves to other nodes when told to.
    """

    def __init__(self, fields, mesh, at, stiffness, conservative=True):
        self.number = fields.unknowns.fields.index(fields.kinematics(mesh).block.fields[0])
        self.field, self.stiffness, self.conservative = fields.unknowns.fields[self.number], stiffness, conservative
        self.accepted, self._fields, self._model = 0, fields, mesh
        self.move_to(at)

    def move_to(self, at):
        self.nodes, self.moved = self._fields.nodes(self._model, at), True

    def pattern(self, layout):
        self.moved = False
        rows = layout.free_numbers[self.number][self.nodes].ravel()
        return rows, rows

    def residual(self, forces):
        forces.on(self.number)[self.nodes] += self.stiffness * self.field.table[self.nodes]

    def tangent(self, held):
        return [np.full(2 * len(self.nodes), self.stiffness)]

    def commit(self):
        self.accepted += 1

    def snapshot(self):
        return {"accepted": np.array(self.accepted)}

    def restore(self, snapshot):
        self.accepted = int(snapshot["accepted"])


class Ground(fx.Joint):
    def __init__(self, mesh, at, stiffness):
        self.mesh, self.at, self.stiffness = mesh, at, stiffness

    def contributions(self, fields):
        self.made = Grounded(fields, self.mesh, self.at, self.stiffness)
        yield self.made


def sprung_cantilever(joints):
    """Cantilever of stiffness 3 EI / L^3 = 3 with points at its middle and its tip; EI = 1."""
    nodes = {"base": (0.0, 0.0), "middle": (0.5, 0.0), "tip": (1.0, 0.0)}
    mesh = fx.read(lambda: fx.meshes.frame(nodes, {"left": ("base", "middle", 4), "right": ("middle", "tip", 4)}), 2)
    beam = fx.Beam(mesh, fx.Rectangle(1.0, 0.001), fx.Elastic(12e9), shear_rigidity=1e3)
    return fx.Scene([beam], [fx.clamp(mesh, "base")], [fx.PointForce(mesh, "tip", (0.0, 1e-4))],
                    fx.Monitor(mesh, "tip", "y"), joints=[joint(mesh) for joint in joints])


def test_contribution_of_ones_own():
    """Deflection F / (3 + k) of a cantilever of unit bending stiffness with a spring k at its tip."""
    scene = sprung_cantilever([lambda mesh: Ground(mesh, "tip", 4.0)])
    record = fx.trace(fx.Case(scene, fx.LoadControl(0.25, fixed=True)))
    assert record.states[-1].deflection == pytest.approx(1e-4 / 7, rel=1e-6)
    assert [int(s.fields["accepted"]) for s in record.states] == [1, 2, 3, 4, 5]
    record.show(record.states[2])
    assert scene.joints[0].made.accepted == 3, "history goes back with the state"


def test_pattern_that_moves_is_made_anew():
    """A spring k that moves from the tip to the middle: F (L^3 / 3 - (5 / 48)^2 k / (1 + k / 24))."""
    scene = sprung_cantilever([lambda mesh: Ground(mesh, "tip", 4.0)])
    path = fx.Path(scene, fx.LoadControl(0.5, fixed=True))
    states = iter(path)
    next(states), next(states)
    scene.joints[0].made.move_to("middle")
    *_, last = states
    exact = 1e-4 * (1 / 3 - (5 / 48) ** 2 * 4.0 / (1 + 4.0 / 24))
    assert last.deflection == pytest.approx(exact, rel=1e-6)


def test_flags_of_contributions_are_those_of_the_system():
    scene = sprung_cantilever([lambda mesh: Ground(mesh, "tip", 4.0)])
    system = fx.Path(scene).discretisation.system
    assert system.smooth and system.conservative

    class Rough(Ground):
        def contributions(self, fields):
            contribution = Grounded(fields, self.mesh, self.at, self.stiffness, conservative=False)
            contribution.smooth = False
            contribution.without_fall = "a spring of the test has no energy"
            yield contribution

    path = fx.Path(sprung_cantilever([lambda mesh: Rough(mesh, "tip", 4.0)]))
    assert not path.discretisation.system.smooth and not path.discretisation.system.conservative
    assert path.tracer.state.unstable_modes is None, "an unsymmetric tangent has no inertia"


def test_each_step_of_a_fall_is_accepted():
    """Its push along the mode, its steps and its end: what has history follows the motion."""
    nodes = {"left": (-1.0, 0.0), "apex": (0.0, 0.2), "right": (1.0, 0.0)}
    mesh = fx.read(lambda: fx.meshes.frame(nodes, {"a": ("left", "apex", 1), "b": ("apex", "right", 1)}), 2)
    scene = fx.Scene([fx.Bar(mesh, fx.Rectangle(1.0, 1.0), fx.Elastic(1.0))],
                     [fx.pin(mesh, "left"), fx.pin(mesh, "right")], [fx.PointForce(mesh, "apex", (0.0, -1.0))],
                     fx.Monitor(mesh, "apex", "y", -1.0), joints=[Ground(mesh, "apex", 1e-9)])
    record = fx.trace(fx.Case(scene, fx.ArcLength(0.01), fx.Until(deflection=0.2)))
    unstable = next(s for s in record.states if s.unstable_modes)
    fall = record.snap(unstable)
    assert fall.iterations > 3
    assert fall.after.fields["accepted"] == unstable.fields["accepted"] + 1 + fall.iterations + 1


def test_histories_of_one_name_are_refused():
    scene = sprung_cantilever([lambda mesh: Ground(mesh, "tip", 4.0), lambda mesh: Ground(mesh, "middle", 4.0)])
    with pytest.raises(ValueError, match="Grounded: its history has the name 'accepted', which another one uses"):
        fx.Path(scene)
