"""A run's folder: what a new run deletes there, which folders are refused, and who may write."""

import os
import shutil
import signal
import socket
import subprocess
import sys
import textwrap
import warnings
from pathlib import Path

import numpy as np
import pytest
from mpi4py import MPI

from sheetfx.archive.folder import Archive, Interrupted, Stopped
from sheetfx.continuation.state import State

PARAMETERS = {"elements": 8}
PICTURES = ("path.png", "shape [1].png", "paraview/path.pvd", "fall1/snap.json")


def state(step):
    return State(step, 0.1 * step, 0.2 * step, 0.3 * step, 0, 1, 0.5, 3, 3, 4, 0.1, 0.1, 0.1, 1.0, (1.0, 1.0),
                 increment=np.ones(2), response=np.ones(2), fields={"u": np.ones(2)})


def draw(archive, *names):
    with archive.drawing() as folder:
        for name in names if archive.comm.rank == 0 else ():
            (folder / name).parent.mkdir(exist_ok=True)
            (folder / name).write_text(f"drawn {name}")


def write_run(folder, steps=3, resume=False, pictures=PICTURES):
    """A run without a structure; the number of states that it went on from."""
    archive = Archive(folder, MPI.COMM_WORLD)
    with archive.opened(PARAMETERS, resume) as start:
        for step in range(len(start), steps):
            archive(state(step))
        draw(archive, *pictures)
        if archive.comm.rank == 0:
            archive.write_json("summary.json", {})
    return len(start)


def in_processes(number, folder, body):
    """The result of a script that knows the folder and what is defined here, on a number of MPI processes."""
    script = "import signal\nfrom test_archive import *\nfolder = Path(sys.argv[1])\n" + textwrap.dedent(body)
    return subprocess.run(["mpirun", "-n", str(number), sys.executable, "-c", script, str(folder)],
                          capture_output=True, text=True, timeout=60, cwd=Path(__file__).parent)


def content(folder):
    """Bytes of all files by their names, but for the lock's."""
    return {f.relative_to(folder).as_posix(): f.read_bytes() for f in folder.rglob("*")
            if f.is_file() and f.name != ".lock"}


def put(folder, *names):
    for name in names:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text("mine")


def test_new_run_deletes_what_an_earlier_one_wrote(tmp_path):
    write_run(tmp_path)
    assert set(PICTURES) < set(content(tmp_path))
    write_run(tmp_path, steps=1, pictures=())
    assert set(content(tmp_path)) == {"manifest.json", "parameters.json", "path.csv", "states/000000.0.npz",
                                      "summary.json"}
    assert sorted(f.name for f in tmp_path.iterdir() if f.is_dir()) == ["states"]


@pytest.mark.parametrize("names", [
    ["states/mine.npz"], ["states/000001.0.npz"], ["path.png"], ["manifest.json"], ["paraview/deep/mine.vtu"]])
def test_folder_without_a_run_is_refused(tmp_path, names):
    """Nothing in it is touched, and it gets no lock."""
    put(tmp_path, *names)
    with pytest.raises(ValueError, match=f"{tmp_path} holds files .*: {names[0]}; choose an empty folder with -o"):
        write_run(tmp_path)
    assert [f for f in tmp_path.rglob("*") if f.is_file()] == [tmp_path / names[0]]
    assert (tmp_path / names[0]).read_text() == "mine"


@pytest.mark.parametrize("name", ["notes.txt", "states/mine.npz", "states/000001.0.npz.bak", "shape 1.png", "states2"])
def test_file_beside_an_earlier_run_is_refused(tmp_path, name):
    write_run(tmp_path)
    put(tmp_path, name)
    before = content(tmp_path)
    with pytest.raises(ValueError, match=f": {name};"):
        write_run(tmp_path)
    assert content(tmp_path) == before


