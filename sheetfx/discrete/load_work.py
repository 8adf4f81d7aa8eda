"""From the loads of a scene's stages to contributions."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from ..model.loads import Load
from ..model.scene import Scene
from .contribution import Contribution
from .elements import ElementWork
from .fields import Fields, NodalForces
from .form_work import FormWork, by_mesh, work_of
from .natural_strain import NaturalStrainLoad
from .nodal import NodalLoads


def works_of_loads(fields: Fields) -> Iterator[tuple[Load | None, Iterator[Contribution]]]:
    """Work of the loads of each stage: those that follow the structure one by one, all others together (None)."""
    for number, stage in enumerate(fields.scene.all_stages):
        at_stage = fields.at_stage(number)
        yield None, _work_of([load for load in stage.loads if load.conservative], at_stage)
        for load in stage.loads:
            if not load.conservative:
                yield load, _work_of([load], at_stage)


def _work_of(loads: Sequence[Load], fields: Fields) -> Iterator[Contribution]:
    """The work of some loads on each mesh in one form, their forces at points, and other contributions."""
    conservative, nodal = all(load.conservative for load in loads), NodalForces(fields)
    for load in loads:
        load.at_points(nodal)
        yield from load.contributions(fields)
    if any(array is not None for array in nodal.arrays):
        yield NodalLoads(nodal.arrays, fields.factor_now, fields.stage, conservative)
    for work in by_mesh([work_of(load, fields) for load in loads]):
        yield FormWork(fields.unknowns, -work, factor=fields.factor, conservative=conservative, stage=fields.stage)


def works_of_natural_strains(scene: Scene, parts: Sequence[ElementWork]) -> Iterator[Contribution]:
    """Load vectors of changes of the strains at which parts are free of stress."""
    for stage, load in scene.stress_free:
        yield NaturalStrainLoad(parts[scene.parts.index(load.part)], load.natural(), stage)
