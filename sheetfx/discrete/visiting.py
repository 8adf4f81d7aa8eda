"""Being at another state for a while."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from .system import System


class Visiting:
    """What has a system that can be put to any state of its path."""

    system: System

    @contextmanager
    def visiting(self, snapshot: dict[str, np.ndarray]) -> Iterator[None]:
        """Be at a state with its load factor, and afterwards where it was before."""
        kept = self.system.snapshot()
        try:
            self.system.restore(snapshot)
            yield
        finally:
            self.system.restore(kept)
