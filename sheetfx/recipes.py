"""What weak forms are made of, by which their kernels are found again.

DOLFINx looks for the kernel of an expression by a signature of its derivatives, carried out: to find one it
does the work of a form compiler but for the code. Here an expression is described as it is written: operators, numbers
and elements, with its coefficients and constants by their places. The hash of the description names a recipe beside the
kernels, which says in which library the kernel is, and which coefficients and constants it takes in which order.
"""

from __future__ import annotations

import hashlib
import json
import os
import sysconfig
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path
from tempfile import NamedTemporaryFile

import ufl
from dolfinx import default_scalar_type
from dolfinx.fem import Constant
from ufl.algorithms.analysis import extract_coefficients, extract_constants

LITERAL = ufl.classes.ScalarValue, ufl.classes.Identity, ufl.classes.PermutationSymbol


class Undescribed(TypeError):
    """An expression with something of which nothing is known here."""


class Description:
    """What an expression is made of.

    Parameters
    ----------
    expression : UFL expression, with derivatives that need not be carried out
    further : what else its kernel depends on; its `repr` counts

    Attributes
    ----------
    key : of two expressions with the same one, the things at the same places below play the same parts
    coefficients, constants, domains : in the order in which they occur

    Raises
    ------
    Undescribed
        Where it has arguments or other things that kernels of values at points do without.
    """

    def __init__(self, expression, *further):
        self.coefficients: list = []
        self.constants: list = []
        self.domains: list = []
        self._places: dict[tuple[str, object], int] = {}
        nodes, made = {}, {}  # numbers of nodes by what they are made of, and by the objects
        pending = [expression]
        while pending:  # operands before their operators, each object once
            node = pending[-1]
            missing = [o for o in node.ufl_operands if id(o) not in made]
            if missing:
                pending += reversed(missing)
                continue
            pending.pop()
            if id(node) not in made:
                parts = [made[id(o)] for o in node.ufl_operands] or self._terminal(node)
                made[id(node)] = nodes.setdefault((type(node).__name__, *parts), len(nodes))
        if not self.domains:
            raise Undescribed("an expression on no mesh")
        orders = [sorted(range(len(things)), key=[t.count() for t in things].__getitem__)
                  for things in (self.coefficients, self.constants)]
        text = repr((_versions(), *further, orders, *nodes))
        self.key = hashlib.sha256(text.encode()).hexdigest()

    def _terminal(self, node) -> Sequence:
        if isinstance(node, ufl.classes.MultiIndex):
            return [int(i) if isinstance(i, ufl.classes.FixedIndex) else ("free", self._place("index", i.count()))
                    for i in node]
        if isinstance(node, ufl.classes.Zero):
            free = [self._place("index", count) for count in node.ufl_free_indices]
            return node.ufl_shape, *free, node.ufl_index_dimensions
        if isinstance(node, ufl.classes.Label):
            return [self._place("label", node.count())]
        if isinstance(node, LITERAL):
            return [repr(node)]
        if isinstance(node, ufl.classes.GeometricQuantity):
            return self._domain(ufl.domain.extract_unique_domain(node))
        if isinstance(node, ufl.classes.Coefficient):
            space = node.ufl_function_space()
            return (self._listed("coefficient", node, self.coefficients), _text(space.ufl_element()),
                    *self._domain(space.ufl_domain()))
        if isinstance(node, ufl.classes.Constant):
            return (self._listed("constant", node, self.constants), node.ufl_shape, *self._domain(node.ufl_domain()))
        if isinstance(node, (ufl.classes.ExprList, ufl.classes.ExprMapping)):
            return ()
        raise Undescribed(type(node).__name__)

    def _domain(self, domain) -> tuple[int, str]:
        return self._listed("domain", domain, self.domains), _text(domain.ufl_coordinate_element())

    def _listed(self, kind: str, thing, things: list) -> int:
        place = self._place(kind, thing)
        if place == len(things):
            things.append(thing)
        return place

    def _place(self, kind: str, thing) -> int:
        """Number of a thing among the things of its kind that occur."""
        numbers = self._places.setdefault(kind, {})
        return numbers.setdefault(thing, len(numbers))


@dataclass(frozen=True)
class Recipe:
    """Where a kernel is, and what it takes.

    Attributes
    ----------
    library, name : file beside the recipes' folder, and the kernel's name in it
    coefficients : places in a description
    constants : places in a description, before
    values, domain : of constants that stand for numbers of the expression, and the place of their domain
    """

    library: str
    name: str
    coefficients: list[int]
    constants: list[int]
    values: list[list[float]]
    domain: int

    @classmethod
    def of(cls, description: Description, compiled, library: str, name: str) -> Recipe | None:
        """The recipe of an expression that was compiled as another one; None where it has come by something else."""
        coefficients, constants = extract_coefficients(compiled), extract_constants(compiled)
        known = [c for c in constants if c in description.constants]
        new = [c for c in constants if c not in description.constants]
        domains = {c.ufl_domain() for c in new}
        if (constants != known + new or len(domains) > 1 or not domains <= set(description.domains)
                or not set(coefficients) <= set(description.coefficients) or any(len(c.ufl_shape) != 1 for c in new)):
            return None
        return cls(library, name, [description.coefficients.index(c) for c in coefficients],
                   [description.constants.index(c) for c in known], [c.value.tolist() for c in new],
                   description.domains.index(*domains) if domains else 0)

    def standing_in(self, description: Description):
        """An expression with the coefficients and constants that the kernel takes."""
        new = [Constant(description.domains[self.domain], values) for values in self.values]
        return ufl.classes.ExprList(*(description.coefficients[n] for n in self.coefficients),
                                    *(description.constants[n] for n in self.constants), *new,
                                    *map(ufl.SpatialCoordinate, description.domains[:1]))

    @classmethod
    def read(cls, file: Path) -> Recipe | None:
        """From a file, where there are it and the library."""
        try:
            found = cls(**json.loads(file.read_text()))
        except (FileNotFoundError, ValueError, TypeError):
            return None
        return found if (file.parents[1] / found.library).exists() else None

    def write(self, file: Path) -> None:
        """Into a file, at once or not at all."""
        file.parent.mkdir(parents=True, exist_ok=True)
        with NamedTemporaryFile("w", dir=file.parent, delete=False) as stream:
            json.dump(asdict(self), stream)
        os.replace(stream.name, file)


_texts: dict[int, tuple] = {}  # of elements, which are kept so that no other one gets their number


def _text(element) -> str:
    """An element as a text, which takes long for rules of many points."""
    if id(element) not in _texts:
        _texts[id(element)] = repr(element), element
    return _texts[id(element)][0]


@lru_cache
def _versions() -> tuple:
    """What kernels depend on beside their expressions and options."""
    packages = "fenics-ufl", "fenics-ffcx", "fenics-basix"
    return (*map(version, packages), sysconfig.get_config_var("SOABI"), default_scalar_type.__name__,
            hashlib.sha256(Path(__file__).read_bytes()).hexdigest())
