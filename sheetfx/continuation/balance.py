"""The balance of energy along a path: the work of its loads, and the energy stored and dissipated.

Along a path of equilibrium states the loads f of a stage do the work

    integral of factor dW = [factor W] - integral of W d factor,    W = f . x,

and what is prescribed does the integral of its force times its distance, by the factor. With q = f . x, where x has
the multipliers of prescribed motions too, both are [factor W] less the integral of q by the factor. At each state q
and, from its tangent, the rate of q by the factor are known: Hermite's interpolation through up to four states
integrates it, by the factor or, about limit points, by q. How far that of fewer states is off tells its accuracy. Where
that is not enough, states within steps are found and interpolated through as well.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import cast

import numpy as np
from scipy.interpolate import KroghInterpolator

from ..checks import Positive, require
from ..discrete.discretisation import Discretisation
from .energy_ledger import Account, EnergyLedger
from .state import State
from .tracer import Tracer

WINDOWS = (-1, 3), (0, 3), (-1, 2), (0, 2)  # states about a step that are interpolated through, by falling number
STEEPEST = 3.0  # tangent of the angle between the path and the chord of a step, in the plane of factor and q
GAUSS = np.polynomial.legendre.leggauss(8)
SAFETY = 5.0  # times the accuracy of the work, that it may differ from the stored energy: contact bends paths sharply
ROUNDS = 24  # of halving pieces of steps: about a corner, to 1e-7 of a step
ROUNDING = 1e-6  # of the largest energy, by which work and stored energy may differ


@dataclass(frozen=True)
class Balance:
    """Energies of the modelled structure along a path, the same on all processes.

    Attributes
    ----------
    parts : energy that each part of the scene stores in all states, by its strains and by hardening, shape (states,
        parts); NaN where a law with history does not tell
    joints : energy of joints and contacts, as far as they tell, shape (states,)
    dissipated : by plastic flow, friction, and in falls under a held load, since the first state, shape (states,)
    work : that loads and prescribed motions have done since the first state, shape (states,); NaN where it is not known
    accuracy : of the work, shape (states,)
    untold : what does not tell its energy or its work, so that there is no balance
    """

    parts: np.ndarray
    joints: np.ndarray
    dissipated: np.ndarray
    work: np.ndarray
    accuracy: np.ndarray
    untold: tuple[str, ...]

    @property
    def stored(self) -> np.ndarray:
        """Energy of parts, joints and contacts, beyond the first state's."""
        stored = self.parts.sum(axis=1) + self.joints
        return stored - stored[0]

    @property
    def off(self) -> float | None:
        """Largest difference of work and energy, stored and dissipated, over the largest of both; None: not known."""
        return None if self.untold else float(np.abs(self.work - self._taken).max() / self._largest)

    @property
    def tolerance(self) -> float:
        """Accuracy of the work over the largest energy."""
        return float(self.accuracy.max() / self._largest)

    @property
    def broken(self) -> str:
        """What is wrong with the balance, "" if nothing is or it is not known."""
        if self.off is None or self.off <= ROUNDING + SAFETY * self.tolerance:
            return ""
        dissipated = f" and {self.dissipated[-1]:.8g} dissipated" if self.dissipated.any() else ""
        return (f"the energy does not balance: the loads have done {self.work[-1]:.8g}, {self.stored[-1]:.8g} is "
                f"stored{dissipated}; along the path these differ by up to {self.off:.2g} of the largest, more than "
                f"the {self.tolerance:.2g} that the length of the steps explains. States may lie on other paths than "
                "those before them (try shorter steps), or a law or a load may not be what it says")

    def summary(self) -> dict:
        """Energies of the last state, and the balance along the path, for people to read."""
        def known(value: float) -> float | None:
            return float(value) if np.isfinite(value) else None

        return {"strain": list(map(known, self.parts[-1])), "joints_and_contacts": known(self.joints[-1]),
                "dissipated": known(self.dissipated[-1]), "work_of_loads": known(self.work[-1]), "off": self.off,
                "accuracy": known(self.tolerance), "not_balanced": list(self.untold)}

    @property
    def _taken(self) -> np.ndarray:
        return self.stored + self.dissipated

    @property
    def _largest(self) -> float:
        return float(max(np.abs(self.work).max(), np.abs(self._taken).max())) or 1.0


