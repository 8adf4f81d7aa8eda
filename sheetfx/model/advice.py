"""What to do about a structure that can move freely."""

from __future__ import annotations

from ..mesh.pieces import pieces_without, straight_joints
from .beam import Bar


def advice_on_supports(scene) -> str:
    """What to do about a structure that can move freely: names a piece without support where there is one."""
    for mesh in scene.meshes:
        held = [support.at for support in scene.supports if support.mesh is mesh]
        held += [at for joint in scene.joints for other, at in joint.points if other is mesh]
        loose = pieces_without(mesh, held)
        if loose:
            return f"nothing supports the piece with {loose[0]}; add a support or join it to the rest"
    for bars in (part for part in scene.parts if isinstance(part, Bar)):
        if count := straight_joints(bars.mesh):
            return (f"{count} nodes join two bars in line, which hinge there; mesh each bar with one cell, or make the "
                    "bars beams")
    return "check that the supports hold all rigid motions of every part"
