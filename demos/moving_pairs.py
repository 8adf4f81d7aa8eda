# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: percent
# ---

# %% [markdown]
# # Pairs that stay, and pairs that move
# A rod is pressed on a curved bar and drawn along it. The contact asks the rod's tip for its gap to a partner on the
# bar. If the partner is the point that was opposite in the beginning, the tip goes on along the tangent there, whatever
# is below it: above a bar that bends away (pseudo-separation), and inside of one that bends up (pseudo-penetration).
# With `moving=True`, the default, the partner is the point of the current bar that is opposite.

# %%
import os

import matplotlib.pyplot as plt
import numpy as np

import sheetfx as fx

QUICK = bool(os.environ.get("SHEETFX_QUICK"))
RISE, TRAVEL, FORCE, STIFFNESS = 0.2, 0.3 if QUICK else 0.75, 0.1, 1e5
PLACES = np.linspace(-1.0, 1.0, 18)
RISES = (RISE,) if QUICK else (RISE, -RISE)


def heights(rise: float) -> np.ndarray:
    return rise * (1 - PLACES**2)


def tips_of_rod(rise: float, moving: bool) -> np.ndarray:
    """Places of the rod's tip, which is pressed on the middle of a bar, as its other end is drawn along."""
    nodes = {f"p{n}": place for n, place in enumerate(zip(PLACES, heights(rise), strict=True))}
    pieces = {f"piece {n}": (f"p{n}", f"p{n + 1}", 1) for n in range(len(PLACES) - 1)}
    bar = fx.read(lambda: fx.meshes.frame(nodes, pieces), 2)
    ends = {"top": (0.0, rise + 0.3), "tip": (0.0, rise)}
    rod = fx.read(lambda: fx.meshes.frame(ends, {"rod": ("top", "tip", 1)}), 2)
    beams = [fx.Beam(mesh, fx.Rectangle(0.05, 0.05), fx.Elastic(2.1e7, 0.3)) for mesh in (bar, rod)]
    contact = fx.PairContact(rod, "tip", (bar, None), toward=(0.0, -1.0), moving=moving, stiffness=STIFFNESS,
                             reach=1e-2)
    scene = fx.Scene(
        beams, [fx.clamp(bar, "p0"), fx.clamp(bar, f"p{len(PLACES) - 1}"), fx.Support(rod, "top", "rz")],
        [fx.PrescribedDisplacement(rod, "top", "x", 1.0)], fx.Monitor(rod, "top", "x"), joints=[contact],
        stages=[fx.Stage([fx.PointForce(rod, "top", (0.0, -FORCE))], control=fx.LoadControl(step=1.0, fixed=True))])
    record = fx.trace(fx.Case(scene, fx.LoadControl(step=TRAVEL / 20, target=TRAVEL, fixed=True)))
    tips = []
    for state in record.states[1:]:
        record.show(state)
        tips.append(record.pairs(contact).position[0])
    return np.array(tips)


# %% [markdown]
# ## Off an arch, and up a hollow
# Fixed pairs are wrong by all that the bar falls or rises.

# %%
figure, axes = plt.subplots(1, 2, figsize=(9, 3), layout="constrained")
for ax, rise in zip(axes, RISES, strict=False):
    wrong = "pseudo-separation" if rise > 0 else "pseudo-penetration"
    ax.plot(PLACES, heights(rise), "k", lw=4, alpha=0.3, label="bar")
    for moving, style in ((False, "o"), (True, ".")):
        tips = tips_of_rod(rise, moving)
        clearance = tips[:, 1] - np.interp(tips[:, 0], PLACES, heights(rise))
        label = "moving pair" if moving else f"fixed pair: {wrong}"
        ax.plot(*tips.T, style, ms=7 if moving else 4, label=label)
        print(f"{label:32s} clearance at the end {clearance[-1]:9.5f}")
        expected = np.zeros(len(tips)) if moving else rise * tips[:, 0] ** 2
        assert np.abs(clearance - expected).max() < 4e-3         # what the bar gives way, and its corners
    ax.set(xlabel="x", ylabel="height of the rod's tip")
    ax.legend(frameon=False)
figure.savefig("moving_pairs.png", dpi=100)
