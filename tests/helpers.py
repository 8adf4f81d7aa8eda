"""Small structures and independent solutions that tests share."""

from __future__ import annotations

import atexit
import json
import os
import subprocess
import sys
import time
from math import pi, radians, tan
from pathlib import Path as Folder
from tempfile import TemporaryFile
from threading import Timer

import numpy as np
from pair import END
from scipy.integrate import solve_bvp, solve_ivp
from scipy.optimize import fsolve
from scipy.spatial.transform import Rotation

from sheetfx import meshes
from sheetfx.case import Case, trace
from sheetfx.continuation.control import LoadControl
from sheetfx.continuation.state import CriticalPoint
from sheetfx.critical.branches import Branch, branches
from sheetfx.mesh.quadrature import simplex
from sheetfx.mesh.reader import NamedMesh, read
from sheetfx.model.beam import Beam
from sheetfx.model.loads import LineForce, PointForce
from sheetfx.model.scene import Monitor, Scene
from sheetfx.model.section import Elastic, Rectangle
from sheetfx.model.shell import TRIANGLE, ShellForm
from sheetfx.model.supports import Support, clamp, pin, symmetry
from sheetfx.path import Path, Until
from sheetfx.record import Record

DIRECTIONS = 12  # of differences
TURNED_AT_EDGES = ShellForm(TRIANGLE, ("P", 2), ("CR", 1), simplex(1), simplex(2))  # a form of one's own


def straight(elements: int, length: float = 1.0, dimension: int = 2) -> NamedMesh:
    """Straight mesh along x with the points base and tip."""
    nodes = {"base": (0, 0), "tip": (length, 0)}
    return read(lambda: meshes.frame(nodes, {"beam": ("base", "tip", elements)}), dimension)


def cantilever(mesh: NamedMesh, loads, component: str = "y", **beam) -> Scene:
    """Scene of a straight mesh of length 1, clamped at its base; `loads` is a function of the beam."""
    settings = {"section": Rectangle(0.1, 0.1), "material": Elastic(1.2e5, 0.0)} | beam
    structure = Beam(mesh, **settings)
    return Scene([structure], [clamp(mesh, "base")], loads(structure), Monitor(mesh, "tip", component))


def shallow_arch(elements: int, degree: int = 2) -> Scene:
    """Symmetric half of the clamped shallow arch under a point load (thesis, section 4.5.2)."""
    mesh = read(lambda: meshes.arc(3380.6, 0.0, radians(7.338), elements, {"crown": 0.0}), 2, degree)
    beam = Beam(mesh, Rectangle(25.4, 4.7625), Elastic(72395.0), degree=degree)
    return Scene([beam], [clamp(mesh, "end"), symmetry(mesh, "crown")],
                 [PointForce(mesh, "crown", (0.0, -0.5))], Monitor(mesh, "crown", "y", -1.0), symmetry_factor=2)


def whole_arch(elements: int) -> NamedMesh:
    """The arch of `shallow_arch` from hinge to hinge, with its crown."""
    half = radians(7.338)
    return read(lambda: meshes.arc(3380.6, -half, half, elements, {"crown": 0.0}), 2, 2)


def hinged_arch(mesh: NamedMesh) -> Scene:
    """The whole shallow arch on hinges under a force at its crown; it sways at 129.8, before its limit load."""
    beam = Beam(mesh, Rectangle(25.4, 4.7625), Elastic(72395.0))
    return Scene([beam], [pin(mesh, "start"), pin(mesh, "end")], [PointForce(mesh, "crown", (0.0, -1.0))],
                 Monitor(mesh, "crown", "y", -1.0))


def hinged_column(dimension: int = 2, width: float = 0.01) -> Scene:
    """Column of length 1 on two hinges with its middle monitored; it buckles at about 8.2."""
    nodes = {"base": (0, 0), "middle": (0.5, 0), "tip": (1, 0)}
    members = {"lower": ("base", "middle", 8), "upper": ("middle", "tip", 8)}
    mesh = read(lambda: meshes.frame(nodes, members), dimension)
    supports = [pin(mesh, "base"), Support(mesh, "tip", "y")]
    if dimension == 3:
        supports = [Support(mesh, "base", "x y z rx"), Support(mesh, "tip", "y z")]
    return Scene([Beam(mesh, Rectangle(width, 0.01), Elastic(1e9))], supports,
                 [PointForce(mesh, "tip", (-1.0, 0.0, 0.0)[:dimension])], Monitor(mesh, "middle", "y"))


