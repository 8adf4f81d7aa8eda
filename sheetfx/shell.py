"""Shells as parts of a scene, and the families of their discrete forms."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import basix
import numpy as np
import ufl

from . import forms
from .elements import Internal, Term
from .mesh.reader import Model
from .numbers import as_constants
from .quadrature import Rule, gauss, simplex
from .section import Elastic, GivenPlate, Plate

TRIANGLE, QUADRILATERAL = basix.CellType.triangle, basix.CellType.quadrilateral
MEMBRANE, BENDING, SHEAR, DRILLING = range(3), range(3, 6), range(6, 8), range(8, 9)


@dataclass(frozen=True)
class ShellForm:
    """A discrete form: spaces of displacement and rotation, and what is integrated with which rule.

    Attributes
    ----------
    cell : of the mesh
    displacement, rotation : family and degree of the spaces
    low, full : quadrature rules; membrane and shear energies are integrated with (1 - share) of the low and
        `share` of the full rule, bending and drilling with the full rule (partial selective reduced integration)
    directional : integrate the strains along each edge direction with one point more across it (quadrilaterals)
    """

    cell: basix.CellType
    displacement: tuple[str, int]
    rotation: tuple[str, int]
    low: Rule
    full: Rule
    directional: bool = False


def quadrilateral(degree: int, directional: bool) -> ShellForm:
    """Form of equal degree for displacement and rotation on quadrilaterals."""
    return ShellForm(QUADRILATERAL, ("P", degree), ("P", degree), gauss(QUADRILATERAL, degree, degree),
                     gauss(QUADRILATERAL, degree + 1, degree + 1), directional)


FORMS = {
    "naghdi-q2": quadrilateral(2, False),
    "naghdi-q3": quadrilateral(3, False),
    "naghdi-q2d": quadrilateral(2, True),
    "naghdi-q3d": quadrilateral(3, True),
    "naghdi-p2cr": ShellForm(TRIANGLE, ("P", 2), ("CR", 1), simplex(1), simplex(2)),
    "naghdi-p3": ShellForm(TRIANGLE, ("P", 3), ("P", 3), simplex(4), simplex(6)),
}


@dataclass(frozen=True, eq=False)
class Shell:
    """Shells on the surfaces of a model.

    Attributes
    ----------
    model : mesh with named groups
    section, material : constants of the section law
    form : name of a form in FORMS, or a ShellForm
    strains : function (u, rotation, frame) -> ShellStrains
    law : function (strains, stiffness) -> stress resultants, gradient of an energy; strains as a UFL vector of
        membrane, bending, shear and drilling, shape (9,)
    group : physical group of the surfaces; None: all
    offset : distance of the mid-surface from the meshed surface, along its normal
    """

    model: Model
    section: Plate | GivenPlate
    material: Elastic | None = None
    form: str | ShellForm = "naghdi-q2"
    strains: Callable | None = None
    law: Callable = forms.section.linear_shell
    group: str | None = None
    offset: float = 0.0

    def __post_init__(self):
        if isinstance(self.form, str) and self.form not in FORMS:
            raise ValueError(f"Shell: no form {self.form!r}; choose from {', '.join(FORMS)}")
        cell = self.model.mesh.basix_cell()
        if self.discrete.cell != cell:
            raise ValueError(f"Shell: form {self.form!r} needs a mesh of {self.discrete.cell.name} cells, "
                             f"this one has {cell.name} cells")

    @property
    def discrete(self) -> ShellForm:
        return FORMS[self.form] if isinstance(self.form, str) else self.form

    def internal(self, u, rotation, frame) -> Internal:
        """Internal virtual work."""
        form, mesh = self.discrete, self.model.mesh
        stiffness, thickness, offset = as_constants(
            mesh, (self.section.stiffness(self.material), self.section.thickness, self.offset))
        measure = self.strains or (lambda u, rotation, frame: forms.shell.naghdi(u, rotation, frame, offset))
        strains = measure(u, rotation, frame)
        share = _share(mesh, thickness)
        cells = self.model.group(self.group)

        def law(places, factor=1.0):
            """The section law restricted to some strains, the others being zero."""
            def restricted(e):
                full = [0.0] * 9
                for n, place in enumerate(places):
                    full[place] = e[n]
                resultants = self.law(ufl.as_vector([ufl.as_ufl(c) for c in full]), stiffness)
                return factor * ufl.as_vector([resultants[place] for place in places])
            return restricted

        def term(vector, function, rule):
            return Term(vector, function, rule)

        def work(*terms):
            return Internal(terms, mesh, cells)

        def joined(*vectors):
            return ufl.as_vector([v[i] for v in vectors for i in range(v.ufl_shape[0])])

        thin = joined(strains.membrane, strains.shear)
        stretch, bend = [*MEMBRANE, *SHEAR], [*BENDING, *DRILLING]
        thick = joined(strains.bending, ufl.as_vector([strains.drilling]))
        if form.directional:
            terms = [term(thin, law(stretch), form.low), term(thick, law(bend), form.full)]
            count = round(len(form.low.weights) ** 0.5)
            for number, counts in enumerate(((count, count + 1), (count + 1, count))):
                along = joined(*forms.shell.along_edge(strains.membrane, strains.shear, frame, number))
                rule = gauss(form.cell, *counts)
                rule = Rule(np.concatenate([rule.points, form.low.points]),
                            np.concatenate([rule.weights, -form.low.weights]))
                terms.append(term(along, law(stretch), rule))
            return work(*terms)
        whole = joined(thin, thick)
        shared = law(stretch, share)

        def full_law(e):
            n, m = shared(ufl.as_vector([e[i] for i in range(5)])), law(bend)(ufl.as_vector([e[i] for i in range(5, 9)]))
            return joined(n, m)

        return work(term(thin, law(stretch, 1 - share), form.low), term(whole, full_law, form.full))


def _share(mesh, thickness):
    """Share of the full rule, thickness^2 / area of the cell and at most 1 (Arnold and Brezzi 1997, section 4)."""
    jacobian = ufl.JacobianDeterminant(mesh)
    return ufl.min_value(1.0, thickness**2 / jacobian)
