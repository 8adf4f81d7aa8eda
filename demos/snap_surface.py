# %% [markdown]
# # The snap surface of a strip with moved ends
#
# This demo illustrates how far the ends of a thin strip can be moved and turned before it snaps: a surface in the space
# of its end positions (Cazzolli and Dal Corso, *Snapping of elastic strips with controlled ends*, 2019).
#
# The strip has length 1. Its ends come as near as $d$, and the left one turns by $\theta_0$, so that the strip bulges
# upwards. Then the right end turns against the bulge, until at $\theta_1$ the strip snaps to the other side. A path
# finds that limit point for one distance; a curve of limit points follows it over all others.

# %%
import os

import matplotlib.pyplot as plt
import numpy as np
from mpi4py import MPI
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve

import sheetfx as fx
from sheetfx.case import Case, trace

THICKNESS, NEAR, FAR = 0.002, 0.3, 0.8
QUICK = bool(os.environ.get("SHEETFX_QUICK"))
TURNS = [0.6] if QUICK else [0.3, 0.6, 0.9]
START = 0.7

# %% [markdown]
# ## The strip
#
# Ends are prescribed, so that reactions and moments are unknowns. The bending stiffness is 1, and so is the length.

# %%
def strip(distance, left, right=1.6, elements=16):
    ends = {"left": (0.0, 0.0), "right": (1.0, 0.0)}
    mesh = fx.read(lambda: fx.meshes.frame(ends, {"strip": ("left", "right", elements)}), 2)
    beam = fx.Beam(mesh, fx.Rectangle(1.0, THICKNESS), fx.Elastic(12 / THICKNESS**3))
    nearer = fx.PrescribedDisplacement(mesh, "right", "x", distance - 1)
    before = fx.Stage([nearer, fx.PrescribedRotation(mesh, "left", left)], "ends of the bulge")
    return fx.Scene([beam], [fx.pin(mesh, "left"), fx.Support(mesh, "right", "y")],
                    [fx.PrescribedRotation(mesh, "right", right)], fx.Monitor(mesh, "right", "rz"), stages=[before])


def snap(left):
    """Limit point of a strip, its state and its null vector."""
    until = fx.Until(event=lambda state: state.stage and state.deflection < -0.1)
    record = trace(Case(strip(START, left), fx.ArcLength(0.05), until))
    point = next(p for p in record.critical_points if p.kind == "limit")
    return point, record.state_at(point), record.critical_modes(point)


# %% [markdown]
# ## The elastica
#
# An inextensible strip under the end forces $H$, $V$ has $\theta'' = V \cos\theta - H \sin\theta$. Its end is a
# function of $\theta'(0), H, V$; where the determinant of this function's derivatives is zero the strip snaps.

# %%
def end(unknowns, left):
    """Position and angle of the right end, and their derivatives."""
    curvature, push, lift = unknowns

    def along(_, z):
        (angle, bend, *_), rates = z[:4], z[4:].reshape(3, 4)
        sine, cosine = np.sin(angle), np.cos(angle)
        own = [[r[1], -(push * cosine + lift * sine) * r[0] + by, -sine * r[0], cosine * r[0]]
               for r, by in zip(rates, (0.0, -sine, cosine), strict=True)]
        return [bend, lift * cosine - push * sine, cosine, sine, *np.ravel(own)]

    start = [left, curvature, 0.0, 0.0, 0.0, 1.0, *np.zeros(10)]
    z = solve_ivp(along, (0, 1), start, rtol=1e-10, atol=1e-12).y[:, -1]
    return z[[2, 3, 0]], z[4:].reshape(3, 4)[:, [2, 3, 0]].T


def elastica(distance, left, guess):
    """Curvature, forces and angle of the right end where the elastica snaps."""
    def equations(q):
        (x, y, angle), rates = end(q[:3], left)
        return x - distance, y, angle - q[3], 100 * np.linalg.det(rates)

    found, _, converged, said = fsolve(equations, guess, xtol=1e-12, full_output=True)
    assert converged == 1, said
    return found


# %% [markdown]
# ## Curves of limit points
#
# Each curve begins at the limit point of one path, and takes some five factorisations a point.

# %%
curves = {}
for left in TURNS:
    point, state, modes = snap(left)
    found = []
    for to in (NEAR,) if QUICK else (NEAR, FAR):
        def scene(distance, left=left):
            return strip(distance, left)

        curve = fx.CriticalCurve(point, state, modes, scene, START, to, steps=3 if QUICK else 8)
        found += [(p.number, p.deflection) for p in curve]
        print(f"theta_0 = {left:.1f}, d = {START} to {to}: {curve.factorisations} factorisations", flush=True)
    curves[left] = np.array(sorted(set(found), reverse=True))

# %% [markdown]
# The beam stretches and shears a little, the elastica does not; that is $10^{-4}$ of the angle.

# %%
exact, worst = {}, 0.0
for left, found in curves.items():
    begin = int(np.argmin(abs(found[:, 0] - START)))
    exact[left] = np.zeros(len(found))
    for order in (range(begin, len(found)), range(begin, -1, -1)):
        guess = [5.0 + 2 * left, 55.0, -6.0, found[begin, 1]]
        for n in order:
            guess = elastica(found[n, 0], left, [*guess[:3], found[n, 1]])
            exact[left][n] = guess[3]
    worst = max(worst, abs(found[:, 1] / exact[left] - 1).max())
print(f"largest difference from the elastica: {100 * worst:.4f} %")
assert worst < 5e-4, worst

# %%
if MPI.COMM_WORLD.rank == 0:
    figure, axes = plt.subplots(figsize=(6.5, 4.5), layout="constrained")
    for left, found in curves.items():
        (line,) = axes.plot(found[:, 0], exact[left], linewidth=1.2)
        axes.plot(found[:, 0], found[:, 1], "o", color=line.get_color(), markersize=4,
                  label=f"$\\theta_0$ = {left:.1f}")
    axes.set_xlabel("distance of the ends $d$ over the length")
    axes.set_ylabel("angle $\\theta_1$ at which the strip snaps")
    axes.set_title("Snap surface: curves of limit points (dots), elastica (lines)", fontsize=10)
    axes.legend(frameon=False)
    axes.grid(color="#dddddd", linewidth=0.6)
    figure.savefig("snap_surface.png", dpi=150)
