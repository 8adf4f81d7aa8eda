"""How far a plastic critical load is off by layers, fibres and steps: the same path with twice as many."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from ..continuation.control import StepRule
from ..critical.remade import remade
from ..discrete.plastic import is_plastic

if TYPE_CHECKING:
    from ..case import Case


def integrated_finer(case: Case, times: int = 1) -> Case:
    """A case with twice as many layers or fibres in its plastic parts and steps half as long, once or several times."""
    if not times:
        return case
    case = integrated_finer(case, times - 1)
    sections = {id(part.section): part.section for part in case.scene.parts
                if is_plastic(part) and isinstance(getattr(part.section, "points", None), int)}
    new = {one: replace(one, points=2 * one.points) for one in sections.values()}
    scene = remade(case.scene, new) if new else case.scene
    until = replace(case.until, event=None, steps=2 * case.until.steps)
    return replace(case, scene=scene, control=_halved(case.control), events=(), until=until)


def _halved(control: StepRule) -> StepRule:
    if control.step is None:
        return replace(control, largest=control.largest / 2)
    return replace(control, step=control.step / 2)
