"""Interrupts within functions that PETSc and SLEPc call: petsc4py wraps them in errors of its own."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from petsc4py import PETSc


@contextmanager
def interruptible() -> Iterator[None]:
    """Have a `KeyboardInterrupt` in a callback leave the `with` block as such, for scripts and notebooks."""
    try:
        yield
    except PETSc.Error as error:
        inner: BaseException | None = error
        while isinstance(inner, PETSc.Error):
            inner = inner.__cause__ or inner.__context__
        if isinstance(inner, KeyboardInterrupt):
            raise inner from None
        raise