def test_linked_folder_is_refused(tmp_path):
    """Neither followed nor passed over: states behind it would be taken for those of the new run."""
    put(tmp_path / "elsewhere", "000007.0.npz")
    write_run(tmp_path / "run")
    shutil.rmtree(tmp_path / "run" / "states")
    (tmp_path / "run" / "states").symlink_to(tmp_path / "elsewhere")
    with pytest.raises(ValueError, match=": states;"):
        write_run(tmp_path / "run")
    assert (tmp_path / "elsewhere" / "000007.0.npz").exists()


def test_refusal_names_three_files(tmp_path):
    put(tmp_path, *"abcde")
    with pytest.raises(ValueError, match=r": [a-e], [a-e], [a-e] and others; "):
        write_run(tmp_path)


def test_hidden_files_are_left(tmp_path):
    put(tmp_path, ".gitignore", ".mine/notes.txt")
    write_run(tmp_path)
    write_run(tmp_path)
    assert {".gitignore", ".mine/notes.txt"} < set(content(tmp_path))
    assert not (tmp_path / ".pictures.part").exists()


def test_resumed_run_leaves_files_of_the_user(tmp_path):
    write_run(tmp_path, steps=2, pictures=["path.png"])
    put(tmp_path, "notes.txt", "states/mine.0.npz")
    assert write_run(tmp_path, resume=True) == 2
    assert {"notes.txt", "states/mine.0.npz", "states/000002.0.npz", *PICTURES} < set(content(tmp_path))
    with pytest.raises(ValueError, match="notes.txt"):
        write_run(tmp_path)


def test_resumed_run_draws_over_no_picture_of_the_user(tmp_path):
    write_run(tmp_path, pictures=[])
    put(tmp_path, "path.png")
    with pytest.raises(ValueError, match="path.png is not of this run.*; move it away and add --resume"):
        write_run(tmp_path, resume=True)
    assert (tmp_path / "path.png").read_text() == "mine"
    (tmp_path / "path.png").unlink()
    assert write_run(tmp_path, resume=True) == 3
    assert (tmp_path / "path.png").read_text() == "drawn path.png"


def test_run_of_an_older_version_can_only_be_resumed(tmp_path):
    """It has no manifest."""
    write_run(tmp_path, pictures=[])
    (tmp_path / "manifest.json").unlink()
    with pytest.raises(ValueError, match="holds files .* and others; .* or move or delete them"):
        write_run(tmp_path)
    assert write_run(tmp_path, resume=True) == 3
    write_run(tmp_path)


def test_run_that_was_killed(tmp_path):
    """Its states and a half-drawn picture are known as the program's: a new run deletes them, --resume goes on."""
    killed = tmp_path / "killed"
    result = in_processes(1, killed, """
        archive = Archive(folder, MPI.COMM_WORLD)
        with archive.opened(PARAMETERS, False):
            for step in range(2):
                archive(state(step))
            draw(archive, "path.png")
            (folder / "states" / "000002.0.part").touch()  # a state half-written
            with archive.drawing() as unfinished:
                (unfinished / "shape.png").touch()
                os.kill(os.getpid(), signal.SIGKILL)
        """)
    assert (killed / ".pictures.part" / "shape.png").exists(), result.stderr
    shutil.copytree(killed, tmp_path / "resumed")
    assert write_run(tmp_path / "resumed", resume=True) == 2
    write_run(killed)
    write_run(tmp_path / "whole")
    new, resumed, whole = (set(content(tmp_path / name)) for name in ("killed", "resumed", "whole"))
    assert new == resumed == whole


def test_second_run_in_a_folder_is_refused(tmp_path):
    """On all MPI processes, with the process that holds it; not once the first has ended."""
    archive = Archive(tmp_path, MPI.COMM_SELF)
    with archive.opened(PARAMETERS, False):
        archive.write_json("parameters.json", PARAMETERS | {"processes": 2})
        before = content(tmp_path)
        result = in_processes(2, tmp_path, """
            for resume in (False, True):
                try:
                    write_run(folder, resume=resume)
                except ValueError as error:
                    os.write(1, f"{error}\\n".encode())
            """)
        assert content(tmp_path) == before
    line = (f"{tmp_path} is in use by process {os.getpid()} on {socket.gethostname()}; wait for its end, "
            "or choose another folder with -o")
    assert result.stdout.splitlines() == 4 * [line], result.stderr
    write_run(tmp_path)


