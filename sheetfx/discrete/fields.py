"""What parts, joints, contacts and loads write their virtual work in."""

from __future__ import annotations

import copy
from collections.abc import Callable, Sequence

import numpy as np
from dolfinx import fem
from dolfinx.common import IndexMap
from mpi4py import MPI
from scipy.spatial import cKDTree

from ..mesh.meeting import Side
from ..mesh.numbers import constants_on
from ..mesh.projection import Cells, cells_at
from ..mesh.reader import NamedMesh
from ..mesh.samples import Samples
from ..mesh.whole import whole
from ..model.scene import Scene
from .condensed_pairs import CondensedPairs
from .gaping import refuse_apart, tell_gaping
from .kinematics import Kinematics, kinematics_of
from .load_factors import LoadFactors
from .nodal_field import AdditiveField
from .number import NumberField, shared_by_all
from .obstacle_work import ObstacleWork
from .origins import components, of_nodes
from .pair_work import Pairs, PairWork
from .partners import Partners
from .point_law import PointLaw
from .points import PointWork, Trace
from .sharing import Sharing, same_places
from .surface_partners import SurfacePartners
from .surface_work import SurfaceWork
from .unknowns import Block, Unknowns
from .whole import WholeField

QUANTITIES = "displacement", "rotation"
SAME_PLACE = 1e-6  # distance of nodes that are joined, over the size of their mesh


