"""What to say of a structure that is unstable before any load acts."""

from __future__ import annotations

import numpy as np

from ..continuation.spectrum import diagonal, nearest_to_zero
from ..continuation.tracer import Tracer
from ..discrete.motion_words import motions_in_words, rigid_motions_in_words

TOLD = 3  # modes that words describe


def unstable_at_rest(tracer: Tracer) -> str:
    """Number of unstable modes of the unloaded structure, and what the first ones look like; on all processes."""
    count, home = tracer.state.unstable_modes, tracer.discretisation
    text = f"Scene: the unloaded structure is unstable in {count} mode{'s' * (count > 1)}"
    advice = ("; loads of a first stage may stabilise it, else look for stiffnesses that are negative, as of springs "
              "or own laws")
    if home.system.comm.size > 1:
        return f"{text}{advice}; run it on one process to have the modes described"
    values, modes = nearest_to_zero(tracer.stepper.linear, diagonal(home.system.weights), count + TOLD)
    wanted = [mode.array for value, mode in zip(values, modes, strict=True) if value < 0][:TOLD]
    told = [rigid_motions_in_words(home, column) or motions_in_words(home, column)
            for column in (np.array(mode)[:, None] for mode in wanted)]
    return text + (f" ({'; '.join(told)})" if told else "") + advice
