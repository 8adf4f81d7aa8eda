"""Rigid motions of a structure that nothing supports, and whether its loads are in equilibrium."""

from __future__ import annotations

import numpy as np
from petsc4py import PETSc

from ..notices import listed

BALANCED = 1e-6  # sum of forces over the sum of their sizes, that is rounding of the numbers that were given
MOTIONS = {2: ("along x", "along y", "about z"),
           3: ("along x", "along y", "along z", "about x", "about y", "about z")}


def rigid_motions(discretisation) -> dict[str, PETSc.Vec]:
    """Steps that move the whole structure along and about the axes, from where it is now, by their words."""
    dimension = discretisation.scene.parts[0].mesh.dimension
    size = max(mesh.size for mesh in discretisation.scene.meshes)
    places = _places(discretisation)
    ends = [np.concatenate(discretisation.system.comm.allgather(x)) for x, turns in places if not turns]
    middle = np.mean(np.concatenate(ends), axis=0)
    found = {}
    for number, words in enumerate(MOTIONS[dimension]):
        along, about = np.zeros(3), np.zeros(3)
        if number < dimension:
            along[number] = size
        else:
            about[number - dimension if dimension == 3 else 2] = 1.0
        motions = []
        for field, (x, turns) in zip(discretisation.unknowns.fields, places, strict=True):
            if x is None:
                motions.append(np.zeros((len(field.table), field.width)))
            elif turns:
                motions.append(np.tile(about if field.width == 3 else about[2:], (len(x), 1)))
            else:
                motions.append((along + np.cross(about, x - middle))[:, :dimension])
        found[words] = discretisation.system.step_by(motions)
    return found


def _places(discretisation) -> list[tuple]:
    """For each field where its nodes are, (nodes, 3), None where it has none, and whether they turn there."""
    found = dict.fromkeys(range(len(discretisation.unknowns.fields)), (None, True))
    for mesh in discretisation.scene.meshes:
        moving, *turning = discretisation.kinematics(mesh).block.fields
        for field in (moving, *turning):
            space = field.value.function_space
            x = space.tabulate_dof_coordinates().copy()
            if field is moving:
                x[:, :mesh.dimension] += field.table
            found[discretisation.unknowns.fields.index(field)] = x, field is not moving
    return [found[number] for number in sorted(found)]


def unbalanced(discretisation, load: PETSc.Vec) -> str:
    """The fault of a load vector that is not in equilibrium; "": nothing, or something holds the structure."""
    if not discretisation.scene.free:
        return ""
    motions, told = rigid_motions(discretisation), []
    moving = sum(np.abs(motion.array) for motion in motions.values())
    sums = [*(load.array @ motion.array for motion in motions.values()), np.abs(load.array) @ moving]
    *works, size = discretisation.system.comm.allreduce(np.array(sums))
    for words, work in zip(motions, works, strict=True):
        if abs(work) > BALANCED * size:
            told.append(f"{'force' if 'along' in words else 'moment'} {words}")
    if not told:
        return ""
    return (f"Scene: supports is empty, and the loads are not in equilibrium: there is a {listed(told, 6, ', a ')}; "
            "add a support, or give loads whose forces and moments cancel out")
