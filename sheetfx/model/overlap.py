"""Parts that lie on the same cells, whose stiffness adds up."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from itertools import combinations

import numpy as np

from ..notices import warn
from .beam import Bar, Beam
from .shell import Shell


def refuse_overlap(parts: Sequence[Beam | Bar | Shell]) -> None:
    """Refuse parts at one place that have cells in common; parts of unlike offsets are layers.

    Two parts with other sections, materials or laws on just the same cells may be meant, and are told.

    Raises
    ------
    ValueError
    """
    for one, other in combinations(parts, 2):
        pair = one, other
        if one.mesh is not other.mesh or not np.array_equal(*(np.ravel(getattr(p, "offset", 0.0)) for p in pair)):
            continue
        groups = [part.mesh.group(part.group) for part in pair]
        both, *own = one.mesh.comm.allreduce(np.array([len(np.intersect1d(*groups)), *map(len, groups)]))
        if not both:
            continue
        names = [f"{type(p).__name__} on {'all cells' if p.group is None else f'group {p.group!r}'}" for p in pair]
        common = f"{both} cell{'s' if both > 1 else ''} in common"
        twice = f"{names[0]} and {names[1]} have {common}, whose stiffness and loads count twice"
        unlike = [f.name for f in fields(one) if f.name not in ("mesh", "group") and type(one) is type(other)
                  and repr(getattr(one, f.name)) != repr(getattr(other, f.name))]
        if both == own[0] == own[1] and unlike:
            warn(f"Scene: {twice}; they differ in {', '.join(unlike)} alone, as two layers that act together do")
            continue
        raise ValueError(f"Scene: {twice}; give them groups without common cells, or layers offsets or meshes of their "
                         "own")
