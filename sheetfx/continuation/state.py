"""A converged state of a path, which knows how to write and read itself."""

from __future__ import annotations

import json
import os
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any

import numpy as np

ARRAYS = "increment", "response", "fields", "scene"  # of a state, which are not among the numbers of its file
RENAMED = {"unstable": "unstable_modes", "determinant": "determinant_sign"}  # in files of version 0.1


@dataclass(frozen=True)
class CriticalPoint:
    """A point of a path where stability changes.

    Attributes
    ----------
    kind : "limit" (the load has an extremum), "bifurcation", "flutter" (two frequencies meet, see
        `critical.flutter`), or "event" (of one's own, see `events.event`)
    load : total load on the whole structure
    deflection : of the monitored point
    step : number of the step that the point lies in
    length : of that step up to the point, in the measure of the control
    multiplicity : number of null vectors of the tangent
    name : "maximum" or "minimum" of the load; "asymmetric", "stable symmetric", "unstable symmetric" or "multiple"
        bifurcation, "comparison solid" where points have yielded (Hill 1958: the tangent is that of loading), "corner"
        where something begins or ceases to touch or to slip, and eigenvalues jump past zero; "begins" or "ends" of
        flutter; the name of an event; "" where the tangent is not symmetric or there is contact, and the energy has no
        variations, and where these vanish up to the fourth, so that the load of the branch only rounds
    slope, curvature : Koiter's a and b of a simple bifurcation, factor = critical factor (1 + a xi + b xi^2), where the
        load factor is that of forces or of a prescribed motion, and xi is the mode's largest displacement, its largest
        component being positive; None: not known
    spread : loads between which bifurcations lie that could not be told apart, of which `multiplicity` is the least
        number and `load` about their middle; or between which an event happens and nothing converges, `load` being that
        of the state behind; None: the load is exact
    """

    kind: str
    load: float
    deflection: float
    step: int
    length: float = 0.0
    multiplicity: int = 1
    name: str = ""
    slope: float | None = None
    curvature: float | None = None
    spread: tuple[float, float] | None = None

    def __str__(self) -> str:
        return f"{self.title} at load {self.load:.6g}, deflection {self.deflection:.6g}"

    @property
    def title(self) -> str:
        """Kind and name in words, for example "limit point (maximum)"."""
        between = "between the loads {:.8g} and {:.8g}".format(*self.spread) if self.spread else ""
        if self.kind == "event":
            return self.name + (f" ({between})" if between else "")
        if between:
            where = "at a corner" if self.name == "corner" else "not told apart"
            return f"{self.kind} points (at least {self.multiplicity}, {where}, {between})"
        name = f"{self.multiplicity}-fold" if self.multiplicity > 1 else self.name
        return f"{self.kind} point" + (f" ({name})" if name else "")


class ForeignState(ValueError):
    """A state of another run."""


def write_arrays(file: Path, **arrays) -> None:
    """Write a NumPy archive that appears complete or not at all."""
    part = file.with_suffix(".part")
    try:
        with part.open("wb") as stream:
            np.savez(stream, **arrays)
        os.replace(part, file)
    except OSError as error:
        part.unlink(missing_ok=True)
        error.filename = error.filename or str(file)
        raise


