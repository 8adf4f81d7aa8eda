"""CPU seconds by kind of work."""

from __future__ import annotations

import time
from collections import defaultdict
from contextlib import contextmanager


class Stopwatch:
    """Adds up the CPU time of named parts; parts do not overlap."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = defaultdict(float)
        self._start = time.process_time()

    @contextmanager
    def __call__(self, part: str):
        start = time.process_time()
        try:
            yield
        finally:
            self.seconds[part] += time.process_time() - start

    @property
    def total(self) -> float:
        return time.process_time() - self._start