def test_states_of_all_processes_are_deleted(tmp_path):
    result = in_processes(2, tmp_path, "write_run(folder)\nwrite_run(folder, steps=2)")
    assert result.returncode == 0, result.stderr
    assert sorted(f.name for f in (tmp_path / "states").iterdir()) == [
        f"00000{step}.{rank}.npz" for step in range(2) for rank in range(2)]
    write_run(tmp_path, steps=1)
    assert [f.name for f in (tmp_path / "states").iterdir()] == ["000000.0.npz"]


def test_folder_is_cleared_again_and_again_by_one_process(tmp_path):
    """As the failure map does, which locks no folder and reads others' states."""
    archive = Archive(tmp_path / "method", MPI.COMM_SELF)
    for steps in (3, 1):
        archive.clear({})
        for step in range(steps):
            archive(state(step))
    assert [s.step for s in Archive(tmp_path / "method", MPI.COMM_SELF).states()] == [0]
    assert Archive(tmp_path / "nothing", MPI.COMM_SELF).states() == []
    assert not (tmp_path / "nothing").exists()


def test_file_instead_of_a_folder(tmp_path):
    put(tmp_path, "file")
    with pytest.raises(ValueError, match=f"{tmp_path / 'file'} is a file; choose a folder"):
        write_run(tmp_path / "file")


def test_empty_name_of_a_folder(tmp_path):
    result = subprocess.run([sys.executable, "-m", "sheetfx", "run", "arch", "--elements", "4", "-o", ""],
                            capture_output=True, text=True, timeout=60, cwd=tmp_path)
    assert result.returncode == 2
    assert result.stderr == "sheetfx: error: -o: the name '' is empty; give the name of a folder, or leave -o out\n"
    assert not list(tmp_path.iterdir())


def shallow(folder, resume=False, listeners=(), steps=8):
    """A run of an arch of four elements to its first limit point and beyond; the loads of its states."""
    from helpers import shallow_arch

    from sheetfx.case import Case, run
    from sheetfx.continuation.control import ArcLength
    from sheetfx.path import Until

    case = Case(shallow_arch(4), ArcLength(0.01), Until(steps=steps))
    run(case, "arch", PARAMETERS, folder, resume, listeners)
    return [(s.load, s.deflection) for s in Archive(folder, MPI.COMM_SELF).states()]


def at_step(number, action):
    def listener(state):
        if state.step == number:
            action()

    return listener


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole") / "run"
    return folder, shallow(folder)


def file_of(folder, step):
    return folder / "states" / f"{step:06d}.0.npz"


def damage(folder, how, other):
    file, next_one = file_of(folder, 4), file_of(folder, 6)
    if how == "missing":
        file.unlink()
    elif how == "truncated":
        file.write_bytes(file.read_bytes()[:-200])
    elif how == "empty":
        file.write_bytes(b"")
    elif how == "swapped":
        content = file.read_bytes()
        file.write_bytes(next_one.read_bytes())
        next_one.write_bytes(content)
    else:
        shutil.copy(file_of(other, 4), file)


@pytest.mark.parametrize(("how", "said"), [
    ("missing", "is missing"), ("truncated", "cannot be read"), ("empty", "cannot be read"),
    ("swapped", "is that of step 6"), ("foreign", "is of another run")])
