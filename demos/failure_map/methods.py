"""Methods of path following by their names: each changes how a case is traced, not the case.

Classical methods run as in textbooks, without the bound on the turn of a step that keeps sheetfx on its path; their
first step loads the unloaded structure as much as the case's.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import inf, pi

from sheetfx.case import Case
from sheetfx.continuation.control import ArcLength, DisplacementControl, LoadControl, StepRule
from sheetfx.discrete.contact import ContactFields
from sheetfx.path import Path

SOFT, STIFF = 1e-4, 1e8  # times the augmentation that the beam's stiffness gives


def _follow(rule: type[StepRule], **options) -> Callable[[Case], Case]:
    """A method that follows the path with another control."""
    def change(case: Case) -> Case:
        path, old = Path(case.scene, case.control), case.control
        new = rule(smallest=old.smallest, largest=old.largest, iterations=old.iterations, turn=pi, **options)
        tangent = path.tracer.tangent
        step = old.predict(old.first, 1.0, tangent) / new.predict(1.0, 1.0, tangent)
        until = case.until
        if isinstance(old, LoadControl):
            system = path.discretisation.system
            system.configure(system.create_vector(), old.target)
            until = replace(until, load=abs(path.discretisation.total_load()))
        return replace(case, control=replace(new, step=step), until=until)
    return change


def _iterate(mixed_points: bool = True, **options) -> Callable[[Case], Case]:
    """A method with another tangent in the iteration."""
    return lambda case: replace(case, mixed_points=mixed_points, control=replace(case.control, turn=pi, **options))


def _enforce(enforcement: str, times: float = 1.0) -> Callable[[Case], Case]:
    """A method that enforces exact contact at integration points with a multiple of the usual augmentation."""
    def change(case: Case) -> Case:
        contacts = [replace(c, enforcement=enforcement, layer=0.0, scale=times * ContactFields(c, "trial").scale)
                    for c in case.scene.contacts]
        return replace(case, scene=replace(case.scene, contacts=contacts), control=replace(case.control, turn=pi))
    return change


ENFORCEMENTS: dict[str, Callable[[Case], Case]] = {
    "penalty-small": _enforce("penalty", SOFT),
    "penalty": _enforce("penalty"),
    "penalty-large": _enforce("penalty", STIFF),
    "uzawa": _enforce("uzawa"),
    "semismooth": _enforce("semismooth"),
}
METHODS: dict[str, Callable[[Case], Case]] = {
    "default": lambda case: case,
    "load": _follow(LoadControl, target=inf),
    "displacement": _follow(DisplacementControl),
    "cylindrical": _follow(ArcLength),
    "spherical": _follow(ArcLength, shape="spherical"),
    "elliptical": _follow(ArcLength, shape="elliptical"),
    "determinant": _follow(ArcLength, sign="determinant"),
    "current-stiffness": _follow(ArcLength, sign="current stiffness"),
    "displacement-extremes": _follow(ArcLength, sign="current stiffness with displacement extremes"),
    "plain-newton": _iterate(mixed_points=False),
    "modified-newton": _iterate(newton="modified", iterations=25),
    **ENFORCEMENTS,
}


def applies(name: str, case: Case) -> bool:
    """Whether a method changes what a case has: without contact there is none to enforce."""
    return name not in ENFORCEMENTS or bool(case.scene.contacts)


def references(case: Case) -> list[Case]:
    """The default method with steps a quarter as long that do not grow (without contact), as long, and that grow.

    The first that reaches the end of its path is the reference of all methods.
    """
    parts = (1,) if case.scene.contacts else (4, 1)
    even = [replace(case, control=replace(case.control, step=case.control.first / part, largest=1.0)) for part in parts]
    return [*even, case]
