"""Geometry of the scenes, as gmsh scripts with named physical groups, and tables of structures."""

try:
    import gmsh as _gmsh  # noqa: F401
except OSError as missing:
    raise OSError(f"gmsh cannot be loaded, {missing}: install what it takes from the system (apt-get install libgl1 "
                  "libglu1-mesa libxcursor1 libxft2 libxinerama1)") from missing

from .curves import arc, frame
from .profiles import profile
from .structures import edges_of, structure
from .surfaces import panels, rectangle
from .tables import Table, dome, read_table

__all__ = ["Table", "arc", "dome", "edges_of", "frame", "panels", "profile", "read_table", "rectangle", "structure"]
