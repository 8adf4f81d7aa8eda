"""A case: a scene, the control of its path, and its reports."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path as Folder
from typing import TYPE_CHECKING, Any

from mpi4py import MPI

from .archive.folder import Archive
from .checks import Positive, check, require
from .continuation.control import ArcLength, StepRule
from .continuation.state import CriticalPoint, State
from .critical.defining import without_third_variations
from .critical.verdict import doubts
from .events.event import Event
from .model.reported import AXES, NOT_ASKED, counted, meaning
from .model.scene import Scene
from .notices import warn
from .path import Path, PathFailure, Until
from .record import Record
from .show.standard import STANDARD

if TYPE_CHECKING:
    from .critical.buckling import BucklingLoad

FREE = 40  # factorisations of a path for each critical point, whose error bars then come at a quarter of its time
PARTS = ("compile", "assembly", "factorisation", "solve", "contact", "path", "output")


def _linear_buckling(path: Path, state: State) -> list[BucklingLoad]:
    """`critical.buckling.buckling`, imported when first asked for: SLEPc starts slowly."""
    from .critical.buckling import buckling

    return buckling(path, state)


@dataclass(frozen=True, eq=False)
class Case:
    """What `sheetfx run` needs to know.

    Attributes
    ----------
    scene : Scene
    control : of the path
    until : end of the path
    quantities : function (record) -> name and value of what the scene is known for
    pictures : functions (record, folder), each draws one picture; what it writes moves to the run's folder when it
        is whole. By default curve, shapes, files for ParaView, and with `Until(steps=0)` buckling modes
    axes : names of deflection and load on plots; None: in mm and N, with what the load is
    mixed_points : large-step tangent
    buckling : function (path, state) -> buckling loads, for `Record.buckling`; with `Until(steps=0)` they are those
        of the unloaded structure and the only result
    events : what the path looks for beside limit points and bifurcations
    balance : accuracy of the energy balance that a run tells, see `Record.balance`
    error : whether a run gives critical loads error bars, see `critical.error_bar`; None: where that costs at most
        about a quarter of the path, at FREE factorisations of the path for each point
    snaps : whether the structure falls where it has lost its stability, and the path goes on from there, see `Path`
    """

    scene: Scene
    control: StepRule = field(default_factory=ArcLength)
    until: Until = field(default_factory=Until)
    quantities: Callable[[Record], dict[str, float]] = lambda record: {}
    pictures: Sequence[Callable[[Record, Folder], None]] = STANDARD
    axes: tuple[str, str] | None = None
    mixed_points: bool = True
    buckling: Callable[[Path, State], list] = _linear_buckling
    events: Sequence[Event] = ()
    balance: Positive | None = None
    error: bool | None = None
    snaps: bool = False

    def __post_init__(self):
        check(self)
        if self.axes is None:
            object.__setattr__(self, "axes", ("deflection (mm)", AXES[counted(self.scene.loads)[0]]))


@dataclass(frozen=True)
class Followed:
    """What a record asks of a case, of a path that has been made without one.

    Attributes
    ----------
    path : Path
    axes : names of deflection and load on plots
    """

    path: Path
    axes: tuple[str, str] = ("monitored value", "load factor")

    @property
    def scene(self) -> Any:
        return self.path.scene

    @property
    def until(self) -> Until:
        return self.path.until

    def buckling(self, path: Path, state: State) -> list[BucklingLoad]:
        return _linear_buckling(path, state)


def trace(case: Case | Path, listeners: Sequence[Callable[[State], None]] = (), start: Sequence[State] = (),
          archive: Archive | None = None, enough: Callable[[Record], bool] = lambda record: False) -> Record:
    """Trace a path to its end.

    Parameters
    ----------
    case : Case, or a path, as `fx.continuation` gives
    listeners : called with every new state
    start : states of an interrupted run of the same case
    archive : keeps every new state
    enough : whether the path so far, which ends there, is all that is asked for

    Raises
    ------
    PathFailure
        With the attribute `record`, the path so far.
    """
    path = case if isinstance(case, Path) else Path(case.scene, case.control, case.until, start=start,
                                                    mixed_points=case.mixed_points, events=case.events,
                                                    snaps=case.snaps)
    record = Record(Followed(path) if case is path else case, path, path.start)
    if archive:
        archive.keep_origins(path.discretisation.system.origins())
        path.subscribe(archive)
    for listener in listeners:
        path.subscribe(listener)
    try:
        for state in path:
            record.states.append(state)
            if enough(record):
                break
    except PathFailure as failure:
        failure.record = record
        raise
    finally:
        for doubt in doubts(path.discretisation, record.states):
            warn(doubt)
    return record


def run(case: Case, name: str, parameters: dict, folder: Folder, resume: bool,
        listeners: Sequence[Callable[[State], None]] = (),
        further: Callable[[Record], dict[str, Any]] | None = None,
        bars: Callable[[Record], Any] = Record.error_bars) -> dict:
    """Trace a case, write its folder and return its summary.

    Parameters
    ----------
    further : what else the summary is to have
    bars : makes error bars of a record

    Raises
    ------
    ValueError
        Where the folder holds files of others or another run; to resume, also a run of another scene, of other
        parameters or of another command.
    """
    archive = Archive(folder, MPI.COMM_WORLD)
    with archive.opened({"command": "run", "scene": name} | parameters, resume) as start:
        try:
            record = trace(case, listeners, start, archive)
            status, message = "finished", record.path.message
        except PathFailure as failure:
            record, status, message = failure.record, "stopped", str(failure)
        clock = record.path.clock
        if case.error or (case.error is None and _is_cheap(record)):
            bars(record)
        quantities = case.quantities(record)
        require("Case", **{"what quantities returns": (quantities, Mapping[str, Any])})
        with clock("output"):
            energy = record.balance(case.balance)
            for picture in case.pictures:
                with archive.drawing() as unfinished:
                    picture(record, unfinished)
        summary = {
            "scene": name, "parameters": parameters, "axes": case.axes,
            "load": meaning(counted(case.scene.loads)[0], case.scene.symmetry_factor),
            "stages": [stage.name for stage in case.scene.all_stages],
            "status": status, "message": message,
            "unknowns": record.path.unknowns, "steps": record.states[-1].step,
            "iterations": sum(s.iterations for s in record.states),
            "factorisations": sum(s.factorisations for s in record.states),
            "searched": record.path.searched,
            "critical_points": [vars(p) | _error_of(record, p) for p in record.critical_points],
            "quantities": quantities, "energy": energy.summary(),
            "timings": {part: clock.seconds[part] for part in PARTS} | {"total": clock.total},
        }
        _write(archive, summary)
        if further:
            summary |= further(record)
            _write(archive, summary)
    if energy.broken:
        warn(energy.broken)
    return summary


def _write(archive: Archive, summary: dict) -> None:
    if archive.comm.rank == 0:
        archive.write_json("summary.json", summary)


def _is_cheap(record: Record) -> bool:
    """Whether error bars cost at most about a quarter of the path, which pieces of another path never do."""
    spent = sum(state.factorisations for state in record.states)
    count = len([p for p in record.critical_points if p.kind != "event"])
    return not without_third_variations(record.path.discretisation.system) and 0 < FREE * count <= spent


def _error_of(record: Record, point: CriticalPoint) -> dict:
    """What a summary says of the error of a critical load."""
    bar = record.errors.get(point)
    if bar is None:
        return {"error": None, "error_reason": "an event has none" if point.kind == "event" else NOT_ASKED}
    return {"error": bar.error, "error_reason": bar.reason}