def balance(tracer: Tracer, states: Sequence[State], accuracy: float | None = None) -> Balance:
    """The balance along the states of a path; the tracer comes back to where it was.

    Parameters
    ----------
    accuracy : of the work over the largest energy; states within steps are found where it needs them. None: what the
        states of the path tell
    """
    require("balance", accuracy=(accuracy, Positive | None))
    system, present = tracer.system, tracer.state
    works = cast(Discretisation, tracer.discretisation).works_of_parts
    untold = {f"{c.called or type(c).__name__} does not tell its energy" for c in system.contributions
              if c.stage is None and c not in works and c.energy() is None}
    untold |= {f"{c.called} does not tell its work" for c in system.contributions if not c.tells_work}
    if not all(work.tells_energy for work in works):
        untold.add("a law with history does not tell what it stores")
    books = EnergyLedger(tracer, states)
    if books.fallen and not books.dead:
        untold.add("what loads that follow do in a fall is not told")
    accounts = books.balanced()
    asked = 0.0 if untold else accuracy or 0.0
    steps = _steps(books, accounts)
    for _ in range(ROUNDS if asked else 0):
        energies = [sum(a.parts) + sum(a.joints) + a.dissipated for a in accounts] + _sums(steps)[:, 2]
        most = asked * (np.ptp(energies) or 1.0) / len(accounts)
        if not books.halve(np.flatnonzero(steps[:, 1] > most).tolist()):
            break
        accounts = books.balanced()
        steps = _steps(books, accounts)
    tracer.back_to(present)
    known = all(account.dead or account.proportional for account in accounts)
    if not known:
        untold.add("loads are not proportional to their factor")
    given = [i for i, account in enumerate(accounts) if account.place == 0.0]
    work, unsure, rubbed = _sums(steps)[given].T
    parts, joints, dissipated = (np.array([getattr(accounts[i], name) for i in given])
                                 for name in ("parts", "joints", "dissipated"))
    joints, dissipated = joints.sum(axis=1), dissipated - dissipated[0] + rubbed
    for after in books.fallen:
        stored = parts.sum(axis=1) + joints
        dissipated[after:] += np.diff(work - stored - dissipated)[after - 1]
    return Balance(parts, joints, dissipated, work if known else np.full_like(work, np.nan), unsure,
                   tuple(sorted(untold)))


def _steps(books: EnergyLedger, accounts: Sequence[Account]) -> np.ndarray:
    """Of each step the work along it, the accuracy of all that is integrated, and what friction dissipates.

    The accuracy of the latter is its change where it is integrated over two steps at once.
    """
    steps = np.array([_step(accounts, i) for i in range(len(accounts) - 1)]).reshape(-1, 2)
    rubbed = np.array([books.rubbed(before, after) for before, after in pairwise(accounts)])
    twice = [books.rubbed(before, after) for before, after in zip(accounts, accounts[2:], strict=False)]
    unsure = np.abs(twice - rubbed[1:] - rubbed[:-1])
    steps[1:, 1] += unsure
    return np.column_stack((steps, rubbed))


def _sums(steps: np.ndarray) -> np.ndarray:
    """What has been added up until each account."""
    return np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])


def _step(accounts: Sequence[Account], i: int) -> tuple[float, float]:
    """Work along the step from a state to the next, and its accuracy."""
    before, after = accounts[i], accounts[i + 1]
    stage, earlier = after.state.stage, before.done
    work = sum(b - a for a, b in zip(earlier[:stage], after.done[:stage], strict=False))
    if stage != before.state.stage:
        return work, 0.0
    integral, accuracy = _integral(accounts, i)
    accuracy += max(abs(before.state.factor), abs(after.state.factor)) * after.unsure
    return work + after.state.factor * after.done[stage] - before.state.factor * before.done[stage] - integral, accuracy


def _integral(accounts: Sequence[Account], i: int) -> tuple[float, float]:
    """Integral of q by the factor along a step, and how far interpolation through fewer states is off."""
    stage, found = accounts[i + 1].state.stage, []
    for first, last in WINDOWS:
        if i + first < 0 or i + last > len(accounts):
            continue
        window = accounts[i + first: i + last]
        if all(a.state.stage == stage for a in window) and (value := _through(window, -first)) is not None:
            found.append(value)
    before, after = accounts[i: i + 2]
    trapezoid = (before.product + after.product) / 2 * (after.state.factor - before.state.factor)
    if len(found) > 1:
        return found[0], abs(found[0] - found[1])
    value = found[0] if found else trapezoid
    return value, abs(value - trapezoid) if found else abs(value)


def _through(window: Sequence[Account], step: int) -> float | None:
    """Integral along a step of a window by the curve through its states; None: that bends too much for a polynomial.

    The curve of q over the factor is a function on axes that are turned so that the first is the chord of the step.
    """
    places = np.array([(a.state.factor, a.product) for a in window])
    scales = np.ptp(places, axis=0)
    if not scales.all():
        return 0.0 if not scales[0] else float(places[0, 1] * (places[step + 1, 0] - places[step, 0]))
    places = (places - places[step]) / scales
    tangents = np.array([(1.0, a.rate) for a in window]) / scales * np.sign([[a.state.load_rate] for a in window])
    size = np.linalg.norm(places[step + 1])
    cosine, sine = places[step + 1] / size
    turn = np.array([(cosine, -sine), (sine, cosine)]) / size
    (x, y), (along, across) = (places @ turn).T, (tangents @ turn).T
    if not ((np.diff(x) > 0).all() and (np.abs(across) <= STEEPEST * along).all()):
        return None
    curve = KroghInterpolator(np.repeat(x, 2), np.column_stack((y, across / along)).ravel())
    at = (1 + GAUSS[0]) / 2
    height, slope = curve(at), curve.derivative(at)
    products, factors = size * (sine * at + cosine * height), size * (cosine - sine * slope)
    offset = window[step].product / scales[1]
    return float(scales[0] * scales[1] * (GAUSS[1] / 2 @ ((offset + products) * factors)))