class Fields:
    """Unknown fields of a scene, the load factor, and variations.

    Things of a scene first add unknowns of their own, then write their virtual work.

    Attributes
    ----------
    scene : Scene
    blocks : of the solver's vector, in their order
    fixed : for blocks that things have added arrays of local dofs whose increment is zero
    unknowns : Unknowns, once all blocks are there
    stage : number of the load stage whose factor `factor` is
    """

    def __init__(self, scene: Scene):
        self.scene, self.fixed = scene, {}
        self._kinematics = {p.mesh: kinematics_of(p.mesh, *p.spaces) for p in scene.parts}
        self._own: dict[tuple, NumberField | AdditiveField] = {}
        self._factors = LoadFactors(scene.parts[0].mesh.domain, len(scene.all_stages))
        self._names: dict[str, int] = {}
        self._wholes: dict[AdditiveField, WholeField] = {}
        self.blocks: list[Block] = [k.block for k in self._kinematics.values()]
        self.unknowns: Unknowns | None = None
        self.stage = 0

    @property
    def comm(self) -> MPI.Comm:
        return self.scene.parts[0].mesh.comm

    @property
    def factors(self) -> LoadFactors:
        return self._factors

    @property
    def factor(self):
        """The load factor as a UFL variable."""
        return self._factors.symbols[self.stage]

    def factor_now(self) -> float:
        """The present value of the load factor."""
        return self._factors.value(self.stage)

    def at_stage(self, stage: int) -> Fields:
        """The same fields with the load factor of a stage."""
        view = copy.copy(self)
        view.stage = stage
        return view

    @property
    def meshes(self) -> list[NamedMesh]:
        return list(self._kinematics)

    def kinematics(self, mesh: NamedMesh) -> Kinematics:
        return self._kinematics[mesh]

    def displacement(self, mesh: NamedMesh) -> fem.Function:
        """Displacement of a mesh's parts (length unit of the mesh)."""
        return self._kinematics[mesh].u

    def rotation(self, mesh: NamedMesh):
        """Rotation of a mesh's parts, see `forms.rotation`; None where they have none."""
        return self._kinematics[mesh].rotation

    def spin(self, mesh: NamedMesh):
        """What moments are conjugate to; None where parts have no rotation."""
        return self._kinematics[mesh].spin

    def residual_stresses(self, part, at) -> np.ndarray | float:
        """Stresses without resultants in a layer of a part now, as of plies that expand unlike."""
        height = float(np.ravel(at)[0])
        found = [self._factors.value(stage) * own for stage, load in self.scene.stress_free
                 if load.part is part and (own := load.residual(height)) is not None]
        return np.sum(found, axis=0) if found else 0.0

    def natural_strains(self, part):
        """Strains at which a part is free of stress by the present load factors, a UFL vector; None: at none."""
        found = [self._factors.symbols[stage] * load.natural() for stage, load in self.scene.stress_free
                 if load.part is part]
        return constants_on(part.mesh.domain.ufl_domain(), sum(found[1:], found[0])) if found else None

    def vary(self, expression):
        """Variation of a UFL expression of the fields and numbers."""
        return self.unknowns.vary(expression)

    def previous(self, expression):
        """A UFL expression as it was at the last converged state."""
        return self.unknowns.previous(expression)

    def add_number(self, owner, mesh: NamedMesh, name: str, scale: float, multiplier: bool = False) -> None:
        """Add one number that all processes share, and that forms on a mesh may use."""
        field = NumberField(self._unique(name), shared_by_all(mesh.comm), scale, multiplier, mesh.domain)
        self._add(owner, name, Block.of_numbers(field))

    def add_numbers(self, owner, mesh: NamedMesh, name: str, origins: np.ndarray, count: int,
                    without: Sequence[int] = (), whole: bool = False) -> None:
        """Add Lagrange multipliers at the points of this process.

        Parameters
        ----------
        origins : of the points: numbers that tell them from each other on any number of processes
        count : of multipliers at each point
        without : those that are none, since supports hold what they would
        whole : whether each process has all points; process 0 answers for them
        """
        numbers = components(origins, count)
        own = numbers[:0] if whole and mesh.comm.rank else numbers
        field = NumberField(self._unique(name), IndexMap(mesh.comm, len(own)), np.inf, True, origins=own)
        if whole:
            self._everywhere(field, numbers)
        block = Block.of_numbers(field)
        self._add(owner, name, block)
        self.fixed[block] = [field.dofs[np.asarray(without, dtype=int)]]

    def add_multiplier(self, owner, mesh: NamedMesh, name: str, at: str, without: Sequence[str] = ()) -> None:
        """Add a field of Lagrange multipliers on a component of displacement at a named point or edge.

        Parameters
        ----------
        without : points and edges where supports hold the component, so that there is no multiplier
        """
        element = self.displacement(mesh).function_space.ufl_element().sub_elements[0]
        space = fem.functionspace(mesh.domain, element)
        value = fem.Function(space, name=self._unique(name))
        block = Block.of_space(space, AdditiveField(value, np.arange(len(value.x.array)), np.inf, True))
        self._add(owner, name, block)
        there, *held = (fem.locate_dofs_topological(space, *mesh.at(place)) for place in (at, *without))
        nodes = np.setdiff1d(there, np.concatenate([np.empty(0, dtype=there.dtype), *held]))
        self.fixed[block] = [np.setdiff1d(block.fields[0].dofs, nodes)]

    def _unique(self, name: str) -> str:
        self._names[name] = self._names.get(name, -1) + 1
        return f"{name}{self._names[name]}"

    def _add(self, owner, name: str, block: Block) -> None:
        self._own[owner, name] = block.fields[0]
        self.blocks.append(block)

    def has(self, owner, name: str) -> bool:
        """Whether an owner has added an unknown of this name."""
        return (owner, name) in self._own

    def own(self, owner, name: str):
        """What an owner has added, as it occurs in forms."""
        return self._own[owner, name].symbol

    def own_field(self, owner, name: str) -> AdditiveField:
        """What an owner has added, as an unknown field."""
        return self._own[owner, name]

    def nodes(self, mesh: NamedMesh, at: str, quantity: str = "displacement", ghosts: bool = False) -> np.ndarray:
        """Local numbers of the nodes of a named point or edge that this process owns, or also knows of (`ghosts`).

        Raises
        ------
        ValueError
            If no process has one: rotations of some triangles live at the middles of edges only.
        """
        space = self._field(mesh, quantity).value.function_space
        nodes = fem.locate_dofs_topological(space, *mesh.at(at))
        if not mesh.comm.allreduce(len(nodes)):
            raise ValueError(f"{at!r} has no node of the {quantity}; choose an edge, or a form of shells with "
                             "rotations at corners")
        return nodes if ghosts else nodes[nodes < space.dofmap.index_map.size_local]

    def origins(self, mesh: NamedMesh, nodes: np.ndarray, quantity: str = "displacement") -> np.ndarray:
        """What tells nodes on any number of processes."""
        return self._field(mesh, quantity).origins[nodes]

    def places(self, mesh: NamedMesh, nodes: np.ndarray, quantity: str = "displacement") -> np.ndarray:
        """Places of nodes in the reference configuration, shape (n, dimension)."""
        return self._field(mesh, quantity).value.function_space.tabulate_dof_coordinates()[nodes, :mesh.dimension]

    def matching(self, mesh: NamedMesh, at: str, places: np.ndarray, quantity: str = "displacement") -> np.ndarray:
        """Nodes of a named point, or of a named edge those that stand at given places.

        Raises
        ------
        ValueError
            If they do not match, or another process has them.
        """
        nodes = self.nodes(mesh, at, quantity, ghosts=True)
        matched = len(places) == 0 or len(nodes) == len(places) == 1
        found = nodes[: len(places)]
        if not matched and len(nodes):
            distances, order = cKDTree(self.places(mesh, nodes, quantity)).query(places)
            matched = len(set(order)) == len(places) and distances.max() <= SAME_PLACE * mesh.size
            found = nodes[order]
        comm = mesh.comm
        if comm.allreduce(not matched, op=MPI.LOR):
            others = f", or stand on different ones of the {comm.size} processes, which is not possible yet" * (
                comm.size > 1)
            raise ValueError(f"joint at {at!r}: its nodes do not match those that it is joined to{others}; join "
                             "points, or edges whose nodes have the same places")
        return found

    def sharings(self, mesh: NamedMesh, to: NamedMesh, at: str | None, quantities: Sequence[str]) -> list[Sharing]:
        """Nodes of a mesh, or of a named place of it, that are to have the unknowns of another's nodes at their place.

        Raises
        ------
        ValueError
            If no node stands at another's.
        """
        turning = self.spin(mesh) is not None and self.spin(to) is not None
        near = SAME_PLACE * max(mesh.size, to.size)
        refuse_apart(mesh, to, at, near)
        found = [same_places(mesh, self._field(mesh, q), self._field(to, q), at, near)
                 for q in quantities if turning or q == "displacement"]
        if not mesh.comm.allreduce(sum(len(s.nodes) for s in found)):
            raise ValueError(f"Compatible: no node of {at or ', '.join(mesh.cells)} stands at a node of "
                             f"{', '.join(to.cells)}; mesh them with common nodes, or weld them")
        tell_gaping((mesh, to), at, found[0], near)
        return found

    def _field(self, mesh: NamedMesh, quantity: str) -> AdditiveField:
        return self._kinematics[mesh].block.fields[QUANTITIES.index(quantity)]

    def _whole(self, mesh: NamedMesh, quantity: str = QUANTITIES[0]) -> AdditiveField | WholeField:
        """A field of a mesh on all processes."""
        field = self._field(mesh, quantity)
        if mesh.comm.size == 1 or field in self._wholes:
            return self._wholes.get(field, field)
        space = fem.functionspace(whole(mesh).domain, field.space.ufl_element())
        return self._everywhere(field, of_nodes(space), space)

    def _everywhere(self, field: AdditiveField, origins: np.ndarray,
                    space: fem.FunctionSpace | None = None) -> AdditiveField | WholeField:
        """A field with its nodes on all processes, see `WholeField`; itself where there is one process."""
        if self.comm.size > 1 and field not in self._wholes:
            self._wholes[field] = WholeField(field, origins, space)
        return self._wholes.get(field, field)

    def trace(self, mesh: NamedMesh, nodes: np.ndarray, quantity: str = "displacement") -> Trace:
        """Values of displacement or rotation at nodes."""
        return Trace.at_nodes(self.unknowns.fields.index(self._field(mesh, quantity)), nodes)

    def trace_in(self, mesh: NamedMesh, cells: np.ndarray, reference: np.ndarray,
                 quantity: str = "displacement") -> Trace:
        """Values of displacement or rotation at reference points of cells of the whole mesh, one in each.

        Each process has all points; see `mesh.whole.whole`.
        """
        number, everywhere = self.unknowns.fields.index(self._field(mesh, quantity)), self._whole(mesh, quantity)
        return Trace.in_cells(number, everywhere.space, cells, reference, everywhere)

    def own_trace(self, owner, name: str, nodes: np.ndarray, weights: np.ndarray | None = None) -> Trace:
        """Values of numbers that an owner has added, or of sums of them."""
        field = self._own[owner, name]
        number, of = self.unknowns.fields.index(field), self._wholes.get(field)
        return Trace.at_nodes(number, nodes, of) if weights is None else Trace(number, nodes, weights, of)

    def point_work(self, traces: Sequence[Trace], strains: Callable, law: Callable, data: Sequence[np.ndarray] = (),
                   stage: int | None = None, weights: np.ndarray | None = None) -> PointWork:
        """Virtual work of the values of traces, from strains and a law in UFL, see `points.PointLaw`."""
        sizes = [self.unknowns.fields[t.field].components for t in traces]
        forces = PointLaw(strains, law, sizes, data, len(traces[0].nodes), self.factor_now, weights)
        return PointWork(self.unknowns, traces, forces, load=None if stage is None else forces.load, stage=stage)

    def pair_work(self, owner, first: Side, second: Side, how: dict) -> PairWork:
        """Contact of two parts at pairs of points.

        Parameters
        ----------
        owner : PairContact
        first, second : where the pairs are on both parts
        how : attributes of `Pairs` but for the points
        """
        to = owner.to[0]
        quantities = QUANTITIES[:1] if self.spin(owner.mesh) is None else QUANTITIES
        traces = [self.trace_in(owner.mesh, first.cells, first.reference, q) for q in quantities]
        partner: Trace | Partners = self.trace_in(to, second.cells, second.reference)
        if owner.moving:
            field, cells = self._field(to, QUANTITIES[0]), Cells(whole(to), cells_at(whole(to), owner.to[1]))
            partner = Partners(self._whole(to), self.unknowns.fields.index(field), cells,
                               np.searchsorted(cells.cells, second.cells), second.reference)
        kind = PairWork if owner.enforcement == "penalty" else CondensedPairs
        return kind(self.unknowns, traces, partner, Pairs(first.places, **how), owner, self._unique("contact"))

    def surface_work(self, owner, samples: Samples, second: tuple, how: dict) -> SurfaceWork:
        """Contact of points with surfaces.

        Parameters
        ----------
        owner : SurfaceContact
        second : cells of the surfaces, and which, where in them and on what side the closest points are at the start
        how : attributes of `Pairs` but for the points
        """
        first = self.trace_in(owner.mesh, samples.cells, samples.reference)
        field = self._field(owner.to[0], QUANTITIES[0])
        partners = SurfacePartners(self._whole(owner.to[0]), self.unknowns.fields.index(field), *second,
                                   owner.border(self))
        return SurfaceWork(self.unknowns, [first], partners, Pairs(samples.places, **how), owner,
                           self._unique("contact"))

    def obstacle_work(self, owner, samples: Samples, how: dict) -> ObstacleWork:
        """Contact of points with a rigid obstacle.

        See `pair_work`; the owner is an ObstacleContact.
        """
        first = self.trace_in(owner.mesh, samples.cells, samples.reference)
        travel = None
        if self.has(owner.obstacle, "travel"):
            field = self.own_field(owner.obstacle, "travel")
            self._everywhere(field, field.origins)
            travel = self.own_trace(owner.obstacle, "travel", np.zeros(len(samples.places), dtype=np.int64))
        return ObstacleWork(self.unknowns, [first], travel, Pairs(samples.places, **how), owner,
                            self._unique("contact"))


class NodalForces:
    """Where loads put forces at points, for a load factor of 1."""

    def __init__(self, fields: Fields):
        self._fields, self.arrays = fields, [None] * len(fields.blocks)

    def add(self, mesh: NamedMesh, at: str, component: str, value: float) -> None:
        """Add a force or moment at each vertex of a named point."""
        kinematics = self._fields.kinematics(mesh)
        dofs = kinematics.point_dofs(mesh, at, component)
        if not mesh.comm.allreduce(len(dofs)):
            raise ValueError(f"{at!r} has no node with a component {component}, so that nothing can act there; choose "
                             "an edge, or a form of shells with rotations at corners")
        self._array(kinematics.block)[dofs] += value

    def add_to_own(self, owner, name: str, value: float) -> None:
        """Add a force on a number that an owner has added."""
        field = self._fields.own_field(owner, name)
        block = next(b for b in self._fields.blocks if b.fields[0] is field)
        self._array(block)[: block.index_map.size_local] += value

    def _array(self, block: Block) -> np.ndarray:
        place = self._fields.blocks.index(block)
        if self.arrays[place] is None:
            count = block.index_map.size_local + block.index_map.num_ghosts
            self.arrays[place] = np.zeros(count * block.width)
        return self.arrays[place]
