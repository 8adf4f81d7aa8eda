"""Geometry of the scenes, as gmsh scripts with named physical groups, and tables of structures."""

from .curves import arc, frame
from .profiles import profile
from .structures import edges_of, structure
from .surfaces import panels, rectangle
from .tables import Table, dome, read_table

__all__ = ["Table", "arc", "dome", "edges_of", "frame", "panels", "profile", "read_table", "rectangle", "structure"]
