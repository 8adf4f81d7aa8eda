"""Critical points and what they tell: names, branches, falls, buckling, vibrations, sensitivity to imperfections.

Called as a function, `fx.critical(scene, guess, mode)`, the room finds a point directly: see `critical.augmented`.
"""

from ..rooms import called_as_function

called_as_function(__name__, "sheetfx.critical.augmented")
