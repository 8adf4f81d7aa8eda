"""The event at which a structure yields first."""

from __future__ import annotations

from mpi4py import MPI

from ..continuation.state import State
from ..discrete.plastic import is_plastic
from ..model.loads import PointForce
from ..model.scene import Scene
from ..notices import warn
from .event import Event

NAME = "first yield"
NEAR = 1e-6  # of the yield stress


def first_yield(scene: Scene) -> Event:
    """Event at which the first point of a plastic part yields, in layers and fibres at their own places.

    Until then strains are elastic, so that stresses follow from them; they go on growing where it has yielded. Under a
    force at a point of a shell they grow with the logarithm of the number of cells, so that first yield has no limit
    as the mesh is refined: a warning says so.

    Raises
    ------
    ValueError
        For a scene without plastic parts.
    """
    laws = {f"history of part {n} 0": part.section_law for n, part in enumerate(scene.parts) if is_plastic(part)}
    if not laws:
        raise ValueError("first_yield: no part of the scene is plastic; give one an fx.Plastic material")
    shells = [part.mesh for part in scene.parts if is_plastic(part) and hasattr(part, "discrete")]
    at = [load.at for load in scene.loads
          if isinstance(load, PointForce) and load.mesh in shells and load.at in load.mesh.points]
    if at:
        what = f"a force acts at the point {at[0]!r}" if len(at) == 1 else (
            f"forces act at the points {', '.join(map(repr, at))} ({len(at)})")
        warn(f"first_yield: {what} of a plastic shell, where first yield has no limit as the mesh is refined; spread "
             "it by a SurfaceForce with a function of the place")
    comm = scene.parts[0].mesh.comm

    def excess(state: State) -> float:
        largest = 0.0
        for name, law in laws.items():
            kept = state.fields[name]
            strains = kept[..., :kept.shape[2] - law.remembered].reshape(-1, kept.shape[2] - law.remembered)
            largest = max(largest, float(law.elastic_utilisation(strains).max(initial=0.0)))
        return comm.allreduce(largest, op=MPI.MAX) - 1

    return Event(NAME, excess, NEAR)
