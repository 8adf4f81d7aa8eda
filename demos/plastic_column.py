# %% [markdown]
# # An elastic-plastic column
# A column on hinges yields before it buckles. Three loads are known for it: the tangent-modulus load
# $P_t = \pi^2 E_t I / L^2$, at which the straight column bifurcates while the load goes on rising (Shanley 1947), the
# reduced-modulus load $P_r$, up to which a column that is held straight still resists a small force at a constant load
# (von Karman 1910), and between them the largest load of columns that are not quite straight. sheetfx finds the first
# as a bifurcation of the comparison solid (Hill 1958), and the others on paths along which fibres unload elastically.

# %%
import os
from math import pi, sqrt, tan

import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import brentq

import sheetfx as fx
from sheetfx import meshes

QUICK = bool(os.environ.get("SHEETFX_QUICK"))
MODULUS, HARDENING, DEPTH = 200e3, 50e3, 0.02
TANGENT_MODULUS = MODULUS * HARDENING / (MODULUS + HARDENING)
REDUCED_MODULUS = 4 * MODULUS * TANGENT_MODULUS / (sqrt(MODULUS) + sqrt(TANGENT_MODULUS)) ** 2
INERTIA = DEPTH**4 / 12
TANGENT, REDUCED = (pi**2 * modulus * INERTIA for modulus in (TANGENT_MODULUS, REDUCED_MODULUS))


def column(imperfection=0.0, force=0.0, held=None):
    """Half waves of an imperfection; a force in the middle, under a load that is held, in the place of the load."""
    nodes = {"base": (0, 0), "middle": (0.5, 0), "tip": (1, 0)}
    mesh = fx.read(lambda: meshes.frame(nodes, {"lower": ("base", "middle", 4), "upper": ("middle", "tip", 4)}), 2)
    x = mesh.domain.geometry.x
    x[:, 1] += imperfection * np.sin(pi * x[:, 0])
    steel = fx.Plastic(MODULUS, 0.3, yield_stress=0.8 * TANGENT / DEPTH**2, hardening=HARDENING)
    beam = fx.Beam(mesh, fx.Rectangle(DEPTH, DEPTH, points=20), steel, shear_rigidity=30.0)
    press = fx.PointForce(mesh, "tip", (-(held or TANGENT), 0.0))
    loads = [fx.PointForce(mesh, "middle", (0.0, force))] if held else [press]
    return fx.Scene([beam], [fx.pin(mesh, "base"), fx.Support(mesh, "tip", "y")], loads,
                    fx.Monitor(mesh, "middle", "y"), stages=[fx.Stage([press], "press")] if held else [])


# %% [markdown]
# ## The straight column

# %%
straight = fx.trace(fx.Case(column(), fx.LoadControl(step=0.1, target=1.2)))
(point,) = straight.critical_points
print(f"{point.title} at {point.load / TANGENT:.4f} of the tangent-modulus load")
assert point.name == "comparison solid" and abs(point.load / TANGENT - 1) < 1e-3

# %% [markdown]
# Its branch rises: load and deflection grow together so that nothing unloads at first,
# $P / P_t = 1 + 6 w / d$ for a square section (Hutchinson 1974); then fibres unload, and the load has a maximum.

# %%
BEND = 0.02
branch = straight.branches(point, 1e-4)[0]
forward = fx.DisplacementControl(step=2e-4, turn=4.0)
shanley = [branch.start, *fx.Path(column(), forward, fx.Until(deflection=BEND), start=[branch.start])]
(largest,) = [p.load / TANGENT for s in shanley for p in s.critical if p.kind == "limit"]
rise = (branch.start.load / point.load - 1) / (6 * abs(branch.start.deflection) / DEPTH)
print(f"the branch begins with {rise:.3f} of the slope 6 / d; its largest load is {largest:.4f}")
assert 0.8 < rise < 1.0 and 1 < largest < REDUCED / TANGENT

# %% [markdown]
# ## Held straight above the tangent-modulus load
# A small force in the middle bends the column under a load that does not change: each section loads on one side and
# unloads on the other, and bends with the reduced modulus: $w = Q / (2 P k)\, (\tan(k L / 2) - k L / 2)$,
# $k^2 = P / (E_r I)$.

# %%
FORCE, held = 1e-4 * TANGENT, {}
for ratio in (1.1,) if QUICK else (1.1, 1.3, 1.5, 1.7, 1.8):
    *_, last = fx.Path(column(force=FORCE, held=ratio * TANGENT), fx.LoadControl(step=1.0, fixed=True, turn=4.0))
    k = sqrt(ratio * TANGENT / REDUCED_MODULUS / INERTIA)
    exact = FORCE / (2 * ratio * TANGENT * k) * (tan(k / 2) - k / 2)
    held[ratio] = FORCE / last.deflection
    print(f"P = {ratio} P_t: deflection {last.deflection / exact:.4f} of that with the reduced modulus")
    assert abs(1 - exact / last.deflection) * (1 - ratio * TANGENT / REDUCED) < 1e-3

# %% [markdown]
# ## Columns that are not straight
# An independent figure: half a sine wave in the place of the deflection, sections at eight points of Gauss, each with
# the moment and force of its fibres, balanced in the mean (Ritz).

