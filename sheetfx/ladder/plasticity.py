"""Whether materials yield before the first critical point: stresses of the elastic structure over the yield stress."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields

import numpy as np
from mpi4py import MPI

from ..continuation.state import State
from ..critical.remade import remade
from ..discrete.plastic import is_plastic
from ..discrete.section_forces import section_forces
from ..model.beam import Bar
from ..model.plasticity import Plastic
from ..model.scene import Scene
from ..model.section import Elastic
from ..model.stresses import stresses, von_mises
from ..record import Record
from .rung import Evidence


class Utilisation:
    """Largest stress of an elastic structure over the yield stress of its materials, over the states of a path.

    Parameters
    ----------
    scene : with the plastic parts, in the order of the elastic ones
    record : of the elastic structure

    Attributes
    ----------
    largest, load : the largest so far, and the load of its state
    """

    def __init__(self, scene: Scene, record: Record):
        self._record, self._parts = record, list(zip(scene.parts, record.case.scene.parts, strict=True))
        self._comm = scene.parts[0].mesh.comm
        self.largest, self.load = 0.0, 0.0

    def __call__(self, state: State) -> Evidence | None:
        with self._record.path.discretisation.visiting(state.fields):
            now = max(self._of(plastic, elastic) for plastic, elastic in self._parts if _yields(plastic))
        now = self._comm.allreduce(now, op=MPI.MAX)
        if now > self.largest:
            self.largest, self.load = now, state.load
        return Evidence(self.told) if now >= 1.0 else None

    @property
    def told(self) -> str:
        return f"the largest von Mises stress, at load {self.load:.6g}, is {self.largest:.0%} of the yield stress"

    def _of(self, plastic, elastic) -> float:
        structure = self._record.path.discretisation
        forces, held = section_forces(structure, elastic), structure.fields.residual_stresses
        found = [von_mises(stresses(elastic, forces, at) + held(elastic, at)) for at in _places(plastic)]
        return max((float(one.max(initial=0.0)) for one in found), default=0.0) / plastic.material.yield_stress


def _yields(part) -> bool:
    """Whether a part flows because of its material, and not by a law of its own."""
    return is_plastic(part) and isinstance(part.material, Plastic)


def _places(part) -> list:
    """Places of the layers or fibres that a plastic part is integrated over."""
    if isinstance(part, Bar):
        return [0.0]
    if hasattr(part.section, "layers"):
        return list(part.section.layers()[0])
    places = np.asarray(part.section.fibres()[0])
    return list(places) if part.mesh.dimension == 3 else list(np.unique(places.reshape(len(places), -1)[:, 0]))


class Plasticity:
    """Yielding of plastic materials; until the first yield the structure is the elastic one."""

    name = "plasticity"
    NEAR = 0.9  # of the yield stress, from which on stresses between the points looked at may reach it

    def present(self, scene: Scene) -> bool:
        return any(map(_yields, scene.parts))

    def without(self, scene: Scene) -> Scene:
        materials = {id(part.material): part.material for part in scene.parts if _yields(part)}
        return remade(scene, {one: _elastic(one) for one in materials.values()})

    def watch(self, scene: Scene, record: Record) -> Callable[[State], Evidence | None]:
        return Utilisation(scene, record)

    def evidence(self, seen: Utilisation) -> Evidence:
        return Evidence(seen.told, 0.0 if seen.largest < self.NEAR else None)


def _elastic(material: Plastic) -> Elastic:
    return Elastic(**{f.name: getattr(material, f.name) for f in fields(Elastic)})
