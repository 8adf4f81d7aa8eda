"""Folders, resumption, the command line, messages of errors, and two processes."""

import csv
import json
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from petsc4py import PETSc

import sheetfx as fx
from sheetfx.archive.folder import Archive
from sheetfx.case import Case, run, trace
from sheetfx.model.contact import Contact
from sheetfx.model.loads import PointForce
from sheetfx.model.obstacles import RigidCylinder
from sheetfx.model.scene import Monitor, Scene
from sheetfx.model.supports import Support
from sheetfx.path import PathFailure, Until
from sheetfx.scenes.arch import arch_model
from sheetfx.scenes.arch import case as arch_case

SMALL = {"ratio": 1.0, "elements": 40, "layer": 10.8, "to": 12.0}
CONTRACT = {"axes", "scene", "parameters", "status", "message", "unknowns", "steps", "iterations", "factorisations",
            "critical_points", "quantities", "energy", "timings", "stages", "searched", "load"}
PARTS = {"compile", "assembly", "factorisation", "solve", "contact", "path", "output", "total"}


def sheetfx(*arguments, processes=1, **options):
    command = [sys.executable, "-m", "sheetfx", *map(str, arguments)]
    if processes > 1:
        command = ["mpirun", "-n", str(processes), *command]
    return subprocess.run(command, capture_output=True, text=True, timeout=300, **options)


