"""An X server for VTK before 9.4, which ends the whole process where it finds none; later ones can do without."""

from __future__ import annotations

import ctypes
import ctypes.util
import os
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager

from ..interrupts import finally_

WINDOWS = {"EGL": "vtkEGLRenderWindow", "OSMesa": "vtkOSOpenGLRenderWindow"}  # by the library that they need
STARTS = 3  # of Xvfb, until one accepts connections
CHOICE = "VTK_DEFAULT_OPENGL_WINDOW"  # variable by which VTK is told


class NoDisplay(RuntimeError):
    """There is no X server and none can be started; the message names the remedy."""


@contextmanager
def display() -> Iterator[None]:
    """Make sure that VTK can draw: on the X server that DISPLAY names, without one, or on Xvfb."""
    if answers():
        yield
    elif window := _window():
        with _variable(CHOICE, window):
            yield
    else:
        server, name = _start()
        try:
            with finally_(server.terminate), _variable("DISPLAY", name):
                yield
        finally:
            server.wait()


@contextmanager
def _variable(name: str, value: str) -> Iterator[None]:
    """Set a variable of the environment, and put it back."""
    before = os.environ.get(name)
    os.environ[name] = value
    try:
        yield
    finally:
        os.environ.pop(name)
        if before is not None:
            os.environ[name] = before


def _window() -> str | None:
    """VTK's class of a window off the screen, where this version has them and their library is here."""
    from vtkmodules.vtkCommonCore import vtkVersion

    if (vtkVersion.GetVTKMajorVersion(), vtkVersion.GetVTKMinorVersion()) < (9, 4):
        return None
    return next((window for library, window in WINDOWS.items() if ctypes.util.find_library(library)), None)


def answers() -> bool:
    """Whether the X server that DISPLAY names accepts a connection."""
    name = ctypes.util.find_library("X11")
    if not os.environ.get("DISPLAY") or name is None:
        return False
    x11 = ctypes.CDLL(name)
    x11.XOpenDisplay.restype = ctypes.c_void_p
    connection = x11.XOpenDisplay(None)
    if connection:
        x11.XCloseDisplay(ctypes.c_void_p(connection))
    return bool(connection)


def _start() -> tuple[subprocess.Popen, str]:
    """Start an Xvfb that accepts connections: on a busy machine one may not, and VTK would end the process."""
    for _ in range(STARTS):
        server, name = _begun()
        with _variable("DISPLAY", name):
            if answers():
                return server, name
        server.terminate()
        server.wait()
    raise NoDisplay(f"Xvfb has been started {STARTS} times and accepts no connection; run Xvfb by hand to see why")


def _begun() -> tuple[subprocess.Popen, str]:
    """Begin an Xvfb and wait for the number that it reports."""
    executable = shutil.which("Xvfb")
    if executable is None:
        raise NoDisplay("there is no X server and Xvfb is missing: install the package xvfb (apt-get install xvfb)")
    reader, writer = os.pipe()
    # Without -noreset it begins anew as the connection that tries it ends, and may refuse the one that follows.
    options = ["-displayfd", str(writer), "-noreset", "-screen", "0", "1600x900x24", "-nolisten", "tcp"]
    server = subprocess.Popen([executable, *options], pass_fds=[writer],
                              stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    os.close(writer)
    with os.fdopen(reader) as stream:
        number = stream.readline().strip()
    if not number:
        raise NoDisplay(f"Xvfb ended with status {server.wait()} before it was ready; run Xvfb by hand to see why")
    return server, f":{number}"
