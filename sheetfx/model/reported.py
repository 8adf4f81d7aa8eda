"""The reported load of a stage: the sum of its forces, or another load as it is."""

from __future__ import annotations

from collections.abc import Sequence

from .loads import FORCE, LINE_PRESSURE, MOMENT, PRESSURE, Load

FACTOR = "load factor"
NOT_ASKED = "not asked for; --error estimates it"  # why a critical load has no error bar
AXES = {FORCE: "load (N)", MOMENT: "moment (N mm)", PRESSURE: "pressure (N/mm²)", LINE_PRESSURE: "pressure (N/mm)",
        FACTOR: FACTOR}  # what the load is called on plots, in the units that deflections have there


def counted(loads: Sequence[Load]) -> tuple[str, list[Load]]:
    """What the reported load is, a key of AXES, and the loads that it is one of: the forces where there are any."""
    kinds = [FACTOR if type(load).total is Load.total else load.reports for load in loads]
    kind = next(kind for kind in AXES if kind in kinds)
    return kind, [load for load, one in zip(loads, kinds, strict=True) if one == kind]


def combined(kind: str, sizes: Sequence[float], symmetry_factor: int) -> float:
    """The reported load of the whole structure: forces and moments add up, of several pressures it is the largest."""
    return symmetry_factor * sum(sizes) if kind in (FORCE, MOMENT) else max(sizes, key=abs)


def meaning(kind: str, symmetry_factor: int) -> str:
    """A reported load in words, with its unit."""
    parts = "" if symmetry_factor == 1 else f" of all {symmetry_factor} equal parts"
    return {FORCE: f"total force{parts}", MOMENT: f"total moment{parts}", PRESSURE: "pressure, a force per area",
            LINE_PRESSURE: "pressure, a force per length", FACTOR: "factor on the loads"}[kind]
