"""Runs of other processes that charts are made of."""

from __future__ import annotations

import re

from .. import interrupts

FAILURE = re.compile(r"(\w+Error|sheetfx: error|stopped): ")
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}


class Unusable(Exception):
    """Why a method cannot be charted."""


def call(command: list[str], environment: dict) -> str:
    """Standard output of a command that must succeed."""
    result = interrupts.call(command, environment)
    if result.returncode == 0:
        return result.stdout
    lines = [line for line in (result.stdout + "\n" + result.stderr).splitlines() if FAILURE.match(line)]
    reason = lines[-1] if lines else f"exit status {result.returncode}"
    if reason.startswith(("ModuleNotFoundError", "ImportError")):
        raise Unusable(f"its package cannot be imported ({reason.partition(': ')[2]}); see demos/peers/README.md")
    raise Unusable(reason)
