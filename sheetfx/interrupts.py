"""Ctrl-C on the command line: one line that says what stays and how to go on, and status 130.

What a command keeps is whole on disk at every moment, so that an interrupt may end the process where it stands. Nothing
is raised: no callback, library or thread can lose the interrupt on its way. Python calls the handler between two
instructions of the main thread; a long call of PETSc or gmsh ends first. Scripts that use the package keep Python's
`KeyboardInterrupt`.

Under mpirun process 0 speaks and others ignore the signal, since process 0 may wait for them. Open MPI sends SIGTERM on
Ctrl-C, drops what its processes print from then on, and ends with a status of its own; the line goes past it.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from threading import Lock

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
RANKS = ("OMPI_COMM_WORLD_RANK", "PMI_RANK", "PMIX_RANK")
HOW = "go on with --resume"
CLEAR = b"\r\x1b[2K\x1b[?25h"  # of a terminal: the line of progress away, the cursor back

_actions: list[Callable[[], object]] = []
_processes: set[subprocess.Popen] = set()
_starting = Lock()  # held while a process starts, and by the end of the command for good
_asked: list[int] = []  # signals so far
_stderr = 2


def _account() -> str:
    return "nothing new is kept, and the folder is as it was"


def own() -> None:
    """Have interrupts end this process in one line; signals that are ignored already stay so."""
    global _stderr
    rank = next((os.environ[name] for name in RANKS if name in os.environ), None)
    if rank == "0":
        with suppress(OSError):  # another system than Linux, or another user's mpirun
            _stderr = os.open(f"/proc/{os.getppid()}/fd/2", os.O_WRONLY | os.O_APPEND)
    for number in SIGNALS:
        if signal.getsignal(number) != signal.SIG_IGN:
            signal.signal(number, _interrupted if rank in (None, "0") else signal.SIG_IGN)
    # PETSc would put a handler of its own in the place of that of SIGTERM, and print pages.
    os.environ["PETSC_OPTIONS"] = f"{os.environ.get('PETSC_OPTIONS', '')} -no_signal_handler".strip()


def release() -> None:
    """Ignore interrupts from now on: all is written, and said."""
    for number in SIGNALS:
        if signal.getsignal(number) == _interrupted:
            signal.signal(number, signal.SIG_IGN)


def tell(account: Callable[[], str]) -> None:
    """Have an interrupt say what stays, such as "4 states are kept in results/roof"."""
    global _account
    _account = account


@contextmanager
def finally_(action: Callable[[], object]) -> Iterator[None]:
    """Do something at the end of a `with` block, or where an interrupt ends the process within it."""
    _actions.append(action)
    try:
        yield
    finally:
        _actions.remove(action)
        action()


def call(command: Sequence[str], environment: Mapping[str, str],
         timeout: float | None = None) -> subprocess.CompletedProcess[str]:
    """Run a command, and those that it starts, to its end or this process's; its output is captured.

    Raises
    ------
    subprocess.TimeoutExpired
        Where it takes longer; then it has been killed.
    """
    with _starting:
        process = subprocess.Popen(command, env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True, start_new_session=True)
        _processes.add(process)
    if _asked and _starting.acquire(blocking=False):
        _end()
    try:
        output, errors = process.communicate(timeout=timeout)
    except BaseException:
        _kill(process)
        process.wait()
        raise
    finally:
        _processes.discard(process)
    return subprocess.CompletedProcess(command, process.returncode, output, errors)


def _interrupted(number: int, frame: object) -> None:
    _asked.append(number)
    if _starting.acquire(blocking=False):  # else the thread that starts a process ends all once it has
        _end()


def _end() -> None:
    """End the process and those that it has started; called once, since the lock is never let go of."""
    try:
        for process in list(_processes):
            _kill(process)
        for process in list(_processes):
            with suppress(ChildProcessError):  # seen by the thread that waits for it
                os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOWAIT)
        for action in _actions:
            with suppress(OSError):
                action()
        _say()
    finally:
        os._exit(128 + _asked[0])


def _kill(process: subprocess.Popen) -> None:
    """A process and those that it has started."""
    with suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)


def _say() -> None:
    try:
        kept = _account()
    except Exception:  # of files that cannot be read: the command ends all the same
        kept = "what is kept cannot be read"
    with suppress(Exception):  # a print may have been interrupted in its middle
        sys.stdout.flush()
    for stream in (1, _stderr):
        if os.isatty(stream):
            os.write(stream, CLEAR)
    os.write(_stderr, f"sheetfx: interrupted; {kept}; {HOW}\n".encode())
