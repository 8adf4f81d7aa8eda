"""Section laws: from generalised strains to stress resultants."""

from __future__ import annotations

import ufl


def linear_elastic(strains, stiffness):
    """Uncoupled linear elastic section: resultant_i = stiffness_i strain_i.

    Parameters
    ----------
    strains : UFL vector, shape (n,)
    stiffness : sequence of n floats or UFL constants
        In the order of the strains, for a beam in the plane EA, k GA, EI.

    Returns
    -------
    UFL vector, shape (n,): for a beam forces and moments on the axes of the section.
    """
    return ufl.as_vector([c * e for c, e in zip(stiffness, strains, strict=True)])