@dataclass(frozen=True)
class State:
    """A converged state.

    Attributes
    ----------
    step : number, 0 for the start
    stage : number of the load stage that it is in, 0 where the scene has one only
    factor : load factor of that stage
    load : total load of that stage on the whole structure
    deflection : monitored displacement
    unstable_modes : negative eigenvalues of the tangent, the multipliers' aside; None: not symmetric, not known
    determinant_sign : sign of the tangent's determinant, where multipliers do not count; None: not known
    load_rate : load component of the unit tangent along the path
    iterations, factorisations : of the step that led here, failed tries included
    hardest : most iterations of one Newton solution in its last try
    length, next_length : of that step and the next; 0: the first of the control
    load_sense : 1 or -1, in which the load has changed last by more than it is exact; 0: it has not yet
    load_increment, increment : of that step (increment: this process's part of the solver's vector)
    response : displacement by a unit of load, with the tangent of the step that led here
    current_stiffness : Bergan's current stiffness parameter
    displacement_extremes : number of its sign changes through infinity so far
    reference : squared norm of the first response, and its work; where a load only stresses it, a weight, and 0
    contact_points, penetration : points that touch and largest penetration
    apart : whether contacts do nothing, nor would after a small motion
    forgotten, astray : share of the resultants that laws with history forget of the step's way, and how far that has
        led off the path, over the length of the step, see `continuation.lapse`
    critical : critical points that this state brought to light, in its step or the one before
    fields : values of all fields on this process
    scene : that the state belongs to; None: not known, as of a file
    """

    step: int
    factor: float
    load: float
    deflection: float
    unstable_modes: int | None
    determinant_sign: int | None
    load_rate: float
    iterations: int
    hardest: int
    factorisations: int
    length: float
    next_length: float
    load_increment: float
    current_stiffness: float
    reference: tuple[float, float]
    displacement_extremes: int = 0
    contact_points: int = 0
    penetration: float = 0.0
    apart: bool = False
    forgotten: float = 0.0
    astray: float = 0.0
    load_sense: float = 0.0
    stage: int = 0
    critical: tuple[CriticalPoint, ...] = ()
    increment: np.ndarray = field(repr=False, default=None)
    response: np.ndarray = field(repr=False, default=None)
    fields: dict[str, np.ndarray] = field(repr=False, default_factory=dict)
    scene: Any = field(repr=False, compare=False, default=None)

    def __str__(self) -> str:
        modes = f", {self.unstable_modes} unstable modes" if self.unstable_modes else ""
        return f"step {self.step} at load {self.load:.6g}, deflection {self.deflection:.6g}{modes}"

    @property
    def least_weight(self) -> float:
        """Square of the load's weight in lengths, where it only stresses the first state (which then does no work)."""
        norm2, work = self.reference
        return 0.0 if work else norm2

    @property
    def direction(self) -> tuple[float, np.ndarray]:
        """Increments of load factor and unknowns that led here."""
        return self.load_increment, self.increment

    @property
    def tangent(self) -> tuple[float, np.ndarray]:
        """Rates of load factor and unknowns along the path."""
        return self.load_rate, self.load_rate * self.response

    def on(self, scene: Any) -> State:
        """The state on another mesh, degree or model of its structure, see `continuation.transferred.transferred`.

        ```python
        finer = fx.critical(fine, found.state.on(fine))
        ```
        """
        from .transferred import transferred

        return transferred(self, scene)[0]

    def save(self, file: Path, run: str = "", processes: int = 1) -> None:
        """Write to a NumPy archive; the file appears complete or not at all.

        Parameters
        ----------
        run : what states of one run have in common; "": not known
        processes : number of those that have a part of the state
        """
        numbers = {f.name: getattr(self, f.name) for f in fields(self) if f.name not in ARRAYS}
        numbers["critical"] = [asdict(point) for point in self.critical]
        write_arrays(file, numbers=json.dumps(numbers), run=run, processes=processes, increment=self.increment,
                     response=self.response, **{f"field {k}": v for k, v in self.fields.items()})

    @classmethod
    def load_from(cls, file: Path, run: str = "") -> State:
        """Read what `save` wrote, see `load_part`."""
        return cls.load_part(file, run)[0]

    @classmethod
    def load_part(cls, file: Path, run: str = "") -> tuple[State, int]:
        """Read what `save` wrote: the state and how many processes have a part of it (0: an older version's file).

        Raises
        ------
        ForeignState
            Where it belongs to another run than the one that is given.
        """
        with np.load(file) as archive:
            if run and "run" in archive.files and run != str(archive["run"]):
                raise ForeignState(f"{file} is of another run")
            processes = int(archive["processes"]) if "processes" in archive.files else 0
            numbers = json.loads(str(archive["numbers"]))
            fields = {k.removeprefix("field "): archive[k] for k in archive.files if k.startswith("field ")}
            vectors = {k: archive[k] for k in ("increment", "response")}
        numbers = {RENAMED.get(name, name): value for name, value in numbers.items()}
        numbers["critical"] = tuple(CriticalPoint(**c | {"spread": c.get("spread") and tuple(c["spread"])})
                                    for c in numbers["critical"])
        numbers["reference"] = tuple(numbers["reference"])
        fields.setdefault("load", np.array([0, numbers["factor"]]))  # files of version 0.1 have it in the numbers only
        return cls(**numbers, **vectors, fields=fields), processes
