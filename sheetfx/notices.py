"""Warnings that show the user's line, and lists of names in messages."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Sequence

PACKAGE = __name__.partition(".")[0]


def warn(message: str) -> None:
    """Warn at the first line outside the package that led there."""
    frame, level = sys._getframe(1), 2
    while frame.f_back is not None and str(frame.f_globals.get("__name__")).partition(".")[0] == PACKAGE:
        frame, level = frame.f_back, level + 1
    warnings.warn(message, stacklevel=level)


def listed(names: Sequence[str], most: int, between: str = ", ") -> str:
    """The first names, and how many more there are."""
    more = len(names) - most
    return between.join(names[:most]) + (f" and {more} more" if more > 0 else "")


def alike(kind: str, names: Sequence[str]) -> str:
    """Places of objects of one kind, such as "bolt at 'a'" or "bolts at 'a', 'b' (2)"."""
    if len(names) == 1:
        return f"{kind} at {names[0]!r}"
    return f"{kind}s at {', '.join(map(repr, names))} ({len(names)})"
