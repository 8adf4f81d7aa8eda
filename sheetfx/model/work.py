"""Internal virtual work of a part as data: strains, section law and quadrature."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from dolfinx.mesh import Mesh

from ..mesh.quadrature import Rule
from .history import LawWithHistory
from .tying import Tying


@dataclass(frozen=True)
class Term:
    """Internal virtual work with one quadrature rule.

    Attributes
    ----------
    strains : UFL vector of generalised strains
    law : function from strains to stress resultants, the gradient of an energy density, or a LawWithHistory
    rule : quadrature
    tying : strains that the law is given instead; None: those at the points
    stretch : length or area that resultants belong to, over the mesh's
    """

    strains: Any
    law: Callable | LawWithHistory
    rule: Rule
    tying: Tying | None = None
    stretch: object = 1.0


@dataclass(frozen=True)
class Internal:
    """Internal virtual work of one group of cells.

    Attributes
    ----------
    terms : of the sum
    mesh, cells : of the integral (cells of this process)
    """

    terms: Sequence[Term]
    domain: Mesh
    cells: np.ndarray

    def less(self, natural) -> Internal:
        """That of the strains less those at which the part is free of stress (UFL vector; None: none).

        Raises
        ------
        ValueError
            If these are not as many as the strains.
        """
        if natural is None:
            return self
        for term in self.terms:
            if term.strains.ufl_shape != natural.ufl_shape:
                raise ValueError(f"Scene: a part has {term.strains.ufl_shape[0]} strains, and the initial strain of "
                                 f"{natural.ufl_shape[0]} is that of the usual ones; give a StressFree load whose "
                                 "`natural` returns as many")
        return replace(self, terms=[replace(term, strains=term.strains - natural) for term in self.terms])


class Acting:
    """What acts on a structure: a joint or a load; what it does not define it leaves as here.

    `fields` is what virtual work is written in (`discrete.fields.Fields`): `fields.displacement(mesh)`,
    `fields.rotation(mesh)`, `fields.factor` (the load factor) and `fields.vary(expression)`.

    Attributes
    ----------
    smooth : whether its forces change smoothly with the state; contact does not
    conservative : whether its forces have a potential
    """

    smooth = conservative = True

    def unknowns(self, fields) -> None:
        """Add unknowns of its own, such as multipliers."""

    def work(self, fields):
        """Its virtual work as a UFL form; None: none."""
        return

    def contributions(self, fields) -> Iterable:
        """Contributions to the system beside that form (`discrete.contribution.Contribution`)."""
        return ()
