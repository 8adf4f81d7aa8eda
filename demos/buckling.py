# %% [markdown]
# # Buckling loads
#
# This demo illustrates how to find the loads at which a structure buckles: of a plate without deflections
# before it buckles, where the classical problem is exact, and of a shallow arch that deflects as it is loaded,
# where it is not.
#
# With the tangent $K$ of a state and its derivative $K'$ along the response of the state to the load, buckling loads
# are those at which the tangent, taken as linear in the load, turns singular:
#
# $$(K + \Delta\lambda\, K')\, \varphi = 0.$$

# %%
import os
from math import radians

import matplotlib.pyplot as plt
import numpy as np

import sheetfx as fx
from sheetfx.scenes.plate_buckling import EDGES, buckling_factor
from sheetfx.scenes.plate_buckling import case as plate_case

QUICK = bool(os.environ.get("SHEETFX_QUICK"))

# %% [markdown]
# ## Plates
#
# A plate of width $b$, length $a$ and bending stiffness $D$ buckles at $N = k\, \pi^2 D / b^2$ per length. Theory is
# Kirchhoff's plate; the five edge conditions are the ones that `sheetfx run plate-buckling --edges` knows. The
# loaded edges are simply supported unless the name says that they are clamped.

# %%
ASPECTS = [1.0] if QUICK else [0.6, 0.7, 0.85, 1.0, 1.2, 1.414, 1.6, 1.8, 2.0, 2.3, 2.6]


def factors(edges, aspect):
    """Factor k of the finite elements and of theory."""
    case = plate_case(edges=edges, aspect=aspect, cells=6, count=1)
    found = case.quantities(fx.trace(case))
    return found["factor"], found["theory"]


plates = {edges: np.array([factors(edges, aspect) for aspect in ASPECTS]) for edges in EDGES}
for edges, values in plates.items():
    (k, theory), largest = values[ASPECTS.index(1.0)], np.abs(values[:, 0] / values[:, 1] - 1).max()
    print(f"{edges:18s} square: k = {k:.4f}, theory {theory:.4f}; largest difference {100 * largest:.3f} %")
    assert largest < 1e-3

# %% [markdown]
# ## About states of a nonlinear path
#
# A shallow arch on hinges sways at a bifurcation before its crown snaps through. About the unloaded arch the problem
# is far off. About a loaded state the tangent and its rate belong to that state, and the error falls with the square
# of the distance to the bifurcation. The rate with the stress alone (the initial-stress matrix) neglects that the
# response also turns the arch; here it is the better one all the same.

# %%
angle = radians(7.338)
mesh = fx.read(lambda: fx.meshes.arc(3380.6, -angle, angle, 20, {"crown": 0.0}), dimension=2, order=2)
arch = fx.Beam(mesh, fx.Rectangle(25.4, 4.7625), fx.Elastic(72395.0))
hinged = fx.Scene([arch], [fx.pin(mesh, "start"), fx.pin(mesh, "end")],
                  [fx.PointForce(mesh, "crown", (0.0, -1.0))], fx.Monitor(mesh, "crown", "y", -1.0))
record = fx.trace(fx.Case(hinged, fx.ArcLength(step=0.003), fx.Until(deflection=8.0)))
bifurcation = next(p.load for p in record.critical_points if p.kind == "bifurcation")

# %%
SHARES = np.array([0.0, 0.9, 0.995, 0.9975] if QUICK else [0.0, 0.5, 0.8, 0.9, 0.95, 0.98, 0.99, 0.995, 0.9975])
METHODS = {"stress and displacement": True, "stress alone": False}


def buckling_loads(share):
    """About the state under a share of the bifurcation's load, by each method."""
    path, state = record.path, record.states[0]
    if share > 0:
        path = fx.Path(hinged, fx.LoadControl(step=share * bifurcation / 6, target=share * bifurcation))
        *_, state = path
    return [fx.buckling(path, state, 1, prebuckling=p)[0].load for p in METHODS.values()]


table = np.array([buckling_loads(share) for share in SHARES]) / bifurcation - 1
errors = dict(zip(METHODS, np.abs(table.T), strict=True))
print(f"\nbifurcation of the arch at {bifurcation:.3f} N; errors of buckling loads about states below it")
print(f"{'load of the state':24s}" + "".join(f"{s:9.2%}" for s in SHARES))
for name, values in errors.items():
    print(f"{name:24s}" + "".join(f"{e:9.3%}" for e in values))
order = np.log2(errors["stress and displacement"][-2] / errors["stress and displacement"][-1])
print(f"order {order:.2f}")
assert order > 1.8 and errors["stress and displacement"][-1] < 5e-4

# %%
figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.8), layout="constrained")
fine = np.linspace(0.55, ASPECTS[-1] + 0.05, 60)
for number, (edges, values) in enumerate(plates.items()):
    left.plot(fine, [buckling_factor(edges, a, 0.3) for a in fine], color=f"C{number}", linewidth=1, label=edges)
    left.plot(ASPECTS, values[:, 0], "o", color=f"C{number}", markersize=4)
left.set(xlabel="length / width", ylabel="buckling factor k", ylim=(0, 12), title="plates (lines: theory)")
left.legend(fontsize=9)
gaps = 1 - SHARES
for (name, values), style in zip(errors.items(), ("C0o-", "C1s-"), strict=True):
    right.loglog(gaps, values, style, label=name)
near = gaps[gaps <= 0.1]
right.loglog(near, errors["stress and displacement"][-1] * (near / gaps[-1]) ** 2, "k--", label="order 2")
right.invert_xaxis()
right.set(xlabel="distance of the state to the bifurcation (share of its load)",
          ylabel="relative error of the buckling load", title="shallow arch: buckling about loaded states")
right.legend(fontsize=9)
for axes in (left, right):
    axes.grid(alpha=0.3)
figure.savefig("buckling.png", dpi=150)
