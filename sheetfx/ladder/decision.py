"""What a climb decides, what it ends with, and the errors that it has estimated."""

from __future__ import annotations

from dataclasses import dataclass

from .left_out import LeftOut


@dataclass(frozen=True)
class Decision:
    """What was left out of the model or not, and why.

    Attributes
    ----------
    about : "contact", "friction", "plasticity", "symmetry", "layers and steps", "mesh" or "path"
    decided : such as "left out", "needed", "kept", "enough"
    because : the figures, in words
    worth : change of the load by it, over the load; None: not known
    """

    about: str
    decided: str
    because: str
    worth: float | None = None

    def __str__(self) -> str:
        worth = f" (worth {self.worth:+.1%})" if self.worth else ""
        return f"{self.about} {self.decided}: {self.because}{worth}"


@dataclass(frozen=True)
class Estimate:
    """Error of a load by its discretisation.

    Attributes
    ----------
    error : the load less an ever finer mesh's
    doubt : of that difference, on both sides
    because : the figures, in words
    """

    error: float
    doubt: float
    because: str

    def __add__(self, other: Estimate) -> Estimate:
        return Estimate(self.error + other.error, self.doubt + other.doubt, f"{self.because}; {other.because}")


@dataclass(frozen=True)
class Advice:
    """The least model that a critical load needs, and the load by it.

    Attributes
    ----------
    load : of the first critical point, or the largest one up to the end of the path where it has none, less its
        estimated error; None: the path stops before
    interval : in which the load of the whole model on an ever finer mesh should lie; None likewise
    kind : of the point, in words
    reached : whether the interval is as narrow as asked for
    left : names of the things left out
    level : of the meshes
    mesh : in words
    doubled : how often layers or fibres of plastic parts, and steps, are doubled in number
    decisions : in their order
    cpu_seconds : spent, of this process
    """

    load: float | None
    interval: tuple[float, float] | None
    kind: str
    reached: bool
    left: LeftOut
    level: int
    mesh: str
    doubled: int
    decisions: tuple[Decision, ...]
    cpu_seconds: float

    def __str__(self) -> str:
        if self.load is None or self.interval is None:
            return "no critical load: " + str(self.decisions[-1])
        half = (self.interval[1] - self.interval[0]) / 2
        share = f"{half / abs(self.load):.1%}" if self.load else "no share of it"
        return (f"{self.kind} at load {self.load:.6g} +- {half:.2g} ({share}"
                f"{'' if self.reached else ', wider than asked for'}), {self.left.words}, {self.mesh}; "
                f"{self.cpu_seconds:.1f} s of CPU time")
