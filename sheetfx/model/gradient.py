"""Section laws are gradients of an energy: the tangent is kept as a symmetric matrix."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import ufl
from dolfinx import fem

from ..checks import require_vector
from .history import STRAINS, SYMMETRIC, has_history, require_update

STEP = 1e-5  # of differences


def require_law(name: str, law, stiffness, count: int) -> None:
    """Refuse a section law, with history or without, that has no symmetric moduli."""
    if has_history(law):
        require_update(name, law, count)
    else:
        require_gradient(name, law, stiffness, count)


def require_gradient(name: str, law: Callable, stiffness, count: int) -> None:
    """Refuse a law whose moduli are not symmetric at some strains.

    Parameters
    ----------
    name : of the part
    law : function from a UFL vector of strains, and the stiffness of the section, to one of resultants
    count : number of strains

    Raises
    ------
    ValueError
        The derivative of one resultant by the strain of another differs from that of the other by the strain of the
        one. Laws that depend on fields of their own are not looked at.
    """
    strains = STRAINS * np.cos(np.arange(1, count + 1))
    columns = []
    for unit in np.eye(count):
        ahead, behind = (_values(name, law, stiffness, strains + sign * STEP * unit) for sign in (1, -1))
        if ahead is None or behind is None:
            return
        columns.append((ahead - behind) / (2 * STEP))
    moduli = np.array(columns).T
    size = np.abs(moduli) + np.abs(moduli.T)
    scale = np.sqrt(np.outer(np.abs(np.diag(moduli)), np.abs(np.diag(moduli))))
    wrong = np.abs(moduli - moduli.T) > SYMMETRIC * np.maximum(size, scale)
    if wrong.any():
        i, j = map(int, np.argwhere(wrong)[0])
        raise ValueError(
            f"{name}: its law {getattr(law, '__name__', law)!r} is not the gradient of an energy: resultant {i} "
            f"changes by {moduli[i, j]:.6g} with strain {j}, resultant {j} by {moduli[j, i]:.6g} with strain {i}; "
            "derive it from an energy (ufl.diff), or make it symmetric")


def _values(name: str, law: Callable, stiffness, strains: np.ndarray) -> np.ndarray | None:
    """Resultants as numbers; None where they depend on fields."""
    given = ufl.as_vector([ufl.as_ufl(float(e)) for e in strains])
    found = law(given, stiffness)
    require_vector(f"{name}: its law {getattr(law, '__name__', law)!r}", found, len(strains))
    resultants = ufl.algorithms.expand_derivatives(found)
    if ufl.algorithms.extract_coefficients(resultants):
        return None
    constants = ufl.algorithms.extract_type(resultants, fem.Constant)
    numbers = {c: ufl.as_tensor(c.value.tolist()) if c.value.ndim else ufl.as_ufl(float(c.value)) for c in constants}
    resultants = ufl.replace(resultants, numbers)
    return np.array([resultants[i](()) for i in range(len(strains))])
