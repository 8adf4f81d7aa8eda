"""Geometry of the scenes, as gmsh scripts with named physical groups."""

from .curves import arc, frame
from .profiles import profile
from .surfaces import panels, rectangle

__all__ = ["arc", "frame", "panels", "profile", "rectangle"]
