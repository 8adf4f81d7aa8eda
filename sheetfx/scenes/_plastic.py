"""What scenes with a yield stress report."""

from __future__ import annotations

from typing import Annotated

from typer import Option

from ..checks import POSITIVE
from ..events.event import Event
from ..events.yielding import NAME, first_yield
from ..model.plasticity import Plastic
from ..model.scene import Scene
from ..model.section import Elastic
from ..record import Record
from ..show.evaluate import last_state_kept

Yield = Annotated[float | None, POSITIVE, Option("--yield", help="yield stress (von Mises); default: elastic")]
Hardening = Annotated[float, Option(help="increase of the yield stress by plastic strain, with --yield")]


def material(modulus: float, poisson: float, yield_stress: float | None, hardening: float) -> Elastic:
    """Elastic, or plastic where a yield stress is given."""
    if yield_stress is None:
        if hardening:
            raise ValueError(f"--hardening is {hardening}, but there is no yield stress; add --yield")
        return Elastic(modulus, poisson)
    return Plastic(modulus, poisson, yield_stress=yield_stress, hardening=hardening)


def yield_events(scene: Scene) -> list[Event]:
    """First yield, where the scene is plastic."""
    return [first_yield(scene)] if isinstance(scene.parts[0].material, Plastic) else []


def plastic_quantities(record: Record) -> dict[str, float]:
    """Load and deflection of first yield, and the share of the volume that has flowed at limit points and at the end.

    That at a limit point lies between those of the states beside it, in a straight line.
    """
    if not isinstance(record.case.scene.parts[0].material, Plastic):
        return {}
    events = [p for p in record.critical_points if p.kind == "event" and p.name == NAME]
    values = {"first_yield_load": events[0].load, "first_yield_deflection": events[0].deflection} if events else {}
    with last_state_kept(record):
        shares = {}
        for state in record.states:
            record.show(state)
            shares[state.step] = record.plastic_share()
    lengths = {state.step: state.length for state in record.states}
    names = iter(("limit", "lower_limit"))
    for point in (p for p in record.critical_points if p.kind == "limit"):
        if name := next(names, ""):
            part = point.length / lengths[point.step]
            values[f"plastic_share_at_{name}"] = (1 - part) * shares[point.step - 1] + part * shares[point.step]
    return values | {"plastic_share": shares[record.states[-1].step], "largest_plastic_share": max(shares.values())}
