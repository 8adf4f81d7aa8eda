"""Branches of a bifurcation: a converged state on each of them, from which a path goes on.

Branches are the directions of the space of null vectors in which the reduced equations of `reduction` hold without
forces. All multiplicities are treated alike; what differs is how these directions are found.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import RBFInterpolator
from scipy.optimize import minimize_scalar, root

from .. import rounding
from ..checks import Positive, require
from ..continuation.segment import Jump, Missed
from ..continuation.state import CriticalPoint, State
from ..continuation.tracer import tracer_of
from ..events.search import state_at, step_of
from .corner_branches import Unsettled, corner_of
from .first_piece import FirstPiece
from .modes import largest_displacement
from .reduction import NoSolution, Reduction

ANGLES = 48  # on the circle of directions of a double bifurcation
SAMPLES, STARTS = 100, 200  # on the sphere of a higher one, for each null vector
SMALLEST = 1e-4  # amplitude over the first one tried
CERTAIN = 1e-3  # amplitude over the first one tried, down to which starts on first pieces are looked for
SAME = 1e-3  # distance of unit vectors
TURN = 2 * np.pi


class NoBranch(ArithmeticError):
    """The equations of branches do not converge for any amplitude tried."""


@dataclass(frozen=True)
class Branch:
    """A half-branch: a bifurcation in one direction.

    Attributes
    ----------
    start : state on the branch, from which `Path(scene, control, until, start=[branch.start])` leads away from the
        bifurcation
    direction : of the null vectors' space, a unit vector; of a corner one in which the pairs count that change
    mode : null vector in this direction, of a corner the tangent, this process's part, the largest displacement being 1
        (see `mode_displacement`)
    amplitude : largest displacement of the mode's share in the start, of a corner of the start from that
    family : whether it stands for a continuum of branches, in all directions; a path along it may drift from one to
        another unless a support singles one out
    doubt : why the start is not known to lie on the branch's first piece, before secondary critical points; "" where
        it is
    """

    start: State
    direction: np.ndarray
    mode: np.ndarray
    amplitude: float
    family: bool = False
    doubt: str = ""

    def __str__(self) -> str:
        doubt = f"; {self.doubt}" if self.doubt else ""
        kind = "family of branches" if self.family else "branch"
        return f"{kind} with amplitude {self.amplitude:.4g}, starts at {self.start}{doubt}"


def branches(path, states: Sequence[State], point: CriticalPoint, amplitude: float = 0.05) -> list[Branch]:
    """A start on every half-branch of a bifurcation but the path's own.

    A simple bifurcation has two. A double one's are complete as far as samples each 8 degrees show
    them; for higher ones they are sought from many directions, and some may be missed. Starts lie on the first pieces
    of the branches, before their own critical points; where that cannot be made sure of, `Branch.doubt` says why.

    At a corner, where pairs open or close together, branches are all other tangents with which contacts are consistent
    (see `corner_branches`); starts lie close to it.

    Parameters
    ----------
    path : Path or Tracer that the states belong to; it stays at its present state
    states : of the path, among them those before and after the bifurcation
    point : the bifurcation, one of `critical` of these states
    amplitude : of the modes at the starts, in the scaled inner product (of the size of rotations in radians); it is
        halved until Newton's method converges quickly, to loads within 2 %, in all directions, and all starts lie on
        the first pieces of their branches (see `first_piece`)

    Raises
    ------
    ValueError
        For a limit point, if the amplitude is not positive, or if the states around the point are not given.
    NoBranch
        If none converges, or a corner's are not known: with friction, with pairs that are not
        condensed, or where more than 14 change together.
    """
    require("branches", amplitude=(amplitude, Positive))
    tracer = tracer_of(path)
    if point.kind != "bifurcation":
        raise ValueError(f"branches: a {point.kind} point (load {point.load:.6g}) has no branches; "
                         "the path itself goes on through it")
    before, after = step_of("branches", states, point, len(tracer.x.array))
    present = tracer.state
    try:
        if point.name == "corner":
            return _of_corner(tracer, before, after, point)
        state_at(tracer, before, after, point)
        reduction = Reduction(tracer, point.multiplicity, after)
        return _found(reduction, FirstPiece(reduction, point, (before, after)), amplitude)
    finally:
        tracer.back_to(present)


def _of_corner(tracer, before: State, after: State, point: CriticalPoint) -> list[Branch]:
    """Branches of a corner but the path's own."""
    try:
        corner = corner_of(tracer, before, after, point)
    except (Unsettled, Jump, Missed) as reason:
        raise NoBranch(f"the corner at load {point.load:.6g}: {reason or 'the state ahead of it does not converge'}"
                       ) from None
    found, own = [], corner.changed(after)
    for way in corner.ways():
        start, doubt = (None, "") if np.array_equal(way.changes, own) else corner.start(way)
        if start is not None:
            sizes = [largest_displacement(tracer.discretisation, vector)
                     for vector in (way.response, tracer.system.create_vector(start.increment))]
            mode = way.sense * way.response.array / sizes[0]
            found.append(Branch(start, way.changes / np.linalg.norm(way.changes), mode, sizes[1], doubt=doubt))
    return found


