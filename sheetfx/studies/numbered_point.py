"""A critical point of a path by its number."""

from __future__ import annotations

from ..case import Case, trace
from ..continuation.state import CriticalPoint
from ..critical.augmented import KINDS
from ..record import Record


def numbered_points(record: Record) -> list[CriticalPoint]:
    """Limit points and bifurcations of a path, which `--point` counts from 1."""
    return [point for point in record.critical_points if point.kind in KINDS]


def path_to_point(case: Case, number: int, title: str) -> tuple[Record, CriticalPoint]:
    """The path of a case as far as a critical point.

    Parameters
    ----------
    number : of the point, from 1
    title : of the path in errors

    Raises
    ------
    ValueError
        If the path has fewer points.
    PathFailure
        If the path ends in front of the point.
    """
    record = trace(case, enough=lambda record: len(numbered_points(record)) >= number)
    points = numbered_points(record)
    if number > len(points):
        raise ValueError(f"--point: {number}, but the path of {title} has {len(points)} limit points and "
                         "bifurcations; give one of these, other options, or let the path go further")
    return record, points[number - 1]
