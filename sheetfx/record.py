"""A traced path and what can be asked of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from .continuation.balance import Balance, balance
from .continuation.state import CriticalPoint, State
from .discrete.linearised import LinearSolution
from .discrete.pair_work import PairState, pairs_of
from .discrete.plastic import PlasticState, is_plastic, plastic_share, plastic_state, plastic_stresses
from .discrete.reactions import Holds, Reaction, ReactionPath, joint_path
from .discrete.section_forces import SectionPoints, section_forces, section_points, value_at
from .events.search import state_at, step_of
from .mesh.reader import NamedMesh
from .model.stresses import stresses, transverse_shear
from .path import Path
from .show.animating import Animation
from .show.curves import draw_path
from .show.measure import Along, Measure
from .show.modes import picture_of_modes
from .show.pictures import picture_of_shapes
from .show.saving import MOVING, File, on_process_0, picture, require_ending
from .show.viewer import view_record

if TYPE_CHECKING:
    from .critical.branches import Branch
    from .critical.buckling import BucklingLoad
    from .critical.error_bar import ErrorBar
    from .critical.fall import FallStep
    from .critical.gradient import LoadGradient
    from .critical.snap import Snap
    from .critical.vibration import Vibration
    from .discrete.discretisation import Discretisation
    from .model.scene import Scene


@dataclass
class Record:
    """A traced path: its case (`case.Case`), its states and the discrete problem they belong to.

    Questions about stability leave the path where it is. Modules that need SLEPc are imported when first asked.

    Attributes
    ----------
    errors : error bars of critical points that have been asked for; pictures show them
    """

    case: Any
    path: Path
    states: list[State]
    errors: dict[CriticalPoint, ErrorBar] = field(default_factory=dict, repr=False)

    @property
    def _structure(self) -> Discretisation:
        """The scene's fields and system, which a plain form has not (its error says so)."""
        return cast("Discretisation", self.path.discretisation)

    @property
    def critical_points(self) -> list[CriticalPoint]:
        return [point for state in self.states for point in state.critical]

    def nearest(self, load: float) -> State:
        """The state whose load is closest to `load`."""
        return min(self.states, key=lambda s: abs(s.load - load))

    def state_at(self, point: CriticalPoint) -> State:
        """The state of a critical point itself, within the step that it was found in.

        Raises
        ------
        ArithmeticError
            If the path's search did not keep it, and it does not converge again.
        """
        known, tracer = self.path.critical_states, self.path.tracer
        if point not in known:
            before, after = step_of("state_at", self.states, point, len(tracer.x.array))
            present = tracer.state
            try:
                known[point] = state_at(tracer, before, after, point)
            finally:
                tracer.back_to(present)
        return known[point]

    def branches(self, point: CriticalPoint, amplitude: float = 0.05) -> list[Branch]:
        """A start on every half-branch of a bifurcation, see `critical.branches.branches`."""
        from .critical.branches import branches

        return branches(self.path, self.states, point, amplitude)

    def critical_modes(self, point: CriticalPoint) -> list[np.ndarray]:
        """Null vectors at a bifurcation or limit point, see `critical.shares.critical_modes`."""
        from .critical.shares import critical_modes

        return critical_modes(self.path, self.states, point, self.path.critical_states.get(point))

    def error_bars(self, points: Sequence[CriticalPoint] | None = None) -> list[ErrorBar]:
        """Discretisation errors of the loads of critical points, see `critical.error_bar`.

        Parameters
        ----------
        points : of this record; None: all but events
        """
        chosen = [p for p in self.critical_points if p.kind != "event"] if points is None else points
        found = self._bars(chosen)
        self.errors |= {bar.point: bar for bar in found}
        return found

    def loads_on(self, scene: Scene, points: Sequence[CriticalPoint]) -> list[ErrorBar]:
        """Loads of critical points less those on another discretisation of the structure, as bars."""
        return self._bars(points, scene)

    def _bars(self, points: Sequence[CriticalPoint], scene: Scene | None = None) -> list[ErrorBar]:
        from .richer_path import error_bars_of

        return error_bars_of(self.path, self.states, points, self.state_at, self.critical_modes, scene)

    def gradient(self, point: CriticalPoint, scene: Callable[[float], Scene], at: float,
                 step: float | None = None) -> float | np.ndarray:
        """Derivative of the load of a critical point by a number of the scene, see `critical.gradient.LoadGradient`.

        ```python
        record.gradient(point, lambda t: fx.remade(scene, {plate: fx.Plate(t)}), at=plate.thickness)
        ```
        """
        return self.load_gradient(point).derivative(scene, at, step)

    def load_gradient(self, point: CriticalPoint) -> LoadGradient:
        """Derivatives of the load of a critical point by many numbers of the scene."""
        from .critical.gradient import LoadGradient

        modes = self.critical_modes(point) if point.kind == "bifurcation" else ()
        return LoadGradient(self.path, point, self.state_at(point), modes, self.states)

    def energy_shares(self, modes: Sequence[np.ndarray]) -> list[float]:
        """Shares of the parts, in the scene's order, in the strain energy of modes, see `critical.shares`."""
        from .critical.shares import energy_shares

        return energy_shares(self.path, self.states[0], modes)

    @cached_property
    def _last_buckling(self) -> list[BucklingLoad]:
        return self.case.buckling(self.path, self.states[-1])

    def buckling(self, state: State | None = None, **options) -> list[BucklingLoad]:
        """Linear buckling loads about a state, see `critical.buckling.buckling`.

        Without a state the case's about the last one, found when first asked for.
        """
        if state is None and not options:
            return self._last_buckling
        from .critical.buckling import buckling

        return buckling(self.path, state or self.states[-1], **options)

    def linear(self, factor: float = 1.0) -> LinearSolution:
        """The linear solution about the first state of the last stage, at a load factor, with all its results.

        Raises
        ------
        ValueError
            If loads of a free body are not in equilibrium.
        """
        first = next(state for state in self.states if state.stage == self.states[-1].stage)
        present = self.path.tracer.state
        self.path.tracer.back_to(first)
        words = self.path.discretisation.unbalanced(self.path.tracer.load_vector())
        self.path.tracer.back_to(present)
        if words:
            raise ValueError(words)
        return LinearSolution(self, first, factor)

    def frequencies(self, state: State | None = None, count: int = 6) -> list[Vibration]:
        """Lowest free vibrations about a state (default the last), see `critical.vibration.frequencies`."""
        from .critical.vibration import frequencies

        return frequencies(self.path, state or self.states[-1], count)

    def snap(self, state: State, hold: str = "load", side: int = 1,
             listener: Callable[[FallStep], None] | None = None) -> Snap:
        """The stable state that the structure falls into from an unstable one, see `critical.snap.snap`."""
        from .critical.snap import snap

        return snap(self.path, state, hold, side, listener)

    def curve(self, file: File | None = None) -> Any:
        """The figure of load against deflection, as path.png of a run.

        Parameters
        ----------
        file : .png, .svg or .pdf that it is saved in too

        Returns
        -------
        a figure of matplotlib, on process 0; None elsewhere
        """
        def collected():
            figure = draw_path(self)
            return lambda: figure

        return picture("curve", self, collected, file)

    def shapes(self, file: File | None = None, along: Along = None) -> Any:
        """The figure of deformed shapes at critical points and at the end, as shape.png of a run, see `curve`.

        Parameters
        ----------
        along : direction "x", "y" or "z", or a vector, along which displacements colour all parts of surfaces and of
            curves in space; None: their size
        """
        return picture("shapes", self, lambda: picture_of_shapes(self, Measure(along)), file)

    def modes(self, file: File | None = None, along: Along = None) -> Any:
        """The figure of the linear buckling modes about the last state, as modes.png of a run, see `shapes`."""
        return picture("modes", self, lambda: picture_of_modes(self, Measure(along)), file)

    def animate(self, file: File, along: Along = None) -> None:
        """Write a .gif of the motion along the path, see `shapes`."""
        require_ending("animate", file, MOVING)
        moving = Animation.of(self, Measure(along))
        on_process_0(self, lambda: moving.savefig(file))

    def view(self, file: File | None = None, along: Along = None) -> Any:
        """Open a view that can be turned, with a slider for the states, see `show.viewer.view_folder`."""
        return view_record(self, along, file)

    def show(self, state: State) -> None:
        """Put all fields to a state's, for evaluation and pictures."""
        self.path.discretisation.system.restore(state.fields)

    def displacement(self, at: str, mesh: NamedMesh | None = None) -> np.ndarray:
        """Displacement of a named point in the shown state, the same on all processes.

        Parameters
        ----------
        mesh : that has the point; None: the first one that does
        """
        mesh = mesh or self._model_with(at)
        return self._structure.kinematics(mesh).displacement(mesh, at)

    def rotation(self, at: str, mesh: NamedMesh | None = None) -> float | np.ndarray:
        """Rotation of a named point in the shown state: an angle in the plane, a unit quaternion in space.

        Raises
        ------
        ValueError
            If its parts have no rotation.
        """
        mesh = mesh or self._model_with(at)
        return self._structure.kinematics(mesh).turned(mesh, at)

    def _model_with(self, at: str) -> NamedMesh:
        meshes = self.case.scene.meshes
        return next((m for m in meshes if at in (*m.points, *m.edges)), meshes[0])

    def forces(self, part) -> np.ndarray:
        """Stress resultants of a part in the shown state, on this process, see `discrete.section_forces`.

        Returns
        -------
        array, shape (cells, points, resultants), in the order of the strains of the part: for a beam in the plane
        axial force, shear force, moment; for a shell forces, moments and shear forces per length.
        """
        return section_forces(self._structure, part)

    def section_points(self, part) -> SectionPoints:
        """Where `forces` and `stresses` are evaluated in the shown state, and along which axes they act."""
        return section_points(self._structure, part)

    def value_at(self, part, values: np.ndarray, at: str | Sequence[float]) -> np.ndarray:
        """Forces, stresses or other values at the points of a part, at a named point or a place, see `section_forces`.

        ```python
        record.value_at(plate, record.stresses(plate, at=0.5), (10.0, 0.0, 0.0))
        ```
        """
        return value_at(self._structure, part, values, at)

    def stresses(self, part, at: float | Sequence[float] = 0.0) -> np.ndarray:
        """Stresses of a part in the shown state at a height or fibre, see `model.stresses.stresses`.

        Of a plastic part at the nearest layer or fibre, on this process at its points of integration.
        """
        if is_plastic(part):
            return plastic_stresses(self._structure, part, at)
        return stresses(part, self.forces(part), at) + self._structure.fields.residual_stresses(part, at)

    def transverse_shear(self, part, at: float = 0.0) -> np.ndarray:
        """Shear stresses between layers in the shown state, from equilibrium, see `model.stresses.transverse_shear`."""
        return transverse_shear(part, self.forces(part), at)

    @cached_property
    def _holds(self) -> Holds:
        return Holds(self._structure)

    def reactions(self, of: Any, about: Sequence[float] | None = None) -> ReactionPath:
        """Forces and moments that supports and prescribed motions exert on the modelled structure, in all states.

        Parameters
        ----------
        of : a Support, a PrescribedDisplacement or PrescribedRotation, or the name of a place: all that hold it
        about : fixed place that moments are about; None: the middle of the nodes held, where they are in each state
        """
        return self._holds.along([state.fields for state in self.states], of, about)

    def joint_forces(self, joint, on: NamedMesh | None = None, about: Sequence[float] | None = None) -> ReactionPath:
        """Force and moment that a joint exerts on its second part, in all states: of a weld, bolt, spring or contact.

        Parameters
        ----------
        on : mesh of another part that it joins; None: its second part's
        about : fixed place that moments are about; None: the middle of the nodes that it acts on
        """
        return joint_path(self._structure, [state.fields for state in self.states], joint, on, about)

    def shown_reactions(self) -> list[tuple[Any, Reaction]]:
        """Of each support and prescribed motion in the shown state, node by node, see `discrete.reactions`."""
        return self._holds.reactions()

    def plastic(self, part) -> PlasticState:
        """Where a plastic part has flowed in the shown state, on this process, see `discrete.plastic`."""
        return plastic_state(self._structure, part)

    def plastic_share(self) -> float:
        """Share of the volume of all plastic parts that has flowed in the shown state, on all processes."""
        return plastic_share(self._structure)

    def pairs(self, contact) -> PairState:
        """State of the pairs of a `PairContact` in the shown state, the same on all processes."""
        works = [w for w in pairs_of(self._structure.system.contributions) if w.contact is contact]
        if not works:
            raise ValueError(f"pairs: {type(contact).__name__} is no contact of pairs of this scene; give one of its "
                             "joints that is a PairContact")
        return works[0].evaluate()

    def balance(self, accuracy: float | None = None) -> Balance:
        """Energies in all states against the work of the loads, see `continuation.balance`.

        Parameters
        ----------
        accuracy : of the work over the largest energy, such as 1e-6; takes more states, within steps that are long.
            None: what the states tell as they are. The energy of a section law is exact up to degree five; of laws of
            one's own that bend more it may be off by some millionths
        """
        return balance(self.path.tracer, self.states, accuracy)

    def energies(self) -> list[float]:
        """Strain energy that each part of the scene, in their order, stores in the shown state."""
        return [self._structure.strain_energy(part) for part in self.case.scene.parts]
