"""Rooms with the name of a public function, which are called as the function is."""

import sys
from importlib import import_module
from types import ModuleType


def called_as_function(room: str, home: str) -> None:
    """Let a room be called as the function of its name.

    Parameters
    ----------
    room : full name of the package
    home : full name of the module that has the function
    """
    class Room(ModuleType):
        def __call__(self, *given, **options):
            return getattr(import_module(home), room.rpartition(".")[2])(*given, **options)

    sys.modules[room].__class__ = Room
