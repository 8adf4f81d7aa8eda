"""Following equilibrium: controls, the corrector, steps from state to state.

Called as a function, `fx.continuation(F, u, load_factor, bcs)`, the room follows a plain form: see `sheetfx.plain`.
"""

import sys
from importlib import import_module
from types import ModuleType


class _Room(ModuleType):
    """A package of the name of a public function, which it is called as."""

    def __call__(self, *given, **options):
        return import_module("sheetfx.plain").continuation(*given, **options)


sys.modules[__name__].__class__ = _Room
