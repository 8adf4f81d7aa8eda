"""Weak forms: plain functions from fields to UFL expressions."""

import ufl as _ufl

from . import bar, beam, contact, inertia, interface, load, rotation, section, shell

__all__ = ["bar", "beam", "contact", "inertia", "interface", "load", "rotation", "section", "shell", "vector"]


def vector(components):
    """UFL vector of numbers or expressions."""
    return _ufl.as_vector(list(components))
