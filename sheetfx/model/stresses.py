"""Stresses of linear elastic parts from their resultants, at a height of shells or a fibre of beams."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..forms.section import linear_elastic, linear_shell
from .beam import Bar, Beam
from .laminate import Laminate
from .plasticity import Plastic
from .plate import Plate
from .shell import Shell
from .varying import require_uniform

EDGE = 1e-9  # of the thickness, by which a height may lie outside


def stresses(part: Beam | Bar | Shell, resultants: np.ndarray, at: float | Sequence[float] = 0.0) -> np.ndarray:
    """Stresses at a place of the cross-section.

    Parameters
    ----------
    resultants : of the part, shape (..., n)
    at : of a beam the distance from the centroid along the direction of the depth (in the plane to the left of the
        line's direction), in space that and the distance along the width; of a shell the height above the mid-surface,
        along its normal. Bars have the same stress everywhere

    Returns
    -------
    array, shape (..., 1): normal stress of beams and bars, without what torsion and shear add; shape (..., 3): s11, s22
    and s12 of shells on the axes of their resultants, in the ply at that height (of two that meet there the upper one).

    Raises
    ------
    ValueError
        For a law or section of which stresses are not known, or a place outside.
    """
    name = type(part).__name__
    _require_elastic(part)
    place = np.ravel(np.asarray(at, dtype=float))
    wanted = 2 if isinstance(part, Beam) and part.mesh.dimension == 3 else 1
    if place.shape != (wanted,) or not np.isfinite(place).all():
        raise ValueError(f"{name}: a place of its section has {wanted} finite coordinates, at is {at!r}")
    if isinstance(part, Bar):
        return resultants / part.section.area
    return _in_beam(part, resultants, place) if isinstance(part, Beam) else _in_shell(part, resultants, float(place[0]))


def _require_elastic(part: Beam | Bar | Shell) -> None:
    """Refuse laws that are not linear elastic, of which resultants do not tell stresses, and sections that vary."""
    name = type(part).__name__
    if part.law not in (linear_elastic, linear_shell) or isinstance(part.material, Plastic):
        raise ValueError(f"{name}: stresses are those of linear elastic sections, and its law is "
                         f"{type(part.section_law).__name__}; ask Record.forces and Record.plastic")
    require_uniform(part, "stresses")


def transverse_shear(shell: Shell, resultants: np.ndarray, at: float) -> np.ndarray:
    """Transverse shear stresses of a linear elastic shell at a height, from equilibrium with its stresses.

    A shear force q_1 comes with a moment that changes by it along the first axis, and no other one (cylindrical
    bending, Rolfes and Rohwer 1997): s_13 is minus the integral, from the lower face, of the stress s_11 by that
    moment; s_23 likewise. In a homogeneous plate they are parabolas, in a laminate they are continuous at its plies.

    Parameters
    ----------
    resultants : of the part, shape (..., 9)
    at : height above the mid-surface, along the normal

    Returns
    -------
    array, shape (..., 2) : s_13 and s_23 on the axes of the resultants

    Raises
    ------
    ValueError
        As `stresses`; for a section that has no layers.
    """
    _require_elastic(shell)
    section, half = _layered(shell, at), shell.section.thickness / 2
    if isinstance(section, Plate):
        return resultants[..., 6:8] * 1.5 / (2 * half) * (1 - (at / half) ** 2)
    compliance, bottom, shares = np.linalg.inv(section.stiffness().moduli), -half, np.zeros(2)
    for ply in section.plies:
        low, high = bottom, min(bottom + ply.thickness, at)
        bottom += ply.thickness
        if high > low:
            plane = np.asarray(ply.plane_stress())
            for axis in (0, 1):
                rates = compliance[:, 3 + axis]
                stretched, bent = plane[axis] @ rates[:3], plane[axis] @ rates[3:]
                shares[axis] -= stretched * (high - low) + bent * (high**2 - low**2) / 2
    return resultants[..., 6:8] * shares


def von_mises(stresses: np.ndarray) -> np.ndarray:
    """Equivalent stress of s11, s22 and s12 in a plane, or of a normal stress alone (von Mises 1913).

    Parameters
    ----------
    stresses : as `stresses` gives them, shape (..., 3) or (..., 1)
    """
    if stresses.shape[-1] == 1:
        return np.abs(stresses[..., 0])
    s11, s22, s12 = np.moveaxis(stresses, -1, 0)
    return np.sqrt(s11**2 - s11 * s22 + s22**2 + 3 * s12**2)


def _in_beam(beam: Beam, resultants: np.ndarray, place: np.ndarray) -> np.ndarray:
    """N / A and E (z k_n - y k_b), with the curvatures of the moments; see `plasticity.Fibres`."""
    (about_normal, about_binormal), product = beam.section.second_moments, beam.section.product
    axial = resultants[..., 0] / beam.section.area
    if len(place) == 1:
        return (axial - place[0] * resultants[..., -1] / about_binormal)[..., None]
    moments = np.array([[about_normal, -product], [-product, about_binormal]])
    return (axial + resultants[..., 4:] @ np.linalg.solve(moments, (place[1], -place[0])))[..., None]


def _in_shell(shell: Shell, resultants: np.ndarray, height: float) -> np.ndarray:
    section, forces = _layered(shell, height), resultants[..., :6]
    if isinstance(section, Plate):
        return forces[..., :3] / section.thickness + 12 * height / section.thickness**3 * forces[..., 3:]
    strains = np.linalg.solve(section.stiffness().moduli, forces[..., None])[..., 0]
    return (strains[..., :3] + height * strains[..., 3:]) @ section.ply_at(height).plane_stress()


def _layered(shell: Shell, height: float) -> Plate | Laminate:
    """Section of a shell that tells stresses at a height, which has to be within its thickness."""
    section = shell.section
    if not abs(height) <= section.thickness * (0.5 + EDGE):
        raise ValueError(f"Shell: at is {height:g}, outside of its thickness {section.thickness:g}; give a height "
                         "between minus and plus half of it")
    if not isinstance(section, Plate | Laminate):
        raise ValueError(f"Shell: the stiffness of its {type(section).__name__} does not tell stresses; give a Plate "
                         "or a Laminate")
    return section
