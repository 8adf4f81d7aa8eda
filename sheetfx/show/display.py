"""An X server for VTK, which ends the whole process where it finds none."""

from __future__ import annotations

import ctypes
import ctypes.util
import os
import shutil
import subprocess
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path


class NoDisplay(RuntimeError):
    """There is no X server and none can be started; the message names the remedy."""


@contextmanager
def display() -> Iterator[None]:
    """Make sure that DISPLAY names an X server that answers; start Xvfb where it does not."""
    if _answers():
        yield
        return
    before = os.environ.get("DISPLAY")
    server, os.environ["DISPLAY"] = _start()
    try:
        yield
    finally:
        os.environ.pop("DISPLAY")
        if before is not None:
            os.environ["DISPLAY"] = before
        server.terminate()
        server.wait()


def save_picture(draw: Callable[[Path], None], file: Path) -> None:
    """Draw into a file where there is an X server, otherwise warn."""
    try:
        with display():
            draw(file)
    except NoDisplay as missing:
        warnings.warn(f"{file.name} is not drawn: {missing}", stacklevel=3)


def _answers() -> bool:
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
    """Start Xvfb on a free display and wait for the number that it reports."""
    executable = shutil.which("Xvfb")
    if executable is None:
        raise NoDisplay("there is no X server and Xvfb is missing: install the package xvfb (apt-get install xvfb)")
    reader, writer = os.pipe()
    options = ["-displayfd", str(writer), "-screen", "0", "1600x900x24", "-nolisten", "tcp"]
    server = subprocess.Popen([executable, *options], pass_fds=[writer],
                              stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    os.close(writer)
    with os.fdopen(reader) as stream:
        number = stream.readline().strip()
    if not number:
        raise NoDisplay(f"Xvfb ended with status {server.wait()} before it was ready; run Xvfb by hand to see why")
    return server, f":{number}"