def test_state_that_is_not_whole_is_named(whole, how, said, tmp_path):
    """The path goes on from the last whole state before it, as if it had never stopped; nothing is lost."""
    original, loads = whole
    other, folder = tmp_path / "other", tmp_path / "run"
    if how == "foreign":
        shallow(other, steps=5)
    shutil.copytree(original, folder)
    damage(folder, how, other)
    left = {f.name: f.read_bytes() for f in (folder / "states").glob("0*") if int(f.name[:6]) > 3}
    with pytest.warns(UserWarning, match=f"--resume: states/000004.0.npz {said}; the path goes on from step 3"):
        resumed = shallow(folder, resume=True)
    np.testing.assert_allclose(resumed, loads, rtol=1e-12, atol=1e-14)
    assert {f.name: f.read_bytes() for f in (folder / ".aside").iterdir()} == left
    assert (folder / "path.csv").read_text().count("\n") == len(loads) + 1


def test_run_of_another_scene_is_not_resumed(whole, tmp_path):
    """Neither with the same parameters nor by another command; nothing in the folder changes."""
    from sheetfx.case import run
    from sheetfx.studies.study import Study, trace_study

    shutil.copytree(whole[0], tmp_path / "run")
    before = content(tmp_path / "run")
    with pytest.raises(ValueError, match="--resume: the run in .* has scene = arch, not frame; .*another folder"):
        run(None, "frame", PARAMETERS, tmp_path / "run", resume=True)
    with pytest.raises(ValueError, match="has command = run, not study"):
        trace_study(Study("arch", PARAMETERS, {"friction": [0.0]}), tmp_path / "run", resume=True)
    assert content(tmp_path / "run") == before


def test_run_whose_first_state_is_lost_begins_again(whole, tmp_path):
    original, loads = whole
    shutil.copytree(original, tmp_path / "run")
    file_of(tmp_path / "run", 0).unlink()
    with pytest.warns(UserWarning, match=r"000000.0.npz is missing; the path goes on from its start"):
        assert shallow(tmp_path / "run", resume=True) == loads


def test_disk_that_is_full(whole, tmp_path):
    """The kernel refuses the bytes of the fifth state: it is not there, those before are, and the run goes on later."""
    folder, part = tmp_path / "run", tmp_path / "run" / "states" / "000004.0.part"
    with pytest.raises(Stopped, match=r"No space left on device: .*/000004.0.npz; 4 states are kept in .*; go on with "
                                      "--resume, once that is mended"):
        shallow(folder, listeners=[at_step(3, lambda: part.symlink_to("/dev/full"))])
    assert sorted(f.name for f in (folder / "states").glob("0*")) == [f"00000{n}.0.npz" for n in range(4)]
    np.testing.assert_allclose(shallow(folder, resume=True), whole[1], rtol=1e-12, atol=1e-14)


def test_disk_that_is_full_before_the_table(whole, tmp_path):
    """The state is kept, its line is not; --resume writes the table anew."""
    folder = tmp_path / "run"

    def fill():
        (folder / "path.csv").unlink()
        (folder / "path.csv").symlink_to("/dev/full")

    with pytest.raises(Stopped, match="No space left on device; 5 states are kept"):
        shallow(folder, listeners=[at_step(3, fill)])
    shallow(folder, resume=True)
    assert (folder / "path.csv").read_bytes() == (whole[0] / "path.csv").read_bytes()


def test_disk_that_is_full_for_a_picture(tmp_path):
    """On all processes, with what is kept."""
    def draw_on_a_full_disk(archive):
        with archive.drawing() as folder:
            (folder / "path.png").symlink_to("/dev/full")
            (folder / "path.png").write_text("drawn")

    with pytest.raises(Stopped, match="No space left on device; 1 state is kept in .*; go on with --resume, once"):
        archive = Archive(tmp_path, MPI.COMM_WORLD)
        with archive.opened(PARAMETERS, False):
            archive(state(0))
            draw_on_a_full_disk(archive)
    assert write_run(tmp_path, resume=True) == 1


