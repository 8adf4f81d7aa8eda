"""Section laws are gradients of an energy: the tangent is kept as a symmetric matrix."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import ufl

from ..checks import require_vector
from ..forms.evaluate import Unknown, evaluate, prepared
from .history import STRAINS, has_history, require_update
from .own_forms import called, names_of, number_of, title_of

ROUNDING = 1e-9  # relative difference of moduli and their transpose, which are derived exactly


def require_law(name: str, law, stiffness, sizes, domain) -> None:
    """Refuse a section law, with history or without, that has no symmetric moduli.

    Parameters
    ----------
    sizes : stiffness by each strain as the section has it, which strains are scaled by
    """
    if has_history(law):
        require_update(name, law, len(sizes))
    else:
        require_gradient(name, law, stiffness, sizes, domain)


def require_gradient(name: str, law: Callable, stiffness, sizes, domain) -> None:
    """Refuse a law that is not the gradient of an energy that rest is a minimum of.

    Strains of equal energy are of one size: moduli k_ij are compared with sqrt(k_i k_j), the section's own. They are
    looked at at rest and at strains about it on all sides, where resultants are finite. At rest no eigenvalue of the
    moduli is negative; no strain is without stiffness in all places, though a kink's may be at rest.

    Parameters
    ----------
    name : of the part
    law : function from a UFL vector of strains, and the stiffness of the section, to one of resultants

    Raises
    ------
    ValueError
        Names resultant, strain, value and remedy. Laws that depend on fields of their own are not looked at.
    """
    title, count = title_of(name, "law", law), len(sizes)
    names, sizes = names_of(name, count), np.abs(np.asarray(sizes, float))
    sizes = np.where(sizes > 0, sizes, sizes.max())
    symbol = ufl.Constant(domain.ufl_domain(), shape=(count,))
    given = ufl.variable(ufl.as_vector([symbol[i] for i in range(count)]))
    found = called(title, law, ufl.as_vector([given[i] for i in range(count)]), stiffness)
    require_vector(title, found, count)
    sides = np.random.default_rng(1).uniform(-1, 1, (8, count))
    strains = STRAINS * np.vstack([np.zeros(count), sides, -sides]) * np.sqrt(sizes[0] / sizes)
    try:
        resultants, moduli = (evaluate(prepared(e), lambda node: strains if node == symbol else number_of(node))
                              for e in (found, ufl.diff(found, given)))
    except Unknown:
        return
    resultants = np.broadcast_to(resultants, (len(strains), count))
    moduli = np.broadcast_to(moduli, (len(strains), count, count))
    _require_numbers(title, names, resultants, moduli, strains)
    scaled = moduli / np.sqrt(np.outer(sizes, sizes))
    diagonal = np.maximum(np.abs(np.diagonal(scaled, axis1=1, axis2=2)).max(axis=0), np.finfo(float).tiny)
    scale = np.sqrt(np.outer(diagonal, diagonal)) + np.abs(scaled)
    wrong = np.abs(scaled - scaled.transpose(0, 2, 1)) > ROUNDING * scale
    if wrong.any():
        s, i, j = map(int, np.argwhere(wrong)[0])
        raise ValueError(
            f"{title} is not the gradient of an energy: resultant {i} ({names[i]}) changes by {moduli[s, i, j]:.6g} "
            f"with strain {j}, resultant {j} ({names[j]}) by {moduli[s, j, i]:.6g} with strain {i}, at "
            f"{'rest' if s == 0 else f'strains of {STRAINS:g}'}; derive it from an energy (ufl.diff), or make it "
            "symmetric")
    if (none := np.abs(np.diagonal(scaled, axis1=1, axis2=2)).max(axis=0) == 0).any():
        i = int(np.argmax(none))
        raise ValueError(f"{title}: resultant {i} ({names[i]}) has no stiffness by its strain; give it some, a small "
                         "one where there should be none")
    smallest, vectors = np.linalg.eigh(scaled[0])
    if smallest[0] < -ROUNDING * np.abs(smallest).max():
        i = int(np.argmax(np.abs(vectors[:, 0])))
        raise ValueError(f"{title} has a negative stiffness at rest, of resultant {i} ({names[i]}) above all: "
                         f"{moduli[0, i, i]:.6g} by its strain; change the sign, or the couplings")


def _require_numbers(title: str, names: list[str], resultants, moduli, strains) -> None:
    """Refuse what is complex or not finite."""
    for what, values in (("resultant", resultants), ("stiffness", moduli)):
        if values.dtype.kind == "c":
            raise ValueError(f"{title}: a {what} is complex; return real resultants, without 1j")
        bad = np.argwhere(~np.isfinite(values))
        if len(bad):
            s, i = map(int, bad[0][:2])
            place = "at rest" if not s else f"near rest, at strains {', '.join(f'{e:.3g}' for e in strains[s])}"
            raise ValueError(f"{title}: {what} {i} ({names[i]}) is {values[tuple(bad[0])]:g} {place}; roots, "
                             "logarithms and powers need a form that is smooth there, for both signs")
