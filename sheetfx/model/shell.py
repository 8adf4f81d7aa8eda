"""Shells as parts of a scene, and the families of their discrete forms."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated

import basix
import numpy as np
import ufl
from dolfinx import fem
from mpi4py import MPI

from .. import forms
from ..checks import NONZERO, check
from ..compat import geometry_degree
from ..jit import compiled_expression
from ..mesh.cellwise import cellwise
from ..mesh.numbers import as_constants
from ..mesh.quadrature import Rule, extrapolation, gauss, simplex
from ..mesh.reader import NamedMesh
from .gradient import require_law
from .history import LAW, LawWithHistory, has_history
from .interpolation import Interpolation
from .own_forms import require_strains
from .places import require_group
from .plasticity import Plastic, section_law
from .plate import Plate, ShellSection
from .section import Elastic
from .tying import LowerRule, Tying
from .varying import VaryingSection, require_uniform
from .work import Internal, Term

TRIANGLE, QUADRILATERAL = basix.CellType.triangle, basix.CellType.quadrilateral
ALONG_NORMAL = 1e-6  # part of a direction along a surface that is too small


@dataclass(frozen=True)
class ShellForm:
    """A discrete form: spaces of displacement and rotation, and where strains are taken.

    Attributes
    ----------
    cell : of the mesh
    displacement, rotation : family and degree of the spaces
    low, full : quadrature rules; membrane, shear and drilling energies are integrated with (1 - share) of the low
        and `share` of the full rule, bending with the full rule (partial selective reduced integration, Arnold and
        Brezzi 1997; drilling with the full rule would lock thin curved cells)
    """

    cell: basix.CellType
    displacement: tuple[str, int]
    rotation: tuple[str, int]
    low: Rule
    full: Rule

    def __post_init__(self):
        check(self)

    def share(self, domain, thickness):
        """Share of the full rule, at most 1: thickness^2 / area.

        It keeps the parasitic energy of a bent cell below its bending energy.
        """
        return ufl.min_value(1.0, thickness**2 / ufl.JacobianDeterminant(domain))

    def tying(self, shell: Shell, frame, cells: np.ndarray) -> Tying:
        """Strains that the law of a shell is given on the cells of this process."""
        thickness = shell.sections.numbers(lambda section: section.thickness)
        return LowerRule(self.low, extrapolation(self.cell, self.low, self.full), self.share(frame.domain, thickness))


@dataclass(frozen=True)
class TriangleForm(ShellForm):
    """Triangles whose strains have spaces of their own, see `interpolation.Interpolation`; it has no lower rule."""

    def tying(self, shell: Shell, frame, cells: np.ndarray) -> Tying:
        thickness = shell.sections.in_cells(lambda section: section.thickness)
        moduli = shell.sections.in_cells(lambda section: section.stiffness(shell.material).uncoupled[3:8, 3:8])
        return Interpolation(frame, thickness, moduli, shell.mesh.domain, cells, self.full,
                             self.displacement[1])


def _quadrilateral(degree: int) -> ShellForm:
    """Equal degree of displacement and rotation on quadrilaterals."""
    return ShellForm(QUADRILATERAL, ("P", degree), ("P", degree), gauss(QUADRILATERAL, degree, degree),
                     gauss(QUADRILATERAL, degree + 1, degree + 1))


def _triangle(degree: int, exact: int) -> TriangleForm:
    """Equal degree of displacement and rotation on triangles; `exact` integrates polynomials exactly."""
    rule = simplex(exact)
    return TriangleForm(TRIANGLE, ("P", degree), ("P", degree), rule, rule)


FORMS = {
    "naghdi-q2": _quadrilateral(2),
    "naghdi-q3": _quadrilateral(3),
    "naghdi-t2": _triangle(2, 4),
    "naghdi-t3": _triangle(3, 6),
}
RICHER = {"naghdi-q2": FORMS["naghdi-q3"], "naghdi-q3": _quadrilateral(4), "naghdi-t2": FORMS["naghdi-t3"]}
BY_CELL = {QUADRILATERAL: "naghdi-q2", TRIANGLE: "naghdi-t2"}
FORMER = {"naghdi-p2cr": "naghdi-t2", "naghdi-p3": "naghdi-t3"}  # which were too soft on curved surfaces


def richer_form(form: ShellForm) -> ShellForm | None:
    """The form of one degree more on the same cells; None: there is none."""
    return next((richer for name, richer in RICHER.items() if FORMS[name] is form), None)


def named_form(name: str) -> ShellForm:
    """The form of a name in FORMS.

    Raises
    ------
    ValueError
        Where there is none.
    """
    if name in FORMER:
        raise ValueError(f"Shell: form {name!r} is gone, as it was too soft on curved surfaces; take {FORMER[name]!r}")
    if name not in FORMS:
        raise ValueError(f"Shell: no form {name!r}; choose from {', '.join(FORMS)}")
    return FORMS[name]


@dataclass(frozen=True, eq=False)
class Shell:
    """Shells on the surfaces of a mesh.

    Attributes
    ----------
    mesh : NamedMesh
    section, material : constants of the section law; a Plastic one is integrated through the section's layers
    form : name of a form in FORMS, or a ShellForm; None: the one of degree 2 for the cells of the mesh
    strains : function (u, rotation, frame) -> ShellStrains, of the mid-surface; None: `forms.shell.naghdi`
    law : function (strains, stiffness) -> stress resultants, gradient of an energy, see forms.section.linear_shell;
        it may couple stretching, bending, shear and drilling; or a LawWithHistory
    group : physical group of the surfaces; None: all
    offset : distance of the mid-surface from the meshed surface, along its normal, with which it turns. Strains,
        resultants and mass are per length and area of the mid-surface; loads, supports, contacts and displacements
        belong to the meshed surface
    axis : direction of the first axis of strains, resultants and the section's stiffness: a vector (3,), or a function
        of the place, a UFL vector, that gives one, in UFL or as three numbers; each cell takes what it is along the
        cell's middle. The second axis is 90 degrees further about the normal. None: the first edge of each cell, for
        sections without directions
    """

    mesh: NamedMesh
    section: ShellSection
    material: Elastic | None = None
    form: str | ShellForm | None = None
    strains: Callable | None = None
    law: Annotated[Callable | LawWithHistory, LAW] = forms.section.linear_shell
    group: str | None = None
    offset: float = 0.0
    axis: Annotated[tuple[float, float, float], NONZERO] | Callable | None = None

    def __post_init__(self):
        check(self)
        require_group(self, 2)
        if self.material is None and isinstance(self.section, Plate):
            raise ValueError(f"Shell: material is None, but {self.section} needs one; give an Elastic, or the "
                             "stiffness by a GivenPlate")
        cell = self.mesh.domain.basix_cell()
        if self.discrete.cell != cell:
            raise ValueError(f"Shell: form {self.form!r} needs a mesh of {self.discrete.cell.name} cells, "
                             f"this one has {cell.name} cells")
        stiffness = self.sections.typical.stiffness(self.material)
        if isinstance(self.material, Plastic):
            require_uniform(self, "Shell of a Plastic material")
        if self.section_law is not forms.section.linear_shell:
            require_law("Shell", self.section_law, stiffness, np.diag(stiffness.uncoupled), self.mesh.domain)
        if self.strains is not None:
            require_strains(self, self.strains, 9)
        if self.axis is None and not stiffness.isotropic:
            raise ValueError(f"Shell: axis is None, but the stiffness of its {type(self.section).__name__} differs by "
                             "direction; give the direction of its first axis, as axis=(1, 0, 0)")
        if self.offset or not stiffness.isotropic or np.any(stiffness.coupling):
            self.mesh.require_alike("Shell: offset" if self.offset else f"Shell: section {type(self.section).__name__}",
                                    self.group)
        _ = self._axis
        if self.offset:
            self._check_offset()

    @cached_property
    def sections(self) -> VaryingSection:
        """The section wherever it is integrated."""
        return VaryingSection(self, self.discrete.displacement[1])

    @cached_property
    def section_law(self):
        """The law, or the section's layers' where the material is plastic."""
        return section_law(self.law, self.section, self.material, self.sections.typical.stiffness(self.material))

    @property
    def discrete(self) -> ShellForm:
        form = BY_CELL[self.mesh.domain.basix_cell()] if self.form is None else self.form
        return named_form(form) if isinstance(form, str) else form

    @property
    def spaces(self) -> tuple[tuple[str, int], tuple[str, int]]:
        """Family and degree of displacement and rotation."""
        return self.discrete.displacement, self.discrete.rotation

    def frame(self) -> forms.shell.SurfaceFrame:
        """Reference frame with normals interpolated at the nodes of each cell."""
        return surface_frame(self.mesh.domain, self._axis)

    @property
    def _distance(self):
        """The offset as a constant of its own, so that shells of all sections have the same kernels."""
        return as_constants(self.mesh.domain, self.offset)

    def mid_surface(self) -> tuple[forms.shell.SurfaceFrame, object]:
        """Reference frame of the mid-surface, and its area per area of the meshed surface."""
        frame = self.frame()
        return frame.at(self._distance) if self.offset else (frame, 1.0)

    def _check_offset(self) -> None:
        """Refuse an offset beyond a centre of curvature: what passes there has turned round along one direction."""
        (moved, area), domain = self.mid_surface(), self.mesh.domain
        length = ufl.tr(moved.to_mesh) * area  # the sum of the lengths along both directions
        at_points = compiled_expression(ufl.as_vector([area, length]), self.discrete.full.points)
        smallest = at_points.eval(domain, self.mesh.group(self.group)).min(initial=np.inf)
        if self.mesh.comm.allreduce(smallest, op=MPI.MIN) <= 0:
            raise ValueError(f"Shell: offset {self.offset:g} lies beyond the centre of curvature of group "
                             f"{self.group or 'all'!r}; make it smaller")

    @cached_property
    def _axis(self) -> fem.Function | None:
        """The first axis of each cell, where it is given."""
        return None if self.axis is None else first_axis(self.mesh, self.axis)

    def measure(self):
        """Integral over the shells, for loads."""
        return self.mesh.integral({"quadrature_degree": 2 * self.discrete.displacement[1]}, self.group)

    def _strains_and_law(self, u, rotation):
        """All nine strains of the mid-surface, the section law, its frame, and its area per meshed area."""
        stiffness, law = self.sections.numbers(lambda section: section.stiffness(self.material)), self.section_law
        frame, area = self.frame(), 1.0
        if self.offset:
            u, frame, area = forms.shell.off_the_surface(u, rotation, frame, self._distance)
        strains = (self.strains or forms.shell.naghdi)(u, rotation, frame)
        return strains.vector, law if has_history(law) else lambda e: law(e, stiffness), frame, area

    def pointwise(self, u, rotation):
        """Strains as a UFL vector, the section law, and the points of a cell at which forces and moments are most
        exact: the low rule's.
        """
        strains, law, _, _ = self._strains_and_law(u, rotation)
        return strains, law, self.discrete.low.points

    def internal(self, u, rotation) -> Internal:
        """Internal virtual work."""
        strains, law, frame, area = self._strains_and_law(u, rotation)
        cells = self.mesh.group(self.group)
        term = Term(strains, law, self.discrete.full, self.discrete.tying(self, frame, cells), area)
        return Internal([term], self.mesh.domain, cells)


def surface_frame(domain, axis=None) -> forms.shell.SurfaceFrame:
    """Frame of a surface with its normals interpolated at the nodes of each cell.

    Its axes follow the axes of each cell's middle, so that constant strains have constant components wherever a cell is
    flat.

    Parameters
    ----------
    axis : UFL vector, the first axis of each cell's middle; None: along its first edge
    """
    normal = forms.shell.unit_normal(domain)
    if domain.basix_cell() == TRIANGLE and geometry_degree(domain) == 1:
        return forms.shell.surface_frame(domain, middle=None if axis is None else (axis, normal))
    first = cellwise(domain, forms.shell.unit_tangent(domain), 0) if axis is None else axis
    return forms.shell.surface_frame(domain, cellwise(domain, normal), (first, cellwise(domain, normal, 0)))


def first_axis(mesh: NamedMesh, axis: Sequence[float] | Callable) -> fem.Function:
    """Unit vectors of a direction along the middle of each cell.

    Parameters
    ----------
    axis : see `Shell`

    Raises
    ------
    ValueError
        If it is along the normal of a cell, or no vector in space.
    """
    domain = mesh.domain
    vector = axis(ufl.SpatialCoordinate(domain)) if callable(axis) else axis
    try:
        direction = ufl.as_vector(list(vector)) if isinstance(vector, (Sequence, np.ndarray)) else ufl.as_ufl(vector)
    except ValueError as error:
        raise ValueError(f"Shell: axis gives {vector!r}; give a vector with three components") from error
    if direction.ufl_shape != (3,):
        raise ValueError(f"Shell: axis has the shape {direction.ufl_shape}; give a vector with three components")
    direction = direction + fem.Constant(domain, np.zeros(3))  # numbers alone are on no mesh
    projected = cellwise(domain, forms.shell.along_surface(direction, forms.shell.unit_normal(domain)), 0)
    values, given = projected.x.array.reshape(-1, 3), cellwise(domain, direction, 0).x.array.reshape(-1, 3)
    sizes, whole = (np.linalg.norm(v, axis=1, keepdims=True) for v in (values, given))
    wrong = np.flatnonzero(~(sizes > ALONG_NORMAL * whole))
    if mesh.comm.allreduce(len(wrong)):
        raise ValueError("Shell: axis is along the normal of the surface, or zero, in "
                         f"{mesh.comm.allreduce(len(wrong))} cells; give a direction along the surface")
    values /= sizes
    return projected
