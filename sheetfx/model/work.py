"""Internal virtual work of a part as data: strains, section law and quadrature."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from dolfinx.mesh import Mesh

from ..mesh.quadrature import Rule


@dataclass(frozen=True)
class Term:
    """Internal virtual work with one quadrature rule.

    Attributes
    ----------
    strains : UFL vector of generalised strains
    law : function from strains to stress resultants, the gradient of an energy density
    rule : quadrature
    """

    strains: object
    law: Callable
    rule: Rule


@dataclass(frozen=True)
class Internal:
    """Internal virtual work of one group of cells.

    Attributes
    ----------
    terms : what is summed
    mesh, cells : what is integrated over (cells of this process)
    """

    terms: Sequence[Term]
    mesh: Mesh
    cells: np.ndarray
