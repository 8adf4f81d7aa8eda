"""From a scene to a discrete system: fields, virtual work, supports."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import scifem
import ufl
from dolfinx import fem
from mpi4py import MPI

from .. import forms
from ..compat import JIT
from ..continuation.enforcement import Enforcement
from ..continuation.state import State
from ..mesh.numbers import lift_numbers
from ..mesh.reader import COMPONENTS, Model
from ..model.beam import Bar, Beam
from ..model.loads import EdgeForce, LineForce, Moment, Motion, PointForce, Pressure, Push, SurfaceForce
from ..model.scene import Contact, Monitor, Scene
from .contact import ContactFields
from .kinematics import Kinematics, kinematics_of
from .supports import fixed_places, turn_nodes
from .system import System
from .timing import Stopwatch
from .unknowns import AdditiveField, Block, Unknowns


class Discretisation:
    """Fields and system of a scene.

    Attributes
    ----------
    system : System
    contacts : list of ContactFields
    """

    def __init__(self, scene: Scene, mixed_points: bool = True):
        self.scene = scene
        self.factor = ufl.variable(fem.Constant(scene.parts[0].model.mesh, 0.0))
        self._kinematics = {p.model: kinematics_of(p.model, *p.spaces) for p in scene.parts}
        blocks = [k.block for k in self._kinematics.values()]
        for model, k in self._kinematics.items():
            turn_nodes(k, [s for s in scene.supports if s.model is model])
        self._travels = self._obstacle_travels(blocks)
        self._reactions = self._motion_reactions(blocks)
        self.contacts = [ContactFields(c, f"multiplier{i}") for i, c in enumerate(scene.contacts)]
        blocks += [c.block for c in self.contacts if c.block is not None]
        self.unknowns = Unknowns(blocks)
        self.clock = Stopwatch()
        self._close_contacts()
        fixed = [self._fixed(b) for b in blocks]
        for block, dofs in zip(blocks, fixed, strict=True):
            self._chart_supported_nodes(block, dofs)
        fields = [(part, self.kinematics(part.model)) for part in scene.parts]
        internal = [part.internal(k.u, k.total_rotation) for part, k in fields]
        self.system = System(
            self.unknowns, self.factor, internal, self._work(),
            nodal=self._nodal_loads(blocks),
            fixed=fixed,
            symmetric=not any(c.friction for c in scene.contacts) and not any(_turning(load) for load in scene.loads),
            mixed_points=mixed_points, clock=self.clock,
        )
        self._reaction_forms = [fem.form(r * load.model.facet_measure(load.at), jit_options=JIT)
                                for load, r in self._reactions.items()]
        self._unit_load = sum(self._magnitude(load) for load in scene.loads)
        self.enforcement = Enforcement(self.contacts, self.clock)

    def kinematics(self, model: Model) -> Kinematics:
        return self._kinematics[model]

    def travel(self, obstacle):
        """Displacement vector of an obstacle, as UFL components."""
        if obstacle not in self._travels:
            return [0.0, 0.0]
        return [self._travels[obstacle] * c for c in obstacle.travel]

    def _obstacle_travels(self, blocks) -> dict:
        travels = {}
        for contact in self.scene.contacts:
            obstacle = contact.obstacle
            if obstacle.travel is not None and obstacle not in travels:
                model = contact.beam.model
                travels[obstacle] = self._real(model, f"travel{len(travels)}", model.size, blocks)
        return travels

    def _motion_reactions(self, blocks) -> dict:
        """For each prescribed motion its reaction: a force at the point, or forces per length of the edge."""
        reactions, motions = {}, [load for load in self.scene.loads if isinstance(load, Motion)]
        for load in motions:
            element = self.kinematics(load.model).u.function_space.ufl_element().sub_elements[0]
            space = fem.functionspace(load.model.mesh, element)
            reactions[load] = self._unknown(space, f"reaction{len(reactions)}", np.inf, True, blocks)
        return reactions

    def _real(self, model, name, scale, blocks) -> fem.Function:
        """A single number as an unknown."""
        return self._unknown(scifem.create_real_functionspace(model.mesh), name, scale, False, blocks)

    @staticmethod
    def _unknown(space, name, scale, multiplier, blocks) -> fem.Function:
        """A field with a block of its own."""
        value = fem.Function(space, name=name)
        dofs = np.arange(len(value.x.array))
        blocks.append(Block(space, (AdditiveField(value, dofs, scale, multiplier),)))
        return value

    def position(self, contact: Contact):
        """Current position of the points of a beam that may touch."""
        beam, frame = contact.beam, contact.beam.frame()
        k = self.kinematics(beam.model)
        x = ufl.SpatialCoordinate(beam.model.mesh) + k.u
        if contact.half_depth:
            x = x + contact.half_depth * beam.section.depth / 2 * k.rotation.rotate(frame.normal)
        return x

    def _close_contacts(self) -> None:
        """Express gaps in the fields; refuse obstacles that start inside, move free ones to first touch."""
        for c in self.contacts:
            contact, model = c.contact, c.contact.beam.model
            c.close(self.position(contact), self.travel(contact.obstacle), self._before)
            with self.clock("compile"):
                c.prepare(self.unknowns.at_rest)
            smallest = model.mesh.comm.allreduce(float(c.evaluate().gap.min(initial=np.inf)), op=MPI.MIN)
            if smallest < -1e-6 * contact.beam.section.depth:
                raise ValueError(
                    f"{type(contact.obstacle).__name__}: starts {-smallest:.4g} inside the structure; "
                    "move its centre or point out of it")
            if contact.obstacle in self._travels:
                travel = self._travels[contact.obstacle]
                travel.x.array[:] = max(travel.x.array[0], smallest + 1e-9 * model.size)

    def _before(self, expression):
        return self.unknowns.at_rest(self.unknowns.previous(ufl.as_ufl(expression)))

    def _work(self):
        work = [c.work(self.unknowns.vary) for c in self.contacts]
        work += [self._load_work(x) for x in self.scene.loads if not _nodal(x)]
        return sum(work) if work else None

    def _nodal_loads(self, blocks) -> list[np.ndarray]:
        """Forces and moments at points for a load factor of 1, for each block."""
        loads = [fem.Function(b.space).x.array for b in blocks]
        for load in filter(_nodal, self.scene.loads):
            k = self.kinematics(load.model)
            array = loads[blocks.index(k.block)]
            force = load.force if isinstance(load, PointForce) else np.atleast_1d(load.moment)
            turns = isinstance(load, Moment)
            names = [c for c in COMPONENTS[load.model.dimension] if c.startswith("r") == turns]
            for component, value in zip(names, force, strict=True):
                array[k.point_dofs(load.model, load.at, component)] += value
        return loads

    def _load_work(self, load):
        vary, factor = self.unknowns.vary, self.factor
        match load:
            case EdgeForce():
                k = self.kinematics(load.model)
                work = forms.load.dead_force(factor * forms.vector(load.force), k.u, vary)
                return -work * load.model.facet_measure(load.at)
            case Moment():
                spin = self.kinematics(load.model).spin
                moment = factor * forms.vector(load.moment)
                return -forms.load.spin_moment(moment, vary(spin)) * load.model.facet_measure(load.at)
            case LineForce():
                return -self._line_work(load)
            case SurfaceForce() | Pressure():
                return -self._surface_work(load)
            case Push():
                model, measure = self._touchable(load.obstacle)
                return -factor * load.force / model.measure * vary(self._travels[load.obstacle]) * measure
            case Motion():
                k = self.kinematics(load.model)
                index = COMPONENTS[load.model.dimension].index(load.component)
                error = k.u[index] - factor * load.distance
                return vary(self._reactions[load] * error) * load.model.facet_measure(load.at)
        raise TypeError(f"Scene: {load!r} is not a load")

    def _line_work(self, load: LineForce):
        beam = load.beam
        k = self.kinematics(beam.model)
        force = [self.factor * c for c in load.components()]
        if load.follower:
            density = forms.load.follower_force(force, beam.frame(), k.rotation, k.u, self.unknowns.vary)
        else:
            density = forms.load.dead_force(forms.vector(force), k.u, self.unknowns.vary)
        return density * _along(beam)

    def _surface_work(self, load: SurfaceForce | Pressure):
        shell = load.shell
        u = self.kinematics(shell.model).u
        if isinstance(load, Pressure):
            frame = forms.shell.surface_frame(shell.model.mesh)
            density = forms.load.pressure(self.factor * load.pressure, u, frame, self.unknowns.vary)
        else:
            density = forms.load.dead_force(self.factor * forms.vector(load.force), u, self.unknowns.vary)
        return density * shell.model.integral({"quadrature_degree": 2 * shell.discrete.displacement[1]}, shell.group)

    def _touchable(self, obstacle):
        """A model that an obstacle may touch, and the measure over all its curves."""
        beam = next(c.contact.beam for c in self.contacts if c.contact.obstacle is obstacle)
        return beam.model, beam.model.integral({"quadrature_degree": 2 * beam.degree - 1})

    def _chart_supported_nodes(self, block: Block, fixed: np.ndarray) -> None:
        """Let rotations of which one component is fixed be followed by their Rodrigues vector."""
        for field in block.fields:
            if field.curved:
                field.charted = np.isin(field.dofs, fixed).reshape(-1, field.width).sum(axis=1) == 1

    def _fixed(self, block: Block) -> np.ndarray:
        dofs = [np.empty(0, dtype=np.int32)]
        for model, k in self._kinematics.items():
            if k.block is block:
                dofs += [fixed_places(k, support) for support in self.scene.supports if support.model is model]
        for load, reaction in self._reactions.items():
            if block.space is reaction.function_space:
                dofs.append(self._without_reaction(load, block.space))
        return np.unique(np.concatenate(dofs))

    def _without_reaction(self, load: Motion, space) -> np.ndarray:
        """Nodes off the point or edge of a prescribed motion, and those that a support holds."""
        held = [fem.locate_dofs_topological(space, *load.model.at(support.at)) for support in self.scene.supports
                if support.model is load.model and support.axes is None and load.component in support.fixed.split()]
        count = space.dofmap.index_map.size_local + space.dofmap.index_map.num_ghosts
        moved = np.setdiff1d(fem.locate_dofs_topological(space, *load.model.at(load.at)), np.concatenate([[], *held]))
        return np.setdiff1d(np.arange(count, dtype=np.int32), moved)

    def monitored(self, monitor: Monitor):
        """The monitored field, and its local place (owned by one process, empty elsewhere)."""
        if monitor.at is None:
            value = self._travels[monitor.on]
            block = next(b for b in self.unknowns.blocks if b.fields[0].value is value)
            return block, np.arange(block.space.dofmap.index_map.size_local)
        k = self.kinematics(monitor.on)
        return k.block, k.point_dofs(monitor.on, monitor.at, monitor.component)

    def _magnitude(self, load) -> float:
        match load:
            case PointForce():
                return float(np.linalg.norm(load.force))
            case Moment():
                length = load.model.edge_length(load.at) if load.at in load.model.edges else 1.0
                return float(np.linalg.norm(load.moment)) * length
            case LineForce():
                return self._line_magnitude(load)
            case EdgeForce():
                return float(np.linalg.norm(load.force)) * load.model.edge_length(load.at)
            case SurfaceForce():
                return float(np.linalg.norm(load.force)) * load.shell.model.measure
            case Pressure():
                return abs(load.pressure)
            case Push():
                return abs(load.force)
        return 0.0

    @staticmethod
    def _line_magnitude(load: LineForce) -> float:
        mesh, force = load.beam.model.mesh, load.components()
        if callable(load.force):
            size = ufl.sqrt(ufl.dot(forms.vector(force), forms.vector(force)))
        else:
            size = fem.Constant(mesh, float(np.linalg.norm(force)))
        work = fem.form(lift_numbers(size * _along(load.beam), mesh), jit_options=JIT)
        return mesh.comm.allreduce(fem.assemble_scalar(work))

    def total_load(self) -> float:
        """Load on the whole structure: the sum of the magnitudes of all loads, or the reaction."""
        copies = self.scene.copies
        if self._reactions:
            work = [fem.assemble_scalar(form) for form in self._reaction_forms]
            return -copies * self.system.comm.allreduce(sum(work))
        return copies * self.system.factor * self._unit_load

    def commit(self) -> None:
        """Accept the current configuration as converged."""
        self.enforcement.commit()
        self.system.commit()

    def snapshot(self) -> dict[str, np.ndarray]:
        """All that a state consists of on this process."""
        return self.system.snapshot() | {m.name: m.x.array.copy() for m in self._kept()}

    def restore(self, snapshot: dict[str, np.ndarray]) -> None:
        """Return to a state that `snapshot` gave."""
        self.system.restore(snapshot)
        for m in self._kept():
            m.x.array[:] = snapshot[m.name]
        self.enforcement.keep()

    @contextmanager
    def visiting(self, state: State) -> Iterator[None]:
        """Be at a state with its load factor, and afterwards where it was before."""
        kept, factor = self.snapshot(), self.system.factor
        try:
            self.restore(state.fields)
            self.system.factor = state.factor
            yield
        finally:
            self.restore(kept)
            self.system.factor = factor

    def _kept(self) -> list[fem.Function]:
        return [c.multiplier for c in self.contacts if c.block is None]


def _turning(load) -> bool:
    """Whether a load's tangent is unsymmetric."""
    return (isinstance(load, Pressure) or isinstance(load, LineForce) and load.follower
            or isinstance(load, Moment) and load.model.dimension == 3)


def _nodal(load) -> bool:
    """Whether a load acts at points."""
    return isinstance(load, PointForce) or isinstance(load, Moment) and load.at in load.model.points


def _along(beam: Beam | Bar) -> ufl.Measure:
    """Measure along a beam or along bars, for loads."""
    return beam.model.integral({"quadrature_degree": 2 * beam.degree - 1}, beam.group)
