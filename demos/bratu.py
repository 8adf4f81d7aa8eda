# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: percent
# ---

# %% [markdown]
# # A plain form: Bratu's problem
# $-u'' = \lambda \, e^u$ with $u(0) = u(1) = 0$ has two solutions below the fold $\lambda = 3.513830719$, and none
# above. No structure is needed: the path follower takes any residual form of DOLFINx.

# %%
import sheetfx as fx  # isort: skip  before DOLFINx, whose wheel it loads
from dolfinx import fem, mesh
from mpi4py import MPI
from ufl import TestFunction, dot, dx, exp, grad

line = mesh.create_unit_interval(MPI.COMM_WORLD, 32)
space = fem.functionspace(line, ("Lagrange", 3))
u, v, load = fem.Function(space), TestFunction(space), fem.Constant(line, 0.0)
ends = fem.locate_dofs_geometrical(space, lambda x: x[0] * (1 - x[0]) < 1e-9)
path = fx.continuation((dot(grad(u), grad(v)) - load * exp(u) * v) * dx, u, load,
                       [fem.dirichletbc(0.0, ends, space)], until=fx.Until(deflection=4.0))
(fold,) = fx.trace(path).critical_points
print(f"{fold.title} at {fold.load:.9f}")
assert abs(fold.load - 3.513830719) < 1e-8
