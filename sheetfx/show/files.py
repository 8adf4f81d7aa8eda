"""Fields of a path as files for other programs."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path as Folder

import numpy as np
import ufl
from dolfinx import fem, la
from dolfinx.io import VTKFile

from ..compat import interpolation_points
from ..continuation.state import State
from ..discrete.kinematics import Kinematics
from ..discrete.section_forces import section_points_of, through_points
from ..jit import compiled_expression
from ..mesh.reader import NamedMesh
from ..model.shell import Shell
from ..model.stresses import von_mises
from .evaluate import last_state_kept
from .plastic import largest_strain, mean_share, of_cells, plastic_parts
from .shown import Shown
from .tables import names_of

FACES = "von Mises stress, lower face", "von Mises stress, upper face"  # against the normal, and where it points
AXES = {1: ("along", "axis 1", "axis 2"), 2: ("axis 1", "axis 2", "normal")}  # of parts that are curves and surfaces


def paraview(record: Shown, folder: Folder) -> None:
    """Write path.pvd: displacement and, but for bars, rotation of all states, with the step as time.

    Both have three components: a planar rotation is an angle about z, a spatial one the rotation
    vector (radians, below a full turn), averaged where cells disagree. Each cell has the load, and the means of the
    resultants at its points (`tables.names_of`) with the axes that these act along as they have turned: of shells
    "axis 1" and "axis 2" in the surface and the "normal", by which offsets, plies and sides of pressure go; of beams
    "along", and "axis 1" (the normal in the plane) and "axis 2" of the section; of bars "along". Shells have their
    thickness, and von Mises stresses on both faces, the largest of each cell and at nodes, of plastic ones in the
    outermost layers.
    Plastic parts add the largest equivalent plastic strain of each cell, and the share of its volume that has flowed. A
    scene of several meshes gets path.pvd, path1.pvd and so on. A path of a single state is left out.
    """
    if len(record.states) == 1:
        return
    with last_state_kept(record):
        for i, mesh in enumerate(record.case.scene.meshes):
            _write(record, mesh, Folder(folder) / "paraview" / f"path{i or ''}.pvd")


def _write(record: Shown, mesh: NamedMesh, file: Folder) -> None:
    kinematics = record.path.discretisation.kinematics(mesh)
    degree = min(kinematics.u.function_space.element.basix_element.degree, 2)
    space = fem.functionspace(mesh.domain, ("P", degree, (3,)))
    values = {"displacement": _padded(kinematics.u)}
    if kinematics.rotation is not None:
        values["rotation"] = _rotation_vector(mesh, kinematics)
    points = interpolation_points(space)
    expressions = [compiled_expression(v, points) for v in values.values()]
    share = fem.Function(space)
    _add(share, np.ones((*space.dofmap.list[mesh.group(None)].shape, 3)), mesh)
    functions = [fem.Function(space, name=name) for name in values]
    plastic, forces = _plastic_fields(record, mesh), _Resultants(record, mesh)
    stresses = _FaceStresses(record, mesh, degree)
    with VTKFile(mesh.comm, file, "w") as stream:
        for state in record.states:
            record.show(state)
            for function, expression in zip(functions, expressions, strict=True):
                function.x.array[:] = 0
                _add(function, expression.eval(mesh.domain, mesh.group(None)), mesh)
                function.x.array[:] /= share.x.array
            for function, take in plastic.items():
                function.x.array[mesh.group(None)] = of_cells(record, mesh, take)
                function.x.scatter_forward()
            forces.take(state)
            stresses.take()
            stream.write_function([*functions, *stresses.functions, *plastic, *forces.functions.values()],
                                  float(state.step))


class _Resultants:
    """The load, and resultants of the parts of a mesh with their first axes, as functions with one value in each cell.

    Attributes
    ----------
    functions : by their names
    """

    def __init__(self, record: Shown, mesh: NamedMesh):
        self._record, self._parts = record, [p for p in record.case.scene.parts if p.mesh is mesh]
        self._space = fem.functionspace(mesh.domain, ("DG", 0))
        self._vectors = fem.functionspace(mesh.domain, ("DG", 0, (3,)))
        self.functions: dict[str, fem.Function] = {}

    def take(self, state: State) -> None:
        """Put the functions to the shown state."""
        self._function("load", self._space).x.array[:] = state.load
        for part in self._parts:
            cells, forces = part.mesh.group(part.group), self._record.forces(part)
            values = forces.mean(axis=1)
            if isinstance(part, Shell):
                thickness = part.sections.in_cells(lambda section: section.thickness)
                self._function("thickness", self._space).x.array[cells] = thickness
            for name, column in zip(names_of(part, values.shape[1]), values.T, strict=True):
                self._function(name, self._space).x.array[cells] = column
            axes = self._record.section_points(part).axes.mean(axis=1)
            axes /= np.linalg.norm(axes, axis=2, keepdims=True)
            for name, axis in zip(AXES[part.mesh.domain.topology.dim], axes.transpose(1, 0, 2), strict=False):
                table = self._function(name, self._vectors).x.array.reshape(-1, 3)
                table[cells, :part.mesh.dimension] = axis
        for function in self.functions.values():
            function.x.scatter_forward()

    def _function(self, name: str, space: fem.FunctionSpace) -> fem.Function:
        if name not in self.functions:
            self.functions[name] = fem.Function(space, name=name)
        return self.functions[name]


class _FaceStresses:
    """Equivalent stresses on both faces of the shells of a mesh, the largest of each cell and at nodes.

    At nodes they are means of the cells that meet there.

    Attributes
    ----------
    functions : of the lower and the upper face in cells, and of both at nodes; none where no shell tells its stresses
    """

    def __init__(self, record: Shown, mesh: NamedMesh, degree: int):
        self._record, discretisation = record, record.path.discretisation
        shells = [p for p in record.case.scene.parts if p.mesh is mesh and isinstance(p, Shell)]
        cells, nodes = (fem.functionspace(mesh.domain, family) for family in (("DG", 0), ("P", degree)))
        self._shells = [(s, through_points(mesh, section_points_of(discretisation, s), interpolation_points(nodes)))
                        for s in shells if equivalent_on_faces(record, s) is not None]
        self._of_cells = [fem.Function(cells, name=face) for face in FACES if self._shells]
        self._nodal = [fem.Function(nodes, name=f"{face} at nodes") for face in FACES if self._shells]
        self._count, self._nodes = fem.Function(nodes), nodes.dofmap.list
        self.functions = [*self._of_cells, *self._nodal]

    def take(self) -> None:
        """Put the functions to the shown state."""
        if not self.functions:
            return
        for function in (*self.functions, self._count):
            function.x.array[:] = 0
        for shell, through in self._shells:
            cells, values = shell.mesh.group(shell.group), equivalent_on_faces(self._record, shell)
            nodes = self._nodes[cells].ravel()
            np.add.at(self._count.x.array, nodes, 1.0)
            for largest, nodal, face in zip(self._of_cells, self._nodal, values, strict=True):
                largest.x.array[cells] = face.max(axis=1)
                np.add.at(nodal.x.array, nodes, (face @ through.T).ravel())
        for function in (*self._nodal, self._count):
            function.x.scatter_reverse(la.InsertMode.add)
        for function in self._nodal:
            function.x.array[:] = np.maximum(function.x.array / np.maximum(self._count.x.array, 1.0), 0.0)
        for function in self.functions:
            function.x.scatter_forward()


def equivalent_on_faces(record: Shown, shell: Shell) -> np.ndarray | None:
    """Equivalent stress on the lower and the upper face at the points of `forces`; None where it is not told."""
    half = shell.sections.typical.thickness / 2
    try:
        return np.stack([von_mises(record.stresses(shell, height)) for height in (-half, half)])
    except ValueError:
        return None


def _plastic_fields(record: Shown, mesh: NamedMesh) -> dict[fem.Function, Callable]:
    """Functions with one value for each cell, and what they take from plastic parts; none where there are no such."""
    if not plastic_parts(record, mesh):
        return {}
    space = fem.functionspace(mesh.domain, ("DG", 0))
    takes = {"equivalent plastic strain": largest_strain, "share that has flowed": mean_share}
    return {fem.Function(space, name=name): take for name, take in takes.items()}


def _add(function: fem.Function, values: np.ndarray, mesh: NamedMesh) -> None:
    """Add values at the nodes of each cell, so that fields with jumps can be averaged."""
    nodes = function.function_space.dofmap.list[mesh.group(None)].ravel()
    np.add.at(function.x.array.reshape(-1, 3), nodes, values.reshape(-1, 3))
    function.x.scatter_reverse(la.InsertMode.add)
    function.x.scatter_forward()


def _padded(u):
    return ufl.as_vector([*u, *([0.0] * (3 - len(u)))])


def _rotation_vector(mesh: NamedMesh, kinematics: Kinematics):
    """Angle times axis, as a UFL vector of three components."""
    if mesh.dimension == 2:
        return ufl.as_vector([0.0, 0.0, kinematics.spin])
    q = kinematics.rotation.quaternion
    vector = ufl.as_vector([q[1], q[2], q[3]])
    sine = ufl.sqrt(ufl.dot(vector, vector) + 1e-30)
    return 2 * ufl.atan2(sine, q[0]) / sine * vector