def ring_under_pressure() -> Scene:
    """A quarter of a ring of radius 1 and bending stiffness 1 under a pressure that follows it."""
    mesh = read(lambda: meshes.arc(1.0, 0.0, pi / 2, 24), 2, 2)
    beam = Beam(mesh, Rectangle(1.0, 0.01), Elastic(12e6))
    return Scene([beam], [symmetry(mesh, "start"), symmetry(mesh, "end", "y")],
                 [LineForce(beam, (0.0, -1.0), follower=True)], Monitor(mesh, "start", "y", -1.0))


def follow(scene: Scene, control=None, deflection=None, **case) -> Record:
    """Trace a scene; load control in ten steps unless told otherwise."""
    return trace(Case(scene, control or LoadControl(), Until(deflection=deflection), **case))


def buckled_column(dimension: int = 2, width: float = 0.01) -> Record:
    """Path of `hinged_column` through its first bifurcations."""
    return follow(hinged_column(dimension, width), LoadControl(step=3.0, target=10.0))


def started(record: Record, amplitude: float = 0.05, number: int = 0) -> tuple[CriticalPoint, list[Branch]]:
    """A bifurcation of a path and its branches."""
    point = [p for p in record.critical_points if p.kind == "bifurcation"][number]
    return point, branches(record.path, record.states, point, amplitude)


def displacement(record: Record, at: str = "tip") -> np.ndarray:
    """Displacement of a point in the last state."""
    record.show(record.states[-1])
    return record.displacement(at)


def response(scene: Scene) -> float:
    """Monitored displacement of the unloaded structure by its loads, by linear theory."""
    path = Path(scene)
    state = next(iter(path))
    _, places = path.discretisation.monitored(scene.monitor)
    return scene.monitor.sign * float(state.response[places].sum())


def elastica_under_line_force(bending: float, force: float, follower: bool) -> np.ndarray:
    """Tip of an inextensible, shear-rigid cantilever of length 1 under a transverse line force.

    theta' = m / EI, m' = n_x sin(theta) - n_y cos(theta), n' = -f (Antman 2005, chapter 4), by
    collocation, independent of finite elements.
    """
    def rates(s, y):
        angle, moment, nx, ny = y[:4]
        direction = np.array([-np.sin(angle), np.cos(angle)]) if follower else np.array([0 * angle, 1 + 0 * angle])
        return np.vstack([moment / bending, nx * np.sin(angle) - ny * np.cos(angle), -force * direction,
                          np.cos(angle), np.sin(angle)])

    def ends(a, b):
        return np.array([a[0], b[1], b[2], b[3], a[4], a[5]])

    s = np.linspace(0, 1, 50)
    guess = np.vstack([0 * s, 0 * s, 0 * s, force * (1 - s), s, 0 * s])
    solution = solve_bvp(rates, ends, s, guess, tol=1e-8, max_nodes=100000)
    assert solution.success
    return solution.y[4:, -1]


def rod_bend(radius: float, angle: float, force: float, stiffness: list[float]) -> np.ndarray:
    """Tip of a planar circular bend under a tip force along z, by shooting for the clamp's moment.

    Equilibrium of the rod m' = -x' x n with constant n, and the strains of Simo (1985, eqs. 3.7-3.8)
    on axes (tangent, z, tangent x z); independent of finite elements.
    """
    stiffness, n = np.asarray(stiffness), np.array([0.0, 0.0, force])

    def axes(s):
        t = np.array([np.sin(s / radius), np.cos(s / radius), 0.0])
        z = np.array([0.0, 0.0, 1.0])
        return np.array([t, z, np.cross(t, z)])

    def rates(s, y):
        turn, frame = Rotation.from_quat(y[3:7]).as_matrix(), axes(s)
        stretch = frame.T @ ((frame @ (turn.T @ n)) / stiffness[:3])
        curvature = turn @ frame.T @ ((frame @ (turn.T @ y[7:])) / stiffness[3:])
        along = turn @ (frame[0] + stretch)
        v, w = y[3:6], y[6]
        quaternion = np.append(w * curvature + np.cross(curvature, v), -curvature @ v) / 2
        return np.concatenate([along, quaternion, -np.cross(along, n)])

    def tip(moment):
        start = np.concatenate([[0.0, 0, 0, 0, 0, 0, 1], moment])
        return solve_ivp(rates, (0, radius * angle), start, rtol=1e-9, atol=1e-9, max_step=radius * angle / 20).y[:, -1]

    moment = np.zeros(3)
    for part in np.linspace(0.1, 1.0, 10):
        n = np.array([0.0, 0.0, part * force])
        moment = fsolve(lambda m: tip(m)[7:], moment, xtol=1e-11)
    return tip(moment)[:3]


def move_at_random(discretisation, seed=1, size=0.2):
    """Put a system to a random configuration that keeps the supports, and its stresses to it."""
    system, generator = discretisation.system, np.random.default_rng(seed)
    x = system.create_vector()
    x.array[:] = generator.uniform(-size, size, len(x.array))
    x.array[system.fixed_rows] = 0
    system.configure(x, 1.5)
    system.extrapolate_stress()
    return x


