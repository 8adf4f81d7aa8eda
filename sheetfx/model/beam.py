"""Beams and bars as parts of a scene."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated

import numpy as np
import ufl
from mpi4py import MPI

from .. import forms
from ..checks import Choice, Positive, check, require_components
from ..jit import compiled_expression
from ..mesh.cellwise import cellwise
from ..mesh.numbers import as_constants
from ..mesh.quadrature import Rule, gauss
from ..mesh.reader import NamedMesh
from ..notices import warn
from .gradient import require_law
from .history import LAW, LawWithHistory, has_history
from .own_forms import require_strains
from .places import require_group
from .plasticity import Fibres, Plastic, section_law
from .section import Elastic, Section
from .varying import VaryingSection, require_uniform
from .work import Internal, Term

PARALLEL = 1e-6  # sine of the angle between a beam and the direction of its depth


@dataclass(frozen=True, eq=False)
class Beam:
    """Beams on the curves of a mesh.

    Attributes
    ----------
    mesh : NamedMesh
    section, material : constants of the section law; a Plastic one is integrated over the section's fibres. Measures of
        a section may be functions from the place, a UFL vector, to numbers, such as lambda x: 0.2 - 0.1 * x[0]
    strains : function (u, rotation, frame) -> generalised strains
    law : function (strains, stiffness) -> stress resultants, or a LawWithHistory; stiffness as by
        `Section.stiffness`
    group : physical group of the curves; None: all
    degree : of displacement and rotation, 1 to 4; integrated with `degree` Gauss points, which keeps all free of shear
        and membrane locking
    up : direction of the section's depth, in space: a vector (3,), or a function from the place, a UFL vector, to one
    shear_rigidity : factor on the shear stiffness
    offset : of the section's centroid from the meshed line, so that a stiffener stands beside the mid-surface whose
        nodes it shares: along the depth (in the plane to the left of the line's direction), in space also along the
        width, which is tangent x depth; it turns with the cross-section. Loads, supports, contacts and displacements
        belong to the meshed line, forces and moments to the centroid
    """

    mesh: NamedMesh
    section: Section
    material: Elastic
    strains: Callable = forms.beam.simo_reissner
    law: Annotated[Callable | LawWithHistory, LAW] = forms.section.linear_elastic
    group: str | None = None
    degree: Annotated[int, Choice((1, 2, 3, 4))] = 2
    up: tuple[float, float, float] | Callable = (0.0, 0.0, 1.0)
    shear_rigidity: Positive = 1.0
    offset: float | tuple[float, float] = 0.0

    def __post_init__(self):
        check(self)
        require_group(self)
        if self.mesh.dimension == 3:
            self._check_up()
            self._warn_of_twist()
        _look_at_functions(self, forms.beam.simo_reissner)
        self._check_offset()

    @property
    def _stiffness(self) -> list:
        return self._stiffness_of(self.sections.typical)

    def _stiffness_of(self, section: Section) -> list:
        return section.stiffness(self.material, self.mesh.dimension, self.shear_rigidity)

    @cached_property
    def sections(self) -> VaryingSection:
        """The section wherever it is integrated."""
        return VaryingSection(self, self.degree - 1)

    @cached_property
    def _up(self):
        """Direction of the depth as numbers or a UFL vector."""
        if not callable(self.up):
            return self.up
        vector = self.up(x := ufl.SpatialCoordinate(self.mesh.domain))
        vector = vector if isinstance(vector, ufl.core.expr.Expr) else ufl.as_vector(list(vector))
        if vector.ufl_shape != (3,):
            raise ValueError(f"Beam: up gives UFL of shape {vector.ufl_shape}; give a vector with three components")
        return vector + 0 * x

    @cached_property
    def section_law(self):
        """The law, or the section's fibres' where the material is plastic."""
        return section_law(self.law, self.section, self.material, self._stiffness)

    def _check_up(self) -> None:
        """Refuse a direction of the depth that is parallel to a beam, or none."""
        if callable(self.up):
            self._check_up_function()
            return
        along = self.mesh.chords(self.group)
        across = np.linalg.norm(np.cross(self.up, along), axis=1) / (np.linalg.norm(self.up) or 1.0)
        parallel = self.mesh.comm.allreduce(int((across < PARALLEL).sum()))
        if parallel:
            raise ValueError(f"Beam: up is {tuple(map(float, self.up))}, parallel to {parallel} cells of group "
                             f"{self.group or 'all'!r}; give a direction across them, or a Beam for each group")

    def _check_up_function(self) -> None:
        domain, tangent = self.mesh.domain, forms.beam.unit_tangent(self.mesh.domain)
        across = ufl.cross(self._up, tangent)
        sizes = ufl.as_vector([ufl.dot(across, across), ufl.dot(self._up, self._up)])
        found = compiled_expression(sizes, _rule(self).points).eval(domain, self.mesh.group(self.group)).reshape(-1, 2)
        parallel = self.mesh.comm.allreduce(int((~(found[:, 0] > PARALLEL**2 * found[:, 1])).sum()))
        if parallel:
            raise ValueError(f"Beam: up is parallel to the beam, or zero, at {parallel} points of group "
                             f"{self.group or 'all'!r}; give a direction across it")

    def _warn_of_twist(self) -> None:
        """Say what beams in space lack where their section twists: a shear centre that is not given, and warping, which
        matters where it fades over more than the depth.
        """
        beam, section = f"Beam on group {self.group or 'all'!r}", self.sections.typical
        kind = type(section).__name__
        if section.shear_centre is None:
            warn(f"{beam}: the shear centre of its {kind} is taken as the centroid, which it is not; forces across "
                 "then twist the beam too little or too much: give it, FibreList(shear_centre=...)")
        length = section.warping_length(self.material)
        if length > section.depth:
            warn(f"{beam}: beams do not model warping, by which its {kind} resists twist over lengths of about "
                 f"{length:.3g} (root of E I_w / (G I_t)); where it twists, torsion is too soft and lateral-torsional "
                 "buckling loads are too low: model it by shells where that matters")

    def _check_offset(self) -> None:
        """Refuse an offset of the wrong space, or beyond the centre of a curve."""
        if np.ravel(self.offset).tolist() != [0.0]:
            require_components("Beam: offset", np.ravel(self.offset), self.mesh.dimension - 1)
            if np.ravel(self.offset)[-1]:  # the depth is along `up` in space, whatever the direction
                self.mesh.require_alike("Beam: offset", self.group)
        domain, (_, length) = self.mesh.domain, self.eccentricity()
        if not isinstance(length, float):
            at_points = compiled_expression(length, _rule(self).points)
            lengths = at_points.eval(domain, self.mesh.group(self.group))
            if self.mesh.comm.allreduce(lengths.min(initial=np.inf), op=MPI.MIN) <= 0:
                raise ValueError(f"Beam: offset {np.ravel(self.offset).tolist()} lies beyond the centre of curvature "
                                 f"of group {self.group or 'all'!r}; make it smaller")

    @property
    def spaces(self) -> tuple[tuple[str, int], tuple[str, int]]:
        """Family and degree of displacement and rotation."""
        return ("P", self.degree), ("P", self.degree)

    def frame(self):
        return forms.beam.curve_frame(self.mesh.domain, self._up)

    def measure(self):
        """Integral along the beams, for loads."""
        return self.mesh.integral({"quadrature_degree": 2 * self.degree - 1}, self.group)

    def eccentricity(self) -> tuple[list, object]:
        """Offset as UFL components on the cross-section's axes, empty where there is none, and the length of the line
        of centroids per length of the meshed line.
        """
        if not np.any(self.offset):
            return [], 1.0
        domain, curved = self.mesh.domain, self.mesh.degree > 1
        offset = as_constants(domain, np.ravel(self.offset).tolist())
        direction = cellwise(domain, forms.beam.unit_tangent(domain)) if curved else None
        return offset, forms.beam.curve_frame(domain, self._up, direction).length_at(offset)

    def _strains_and_law(self, u, rotation):
        """Strains of the line of centroids, and the section law."""
        offset, length = self.eccentricity()
        strains, law = _of_the_mesh(self, u, rotation, self.sections.numbers(self._stiffness_of))
        return forms.beam.off_the_line(strains, offset, length) if offset else strains, law

    def internal(self, u, rotation) -> Internal:
        """Internal virtual work."""
        strains, law = self._strains_and_law(u, rotation)
        return _integrated(self, strains, law, self.eccentricity()[1])

    def pointwise(self, u, rotation):
        """Strains as a UFL vector, the section law, and the points of a cell at which forces and moments are exact."""
        return *self._strains_and_law(u, rotation), _rule(self).points


@dataclass(frozen=True, eq=False)
class Bar:
    """Straight bars with pin joints at their ends: each cell of the mesh is a bar.

    Attributes
    ----------
    mesh : NamedMesh of straight cells
    section, material : give the axial stiffness
    strains : function (u, rotation, frame) -> vector of one strain; bars have no rotation, it is None
    law : function (strains, stiffness) -> vector of the axial force, or a LawWithHistory
    group : physical group of the bars; None: all
    """

    mesh: NamedMesh
    section: Section
    material: Elastic
    strains: Callable = forms.bar.engineering
    law: Annotated[Callable | LawWithHistory, LAW] = forms.section.linear_elastic
    group: str | None = None
    degree = 1
    spaces = ("P", 1), None

    def __post_init__(self):
        check(self)
        require_group(self)
        if self.mesh.degree != 1:
            raise ValueError(f"Bar: the mesh has curved cells of degree {self.mesh.degree}; "
                             "bars are straight, read it with order 1")
        _look_at_functions(self, forms.bar.engineering)

    @property
    def _stiffness(self) -> list[float]:
        return self._stiffness_of(self.sections.typical)

    def _stiffness_of(self, section: Section) -> list[float]:
        return [self.material.modulus * section.area]

    @cached_property
    def sections(self) -> VaryingSection:
        """The section wherever it is integrated."""
        return VaryingSection(self, 0)

    @cached_property
    def section_law(self):
        """The law, or one fibre's where the material is plastic."""
        if isinstance(self.material, Plastic) and self.law is forms.section.linear_elastic:
            return Fibres([(0.0, 0.0)], [self.section.area], self.material, self._stiffness)
        return self.law

    def frame(self):
        return forms.bar.bar_frame(self.mesh.domain)

    def measure(self):
        """Integral along the bars, for loads."""
        return self.mesh.integral({"quadrature_degree": 2 * self.degree - 1}, self.group)

    def _strains_and_law(self, u, rotation):
        return _of_the_mesh(self, u, rotation, self.sections.numbers(self._stiffness_of))

    def internal(self, u, rotation) -> Internal:
        """Internal virtual work."""
        return _integrated(self, *self._strains_and_law(u, rotation))

    def pointwise(self, u, rotation):
        """Strain as a UFL vector, the section law, and the point of a cell at which the axial force is exact."""
        return *self._strains_and_law(u, rotation), _rule(self).points


def _look_at_functions(part: Beam | Bar, usual: Callable) -> None:
    """Refuse strains or a law that no structure can have; a law of one's own may take any number of own strains."""
    if isinstance(part.material, Plastic):
        require_uniform(part, type(part).__name__ + " of a Plastic material")
    stiffness = part._stiffness
    sizes = np.diag(stiffness) if np.ndim(stiffness) == 2 else stiffness
    linear = part.law is forms.section.linear_elastic
    if part.strains is not usual:
        count = require_strains(part, part.strains, len(stiffness) if linear else None)
        sizes = sizes if count == len(stiffness) else count * [1.0]
    if part.section_law is not forms.section.linear_elastic:
        require_law(type(part).__name__, part.section_law, stiffness, sizes, part.mesh.domain)


def _of_the_mesh(part: Beam | Bar, u, rotation, stiffness):
    """Strains of the meshed line, and the section law with its stiffness as constants."""
    law, strains = part.section_law, part.strains(u, rotation, part.frame())
    return strains, law if has_history(law) else lambda e: law(e, stiffness)


def _rule(part: Beam | Bar) -> Rule:
    return gauss(part.mesh.domain.basix_cell(), part.degree)


def _integrated(part: Beam | Bar, strains, law, stretch=1.0) -> Internal:
    return Internal([Term(strains, law, _rule(part), stretch=stretch)], part.mesh.domain, part.mesh.group(part.group))
