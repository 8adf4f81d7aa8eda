"""Following equilibrium: controls, the corrector, steps from state to state.

Called as a function, `fx.continuation(F, u, load_factor, bcs)`, the room follows a plain form: see `sheetfx.plain`.
"""

from ..rooms import called_as_function

called_as_function(__name__, "sheetfx.plain")
