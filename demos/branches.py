# %% [markdown]
# # Branches
#
# This demo illustrates how to go on along every branch of a bifurcation: of a column, which may bend to either side,
# and of a star dome (Hangai and Kawamata 1973), whose first two bifurcations lead to twelve and two half-branches.
#
# At a bifurcation with the null vectors $\Phi$ the equations
#
# $$R(x, \lambda) = W \Phi\, t,\qquad t \perp c,\qquad \hat\Phi^T W x = r\, c$$
#
# have one solution for each direction $c$ of the null space and each small amplitude $r$. It is a state of a branch
# where the forces $t$ vanish: always at a simple bifurcation, for some directions at a multiple one.

# %%
import os
from math import pi

import numpy as np

import sheetfx as fx
from sheetfx.scenes import star_dome
from sheetfx.show.curves import draw_branches

QUICK = bool(os.environ.get("SHEETFX_QUICK"))

# %% [markdown]
# ## A column
#
# The path of a perfect column is straight. The branches of Euler's load are the elastica: with the deflection $w$ of
# the middle, $P = P_c\, (1 + \pi^2 / 8\, (w / L)^2 + \dots)$. The extrapolation from two amplitudes removes the next
# term.

# %%
nodes = {"base": (0, 0), "middle": (0.5, 0), "tip": (1, 0)}
members = {"lower": ("base", "middle", 8), "upper": ("middle", "tip", 8)}
mesh = fx.read(lambda: fx.meshes.frame(nodes, members), dimension=2)
bar = fx.Beam(mesh, fx.Rectangle(0.01, 0.01), fx.Elastic(1e9), shear_rigidity=1e3)
column = fx.Case(
    fx.Scene([bar], [fx.pin(mesh, "base"), fx.Support(mesh, "tip", "y")], [fx.PointForce(mesh, "tip", (-1.0, 0.0))],
             fx.Monitor(mesh, "middle", "y")),
    fx.LoadControl(step=3.0, target=10.0), axes=("deflection of the middle", "load"))
record = fx.trace(column)
point = record.critical_points[0]


def bend(amplitude):
    """Coefficient of (w / L)^2 from a state of that amplitude."""
    start = fx.branches(record.path, record.states, point, amplitude)[0].start
    return (start.load / point.load - 1) / start.deflection**2


elastica = (4 * bend(0.05) - bend(0.1)) / 3
print(f"load {point.load:.5f}, {point.name}; bend of the branch {elastica:.4f}, elastica {pi**2 / 8:.4f}")
assert abs(elastica / (pi**2 / 8) - 1) < 1e-3


# %% [markdown]
# A path goes on from the start of each branch, away from the bifurcation.

# %%
def follow(scene, branch, control, until):
    return [branch.start, *fx.Path(scene, control, until, start=[branch.start])]


halves = [(point, follow(column.scene, branch, fx.ArcLength(0.03, largest=2.0), fx.Until(deflection=0.38)))
          for branch in fx.branches(record.path, record.states, point)]
draw_branches(record, halves).savefig("column_branches.png", dpi=150)
assert all(state.unstable_modes == 0 for _, states in halves for state in states)

# %% [markdown]
# ## The star dome
#
# The dome has the symmetries of a hexagon, which has two kinds of mirror planes. Its first bifurcation is double: six
# half-branches keep one plane of the first kind, six one of the second. They are the same but for a turn
# of the dome and have the same loads. The second bifurcation is simple: the dome keeps every second mirror plane, and
# both halves are the same but for a turn of 60 degrees.

# %%
dome = star_dome.case()
record = fx.trace(dome)
bifurcations = [p for p in record.critical_points if p.kind == "bifurcation"][:2]
branches = [fx.branches(record.path, record.states, point) for point in bifurcations]
for point, found in zip(bifurcations, branches, strict=True):
    loads = np.array([branch.start.load for branch in found])
    print(f"{point.multiplicity} null vectors at load {point.load:.6g}: {len(found)} half-branches, starts at loads "
          f"{loads.min():.6g} to {loads.max():.6g}")
assert [point.multiplicity for point in bifurcations] == [2, 1]
assert [len(found) for found in branches] == [12, 2]
angles = np.sort([np.degrees(np.arctan2(*branch.direction[::-1])) % 360 for branch in branches[0]])
assert np.allclose(np.diff(angles), 30.0, atol=0.01)

# %% [markdown]
# The branches are traced on. One of each kind is enough for a picture of load against deflection of the apex; on all of
# them the dome is unstable at first.

# %%
traced = []
for point, found in zip(bifurcations, branches, strict=True):
    for branch in found[:1 if point.multiplicity == 1 else 2] if QUICK else found:
        steps = branch.start.step + (15 if QUICK else 40)
        traced.append((point, follow(dome.scene, branch, fx.ArcLength(0.002, largest=1.0), fx.Until(steps=steps))))
draw_branches(record, traced).savefig("dome_branches.png", dpi=150)
assert all(states[0].unstable_modes > 0 for _, states in traced)
ends = [(round(states[-1].load, 6), round(states[-1].deflection, 3)) for point, states in traced
        if point is bifurcations[0]]
print("ends of the branches of the first bifurcation (load, deflection):", sorted(set(ends)))
assert len(set(ends)) == 2
