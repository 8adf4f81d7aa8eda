"""Free vibrations about a state: the dynamic criterion of stability.

With the tangent K and the mass M of a state, small motions mode exp(i omega t) satisfy K mode = omega^2 M mode. A
stable state has positive omega^2 only; as it nears a critical point the lowest falls to zero, linearly
with the load where the path is straight and keeps the modes as they are. Where the tangent is not symmetric, as under
loads that follow the structure, omega^2 can be complex: the motion then grows while it oscillates, which is flutter
(Bolotin 1963; Ziegler 1968).
"""

from __future__ import annotations

from cmath import sqrt
from collections.abc import Callable
from dataclasses import dataclass
from math import pi
from typing import cast

import numpy as np
from petsc4py import PETSc

from .. import forms
from ..checks import Count, require
from ..continuation.linear import DirectSolver
from ..continuation.spectrum import lowest, nearest_pairs
from ..continuation.state import State
from ..discrete.discretisation import Discretisation
from ..discrete.fields import NodalForces
from ..discrete.free_body import rigid_motions
from ..mesh.numbers import as_constants
from ..model.cross_section import Elastic
from ..model.mass import Mass
from ..model.shell import Shell
from ..rounding import NONE, is_real
from .modes import scaled


@dataclass(frozen=True)
class Vibration:
    """A free vibration about a state.

    Attributes
    ----------
    squared : square of the circular frequency (1 / time^2); negative: the motion grows as exp(sqrt(-squared) t);
        complex: it oscillates and grows
    mode : this process's part of the solver's vector, the largest displacement being 1; of a complex vibration the
        part in phase with it
    rigid : along or about which axis a free body moves as a whole; "": it deforms
    """

    squared: float | complex
    mode: np.ndarray
    rigid: str = ""

    def __str__(self) -> str:
        if self.rigid:
            return f"rigid motion {self.rigid}"
        growth = f", growth rate {self.growth:.6g}" if self.growth else ""
        return f"vibration with frequency {self.frequency:.6g}{growth}"

    @property
    def frequency(self) -> float:
        """Oscillations per time; 0 where the motion does not oscillate."""
        return abs(sqrt(self.squared).real) / (2 * pi)

    @property
    def growth(self) -> float:
        """Rate of growth (1 / time): motions grow as exp(growth t); 0 for steady oscillations."""
        return abs(sqrt(self.squared).imag)


def frequencies(path, state: State, count: int = 6) -> list[Vibration]:
    """Lowest free vibrations about a state, those that grow first; where they can be complex those nearest to zero.

    Parameters
    ----------
    path : Path or Tracer that the state belongs to; it stays at its present state
    state : unloaded or loaded; contact stays as it is
    count : number of vibrations

    Raises
    ------
    ValueError
        If a part has no density, the count is not positive, or there is friction.
    """
    require("frequencies", count=(count, Count))
    discretisation = path.discretisation
    if not (discretisation.system.conservative or discretisation.system.smooth):
        raise ValueError("frequencies: with friction small motions have none; use a contact without it")
    with discretisation.visiting(state.fields):
        return _about_current(discretisation, count)


def _about_current(discretisation: Discretisation, count: int) -> list[Vibration]:
    system, mass = discretisation.system, mass_matrix(discretisation)()
    system.configure(system.create_vector(), system.factor)
    system.extrapolate_stress()
    solver = DirectSolver(PETSc.KSP().create(system.comm), system.tangent(), system.conservative)
    solver.factorise()
    if not system.conservative:
        return [Vibration(_real_or_complex(value), scaled(discretisation, mode))
                for value, mode, _ in nearest_pairs(solver, mass, count) if value.imag >= 0]
    rigid = _rigid(discretisation) if discretisation.scene.free else {}
    negative = solver.negative_pivots() - system.multipliers
    values, modes = lowest(solver, mass, max(count - len(rigid), 1), negative, [*rigid.values()])
    found = [Vibration(0.0, scaled(discretisation, mode), words) for words, mode in rigid.items()]
    found += [Vibration(value, scaled(discretisation, mode)) for value, mode in zip(values, modes, strict=True)]
    return sorted(found, key=lambda vibration: vibration.squared.real)[:count]


def _rigid(discretisation: Discretisation) -> dict[str, PETSc.Vec]:
    """Rigid motions of a free body.

    Raises
    ------
    ValueError
        Where loads do not move with it: a rotation is no free motion then.
    """
    system, motions = discretisation.system, rigid_motions(discretisation)
    tangent, force = system.tangent(), system.create_vector()
    for words, motion in motions.items():
        tangent.mult(motion, force)
        force.array[system.multiplier_rows] = 0
        if force.norm() > NONE * tangent.norm(PETSc.NormType.FROBENIUS) * motion.norm():
            raise ValueError(f"frequencies: the loads of this state do not move with the free body {words}, so that "
                             "it is no free motion; ask about the unloaded state, or add supports")
    return motions


