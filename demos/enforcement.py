# %% [markdown]
# # Three ways to enforce contact
#
# This demo illustrates how penalty, Uzawa's augmentation and semismooth Newton solve the same contact
# problem, and what each costs: the arch of `arch.py` under a punch of its own radius.

# %%
import os
import time

import matplotlib.pyplot as plt

import sheetfx as fx
from sheetfx.scenes.arch import case as arch_case

QUICK = bool(os.environ.get("SHEETFX_QUICK"))
TO = 8.0 if QUICK else 20.0


def measure(**parameters):
    """Path, CPU seconds without compilation, iterations and largest penetration over the depth."""
    fx.trace(arch_case(**parameters | {"to": 0.5}))
    start = time.process_time()
    try:
        record = fx.trace(arch_case(**parameters))
        outcome = "to the end"
    except fx.PathFailure as failure:
        record, outcome = failure.record, f"stopped at {failure.record.states[-1].deflection:.1f} mm"
    seconds = time.process_time() - start - record.path.clock.seconds["compile"]
    penetration = max(s.penetration for s in record.states) / 4.7625
    return record, seconds, sum(s.iterations for s in record.states), penetration, outcome


# %% [markdown]
# On the thesis's mesh with contact at nodes contact is exact (semismooth, Uzawa) or soft (penalty).
# Between nodes, an elastic layer far thinner than the section makes the path smooth: multipliers
# can then be eliminated, which is the penalty method with a stiffness that needs no tuning.

# %%
nodes = {"ratio": 1.0, "elements": 40, "degree": 1, "contact": "nodes", "step": 0.002, "to": TO}
layer = {"ratio": 1.0, "elements": 160, "layer": 2.7, "to": TO}
results = {}
for place, parameters in (("nodes", nodes), ("quadrature", layer)):
    for enforcement in ("penalty", "uzawa", "semismooth"):
        if (place, enforcement) == ("quadrature", "uzawa"):
            continue  # augmentation removes the layer, and with it the smooth path
        results[place, enforcement] = measure(enforcement=enforcement, **parameters)

print(f"{'points':11s}{'enforcement':12s}{'CPU s':>8s}{'iterations':>12s}{'penetration/depth':>19s}  outcome")
for (place, enforcement), (_, seconds, iterations, penetration, outcome) in results.items():
    print(f"{place:11s}{enforcement:12s}{seconds:8.2f}{iterations:12d}{penetration:19.1e}  {outcome}")

# %%
figure, axes = plt.subplots(figsize=(7, 4.5), layout="constrained")
for (place, enforcement), (record, *_) in results.items():
    axes.plot(*fx.show.curve_points(record).T, linewidth=0.8, label=f"{enforcement} at {place}")
axes.set(xlabel="deflection of the crown (mm)", ylabel="load on the whole arch (N)")
axes.grid(alpha=0.3)
axes.legend()
figure.savefig("enforcement.png", dpi=150)

# %%
assert results["nodes", "semismooth"][1] < results["nodes", "uzawa"][1]
assert results["nodes", "semismooth"][3] < 1e-6
assert results["quadrature", "penalty"][1] < results["quadrature", "semismooth"][1]