def table(folder):
    with (folder / "path.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    return np.array([[float(r["load"]), float(r["deflection"])] for r in rows])


def small(folder, resume=False, listeners=()):
    case = arch_case(**SMALL)
    plain = Case(case.scene, case.control, case.until, case.quantities)
    return run(plain, "arch", SMALL, folder, resume, listeners)


def test_summary_and_files(tmp_path):
    result = sheetfx("run", "arch", "--no-punch", "--elements", 16, "-o", tmp_path)
    assert result.returncode == 0, result.stderr
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert set(summary) == CONTRACT
    assert set(summary["timings"]) == PARTS
    assert summary["status"] == "finished"
    assert [p["kind"] for p in summary["critical_points"]] == ["limit", "limit"]
    for name in ("path.csv", "path.png", "shape.png"):
        assert (tmp_path / name).stat().st_size > 500


def test_interrupted_run_resumes_on_the_same_path(tmp_path):
    """Stopped by an exception at step 5, then resumed: every later state to solver tolerance."""
    whole = small(tmp_path / "whole")

    class Interruption(Exception):
        pass

    def interrupt(state):
        if state.step == 5:
            raise Interruption

    with pytest.raises(Interruption):
        small(tmp_path / "parts", listeners=[interrupt])
    resumed = small(tmp_path / "parts", resume=True)
    assert resumed["steps"] == whole["steps"]
    np.testing.assert_allclose(table(tmp_path / "parts"), table(tmp_path / "whole"), rtol=1e-7, atol=1e-9)


def test_killed_run_keeps_its_steps(tmp_path):
    """SIGKILL in the middle; --resume goes on from the last kept step and ends like a whole run."""
    options = ["run", "arch", "--no-punch", "--elements", "400", "--step", "0.0005", "--to", "20", "--no-pictures",
               "-o"]
    process = subprocess.Popen([sys.executable, "-m", "sheetfx", *options, str(tmp_path / "killed")],
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    marker = tmp_path / "killed" / "states" / "000004.0.npz"
    for _ in range(1200):
        if marker.exists() or process.poll() is not None:
            break
        time.sleep(0.05)
    process.send_signal(signal.SIGKILL)
    process.wait()
    assert marker.exists()
    assert sheetfx(*options, tmp_path / "killed", "--resume").returncode == 0
    assert sheetfx(*options, tmp_path / "whole").returncode == 0
    np.testing.assert_allclose(table(tmp_path / "killed"), table(tmp_path / "whole"), rtol=1e-7, atol=1e-9)


def test_resume_with_other_parameters_is_refused(tmp_path):
    small(tmp_path)
    case = arch_case(**SMALL)
    with pytest.raises(ValueError, match="elements"):
        run(case, "arch", SMALL | {"elements": 41}, tmp_path, resume=True)


@pytest.mark.parametrize("friction, to", [
    pytest.param(0.3, 6, marks=pytest.mark.slow), (0.0, 12)], ids=["friction", "smooth"])
def test_two_processes_give_the_same_path(tmp_path, friction, to):
    """To solver tolerance (relative residual 1e-8), with a punch whose travel all processes share."""
    options = ["run", "arch", "--elements", 40, "--layer", 10.8, "--to", to, "--friction", friction, "--no-pictures",
               "-o"]
    for processes in (1, 2):
        result = sheetfx(*options, tmp_path / str(processes), processes=processes)
        assert result.returncode == 0, result.stderr
    np.testing.assert_allclose(table(tmp_path / "2"), table(tmp_path / "1"), rtol=1e-6, atol=1e-8)


def test_new_run_clears_the_falls_of_an_earlier_one(tmp_path):
    """Once the user's file between them is away: until then it is refused, and nothing is deleted."""
    archive, notes = Archive(tmp_path, PETSc.COMM_WORLD.tompi4py()), tmp_path / "fall2" / "notes.txt"
    archive.clear({})
    with archive.drawing() as folder:
        for name in ("fall1/snap.json", "fall1/before.0.npz", "fall1/after.1.npz", "fall2/snap.json"):
            file = folder / name
            file.parent.mkdir(exist_ok=True)
            file.touch()
    notes.touch()
    with pytest.raises(ValueError, match="fall2/notes.txt"):
        archive.clear({})
    assert len(list(tmp_path.glob("fall*/*"))) == 5
    notes.unlink()
    archive.clear({})
    assert not list(tmp_path.glob("fall*"))


def test_own_script(tmp_path):
    script = tmp_path / "my_scene.py"
    script.write_text(
        "from sheetfx.scenes.arch import case as arch\n"
        "def case(elements: int = 8):\n"
        "    '''My arch.'''\n"
        "    return arch(no_punch=True, elements=elements, to=12.0)\n")
    result = sheetfx("run", script, "--elements", 10, "--no-pictures", "-o", tmp_path / "out")
    assert result.returncode == 0, result.stderr
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["parameters"] == {"elements": 10}


def test_scene_list(command):
    names = command("run", "--list")[1].split()
    assert "arch" in names and "lee-frame" in names


@pytest.mark.parametrize(("arguments", "words"), [
    (["nowhere"], ["nowhere", "choose one of", "arch"]),
    (["missing.py"], ["missing.py", "no such file"]),
    (["arch", "--ratio", "0"], ["--ratio is 0", "positive"]),
    (["arch", "--ratio", "-0.5"], ["--ratio is -0.5", "positive"]),
    (["arch", "--step", "0"], ["--step is 0", "positive"]),
    (["arch", "--thickness", "-1"], ["--thickness is -1", "positive"]),
    (["arch", "--half-angle", "0"], ["--half-angle is 0", "above 0 and at most 180"]),
    (["arch", "--elements", "0"], ["--elements is 0", "at least 1"]),
    (["arch", "--contact", "edges"], ["edges", "nodes", "quadrature"]),
    (["arch", "--friction", "-0.1"], ["--friction is -0.1", "zero or positive"]),
    (["arch", "--to", "-1"], ["--to is -1", "positive"]),
    (["arch", "--imperfection", "1"], ["--full"]),
    (["cylinder-panel", "--ratio", "-5"], ["cylinder-panel", "--ratio is -5", "positive"]),
    (["cylinder-panel", "--length", "0"], ["--length is 0", "positive"]),
    (["sinusoidal-arch", "--degree", "4"], ["--degree is 4", "1, 2, 3"]),
    (["deep-arch", "--degree", "0"], ["--degree is 0", "1, 2, 3"]),
])
def test_errors_name_object_value_and_remedy(arguments, words, tmp_path, command):
    status, _, errors = command("run", *arguments, "-o", tmp_path / "out")
    assert status == 2 and errors.count("\n") == 1
    for word in words:
        assert word in errors


def bare_arch(supports, contacts=()):
    mesh = arch_model(7.338, 8, 2, False)
    base = arch_case(no_punch=True, elements=8).scene
    beam = type(base.parts[0])(mesh, base.parts[0].section, base.parts[0].material)
    made = [Contact(beam, obstacle, distance=0.0) for obstacle in contacts]
    return Scene([beam], [Support(mesh, *s) for s in supports], [PointForce(mesh, "crown", (0.0, -1.0))],
                 Monitor(mesh, "crown", "y", -1.0), made)


def test_structure_that_can_move_freely():
    with pytest.raises(ValueError, match="move freely"):
        trace(Case(bare_arch([("end", "x")])))


def test_load_on_supports_only():
    mesh = fx.read(lambda: fx.meshes.frame({"a": (0, 0), "b": (1, 0)}, {"beam": ("a", "b", 2)}), 2)
    scene = fx.Scene([fx.Beam(mesh, fx.Rectangle(0.1, 0.1), fx.Elastic(1e4))], [fx.clamp(mesh, "a")],
                     [fx.PointForce(mesh, "a", (0.0, 1.0))], fx.Monitor(mesh, "b", "y"))
    with pytest.raises(ValueError, match="does not respond to its loads; they act on supports only"):
        fx.Path(scene)


def test_displacement_prescribed_twice():
    base = arch_case().scene
    mesh = base.parts[0].mesh
    motions = [fx.PrescribedDisplacement(mesh, "crown", "y", distance) for distance in (-1.0, 1.0)]
    with pytest.raises(ValueError, match="Displacement of 'crown': component y is prescribed twice; keep one"):
        Scene(base.parts, base.supports, motions, base.monitor)


def test_shell_without_material():
    mesh = fx.read(lambda: fx.meshes.rectangle((1, 1)), 3)
    with pytest.raises(ValueError, match=r"Shell: material is None, but Plate\(thickness=0.1.*give an Elastic"):
        fx.Shell(mesh, fx.Plate(0.1))


def test_structure_without_support():
    with pytest.raises(ValueError, match="supports is empty, and the loads are not in equilibrium: there is a force"):
        trace(Case(bare_arch([])))


def test_unknown_point_and_component():
    with pytest.raises(ValueError, match="'middle'.*crown"):
        bare_arch([("middle", "x")])
    with pytest.raises(ValueError, match="'z'.*x y rz"):
        bare_arch([("end", "z")])


def test_obstacle_inside_the_structure():
    inside = RigidCylinder(100.0, (0.0, 3380.6 + 90.0))
    with pytest.raises(ValueError, match="RigidCylinder: starts 10 inside"):
        trace(Case(bare_arch([("end", "x y rz"), ("crown", "x rz")], [inside])))


def test_failed_path_says_where_and_keeps_its_states():
    """One iteration a step and a tolerance below rounding, through PETSc's own options."""
    options = PETSc.Options()
    settings = {"sheetfx_snes_max_it": 1, "sheetfx_snes_rtol": 1e-30}
    for name, value in settings.items():
        options[name] = value
    try:
        with pytest.raises(PathFailure, match="step 1 from load 0.*DIVERGED_MAX_IT") as failure:
            trace(Case(arch_case(no_punch=True, elements=8).scene, until=Until(deflection=1.0)))
    finally:
        for name in settings:
            options.delValue(name)
    assert len(failure.value.record.states) == 1


@pytest.mark.slow
def test_junctions_stay_whole_on_two_processes(tmp_path):
    """Three panels at an edge, and a dome of bars at whose nodes four and more meet."""
    script = """
import sheetfx as fx
nodes = {n: (x, y, z) for n, x, y, z in zip("abcdefgh", (0, 1, 1, 0, 0, 0, -1, -1), (0, 0, 1, 1, 0, 1, 0, 1),
                                            (0, 0, 0, 0, 1, 1, 0, 0))}
mesh = fx.read(lambda: fx.meshes.panels(nodes, {"one": "abcd", "two": "adfe", "three": "adhg"}, 4), 3)
counts = mesh.comm.gather(mesh.domain.topology.index_map(0).size_global)
print(*(counts or []))
"""
    result = subprocess.run(["mpirun", "-n", "2", sys.executable, "-c", script], capture_output=True, text=True,
                            timeout=100)
    assert result.stdout.split() == ["65", "65"], result.stderr
    loads = []
    for processes in (1, 2):
        folder = tmp_path / str(processes)
        result = sheetfx("run", "star-dome", "--to", 3.5, "--no-pictures", "-o", folder, processes=processes)
        assert result.returncode == 0, result.stderr
        loads.append([p["load"] for p in json.loads((folder / "summary.json").read_text())["critical_points"]])
    assert loads[1] == pytest.approx(loads[0], rel=1e-9)
