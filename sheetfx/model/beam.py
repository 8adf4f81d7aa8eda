"""Beams and bars as parts of a scene."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .. import forms
from ..mesh.numbers import as_constants
from ..mesh.quadrature import gauss
from ..mesh.reader import NamedMesh
from .gradient import require_gradient
from .section import Elastic, Section
from .work import Internal, Term

PARALLEL = 1e-6  # sine of the angle between a beam and the direction of its depth


@dataclass(frozen=True, eq=False)
class Beam:
    """Beams on the curves of a mesh.

    Attributes
    ----------
    mesh : NamedMesh
    section, material : constants of the section law
    strains : function (u, rotation, frame) -> generalised strains
    law : function (strains, stiffness) -> stress resultants
    group : physical group of the curves; None: all
    degree : of displacement and rotation, 1 or 2; integrated with `degree` Gauss points, which
        keeps both free of shear and membrane locking
    up : direction of the section's depth, in space
    shear_rigidity : factor on the shear stiffness
    """

    mesh: NamedMesh
    section: Section
    material: Elastic
    strains: Callable = forms.beam.simo_reissner
    law: Callable = forms.section.linear_elastic
    group: str | None = None
    degree: int = 2
    up: tuple[float, float, float] = (0.0, 0.0, 1.0)
    shear_rigidity: float = 1.0

    def __post_init__(self):
        if self.degree not in (1, 2):
            raise ValueError(f"Beam: degree is {self.degree}; it must be 1 or 2")
        if self.mesh.dimension == 3:
            self._check_up()
        stiffness = self.section.stiffness(self.material, self.mesh.dimension, self.shear_rigidity)
        if self.strains is forms.beam.simo_reissner:
            require_gradient("Beam", self.law, stiffness, len(stiffness))

    def _check_up(self) -> None:
        """Refuse a direction of the depth that is parallel to a beam, or none."""
        along = self.mesh.chords(self.group)
        across = np.linalg.norm(np.cross(self.up, along), axis=1) / (np.linalg.norm(self.up) or 1.0)
        parallel = self.mesh.domain.comm.allreduce(int((across < PARALLEL).sum()))
        if parallel:
            raise ValueError(f"Beam: up is {tuple(map(float, self.up))}, parallel to {parallel} cells of group "
                             f"{self.group or 'all'!r}; give a direction across them, or a Beam for each group")

    @property
    def spaces(self) -> tuple[tuple[str, int], tuple[str, int]]:
        """Family and degree of displacement and rotation."""
        return ("P", self.degree), ("P", self.degree)

    def frame(self):
        return forms.beam.curve_frame(self.mesh.domain, self.up)

    def measure(self):
        """Integral along the beams, for loads."""
        return self.mesh.integral({"quadrature_degree": 2 * self.degree - 1}, self.group)

    def internal(self, u, rotation) -> Internal:
        """Internal virtual work."""
        stiffness = self.section.stiffness(self.material, self.mesh.dimension, self.shear_rigidity)
        return _internal(self, u, rotation, stiffness)

    def resultants(self, u, rotation):
        """Forces and moments as a UFL vector, and the points of a cell at which they are exact."""
        return _resultants(self.internal(u, rotation))


@dataclass(frozen=True, eq=False)
class Bar:
    """Straight bars with pin joints at their ends: each cell of the mesh is a bar.

    Attributes
    ----------
    mesh : NamedMesh of straight cells
    section, material : give the axial stiffness
    strains : function (u, rotation, frame) -> vector of one strain; bars have no rotation, it is None
    law : function (strains, stiffness) -> vector of the axial force
    group : physical group of the bars; None: all
    """

    mesh: NamedMesh
    section: Section
    material: Elastic
    strains: Callable = forms.bar.engineering
    law: Callable = forms.section.linear_elastic
    group: str | None = None
    degree = 1
    spaces = ("P", 1), None

    def __post_init__(self):
        if self.mesh.degree != 1:
            raise ValueError(f"Bar: the mesh has curved cells of degree {self.mesh.degree}; "
                             "bars are straight, read it with order 1")
        require_gradient("Bar", self.law, [self.material.modulus * self.section.area], 1)

    def frame(self):
        return forms.bar.bar_frame(self.mesh.domain)

    def measure(self):
        """Integral along the bars, for loads."""
        return self.mesh.integral({"quadrature_degree": 2 * self.degree - 1}, self.group)

    def internal(self, u, rotation) -> Internal:
        """Internal virtual work."""
        return _internal(self, u, rotation, [self.material.modulus * self.section.area])

    def resultants(self, u, rotation):
        """Axial force as a UFL vector, and the point of a cell at which it is exact."""
        return _resultants(self.internal(u, rotation))


def _resultants(internal: Internal):
    (term,) = internal.terms
    return term.law(term.strains), term.rule.points


def _internal(part: Beam | Bar, u, rotation, stiffness) -> Internal:
    domain = part.mesh.domain
    stiffness = as_constants(domain, stiffness)
    term = Term(strains=part.strains(u, rotation, part.frame()), law=lambda strains: part.law(strains, stiffness),
                rule=gauss(domain.basix_cell(), part.degree))
    return Internal([term], domain, part.mesh.group(part.group))
