# %% [markdown]
# # Large steps
#
# This demo illustrates what the mixed integration point tangent saves (Magisano, Leonetti and Garcea
# 2017): its geometric part uses the stress extrapolated linearly from the previous iterate instead of
# the stress of the current strains. The solution is the same; Newton's radius is not.

# %%
from dataclasses import replace

import sheetfx as fx
from sheetfx.scenes import arch, bend, deep_arch, lee_frame

# %%
CASES = {
    "45-degree bend, 6 load steps": bend.case(),
    "Lee's frame, arc length": lee_frame.case(),
    "215-degree arch, arc length": deep_arch.case(),
    "shallow arch, arc length": arch.case(no_punch=True, elements=40),
}
print(f"{'':32s}{'mixed points':>24s}{'plain Newton':>24s}")
print(f"{'':32s}" + 2 * f"{'steps':>8s}{'factorisations':>16s}")
counts = {}
for name, case in CASES.items():
    for mixed in (True, False):
        record = fx.trace(replace(case, mixed_points=mixed))
        counts[name, mixed] = (record.states[-1].step, sum(s.factorisations for s in record.states))
    print(f"{name:32s}" + "".join(f"{counts[name, m][0]:8d}{counts[name, m][1]:16d}" for m in (True, False)))

# %%
first = "45-degree bend, 6 load steps"
assert counts[first, True][0] == counts[first, False][0] == 6
assert counts[first, True][1] < 0.7 * counts[first, False][1]
