"""Solvers: they see vectors, matrices and a load factor, not structures."""
