"""What contacts have in common whose forces act at samples of a part: on a point, along a line or over a face."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from ..mesh.projection import Cells
from ..mesh.reader import NamedMesh
from ..mesh.samples import Samples, samples_at
from ..mesh.whole import whole
from .beam import Bar, Beam
from .interface import stiffness_over
from .joints import Joint
from .pair_contact import ELASTIC_SLIP, PENETRATION, STIFF
from .places import Place, each_of, require_places, title_of
from .shell import Shell
from .varying import require_uniform


class SampledContact(Joint):
    """A contact of samples of a part.

    Attributes
    ----------
    mesh, at : of the part, and where on it; None: everywhere
    friction : Coulomb's coefficient
    samples : Gauss points on each piece of a line, and along each side of a cell
    stiffness, tangential : pressure over penetration, and against slip; None: chosen
    enforcement : "uzawa": pressures are augmented; or "penalty"
    adjust : overlap at the start up to which points touch where they are, as of imperfect parts; 0: none
    name : what messages call it
    """

    mesh: NamedMesh
    at: Place | None
    friction: float
    samples: int
    stiffness: float | None
    tangential: float | None
    enforcement: str
    adjust: float
    name: str

    smooth = False

    def _require_part(self) -> None:
        """Refuse places that the part does not have."""
        require_places(self.name, self.mesh, each_of(self.at))

    @property
    def _title(self) -> str:
        return title_of(self.name, each_of(self.at)[0])

    @property
    def conservative(self) -> bool:  # type: ignore[override]
        return self.friction == 0

    @cached_property
    def _samples(self) -> Samples:
        return samples_at(whole(self.mesh), each_of(self.at), self.samples, self._title)

    @property
    def _cell_size(self) -> float:
        """Of the cells with samples."""
        return float(Cells(whole(self.mesh), np.unique(self._samples.cells)).sizes.mean())

    @property
    def _normals(self) -> np.ndarray | None:
        """Of the meshed surface at the samples; None: they lie on a line."""
        if self.mesh.domain.topology.dim < 2:
            return None
        cells, which = np.unique(self._samples.cells, return_inverse=True)
        return Cells(whole(self.mesh), cells).normals(which, self._samples.reference)

    def _pairs(self, arms: np.ndarray, apart: np.ndarray, stiffness: float, size: float) -> dict:
        """Attributes of `discrete.pairs.Pairs` but for the points.

        Parameters
        ----------
        arms : from the samples to the second part
        apart : distance of each sample at which parts touch
        stiffness : where none is given
        size : of cells
        """
        (count, d), stiffness = arms.shape, self.stiffness or stiffness
        return {"arms": arms, "axes": np.zeros((count, d, d)), "gap": apart,
                "weights": self._samples.weights, "augmented": self.enforcement == "uzawa",
                "parameters": (stiffness, self.tangential or ELASTIC_SLIP * stiffness, self.friction, 0.0, 0.0),
                "tolerance": PENETRATION * size}


def parts_on(fields, mesh: NamedMesh) -> list[Shell | Beam | Bar]:
    """Parts of the scene that are on a mesh."""
    return [part for part in fields.scene.parts if part.mesh is mesh]


def touch_stiffness(sides: Sequence[Sequence[Shell | Beam | Bar]], size: float, extent: int) -> float:
    """Pressure over penetration: ten times the bending stiffness of the softer side over a size.

    Parameters
    ----------
    sides : parts on each side
    extent : as of `Samples`
    """
    return STIFF * min(max(stiffness_over(part, size)[1] for part in parts) for parts in sides) / size ** (1 + extent)


def faces(parts: Sequence[Shell | Beam | Bar], cells: np.ndarray, normals: np.ndarray | None, toward: np.ndarray,
          thick: bool, title: str) -> np.ndarray:
    """Distance of the face from the meshed surface or line at points, with an offset's part along a direction.

    Parameters
    ----------
    cells, normals, toward : of the points: numbers of cells, normals of a surface, unit vectors to what they touch
    thick : whether half the cell's own thickness is in it
    title : of the contact

    Raises
    ------
    ValueError
        For beams whose faces are not alike on both sides of the meshed line.
    """
    found = np.full(len(cells), -np.inf)
    for part in parts:
        here = np.isin(cells, whole(part.mesh).group(part.group))
        own = np.full(here.sum(), half_thickness([part]) if thick else 0.0)
        if isinstance(part, Shell) and part.offset and normals is not None:
            own = own + part.offset * (normals[here] * toward[here]).sum(axis=1)
        elif isinstance(part, Beam) and thick and here.any() and (np.any(part.offset) or sum(part.section.faces)):
            raise ValueError(f"{title}: the faces of the Beam on group {part.group or 'all'!r} are not alike on both "
                             "sides of its meshed line; give their distance from that line, distance=")
        found[here] = np.maximum(found[here], own)
    return np.where(np.isfinite(found), found, half_thickness(parts) if thick else 0.0)


def half_thickness(parts: Sequence[Shell | Beam | Bar]) -> float:
    """From the mid-surface or axis of parts to their faces; the largest."""
    for part in parts:
        require_uniform(part, "contact of its faces")
    return max((part.section.thickness if isinstance(part, Shell) else part.section.depth) / 2 for part in parts)
