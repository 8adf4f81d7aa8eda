"""Section laws: from generalised strains to stress resultants.

A law is the gradient of an energy density.
"""

from __future__ import annotations

from collections.abc import Sequence

import ufl


def linear_elastic(strains, stiffness):
    """Linear elastic section: resultant_i = stiffness_i strain_i, or the sum of stiffness_ij strain_j.

    Parameters
    ----------
    strains : UFL vector, shape (n,)
    stiffness : sequence of n floats or UFL constants, or the n rows of a symmetric matrix where strains are coupled
        In the order of the strains, for a beam in the plane EA, k GA, EI.

    Returns
    -------
    UFL vector, shape (n,): for a beam forces and moments on the axes of the section.
    """
    if isinstance(stiffness[0], Sequence):
        return ufl.as_vector(_times(stiffness, list(strains)))
    return ufl.as_vector([c * e for c, e in zip(stiffness, strains, strict=True)])


def linear_shell(strains, stiffness):
    """Linear elastic shell section, also orthotropic or layered (classical lamination theory, Reddy 2004, eq. 3.3.38).

    Parameters
    ----------
    strains : UFL vector, shape (9,): membrane (e11, e22, 2 e12), bending (k11, k22, 2 k12), shear (g1, g2), drilling
    stiffness : ShellStiffness
        Symmetric matrices A (membrane), B (coupling), D (bending), shear, and the drilling stiffness, as nested
        sequences of floats or UFL constants, on the axes of the frame.

    Returns
    -------
    UFL vector, shape (9,): conjugate forces and moments per length.
    """
    e, k, g = [strains[i] for i in range(3)], [strains[i] for i in range(3, 6)], [strains[i] for i in range(6, 8)]

    def plus(one, other):
        return [a + b for a, b in zip(one, other, strict=True)]

    coupled = any(any(row) for row in stiffness.coupling)
    n, m = _times(stiffness.membrane, e), _times(stiffness.bending, k)
    if coupled:
        n, m = plus(n, _times(stiffness.coupling, k)), plus(m, _times(stiffness.coupling, e))
    return ufl.as_vector([*n, *m, *_times(stiffness.shear, g), stiffness.drilling * strains[8]])


def _times(matrix, vector):
    return [sum(c * v for c, v in zip(row, vector, strict=True) if c) for row in matrix]