def _real_or_complex(value: complex) -> float | complex:
    return value if is_complex(value) else value.real


def is_complex(value: complex) -> bool:
    """Whether a square of a frequency is not real, but for rounding."""
    return not is_real(value)


def mass_matrix(discretisation: Discretisation) -> Callable[[], PETSc.Mat]:
    """Function that gives the present mass matrix, which turns with the parts.

    Raises
    ------
    ValueError
        If a part has no density.
    """
    works, at_points = _of_masses(discretisation)
    own = sum(inertia(discretisation, part) for part in discretisation.scene.parts)
    parts = discretisation.system.bilinear(sum(works, own))

    if at_points is None:
        return parts
    heavy, first = np.flatnonzero(at_points.array), at_points.getOwnershipRange()[0]

    def now() -> PETSc.Mat:
        matrix = parts()
        for row in heavy:
            matrix.setValue(first + row, first + row, at_points.array[row], addv=PETSc.InsertMode.ADD)
        matrix.assemble()
        return matrix

    return now


def _of_masses(discretisation: Discretisation) -> tuple[list, PETSc.Vec | None]:
    """Work of the inertia of masses along edges, and what those at points add to the diagonal; None: nothing."""
    fields, unknowns, works = discretisation.fields, discretisation.unknowns, []
    at_points = NodalForces(fields)
    for joint in discretisation.scene.joints:
        if not isinstance(joint, Mass):
            continue
        k = discretisation.kinematics(joint.mesh)
        spins = None if k.spin is None else _changes(unknowns, k.spin)
        if (work := joint.work_of_inertia(fields, _changes(unknowns, k.u), spins)) is not None:
            works.append(work)
        for component, size in joint.at_points():
            at_points.add(joint.mesh, joint.at, component, size)
    none = all(array is None for array in at_points.arrays)
    return works, None if none else discretisation.system.diagonal(at_points.arrays)


def inertia(discretisation: Discretisation, part):
    """Virtual work of a part's inertia, a bilinear form in rates and variations of the unknowns."""
    if not part.section.weighs(part.material):
        raise ValueError(f"frequencies: the {type(part).__name__} on group {part.group or 'all'!r} has no density; "
                         f"{part.section.weight}")
    return _shell_inertia(discretisation, part) if isinstance(part, Shell) else _bar_inertia(discretisation, part)


def _shell_inertia(discretisation: Discretisation, shell: Shell):
    k, unknowns, domain = discretisation.kinematics(shell.mesh), discretisation.unknowns, shell.mesh.domain
    mass, rotary = shell.sections.numbers(lambda section: section.inertia(shell.material))
    arm = as_constants(domain, shell.offset + shell.section.mass_centre(cast(Elastic, shell.material)))
    frame, area = shell.mid_surface()
    normal = k.total_rotation.rotate(frame.director)
    changes, spins = _changes(unknowns, k.u), _changes(unknowns, k.spin)
    work = forms.inertia.translation(mass, *_carried(changes, spins, arm * normal))
    work += forms.inertia.director(rotary, spins[0], spins[1], normal)
    return area * work * shell.measure()


def _bar_inertia(discretisation: Discretisation, part):
    """Of a part on curves; those without a field of rotations have no rotary inertia."""
    k, unknowns, mesh = discretisation.kinematics(part.mesh), discretisation.unknowns, part.mesh
    mass, *rotary = part.sections.numbers(lambda section: section.inertia(part.material, mesh.dimension))
    changes = _changes(unknowns, k.u)
    integral = mesh.integral({"quadrature_degree": 2 * part.degree}, part.group)
    if k.spin is None:
        return forms.inertia.translation(mass, *changes) * integral
    spins, frame, (offset, length) = _changes(unknowns, k.spin), part.frame(), part.eccentricity()
    if offset:
        arm = sum(c * k.total_rotation.rotate(axis) for c, axis in zip(offset, frame.axes[1:], strict=True))
        changes = _carried(changes, spins, arm)
    work = forms.inertia.translation(mass, *changes)
    work += forms.inertia.section(rotary, spins[0], spins[1], k.total_rotation, frame)
    return length * work * integral


def _changes(unknowns, field):
    """Rate and variation of a field."""
    return unknowns.linearise(field), unknowns.vary(field)


def _carried(changes, spins, arm):
    """Rate and variation of what stands at the end of an arm."""
    return [forms.inertia.carried(change, spin, arm) for change, spin in zip(changes, spins, strict=True)]
