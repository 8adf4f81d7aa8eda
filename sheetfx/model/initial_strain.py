"""Strains at which parts are free of stress: of heat, shrinkage, lack of fit, prestress, growth."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import ufl
from scipy.linalg import block_diag

from .. import forms
from ..checks import check, require_components, require_vector
from ..mesh.numbers import as_constants
from .beam import Bar, Beam
from .laminate import Laminate
from .loads import Load
from .own_forms import called, title_of
from .shell import Shell
from .varying import require_uniform

COUNTS = {1: "the axial strain", 3: "axial, shear and bending strain",
          6: "axial, two shear, twist and two bending strains",
          9: "membrane (11, 22, 12), bending (11, 22, 12), shear (1, 2) and drilling strains"}


class StressFree(Load):
    """A load that changes the strains at which a part is free of stress; one's own defines `natural`.

    The section law is given the strains of the part less the natural ones times the load factor, so that resultants,
    stresses, plasticity and energy follow from the rest. The reported load is the load factor.

    Attributes
    ----------
    part : Bar, Beam or Shell
    """

    part: Beam | Bar | Shell

    def natural(self):
        """Strains without stress for a load factor of 1: UFL vector in the order of the strains of the part."""
        raise NotImplementedError

    def residual(self, height: float) -> np.ndarray | None:
        """Stresses in a layer of a shell, for a load factor of 1, that have no resultants; None: there are none."""
        return None


@dataclass(frozen=True, eq=False)
class InitialStrain(StressFree):
    """Strains at which a part is free of stress, for a load factor of 1.

    In a `Stage` of its own it prestresses a structure: a bar that is too short by 0.1 % has the strain -0.001.

    Attributes
    ----------
    part : Bar, Beam or Shell
    strains : numbers in the order of the part's strains, or a function from the place (UFL vector) to these: of a bar
        its axial strain; of a beam in the plane axial, shear and bending strain, in space axial, two shear, twist and
        two bending strains; of a shell nine, see `forms.section.linear_shell`
    """

    part: Beam | Bar | Shell
    strains: float | tuple[float, ...] | Callable

    def __post_init__(self):
        check(self)
        if not callable(self.strains):
            require_components(f"InitialStrain of {type(self.part).__name__}: strains ({COUNTS[self._count]})",
                               np.ravel(self.strains), self._count)
        _ = self._given

    @property
    def _count(self) -> int:
        return strains_of(self.part)

    @cached_property
    def _given(self):
        domain = self.part.mesh.domain
        if not callable(self.strains):
            return ufl.as_vector(as_constants(domain, np.ravel(self.strains).astype(float).tolist()))
        title = title_of("InitialStrain", "strains", self.strains)
        found = called(title, self.strains, ufl.SpatialCoordinate(domain))
        vector = ufl.as_vector(list(found)) if isinstance(found, (Sequence, np.ndarray)) else found
        require_vector(title, vector, self._count)
        return vector

    def natural(self):
        return self._given


@dataclass(frozen=True, eq=False)
class InitialStress(StressFree):
    """Resultants that a part has at rest, for a load factor of 1: its prestress, or what welding has left.

    Attributes
    ----------
    part : linear elastic Bar, Beam or Shell of the same section throughout
    resultants : forces and moments, of shells per length, in the order of the part's strains, see `InitialStrain`
    """

    part: Beam | Bar | Shell
    resultants: float | tuple[float, ...]

    def __post_init__(self):
        check(self)
        name, count = type(self.part).__name__, strains_of(self.part)
        require_components(f"InitialStress of {name}: resultants ({COUNTS[count].replace('strains', 'forces')})",
                           np.ravel(self.resultants), count)
        if self.part.section_law not in (forms.section.linear_elastic, forms.section.linear_shell):
            raise ValueError(f"InitialStress: the law of its {name} is not linear; give the strains without stress by "
                             "an InitialStrain")
        require_uniform(self.part, "InitialStress")

    def natural(self):
        part, given = self.part, np.ravel(self.resultants).astype(float)
        if isinstance(part, Shell):
            own = part.sections.typical.stiffness(part.material)
            stiffness = block_diag(own.moduli, own.shear, own.drilling or 1.0)
        else:
            stiffness = np.array(part._stiffness_of(part.sections.typical), dtype=float)
            stiffness = np.diag(stiffness) if stiffness.ndim == 1 else stiffness
        strains = -np.linalg.solve(stiffness, given)
        return ufl.as_vector(as_constants(part.mesh.domain, strains.tolist()))


@dataclass(frozen=True, eq=False)
class Temperature(StressFree):
    """Change of temperature of a part, for a load factor of 1.

    Attributes
    ----------
    part : Bar, Beam or Shell
    change : at the centroid or the mid-surface: a number, or a function from the place (UFL vector) to one
    expansion : coefficient of linear expansion in all directions, per degree; None: of a Laminate its plies' own
    gradient : change of temperature per length: of shells along their normal; of beams along the depth, as heights are
        counted by `Record.stresses`, in space also along the width
    """

    part: Beam | Bar | Shell
    change: float | Callable
    expansion: float | None = None
    gradient: float | tuple[float, float] = 0.0

    def __post_init__(self):
        check(self)
        wanted = 2 if strains_of(self.part) == 6 and np.any(self.gradient) else 1
        require_components("Temperature: gradient", np.ravel(self.gradient), wanted)
        if isinstance(self.part, Bar) and self.gradient:
            raise ValueError(f"Temperature: gradient is {self.gradient}, but bars do not bend; leave it out")
        if self.expansion is None:
            if not isinstance(self.part.section, Laminate):
                raise ValueError("Temperature: expansion is None, and the part has no plies that have their own; give "
                                 "the coefficient of linear expansion")
            _ = self.part.section.expansions()
        elif not self.expansion:
            raise ValueError("Temperature: expansion is 0, so that no temperature does anything; give the "
                             "coefficient of linear expansion")
        _ = self._change

    @cached_property
    def _change(self):
        domain = self.part.mesh.domain
        if not callable(self.change):
            return as_constants(domain, [float(self.change)])[0]
        title = title_of("Temperature", "change", self.change)
        found = ufl.as_ufl(called(title, self.change, ufl.SpatialCoordinate(domain)))
        if found.ufl_shape:
            raise ValueError(f"{title} returns UFL of shape {found.ufl_shape}; return one number")
        return found

    def natural(self):
        domain, count = self.part.mesh.domain, strains_of(self.part)
        if self.expansion is None:
            by_change, by_gradient = self.part.section.expansions()
            bent = (float(np.ravel(self.gradient)[0]) * by_gradient).tolist()
            uniform = as_constants(domain, by_change.tolist())
            given = [c * self._change + g for c, g in zip(uniform, as_constants(domain, bent), strict=True)]
            return ufl.as_vector([*given, 0.0, 0.0, 0.0])
        expansion, *gradient = as_constants(domain, [float(self.expansion), *np.ravel(self.gradient).astype(float)])
        axial, bends = expansion * self._change, [expansion * g for g in gradient]
        return ufl.as_vector({
            1: lambda: [axial],
            3: lambda: [axial, 0.0, -bends[0]],
            6: lambda: [axial, 0.0, 0.0, 0.0, *([bends[1], -bends[0]] if len(bends) > 1 else [0.0, 0.0])],
            9: lambda: [axial, axial, 0.0, bends[0], bends[0], 0.0, 0.0, 0.0, 0.0]}[count]())

    def residual(self, height):
        if self.expansion is not None:
            return None
        if callable(self.change):
            raise ValueError("Temperature: stresses of plies that expand unlike are not known where change is a "
                             "function of the place; give a number")
        section, gradient = self.part.section, float(np.ravel(self.gradient)[0])
        ply, (by_change, by_gradient) = section.ply_at(height), section.expansions()
        laminate = self.change * by_change + gradient * by_gradient
        own = (self.change + gradient * height) * ply.expansions()
        return ply.plane_stress() @ (laminate[:3] + height * laminate[3:] - own)


def strains_of(part: Beam | Bar | Shell) -> int:
    """Number of the usual strains of a part."""
    return 9 if isinstance(part, Shell) else 1 if isinstance(part, Bar) else 3 * (part.mesh.dimension - 1)
