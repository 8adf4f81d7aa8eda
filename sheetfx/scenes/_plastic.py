"""What scenes with a yield stress report."""

from __future__ import annotations

from typing import Annotated

from typer import Option

from ..checks import POSITIVE
from ..continuation.state import State
from ..events.event import Event
from ..events.yielding import NAME, first_yield
from ..model.plasticity import Plastic
from ..model.scene import Scene
from ..model.section import Elastic
from ..record import Record
from ..show.evaluate import last_state_kept
from ..show.pictures import state_of

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

    Of a limit point whose state does not converge again, the share is that at the end of its step.
    """
    if not isinstance(record.case.scene.parts[0].material, Plastic):
        return {}
    events = [p for p in record.critical_points if p.kind == "event" and p.name == NAME]
    values = {"first_yield_load": events[0].load, "first_yield_deflection": events[0].deflection} if events else {}
    limits = [p for p in record.critical_points if p.kind == "limit"][:2]
    at_limits = [state_of(record, point) for point in limits]

    def share(state: State) -> float:
        record.show(state)
        return record.plastic_share()

    with last_state_kept(record):
        shares = [share(state) for state in record.states]
        values |= {f"plastic_share_at_{name}": share(state)
                   for name, state in zip(("limit", "lower_limit"), at_limits, strict=False)}
    return values | {"plastic_share": shares[-1], "largest_plastic_share": max(shares)}
