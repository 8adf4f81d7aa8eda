"""Whether a section law tells cases apart by its strains, so that its moduli may jump."""

from __future__ import annotations

from collections.abc import Callable
from typing import cast

import ufl
from ufl.algorithms import expand_derivatives
from ufl.classes import Abs, Conditional, MaxValue, MinValue, Variable
from ufl.corealg.traversal import unique_pre_traversal

from ..model.history import has_history
from ..model.work import Term

CASES = Conditional, MaxValue, MinValue
KINKS = *CASES, Abs  # whose derivatives have cases


def has_cases(term: Term) -> bool:
    """Whether the moduli of a law in UFL have cases that depend on its strains; smooth cases, as of places, do not."""
    if has_history(term.law):
        return False
    domain = ufl.domain.extract_unique_domain(term.strains)
    given = ufl.variable(ufl.Constant(domain, shape=term.strains.ufl_shape))
    resultants = cast(Callable, term.law)(given)
    if not any(isinstance(node, KINKS) for node in unique_pre_traversal(resultants)):
        return False
    moduli = expand_derivatives(ufl.diff(resultants, given))
    return any(isinstance(node, CASES) and any(isinstance(part, Variable) for part in unique_pre_traversal(decides))
               for node in unique_pre_traversal(moduli) for decides in _decide(node))


def _decide(node) -> list:
    """What a node tells cases apart by."""
    return node.ufl_operands[:1] if isinstance(node, Conditional) else node.ufl_operands