def _found(reduction: Reduction, piece: FirstPiece, amplitude: float) -> list[Branch]:
    """Branches at the largest amplitude for which the search converges, and starts are on first pieces.

    Where they are not for any amplitude, those of the one that leaves the most branches without doubt. Forces that
    single out branches at one amplitude vanish at small ones: these show no continuum.
    """
    search = {1: _both_ways, 2: _around_circle}.get(len(reduction.modes), _over_sphere)
    smallest, certain = SMALLEST * amplitude, CERTAIN * amplitude
    doubtful: list[list[Branch]] = []
    while amplitude > (certain if doubtful else smallest):
        try:
            directions, family = search(reduction, amplitude)
            if family and doubtful and not doubtful[-1][0].family:
                break
            found = [_branch(reduction, piece, c, amplitude, family) for c in directions]
            if not any(branch.doubt for branch in found):
                return found
            doubtful.append(found)
        except NoSolution:
            pass
        amplitude /= 2
    if doubtful:
        return max(doubtful, key=lambda found: sum(not branch.doubt for branch in found))
    raise NoBranch(f"no solution beside the path converges at the bifurcation at load "
                   f"{reduction.bifurcation.load:.6g}, down to amplitude {amplitude:.2g}; check with smaller steps "
                   "that it is one")


def _branch(reduction: Reduction, piece: FirstPiece, direction: np.ndarray, amplitude: float, family: bool) -> Branch:
    mode = reduction.combined(reduction.modes, direction)
    size = largest_displacement(reduction.tracer.discretisation, mode)
    start, doubt = piece.state(direction, amplitude, family), piece.doubt(direction, amplitude, family)
    return Branch(start, direction, mode.array / size, amplitude * size, family, doubt)


def _both_ways(reduction: Reduction, amplitude: float) -> tuple[list[np.ndarray], bool]:
    return [np.array([1.0]), np.array([-1.0])], False


def _around_circle(reduction: Reduction, amplitude: float) -> tuple[list[np.ndarray], bool]:
    """Zeros of the one force that is left, between samples on a circle."""
    def direction(angle):
        return np.array([np.cos(angle), np.sin(angle)])

    def force(angle):
        return float(reduction.solve(direction(angle), amplitude).forces @ direction(angle + np.pi / 2))

    angles = 0.1 + TURN * np.arange(ANGLES) / ANGLES
    solutions = [reduction.solve(direction(angle), amplitude) for angle in angles]
    if max(map(reduction.relative_forces, solutions)) < rounding.NONE:
        return [direction(angles[0])], True
    forces = [float(s.forces @ direction(a + np.pi / 2)) for a, s in zip(angles, solutions, strict=True)]
    return [direction(angle) for angle in zeros_around(force, angles, forces)], False


def zeros_around(force: Callable[[float], float], angles: np.ndarray, values: Sequence[float]) -> list[float]:
    """Angles at which a function is zero, from samples of it at equal distances around the circle.

    Between samples of equal sign it is followed to its least magnitude: two zeros or a double one may be there.
    """
    zeros, samples, spacing = [], list(zip(angles, values, strict=True)), TURN / len(angles)
    for angle, value, *others in zip(angles, values, np.roll(values, 1), np.roll(values, -1), strict=True):
        if all(other * value > 0 and abs(other) > abs(value) for other in others):
            sign = np.sign(value)
            least = minimize_scalar(lambda a, sign=sign: sign * force(a), method="bounded",
                                    bounds=(angle - spacing, angle + spacing), options={"xatol": 1e-6})
            place = angles[0] + (least.x - angles[0]) % TURN
            if abs(least.fun) < rounding.NONE * max(map(abs, values)):
                zeros.append(place)
            elif least.fun < 0:
                samples.append((place, sign * least.fun))
    samples = sorted(samples)
    samples.append((samples[0][0] + TURN, samples[0][1]))
    return sorted(zeros + [rounding.root(force, a, b) for (a, one), (b, other) in zip(
        samples[:-1], samples[1:], strict=True) if one * other < 0])


def _over_sphere(reduction: Reduction, amplitude: float) -> tuple[list[np.ndarray], bool]:
    """Zeros of the forces on a sphere of any dimension, near the zeros of an interpolation between samples."""
    multiplicity = len(reduction.modes)
    samples = _scattered(SAMPLES * multiplicity, multiplicity)
    solutions = [reduction.solve(c, amplitude) for c in samples]
    if max(map(reduction.relative_forces, solutions)) < rounding.NONE:
        return [samples[0]], True
    forces = np.array([solution.forces for solution in solutions])
    size = np.abs(forces).max()
    estimate = RBFInterpolator(samples, forces / size, kernel="cubic")
    guesses = _zeros(lambda c: estimate(c[None, :])[0], _scattered(STARTS * multiplicity, multiplicity))
    return _zeros(lambda c: reduction.solve(c, amplitude).forces / size, guesses), False


def _scattered(count: int, dimension: int) -> np.ndarray:
    """Unit vectors in rows."""
    vectors = np.random.default_rng(count).standard_normal((count, dimension))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def _zeros(force: Callable[[np.ndarray], np.ndarray], starts: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Different directions without forces that are found from some starts."""
    def equations(z):
        length = np.linalg.norm(z)
        return force(z / length) + (length**2 - 1) * z

    found: list[np.ndarray] = []
    for start in starts:
        solution = root(equations, start, tol=1e-10)
        c = solution.x / np.linalg.norm(solution.x)
        if solution.success and all(np.linalg.norm(c - other) > SAME for other in found):
            found.append(c)
    return found
