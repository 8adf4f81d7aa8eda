"""Geometry of the scenes, as gmsh scripts with named physical groups."""

from .curves import arc, frame

__all__ = ["arc", "frame"]
