"""What to do about a structure that can move freely."""

from __future__ import annotations

from ..mesh.pieces import loose_pieces, straight_joints
from .beam import Bar
from .joints import Compatible
from .loads import PrescribedDisplacement, PrescribedRotation


def piece_without_support(scene) -> str | None:
    """Names on a connected piece of a structure that neither a support nor a joint holds; None: there is none.

    Where joints do not name points, or contacts hold parts, nobody can tell.
    """
    compatible = [joint for joint in scene.joints if isinstance(joint, Compatible)]
    others = [joint.points for joint in scene.joints if joint not in compatible]
    if scene.contacts or not all(others) or any(at is None for points in others for _, at in points):
        return None
    held = [(support.mesh, support.at) for support in scene.supports]
    held += [points[0] for points in others if len(points) == 1]
    loose = loose_pieces(scene.meshes, held, others, [(joint.mesh, joint.to) for joint in compatible])
    return loose[0] if loose else None


def advice_on_supports(scene) -> str:
    """What to do about a structure that can move freely: names a piece without support where there is one."""
    if loose := piece_without_support(scene):
        return f"nothing supports the piece with {loose}; add a support or join it to the rest"
    for bars in (part for part in scene.parts if isinstance(part, Bar)):
        if count := straight_joints(bars.mesh):
            return (f"{count} nodes join two bars in line, which hinge there; mesh each bar with one cell, or make the "
                    "bars beams")
    prescribed = (PrescribedDisplacement, PrescribedRotation)
    twice = any(isinstance(load, prescribed) for load in scene.all_loads)
    touches = scene.contacts or not all(joint.smooth for joint in scene.joints)
    return "check that the supports hold all rigid motions of every part" + (
        ", and that nothing else, no support or weld, holds what is prescribed" if twice else "") + (
        "; contact holds nothing where it is open: begin with parts that touch at as many points as they need, or hold "
        "them by a soft spring" if touches else "")
