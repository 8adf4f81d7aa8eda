"""What to say of a structure that is unstable before any load acts."""

from __future__ import annotations

from ..continuation.spectrum import diagonal, nearest_to_zero
from ..continuation.tracer import Tracer

TOLD = 3  # modes that words describe


def unstable_at_rest(tracer: Tracer) -> str:
    """Number of unstable modes of the first state, and on one process the first ones; called on all processes."""
    count, home = tracer.state.unstable_modes or 0, tracer.discretisation
    if home.system.comm.size > 1:
        return f"{home.unstable_at_rest(count, [])}; run it on one process to have the modes described"
    values, modes = nearest_to_zero(tracer.stepper.linear, diagonal(home.system.weights), count + TOLD)
    wanted = [mode.array for value, mode in zip(values, modes, strict=True) if value < 0][:TOLD]
    return home.unstable_at_rest(count, wanted)
