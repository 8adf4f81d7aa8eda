"""Where eigenvalues of the tangent pass zero on a piece of path, told apart however close they are.

They are roots of the determinant of a small matrix, `determinant.Determinant`. It is interpolated between states that
keep a distance from the crossing, since at a critical point rounding decides where a state lies. With an unsymmetric
tangent nothing changes. Where something begins or ceases to touch or to slip eigenvalues jump, and may pass zero with
that: the number of solutions changes there too, as an odd change of the number of unstable modes shows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from operator import itemgetter

import numpy as np
from scipy.interpolate import KroghInterpolator

from .. import rounding
from ..continuation.segment import Jump, Segment
from .determinant import Determinant
from .leaping import leads_around_corner, require_convergence

REACHES = (0.1, 0.03, 0.01, 0.003)  # of a piece of path, distances from crossings of the states that are looked at
ALTERNATELY = (0.1, (-1,)), (0.03, (1,)), (0.01, (-1,))  # likewise, first on one side each
ROUGH = 1e-5  # relative error of the load, which is too large
SAMPLES = 6  # states that are interpolated between
CLOSEST, CORNERED = 1e-4, 1 / 64  # of a step, piece that is not divided any more, in general and with contact
STEEP = 4  # of an even change over the step, change of eigenvalues between two neighbouring states where they jump
EVEN = 0.5  # smaller rate of the load factor over the larger one at the outer samples, where it tells them apart
DOUBT = 4  # of the last correction of a load, difference from another value of it that shows which one is noise
FAR = 0.05  # of a piece of path, distance from crossings of states that tell how far apart these are
APART = 0.1  # of a piece of path, distance of crossings that are looked for one by one
FOLD = 0.9  # of the length of a piece of path, motion along the mode where a limit point is


@dataclass(frozen=True)
class Crossing:
    """Where an eigenvalue of the tangent passes zero; at a corner of the path it jumps past it."""

    length: float
    load: float
    deflection: float
    spread: tuple[float, float] | None = None
    corner: bool = False


def unresolved(segment: Segment, left: float, right: float, count: int) -> list[Crossing]:
    """Crossings that are known to lie between two lengths, and no more; of a step around a corner: its start."""
    one, other = segment[left], segment[right]
    low, high = sorted((one.load, other.load))
    corner = segment.nonsmooth and _jumps(segment, Determinant(segment, left, right, count), left, right)
    load, deflection = (one.load + other.load) / 2, (one.deflection + other.deflection) / 2
    if one is segment.before and leads_around_corner(segment):
        load, deflection = one.load, one.deflection
    return [Crossing(left, load, deflection, (low, high), corner)] * count


def _jumps(segment: Segment, border: Determinant, left: float, right: float) -> bool:
    """Whether eigenvalues change far more between two neighbouring states than over as much of the step elsewhere.

    So they do in a step that leads around a corner of the path, which cannot be divided.
    """
    if leads_around_corner(segment):
        return True
    near, whole = (border.change(*ends) for ends in ((left, right), (0.0, segment.after.length)))
    return near * segment.after.length > STEEP * whole * (right - left)


def pass_zero(segment: Segment, left: float, right: float, count: int) -> list[Crossing]:
    """Crossings between two lengths of a segment, at whose states the numbers of unstable modes differ by `count`.

    Raises
    ------
    Jump
        If the path does not lead through one of them, or they are not found.
    """
    border, lengths, exact = Determinant(segment, left, right, count), [left, right], segment.tracer.control.exact
    if len(border.numbers) != count:
        return _halves(segment, left, right)
    roots, samples, between, close = border.roots(lengths), lengths, np.inf, CLOSEST * segment.after.length
    best = np.inf, roots, samples  # in the end rounding takes over, so that nearer samples are worse
    for reach, sides in (*ALTERNATELY, *((reach, (-1, 1)) for reach in REACHES)):
        gaps = np.diff(roots)
        if len(gaps) and gaps.max() > APART * (right - left):
            middle = float(roots[np.argmax(gaps)] + gaps.max() / 2)
            if segment.reach(middle):
                return _pieces(segment, left, right)
        try:
            lengths = _sampled(border, segment, lengths, roots, reach * (right - left), sides)
        except Jump:  # off the path for rounding or contact: the samples that there are must do
            if len(lengths) == 2:
                raise
            best = min(best, (between, roots, samples), key=itemgetter(0))
            break
        samples = _nearest(lengths, roots)
        coarser, finer = border.roots(samples[:-1]), border.roots(samples)
        if not _counted(segment, lengths, finer):
            return _pieces(segment, left, right)
        between, drift = (_load_change(segment, samples[0], _moved(finer, other, close)) for other in (coarser, roots))
        roots, error = finer, max(between, drift)
        worse = segment.nonsmooth and best[0] <= min(ROUGH, error)
        best = min(best, (error, roots, samples), key=itemgetter(0))
        if error <= exact or worse:
            break
    error, roots, samples = best
    if not error <= ROUGH or (segment.nonsmooth and not _counted(segment, lengths, roots)):
        return _halves(segment, left, right)
    if segment.guarded:
        _compare_sides(segment, roots, samples, border)
    found = _at_loads(segment, _together(border, roots, lengths), samples, border)
    if segment.nonsmooth and error > exact:
        return [replace(c, corner=_jumps(segment, border, *segment.neighbours(c.length))) for c in found]
    return found


def _moved(roots: np.ndarray, others: np.ndarray, close: float) -> float:
    """Largest distance of crossings from others, where they lie close together the distance of their means.

    Rounding parts crossings that lie together, and the more the nearer the states are, but hardly moves their means.
    """
    groups = np.split(roots - others, np.flatnonzero(np.diff(roots) > close) + 1)
    return max(abs(float(group.mean())) for group in groups)


def _together(border: Determinant, roots: np.ndarray, lengths: Sequence[float]) -> np.ndarray:
    """Crossings as far apart as states that are further off have them, if that is less.

    Rounding splits eigenvalues that are alike by as much as it moves states along the mode, in inverse proportion to
    their distance from the crossing; where they lie together these know less exactly, but how far they are apart. They
    do so where one of them less makes a smaller difference.
    """
    size, middle = lengths[-1] - lengths[0], roots.mean()
    far = [s for s in lengths if abs(s - middle) >= FAR * size]
    if not np.ptp(roots) or len(far) < 3:
        return roots
    coarser, finer = (border.roots(_nearest(far, roots)[:n]) for n in (min(len(far), SAMPLES) - 1, SAMPLES))
    doubt = abs(np.ptp(finer) - np.ptp(coarser)) if np.isfinite((coarser, finer)).all() else np.inf
    return middle + finer - finer.mean() if np.ptp(finer) + doubt < np.ptp(roots) else roots


def _at_loads(segment: Segment, roots: np.ndarray, samples: Sequence[float], border: Determinant) -> list[Crossing]:
    """Crossings at lengths, with their loads.

    Rounding moves states along the mode, the more the nearer they are, which changes the length of the path up to them
    and the tangents there, but hardly their loads. The samples' eigenvalues as functions of the load factor, where this
    changes evenly, give loads that do not feel it. They are taken where the others are far beyond their own error.
    """
    found = np.array([segment.seen(float(s)) for s in roots])
    states = [segment[s] for s in sorted(samples)]
    rises, rates = np.diff([state.factor for state in states]), [states[0].load_rate, states[-1].load_rate]
    if abs(np.sign(rises).sum()) == len(rises) and min(rates) * max(rates) > EVEN * max(np.square(rates)):
        factors = [segment[s].factor for s in samples]
        values = KroghInterpolator(factors, [(segment[s].load, segment[s].deflection) for s in samples])
        coarser, finer = (values(border.roots(samples[:n], factors[:n])[::int(np.sign(rises[0]))])
                          for n in (len(samples) - 1, len(samples)))
        off, doubt = finer - found, finer - coarser
        if np.ptp(roots) < CLOSEST * segment.after.length:
            off, doubt = (np.tile(v.mean(axis=0), (len(roots), 1)) for v in (off, doubt))
        exact = segment.tracer.control.exact * np.abs(found[:, 0])
        noisy = np.abs(off[:, 0]) > DOUBT * np.maximum(np.abs(doubt[:, 0]), exact)
        found[noisy] += off[noisy]
    return [Crossing(float(s), float(load), float(deflection))
            for s, (load, deflection) in zip(roots, found, strict=True)]


def _load_change(segment: Segment, near: float, change: float) -> float:
    """Relative change of the load within a small length; infinite where no root has been found."""
    if np.isinf(change):
        return np.inf
    size = max(abs(segment[near].factor), abs(segment.after.load_increment))
    return segment.load_change(segment[near], change) / size


def _counted(segment: Segment, lengths: Sequence[float], roots: np.ndarray) -> bool:
    """Whether between neighbouring states as many crossings lie as their numbers of unstable modes differ by.

    Where a mode that is not among the vectors becomes soft, G has a pole, through which eigenvalues change sign too.
    """
    counts = [segment[s].unstable_modes for s in lengths]
    return list(np.abs(np.diff(counts))) == list(np.histogram(roots, lengths)[0])


def _halves(segment: Segment, left: float, right: float) -> list[Crossing]:
    """Crossings between two lengths, with one more state in the middle."""
    segment.reach((left + right) / 2)
    return _pieces(segment, left, right)


def _pieces(segment: Segment, left: float, right: float) -> list[Crossing]:
    """Crossings between two lengths, between neighbouring states each; where these are too close, not told apart."""
    lengths = [s for s in sorted(segment.states) if left <= s <= right]
    counts = [segment[s].unstable_modes or 0 for s in lengths]
    closest = CORNERED if segment.nonsmooth else CLOSEST
    if len(lengths) < 3 or right - left < closest * segment.after.length:
        if right - left >= closest * segment.after.length:
            require_convergence(segment, left)
        return unresolved(segment, left, right, abs(counts[0] - counts[-1]))
    found = []
    for one, other, count in zip(lengths[:-1], lengths[1:], np.abs(np.diff(counts)), strict=True):
        if count:
            found += pass_zero(segment, one, other, int(count))
    return found


def _nearest(lengths: Sequence[float], roots: np.ndarray) -> list[float]:
    """The samples nearest to some crossings, the nearest one first."""
    return sorted(lengths, key=lambda s: abs(s - roots.mean()))[:SAMPLES]


def _sampled(border: Determinant, segment: Segment, lengths: Sequence[float], roots: np.ndarray, reach: float,
             sides: Sequence[int]) -> list[float]:
    """Lengths of states with one more before (-1) or behind (1) the crossings, as far as they converge.

    Raises
    ------
    Jump
        If one does not with contact.
    """
    found = set(lengths)
    for wanted in (float((roots.min() if side < 0 else roots.max()) + side * reach) for side in sides):
        away, nearest = min((abs(s - wanted), s) for s in segment.states)
        if away < reach / 4:
            found.add(nearest)
        elif min(lengths) < wanted < max(lengths):
            if segment.reach(wanted):
                found.add(wanted)
                border.at(wanted)  # while its factor is at hand
            else:
                require_convergence(segment, max(s for s in segment.states if s < wanted))
    return sorted(s for s in found if min(lengths) <= s <= max(lengths))


def _compare_sides(segment: Segment, roots: np.ndarray, samples: Sequence[float], border: Determinant) -> None:
    """Refuse states on both sides of a bifurcation that the path does not lead through.

    Near the bifurcation of a slightly imperfect structure the path bends away along the mode; a step that goes
    straight on has jumped to another path, from which the mode deviates to the other side, or which itself goes
    along the mode at a limit point. An imperfection grows by the critical load over the distance from it.
    """
    left = max((s for s in samples if s < min(roots)), default=None)
    right = min((s for s in samples if s > max(roots)), default=None)
    if left is None or right is None:
        return
    nearest = min((left, right), key=lambda s: min(abs(s - root) for root in roots))
    factors = KroghInterpolator(samples, [segment[s].factor for s in samples])
    distance = segment.distance(left, right)
    for root, mode in zip(sorted(roots, key=lambda s: abs(s - nearest)), border.null_vectors(nearest), strict=True):
        moved, led = segment.along(mode, left, right)
        size, critical = max(abs(moved), abs(led)), factors(root)
        with np.errstate(divide="ignore"):
            grown = np.abs(critical / np.subtract([segment[s].factor for s in (left, right)], critical)).sum()
        strays = abs(moved - led) > size / 2 and size > rounding.NONE * grown
        if (strays or abs(moved) > FOLD * distance) and size > max(
                rounding.off_path(segment.tracer, segment[s]) for s in (left, right)):
            raise Jump("the path bends away from a bifurcation that the step passes")
