"""Strain energy of parts."""

from __future__ import annotations

import numpy as np
import ufl
from dolfinx import fem
from mpi4py import MPI

from ..compat import JIT
from ..mesh.numbers import lift_numbers
from ..model.work import Internal, Term

# Gauss's rule for the way from no strain to the present one: exact for energies up to the sixth power of strains.
SHARES = (0.5 - 0.15**0.5, 5 / 18), (0.5, 8 / 18), (0.5 + 0.15**0.5, 5 / 18)


def strain_energy(internal: Internal, comm: MPI.Comm) -> float:
    """Energy that a part stores now, on all processes: the work of its resultants on the way to the present strains.

    It is the integral of s(t e) . e over 0 < t < 1 for strains e and resultants s, which holds for any law that is the
    gradient of an energy density.
    """
    return comm.allreduce(sum(_energy(term, internal) for term in internal.terms))


def _energy(term: Term, internal: Internal) -> float:
    density = sum(weight * ufl.dot(term.law(share * term.strains), term.strains) for share, weight in SHARES)
    expression = lift_numbers(ufl.JacobianDeterminant(internal.domain) * density, internal.domain)
    values = fem.Expression(expression, term.rule.points, jit_options=JIT).eval(internal.domain, internal.cells)
    return float(np.sum(values.reshape(len(internal.cells), -1) @ term.rule.weights))