def tangents(system, x, step=1e-5):
    """Assembled tangent K and differences of the residual of the fourth order, both as V^T K V.

    The columns of V are orthonormal random directions of the free unknowns, always the same, since differences along
    each unknown take a minute where there are hundreds. What is wrong in K has the same share of V^T K V.
    """
    system.configure(x, system.factor)
    matrix = system.tangent().copy().convert("dense")
    free = np.setdiff1d(np.arange(len(x.array)), system.fixed_rows)
    directions, _ = np.linalg.qr(np.random.default_rng(1).normal(size=(len(free), min(DIRECTIONS, len(free)))))
    differences = np.zeros_like(directions)
    out, along = system.create_vector(), system.create_vector()
    for direction, difference in zip(directions.T, differences.T, strict=True):
        for times, weight in ((1, 8), (-1, -8), (2, -1), (-2, 1)):
            moved = x.copy()
            along.zeroEntries()
            along.array[free] = times * step * direction
            system.retract(moved, along)
            system.configure(moved, system.factor)
            system.residual(out)
            difference += weight * out.array[free] / (12 * step)
    return directions.T @ matrix.getDenseArray()[np.ix_(free, free)] @ directions, directions.T @ differences


def distance(a, b):
    """Norm of the difference over that of the second."""
    return np.linalg.norm(a - b) / np.linalg.norm(b)


def turn_rigidly(discretisation, angle, axis, steps):
    """Turn all nodes of a structure in space about the origin, in steps that are committed."""
    system = discretisation.system
    displacement_field, rotation_field = discretisation.unknowns.fields
    places = displacement_field.value.function_space.tabulate_dof_coordinates()
    axis = np.asarray(axis) / np.linalg.norm(axis)
    part = angle / steps
    skew = np.cross(axis, np.eye(3)).T
    rotation = np.eye(3) + np.sin(part) * skew + (1 - np.cos(part)) * skew @ skew
    for _ in range(steps):
        current = places + displacement_field.value.x.array.reshape(-1, 3)
        x = system.create_vector()
        x.array[displacement_field.dofs] = (current @ rotation.T - current).ravel()
        x.array[rotation_field.dofs] = np.tile(2 * tan(part / 2) * axis, len(rotation_field.dofs) // 3)
        system.configure(x, system.factor)
        system.history.commit()


def energy_and_residual(discretisation):
    """Energy of a structure of one part, and the norm of its out-of-balance forces."""
    system = discretisation.system
    energy = discretisation.strain_energy(discretisation.scene.parts[0])
    out = system.create_vector()
    system.residual(out)
    return energy, np.linalg.norm(out.array)


class Pair:
    """Two MPI processes that stay for the scripts of all tests, since a start takes seconds, see `pair.py`."""

    def __init__(self):
        here = Folder(__file__).parent
        names = os.pathsep.join([str(here), str(here.parent / "demos"), *filter(None, [os.environ.get("PYTHONPATH")])])
        command = ["mpirun", "-n", "2", sys.executable, str(Folder(__file__).with_name("pair.py"))]
        self.errors = TemporaryFile("w+")  # noqa: SIM115  until the end of the session
        self.process = subprocess.Popen(command, env=os.environ | {"PYTHONPATH": names}, text=True,
                                        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self.errors)
        atexit.register(self.end)

    def printed_by(self, script: str, seconds: float) -> tuple[list[str], bool]:
        """Lines that process 0 prints, and whether the script has ended well; it has not where it takes too long."""
        lines, watch = [], Timer(seconds, self.process.terminate)
        watch.start()
        try:
            print(json.dumps(script), file=self.process.stdin, flush=True)
            while (line := self.process.stdout.readline()) not in ("", f"{END}\n"):
                lines.append(line.rstrip("\n"))
        finally:
            watch.cancel()
        return lines, bool(line)

    def end(self) -> str:
        """End both, where they have not ended; what they have written to standard error."""
        atexit.unregister(self.end)
        self.process.stdin.close()
        try:
            self.process.wait(20)
        except subprocess.TimeoutExpired:
            self.process.kill()
        self.errors.seek(0)
        return self.errors.read()


_pair: list[Pair] = []


def on_two_processes(script: str) -> list[str]:
    """Lines that the first of two processes prints; the script may import from the tests."""
    for seconds in (120, 300):  # OpenMPI 5 may hang where more processes run than there are cores
        if not _pair:
            _pair.append(Pair())
        began = time.monotonic()
        lines, well = _pair[0].printed_by(script, seconds)
        if well:
            return lines
        errors = _pair.pop().end()
        if time.monotonic() - began < seconds:
            break
    raise AssertionError("\n".join([*lines, errors]))
