"""Strain measures of the user's are looked at before anything is compiled: their values at points of one cell."""

from __future__ import annotations

import inspect
import reprlib
import traceback
from collections.abc import Callable
from functools import cached_property
from warnings import catch_warnings, filterwarnings

import basix.ufl
import numpy as np
import ufl
from dolfinx import fem
from ufl import classes

from .. import forms
from ..checks import require_vector
from ..forms.evaluate import Unknown, evaluate, prepared
from ..notices import warn

ROUNDING = 1e-9  # of dimensionless strains, which are of order one where they are not zero
SMALL = 1e-2  # displacement gradients and rotations at which strains are numbers
SHELL = {"membrane": ("11", "22", "12"), "bending": ("11", "22", "12"), "shear": ("1", "2"), "drilling": ("",)}
BEAM = {2: ["axial", "shear", "bending"], 3: ["axial", "shear 1", "shear 2", "twist", "bending 1", "bending 2"]}
REMEDIES = {"ufunc": "use functions of UFL, such as ufl.sin, not those of numpy",
            "real number": "use functions of UFL, such as ufl.exp, not those of math",
            "float": "use functions of UFL, such as ufl.exp, not those of math",
            "multiply sequence": "the stiffness of a section whose strains are coupled is rows of a matrix",
            "bool": "use ufl.conditional, not if", "positional argument": "look at its arguments"}


def title_of(part, kind: str, function) -> str:
    """What messages call a function of the user's."""
    name = part if isinstance(part, str) else type(part).__name__
    return f"{name}: its {kind} {getattr(function, '__name__', None) or reprlib.repr(function)!r}"


def called(title: str, function: Callable, *arguments):
    """What a function of the user's returns.

    Raises
    ------
    ValueError
        Where it fails: names its line, and what was said there.
    """
    try:
        with catch_warnings():
            filterwarnings("ignore", "Couldn't map")  # UFL's, of a float that it then refuses
            return function(*arguments)
    except Exception as error:
        said = " ".join(f"{error}".split()) or type(error).__name__
        remedy = next((r for words, r in REMEDIES.items() if words in said), "mend it")
        raise ValueError(f"{title} fails{_line(function, error)}: {said}; {remedy}") from error


def _line(function: Callable, error: Exception) -> str:
    """The last line of the user's file that led to an error."""
    plain = inspect.unwrap(getattr(function, "func", function))
    code = getattr(plain, "__code__", None)
    lines = [f.lineno for f in traceback.extract_tb(error.__traceback__) if code and f.filename == code.co_filename]
    return f" in line {lines[-1]}" if lines else ""


def names_of(part, count: int) -> list[str]:
    """What the strains of a part are called."""
    shell = [f"{group} {place}".strip() for group, places in SHELL.items() for place in places]
    for known in (["axial"], BEAM[2], BEAM[3], shell):
        if len(known) == count and (count > 1 or part in ("Bar", "Beam")):
            return known
    return [f"strain {i}" for i in range(count)]


def strains_vector(title: str, found, count: int | None = None):
    """The strains that a function has returned as a UFL vector.

    Raises
    ------
    ValueError
        For another kind, number or shape.
    """
    if count != 9 or not title.startswith("Shell"):
        require_vector(title, found, count)
        return found
    if not isinstance(found, forms.shell.ShellStrains):
        shape = getattr(found, "ufl_shape", None)
        given = reprlib.repr(found) if shape is None else f"UFL of shape {shape}"
        raise ValueError(f"{title} returns {given}; return a forms.shell.ShellStrains")
    for name, places in SHELL.items():
        value = getattr(found, name)
        shape = getattr(value, "ufl_shape", () if isinstance(value, (int, float, complex)) else None)
        wanted = (len(places),) if name != "drilling" else ()
        if shape != wanted:
            given = reprlib.repr(value) if shape is None else f"UFL of shape {shape}"
            remedy = f"a UFL vector of {len(places)} (ufl.as_vector)" if wanted else "a UFL scalar"
            raise ValueError(f"{title} returns {name} as {given}; return {remedy}")
    return found.vector