# %%
class OneWave:
    """A column that bends to half a sine wave; its fibres harden isotropically."""

    def __init__(self, imperfection, points=8, fibres=40):
        self.imperfection = imperfection
        (x, weights), (y, areas) = (np.polynomial.legendre.leggauss(n) for n in (points, fibres))
        self.wave, self.weights = np.sin(pi * (x + 1) / 2), weights / 2
        self.y, self.areas = y * DEPTH / 2, areas * DEPTH**2 / 2
        self.plastic, self.total = np.zeros((2, points, fibres))
        self.axial = np.zeros(points)

    def stresses(self, bend):
        """Stress and modulus of each fibre, and what it would remember."""
        trial = MODULUS * (self.axial[:, None] - self.y * pi**2 * bend * self.wave[:, None] - self.plastic)
        flow = np.maximum(np.abs(trial) - 0.8 * TANGENT / DEPTH**2 - HARDENING * self.total, 0) / (MODULUS + HARDENING)
        return (trial - MODULUS * np.sign(trial) * flow, np.where(flow > 0, TANGENT_MODULUS, MODULUS),
                self.plastic + np.sign(trial) * flow, self.total + flow)

    def imbalance(self, load, bend):
        """Work of moments and load on the wave, where each section carries the load."""
        low, high = (np.full_like(self.axial, sign * 0.05) for sign in (-1, 1))
        for _ in range(50):  # Newton's method within a bracket
            stress, modulus, *_ = self.stresses(bend)
            excess = stress @ self.areas + load
            if np.abs(excess).max() < 1e-12 * TANGENT:
                break
            low, high = np.where(excess < 0, self.axial, low), np.where(excess < 0, high, self.axial)
            there = self.axial - excess / (modulus @ self.areas)
            self.axial = np.where((there > low) & (there < high), there, (low + high) / 2)
        moment = -self.stresses(bend)[0] @ (self.areas * self.y)
        return self.weights @ (moment * self.wave) - load * (bend + self.imperfection) / 2

    def bend_to(self, bend):
        """Load at an amplitude of the deflection, from the amplitude before."""
        load = brentq(self.imbalance, 0, 2 * REDUCED, args=(bend,), xtol=1e-9 * TANGENT)
        self.imbalance(load, bend)
        *_, self.plastic, self.total = self.stresses(bend)
        return load


# %%
AMPLITUDES = (1e-3,) if QUICK else (3e-3, 1e-3, 1e-4, 1e-5)
imperfect = {}
for amplitude in AMPLITUDES:
    first = 0.1 * amplitude
    control = fx.DisplacementControl(step=first, largest=1e-3 / first, turn=4.0)
    imperfect[amplitude] = fx.trace(fx.Case(column(amplitude), control, fx.Until(deflection=BEND)))
    (limit,) = [p.load / TANGENT for p in imperfect[amplitude].critical_points if p.kind == "limit"]
    wave = OneWave(amplitude)
    ritz = max(wave.bend_to(bend) for bend in np.geomspace(1e-2 * amplitude, BEND, 60 if QUICK else 150)) / TANGENT
    print(f"imperfection L / {1 / amplitude:.0f}: largest load {limit:.4f}, one sine wave {ritz:.4f}")
    assert abs(limit / ritz - 1) < 0.01 and limit < largest
loads = [max(s.load for s in r.states) for r in imperfect.values()]
assert np.all(np.diff(loads) > 0) and (QUICK or loads[-1] / TANGENT > 0.95 * largest)

# %%
figure, (left, right) = plt.subplots(1, 2, figsize=(11.0, 4.6), layout="constrained")
left.plot([s.deflection / DEPTH for s in shanley], [s.load / TANGENT for s in shanley], "k", label="straight: branch")
for amplitude, record in imperfect.items():
    left.plot(*(fx.show.curve_points(record) / (DEPTH, TANGENT)).T,
              label=f"imperfection L / {1 / amplitude:.0f}")
for load, name in ((1, "tangent-modulus load"), (REDUCED / TANGENT, "reduced-modulus load")):
    left.axhline(load, color="#888888", linestyle="--", linewidth=1)
    left.text(0.99, load - 0.02, name, ha="right", va="top", color="#555555", fontsize=9)
left.set(xlabel="deflection of the middle / depth", ylabel="$P / P_t$", xlim=(0, 1), ylim=(0, 2.05))
left.legend(fontsize=9, frameon=False, loc="lower right")
ratios = np.linspace(1.0, 0.999 * REDUCED / TANGENT, 200)
k = np.sqrt(ratios * TANGENT / REDUCED_MODULUS / INERTIA)
right.plot(ratios, 2 * ratios * TANGENT * k / (np.tan(k / 2) - k / 2) / TANGENT, "k--", linewidth=1,
           label="reduced modulus")
right.plot(list(held), [s / TANGENT for s in held.values()], "o", markerfacecolor="none", label="sheetfx")
right.set(xlabel="$P / P_t$, held", ylabel="lateral stiffness $Q L / (w P_t)$", title="held straight, then bent")
right.legend(fontsize=9, frameon=False)
for axes in (left, right):
    axes.grid(color="#dddddd", linewidth=0.6)
figure.savefig("plastic_column.png", dpi=100)
