"""One run of a study as a task: `python3 -m sheetfx.studies.study_run TASK` with a task of `study` in JSON."""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from pathlib import Path as Folder
from typing import Any

from ..case import run
from ..record import Record
from ..scenes import load_case

NO_MOTION = 1e-9  # share of the monitored displacement in the response to the load that is rounding


def follow(scene: str, parameters: dict[str, Any], folder: str, resume: bool, pictures: bool) -> None:
    """Trace a scene into a folder; its summary gets the initial stiffness among the quantities."""
    case = load_case(scene)(**parameters)
    reported = case.quantities
    case = replace(case, quantities=lambda record: initial_stiffness(record) | reported(record),
                   pictures=case.pictures if pictures else ())
    run(case, Folder(scene).stem, parameters, Folder(folder), resume)


def initial_stiffness(record: Record) -> dict[str, float]:
    """Slope of the load over the deflection where the last load stage begins, by the tangent there.

    Nothing where the monitored displacement does not answer to the load. The slope of a reaction, which is no multiple
    of the load factor, belongs to the stage's first step.
    """
    first, *others = [state for state in record.states if state.stage == record.states[-1].stage]
    tracer = record.path.tracer
    response = tracer.system.create_vector(first.response)
    moved = tracer.monitored_rate(response)
    if abs(moved) <= NO_MOTION * response.norm():
        return {}
    if (load := record.path.discretisation.load_of_unit()) is None:
        if not others or others[0].deflection == first.deflection:
            return {}
        return {"initial_stiffness": (others[0].load - first.load) / (others[0].deflection - first.deflection)}
    return {"initial_stiffness": load / moved}


if __name__ == "__main__":
    follow(**json.loads(sys.argv[1]))