def test_memory_disk_that_fills_up(tmp_path):
    """A file system of 64 kB; where the system lets nobody mount one, /dev/full has been tried above."""
    mounted = tmp_path / "small"
    mounted.mkdir()
    if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=64k", "none", mounted], capture_output=True).returncode:
        pytest.skip("no right to mount a file system")
    try:
        with pytest.raises(Stopped, match="No space left on device.*states are kept in .*; go on with --resume"):
            shallow(mounted / "run", steps=200)
        kept = len(Archive(mounted / "run", MPI.COMM_SELF).states())
        subprocess.run(["mount", "-o", "remount,size=4m", mounted], check=True)
        assert 0 < kept < len(shallow(mounted / "run", resume=True, steps=kept + 2))
    finally:
        subprocess.run(["umount", mounted], check=True)


def test_folder_that_cannot_be_written(tmp_path):
    """Not by root either: a folder of the kernel's."""
    with pytest.raises(ValueError, match=r": /sys/sheetfx; choose another folder with -o"):
        write_run(Path("/sys/sheetfx"))


@pytest.fixture
def ctrl_c():
    """Ctrl-C as a terminal has it; a shell has processes that run behind ignore it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def test_interrupted_run_says_how_to_go_on(whole, tmp_path, ctrl_c):
    folder = tmp_path / "run"
    with pytest.raises(Interrupted, match="interrupted; 4 states are kept in .*; go on with --resume"):
        shallow(folder, listeners=[at_step(3, lambda: os.kill(os.getpid(), signal.SIGINT))])
    np.testing.assert_allclose(shallow(folder, resume=True), whole[1], rtol=1e-12, atol=1e-14)


def test_warnings_reach_the_user(tmp_path, monkeypatch, capsys):
    """In one line by the command, and in scripts too, though FFCx sends warnings to a logger without a reader."""
    from sheetfx import case, cli

    def warn(*_):
        warnings.warn("the work of the loads is not what is stored", stacklevel=2)
        raise Stopped("later")

    monkeypatch.setattr(case, "run", warn)
    monkeypatch.setattr(warnings, "showwarning", warnings.showwarning)
    monkeypatch.setattr("sys.argv", ["sheetfx", "run", "star-dome", "-o", str(tmp_path)])
    with warnings.catch_warnings(), pytest.raises(SystemExit):
        warnings.simplefilter("always")
        cli.main()
    assert capsys.readouterr().err.startswith("sheetfx: warning: the work of the loads is not what is stored\n")
    script = "import warnings, sheetfx as fx, dolfinx\nfx.Path\nwarnings.warn('to be seen')"
    assert "to be seen" in subprocess.run([sys.executable, "-c", script], capture_output=True, text=True).stderr


def test_another_number_of_processes_is_told(tmp_path):
    """Each process has its own part of the states."""
    archive = Archive(tmp_path, MPI.COMM_SELF)
    archive.clear(PARAMETERS)
    archive.write_json("parameters.json", PARAMETERS | {"processes": 2})
    with pytest.raises(ValueError, match="has processes = 2, not 1; start it with mpirun -n 2, or choose"):
        write_run(tmp_path, resume=True)


def test_process_without_states_of_its_own(tmp_path):
    """Where one of two has lost its part, both go on from what both have."""
    result = in_processes(2, tmp_path, "write_run(folder, steps=4)")
    assert result.returncode == 0, result.stderr
    for step in range(2, 4):
        (tmp_path / "states" / f"{step:06d}.1.npz").unlink()
    result = in_processes(2, tmp_path, "print(write_run(folder, steps=4, resume=True))")
    assert result.stdout.split() == ["2", "2"], result.stderr
    assert "states/000002.1.npz is missing; the path goes on from step 1" in result.stderr
    for file in tmp_path.glob("states/*.1.npz"):
        file.unlink()
    result = in_processes(2, tmp_path, "print(write_run(folder, steps=4, resume=True))")
    assert result.stdout.split() == ["0", "0"] and "000000.1.npz is missing" in result.stderr
