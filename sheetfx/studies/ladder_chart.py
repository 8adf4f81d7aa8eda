"""Charts of scenes without a reference of their own: first critical loads of all their models on all meshes.

The reference is the whole model's load with twice as many layers, fibres and steps, extrapolated from its two finest
meshes as if of second order.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from shutil import rmtree
from tempfile import mkdtemp
from typing import TYPE_CHECKING, Any

from .. import interrupts
from ..scenes import load_case
from .chart_runs import ONE_THREAD, Unusable, call

if TYPE_CHECKING:
    from ..ladder.left_out import LeftOut

LOAD = "first critical load"
REMEDY = "give the scene quantities, with their REFERENCE and the CHART of its members"


def _meshes(name: str, finest: int):
    from ..ladder.meshes import by_halving, by_option

    function = load_case(name)
    return by_option(function, {}, finest) or by_halving(function(), finest)


@dataclass(frozen=True, eq=False)
class Model:
    """A scene without some of what it has, on meshes of a level.

    Attributes
    ----------
    method : the things left out, in words
    label : its mesh, in words
    doubled : how often layers or fibres of plastic parts, and steps, are doubled in number
    """

    scene: str
    left: LeftOut
    level: int
    label: str
    doubled: int = 0

    @property
    def method(self) -> str:
        return self.left.words

    def run(self) -> dict:
        """Run once in a process of its own; what `Point` takes."""
        output = call([sys.executable, "-m", __name__, self.scene, str(self.level), str(self.doubled),
                       json.dumps(asdict(self.left))], os.environ | ONE_THREAD)
        return json.loads(output.splitlines()[-1]) | {"method": self.method}


@dataclass(frozen=True, eq=False)
class Advised:
    """The model that `sheetfx advise` finds, with all the time that it takes."""

    scene: str
    label: str = ""
    method: str = "sheetfx advise"

    def run(self) -> dict:
        """Run once in a process of its own; what `Point` takes."""
        folder = mkdtemp()
        with interrupts.finally_(lambda: rmtree(folder)):
            call([sys.executable, "-m", "sheetfx", "advise", self.scene, "--finest", "1", "-o", folder],
                 os.environ | ONE_THREAD)
            advice = json.loads((Path(folder) / "advice.json").read_text())
        return {"method": self.method, "unknowns": float("nan"), "factorisations": float("nan"),
                "iterations": float("nan"), "quantities": {LOAD: advice["load"]}, "cpu_seconds": advice["cpu_seconds"]}


def ladder(name: str) -> list[Model | Advised]:
    """The models of a scene, the poorest ones first, on its meshes, and the advised one."""
    from ..ladder.left_out import LeftOut

    meshes = _meshes(name, 1)
    left = [LeftOut.all_of(meshes.case(meshes.lowest).scene)]
    while left[-1].rungs:
        left.append(left[-1].but(left[-1].rungs[-1].name))
    levels = range(meshes.lowest, meshes.highest + 1)
    return [*(Model(name, one, level, meshes.words(level)) for one in left for level in levels), Advised(name)]


def reference(members: list[Model | Advised], say: Callable[[str], None]) -> dict[str, float]:
    """First critical load of the whole model, from its two finest meshes.

    Raises
    ------
    ValueError
        If the scene has one mesh only, or the path of the whole model stops.
    """
    whole = [replace(one, doubled=1) for one in members if isinstance(one, Model) and not one.left.rungs][-2:]
    if len(whole) < 2:
        raise ValueError(f"chart of {members[0].scene}: its cells cannot be halved, so that nothing tells its error; "
                         f"{REMEDY}")
    loads = []
    for one in whole:
        say(f"reference: {one.method}, {one.label}")
        try:
            loads.append(one.run()["quantities"][LOAD])
        except Unusable as reason:
            raise ValueError(f"chart of {one.scene}: the whole model on {one.label}: {reason}; {REMEDY}") from reason
    return {LOAD: loads[1] - (loads[0] - loads[1]) / 3}


def _first_load(name: str, level: int, doubled: int, left: dict[str, bool]) -> dict[str, Any]:
    """First critical load of a model by its path, and its cost."""
    import time

    from ..discrete.plastic import is_plastic
    from ..ladder.first_point import up_to_first
    from ..ladder.integration import integrated_finer
    from ..ladder.left_out import LeftOut

    case = _meshes(name, 1).case(level)
    begun, out = time.process_time(), LeftOut(**left).of(case)
    if any(map(is_plastic, out.scene.parts)):
        out = integrated_finer(out, doubled)
    found = up_to_first(out, case.scene, LeftOut(), LeftOut())
    if why := found.failure or ("" if found.point else "no limit point or bifurcation up to the end of the path"):
        raise SystemExit(f"sheetfx: error: {why}")
    states = found.record.states
    return {"unknowns": found.record.path.unknowns, "factorisations": sum(s.factorisations for s in states),
            "iterations": sum(s.iterations for s in states), "quantities": {LOAD: found.load},
            "cpu_seconds": time.process_time() - begun}


if __name__ == "__main__":
    print(json.dumps(_first_load(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]), json.loads(sys.argv[4]))))
