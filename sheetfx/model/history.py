"""Section laws that remember: plasticity, damage, or a law of the user's with a history of its own."""

from __future__ import annotations

import numpy as np

from ..checks import Like

STRAINS = 1e-3  # size of the strains at which a law is looked at
SYMMETRIC = 1e-4  # relative difference of moduli that is an error of differences


class LawWithHistory:
    """A section law whose resultants depend on what has happened at a point.

    A part takes any object like this as its `law`. History is zero at the start; what `update` returns becomes it when
    a state of the path is accepted, and not before: every iterate of a step starts from the last accepted one.

    A law that knows its energy says so by a method `energies`, which takes strains, and the history that goes with
    them, and returns the energy that each point stores, and what it has dissipated since the start, both of shape
    (points,): runs then compare them with the work of the loads.

    Attributes
    ----------
    remembered : number of values that each point remembers
    """

    remembered: int

    def update(self, strains: np.ndarray, history: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Resultants, moduli and history of strains, for many points at once.

        Parameters
        ----------
        strains : shape (points, n), in the order of the part's strains
        history : shape (points, remembered), of the last accepted state; not to be changed

        Returns
        -------
        resultants, shape (points, n); their derivatives by the strains, symmetric, shape (points, n, n), where a point
        that is about to yield takes the loading ones; the history at these strains, shape (points, remembered)
        """
        raise NotImplementedError

    def accepted(self, strains: np.ndarray, history: np.ndarray) -> None:
        """Be told of strains and history of an accepted state, shapes as in `update`."""


def has_history(law) -> bool:
    """Whether a section law is one with history."""
    return hasattr(law, "update")


LAW = Like("a function or a law with history", lambda law: callable(law) or has_history(law))


def require_update(name: str, law, count: int) -> None:
    """Refuse a law with history that returns what it should not, at no strains and at some.

    Parameters
    ----------
    name : of the part
    count : number of strains

    Raises
    ------
    ValueError
        For arrays of the wrong shape, values that are no numbers, or moduli that are not symmetric.
    """
    title, remembered = f"{name}: law {type(law).__name__}", getattr(law, "remembered", None)
    if not isinstance(remembered, int) or remembered < 0:
        raise ValueError(f"{title}: remembered is {remembered!r}; give the number of values that a point remembers")
    strains = STRAINS * np.array([np.zeros(count), np.cos(np.arange(1, count + 1))])
    found = law.update(strains, np.zeros((len(strains), remembered)))
    if not isinstance(found, tuple) or len(found) != 3:
        raise ValueError(f"{title}: update returns {type(found).__name__}; return resultants, moduli and history")
    shapes = {"resultants": strains.shape, "moduli": (*strains.shape, count), "history": (len(strains), remembered)}
    for (what, shape), values in zip(shapes.items(), map(np.asarray, found), strict=True):
        if values.shape != shape:
            raise ValueError(f"{title}: update returns {what} of shape {values.shape} for {len(strains)} points with "
                             f"{count} strains; it must be {shape}")
        if not np.isfinite(values).all():
            raise ValueError(f"{title}: update returns {what} that are no numbers, of strains up to {STRAINS}")
    told = law.energies(strains, np.asarray(found[2])) if hasattr(law, "energies") else ()
    for values in map(np.asarray, told):
        if values.shape != (len(strains),) or not np.isfinite(values).all():
            raise ValueError(f"{title}: energies returns shape {values.shape} for {len(strains)} points; return what "
                             "they store and what they have dissipated, one finite number for each point")
    moduli = np.asarray(found[1])
    wrong = np.abs(moduli - moduli.transpose(0, 2, 1)) > SYMMETRIC * np.abs(moduli).max()
    if wrong.any():
        point, i, j = map(int, np.argwhere(wrong)[0])
        raise ValueError(f"{title}: its moduli are not symmetric: {moduli[point, i, j]:.6g} of resultant {i} with "
                         f"strain {j}, {moduli[point, j, i]:.6g} the other way; sheetfx needs an associated law")