class _Points:
    """Fields at points of the first cell of a part, and variations of them about rest.

    Rotations are (1, w / 2) as quaternions, w being the Rodrigues vector, so that w is the rotation to first order.
    """

    def __init__(self, part, cell: int):
        domain = part.mesh.domain
        self.part, self.domain, self.cell = part, domain, cell
        self.dimension, self.along = part.mesh.dimension, domain.topology.dim
        self.points = np.array([[0.5, 0.5, 0.5], [0.3, 0.2, 0.4]])[:, :self.along] * (1 if self.along == 1 else 0.8)
        nodes = domain.geometry.x[domain.geometry.dofmap[cell]][:, :self.dimension]
        (scalar, *_) = domain.ufl_domain().ufl_coordinate_element().sub_elements
        table = scalar.tabulate(2, self.points)
        orders = np.eye(self.along, dtype=int)
        self.place = table[0] @ nodes
        self.jacobian = np.stack([table[basix.index(*o)] @ nodes for o in orders], axis=-1)
        self.bent = np.stack([np.stack([table[basix.index(*(o + p))] @ nodes for p in orders], axis=-1)
                              for o in orders], axis=-2)
        self.inverse = np.linalg.pinv(self.jacobian)
        self.frame_fields: list = []
        self.size = float(np.linalg.norm(np.ptp(nodes, axis=0)))
        self.axes = np.linalg.qr(self.jacobian)[0]
        kind = domain.basix_cell()
        shapes = [(self.dimension,)] + [() if self.dimension == 2 else (4,)] * bool(part.spaces[1])
        spaces = [ufl.FunctionSpace(domain.ufl_domain(), basix.ufl.element("P", kind, 2, shape=s)) for s in shapes]
        self.fields = [ufl.Coefficient(space) for space in spaces]
        self.rates = [ufl.Coefficient(space) for space in spaces]
        turn = forms.rotation.PlanarRotation if self.dimension == 2 else forms.rotation.SpatialRotation
        self.rotation = turn(self.fields[1]) if len(spaces) > 1 else None

    @cached_property
    def directions(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """First tangent and normal of a shell at the points, with their gradients, which are the surface's."""
        first, second = np.moveaxis(self.jacobian, -1, 0)
        turned = [np.cross(self.bent[..., 0, k], second) + np.cross(first, self.bent[..., 1, k]) for k in range(2)]
        found = []
        for vector, rates in ((first, self.bent[..., 0, :]), (np.cross(first, second), np.stack(turned, axis=-1))):
            length = np.linalg.norm(vector, axis=-1)[:, None]
            unit = vector / length
            across = np.eye(3) - unit[:, :, None] * unit[:, None, :]
            found.append((unit, across @ rates @ self.inverse / length[..., None]))
        return found

    @cached_property
    def frame(self):
        """Reference frame; a shell's is written in fields, since interpolated normals need a compiler."""
        if self.along == 1:
            return self.part.frame()
        self.frame_fields = [ufl.Coefficient(self.fields[0].ufl_function_space()) for _ in range(2)]
        first, normal = self.frame_fields
        return forms.shell.SurfaceFrame(self.domain, (first, ufl.cross(normal, first), normal), normal)

    @property
    def spins(self) -> int:
        return 0 if self.rotation is None else 1 if self.dimension == 2 else 3

    def basis(self) -> np.ndarray:
        """Jets of unit size, shape (jets, entries): displacement, its slopes, rotation, its slopes."""
        lengths = np.concatenate([np.full(n, s) for n, s in zip(self._counts, (self.size, 1.0, 1.0, 1 / self.size),
                                                                strict=True)])
        return np.diag(lengths)

    @property
    def _counts(self) -> tuple[int, ...]:
        return self.dimension, self.dimension * self.along, self.spins, self.spins * self.along

    def rotations(self, point: int) -> list[np.ndarray]:
        """Jets of infinitesimal rotations about axes through a point; a shell's end with the normal."""
        axes = self.axes[point]
        if self.dimension == 2:
            spins, turns = [np.ones(1)], [np.array([[0.0, -1.0], [1.0, 0.0]])]
        else:
            spins = [*axes.T, *np.linalg.svd(axes.T)[2][self.along:]]
            turns = [np.cross(w, np.eye(3)).T for w in spins]
        return [np.concatenate([np.zeros(self.dimension), (turn @ axes).ravel(), spin[:self.spins],
                                np.zeros(self.spins * self.along)]) for turn, spin in zip(turns, spins, strict=True)]

    def values(self, expression, point: int, states: np.ndarray, rates: np.ndarray | None = None) -> np.ndarray:
        """An expression at a point, for jets of the fields and of their variations, shape (jets, *shape)."""
        given: dict = {}
        for symbol, (value, slope) in zip(self.frame_fields, self.directions if self.frame_fields else (), strict=True):
            given[symbol], given[ufl.grad(symbol)] = value[point][None], slope[point][None]
        for symbols, jets, start in ((self.fields, states, 1.0), (self.rates, rates, 0.0)):
            if jets is not None:
                u, slopes, spin, bends = np.split(jets, np.cumsum(self._counts)[:3], axis=1)
                axes = self.axes[point]
                slopes = slopes.reshape(len(jets), self.dimension, self.along) @ axes.T
                given[symbols[0]], given[ufl.grad(symbols[0])] = u, slopes
                if self.rotation is not None:
                    bends = bends.reshape(len(jets), self.spins, self.along) @ axes.T
                    if self.dimension == 2:
                        given[symbols[1]], given[ufl.grad(symbols[1])] = spin[:, 0], bends[:, 0]
                    else:
                        given[symbols[1]] = np.hstack([np.full((len(jets), 1), start), spin / 2])
                        given[ufl.grad(symbols[1])] = np.concatenate([0 * bends[:, :1], bends / 2], axis=1)
        found = evaluate(expression, lambda node: self._terminal(node, point, given))
        return np.broadcast_to(found, (len(states), *found.shape[1:]))

    def _terminal(self, node, point: int, given: dict) -> np.ndarray:
        if node in given:
            return given[node]
        if isinstance(node, classes.Jacobian):
            return self.jacobian[point][None]
        if isinstance(node, classes.JacobianInverse):
            return self.inverse[point][None]
        if isinstance(node, classes.JacobianDeterminant):
            return np.sqrt([np.linalg.det(self.jacobian[point].T @ self.jacobian[point])])
        if isinstance(node, classes.SpatialCoordinate):
            return self.place[point][None]
        return number_of(node, self.place[point], self.cell)


def number_of(node, place=None, cell: int = 0) -> np.ndarray:
    """Value of a constant, or of a field of the user's at a place in a cell, with one sample."""
    if isinstance(node, fem.Constant):
        return node.value[None]
    if isinstance(node, fem.Function) and place is not None:
        found = node.eval(np.pad(place, (0, 3 - len(place)))[None], np.array([cell], dtype=np.int32))
        return found.reshape(1, *node.ufl_shape)
    raise Unknown(type(node).__name__)


def require_strains(part, function: Callable, count: int | None) -> int:
    """Number of strains of a measure; refuse one that gives no strains, on all processes.

    Strains are real and finite near rest; zero at rest; of first order zero in rigid motions, and each of them not zero
    in all motions. Theories of shallow shells are accepted: their bending strains may change with a rotation about the
    normal, by the curvature of the surface times that. Drilling that does is told by a warning, since it resists
    in-plane rotations alone. Large rotations are not looked at.

    Parameters
    ----------
    count : number of strains; None: any

    Raises
    ------
    ValueError
        Names strain, value and remedy.
    """
    cells, found, objection = part.mesh.group(part.group), 0, None
    if len(cells):
        try:
            found = _look_at(_Points(part, int(cells[0])), title_of(part, "strains", function), function, count)
        except ValueError as error:
            objection = error
    everywhere = part.mesh.comm.allgather((found, objection and str(objection)))
    if said := next((words for _, words in everywhere if words), None):
        raise ValueError(said) from (objection and objection.__cause__)
    return max(number for number, _ in everywhere)


def _look_at(points: _Points, title: str, function: Callable, count: int | None) -> int:
    strains = strains_vector(title, called(title, function, points.fields[0], points.rotation, points.frame), count)
    number, owner = strains.ufl_shape[0], type(points.part).__name__
    names, zero = names_of(owner, number), np.zeros((1, len(points.basis())))
    lengths = np.array([points.size if n.startswith(("bending", "twist")) else 1.0 for n in names])
    near = SMALL * np.random.default_rng(1).uniform(-1, 1, (4, zero.size)) @ points.basis()
    rate = sum(ufl.derivative(strains, *pair) for pair in zip(points.fields, points.rates, strict=True))
    slopes = []
    try:
        strains, rate = prepared(strains), prepared(rate)
        tables = [(points.values(strains, point, np.vstack([zero, near])),
                   points.values(rate, point, 0 * points.basis(), points.basis()))
                  for point in range(len(points.points))]
    except Unknown as unknown:
        if str(unknown) == "Grad":
            raise ValueError(f"{title} takes second derivatives (grad of grad), which elements of degree 1 to 3 do "
                             "not have across cells; use first derivatives of u and rotation only") from None
        return number
    for point, (values, change) in enumerate(tables):
        rest, small = values[:1], values[1:]
        _require_numbers(title, names, rest[0], small, change)
        if (wrong := np.abs(rest[0]) * lengths > ROUNDING).any():
            i = int(np.argmax(wrong))
            raise ValueError(f"{title}: {names[i]} is {rest[0, i]:.6g} at rest, where u and rotation are zero; "
                             "subtract its value there, or give a prestress by fx.InitialStrain")
        _require_rigid(points, title, names, point, change, lengths)
        slopes.append(np.abs(change).max(axis=0) * lengths)
    for name, slope in zip(names, np.max(slopes, axis=0), strict=True):
        if slope < ROUNDING:
            raise ValueError(f"{title}: {name} is zero in all small motions, so that what it holds, such as rotations, "
                             "has no stiffness; return a strain that changes with them")
    return number


def _require_numbers(title: str, names: list[str], *tables: np.ndarray) -> None:
    """Refuse what is complex or not finite: strains at rest, near it, and their derivatives at rest."""
    together = np.vstack(tables)
    if together.dtype.kind == "c":
        i = int(np.argmax(np.abs(together.imag).max(axis=0)))
        raise ValueError(f"{title}: {names[i]} is complex; return real strains, without 1j")
    for place, table in zip(("at rest", "near rest", "at rest in its derivative"), tables, strict=True):
        if not np.isfinite(table).all():
            bad = np.argwhere(~np.isfinite(np.atleast_2d(table)))[0]
            raise ValueError(f"{title}: {names[bad[1]]} is {np.atleast_2d(table)[tuple(bad)]:g} {place}; roots, "
                             "logarithms and quotients need a form that is smooth there")


def _require_rigid(points: _Points, title: str, names: list[str], point: int, change: np.ndarray, lengths) -> None:
    scales = np.diag(points.basis())
    motions = [("translation", jet) for jet in points.basis()[:points.dimension]]
    motions += [("rotation", jet) for jet in points.rotations(point)]
    bent = points.size * np.linalg.norm(points.directions[1][1][point]) if points.along == 2 else 0.0
    for number, (motion, jet) in enumerate(motions):
        parts = (jet / scales)[:, None] * change * lengths
        allowed = ROUNDING * (1 + np.abs(parts).sum(axis=0))
        if points.along == 2 and number == len(motions) - 1:
            allowed = allowed + 2 * bent * np.array([n.startswith("bending") for n in names])
        wrong = np.abs(parts.sum(axis=0)) > allowed
        if wrong.any():
            i = int(np.argmax(wrong))
            found = parts.sum(axis=0)[i] / lengths[i]
            if names[i] == "drilling" and number == len(motions) - 1:
                warn(f"{title}: drilling is {found:.6g} in a rigid rotation about the normal by an angle of 1, to "
                     "first order, where strains are zero; look at the sign of the rotation beside the slopes of u")
                continue
            remedy = ("take derivatives of u, not u itself" if motion == "translation" else
                      "look at the sign of the rotation beside the slopes of u")
            size = "of unit size, a cell's length" if motion == "translation" else "by an angle of 1, to first order"
            raise ValueError(f"{title}: {names[i]} is {found:.6g} in a rigid {motion} "
                             f"{size}, where strains are zero; {remedy}")
