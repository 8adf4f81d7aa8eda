# %% [markdown]
# # What a shell costs
#
# This demo illustrates where the time of a nonlinear path goes: the pinched hemisphere in two load steps, from a
# thousand unknowns to a hundred thousand. The factorisation and back-substitution are MUMPS's, the rest is sheetfx's.
#
# Times are CPU seconds of the path alone: without the mesh, the compilation and the setting up of the system.

# %%
import os
import time

import matplotlib.pyplot as plt

import sheetfx as fx
from sheetfx.scenes import hemisphere

QUICK = bool(os.environ.get("SHEETFX_QUICK"))
CELLS = {"naghdi-q3": [4, 6], "naghdi-q2": [6, 9]}
if not QUICK:
    CELLS = {"naghdi-q3": [4, 8, 13, 21, 42], "naghdi-q2": [6, 12, 20, 32, 63]}


def measure(form, cells):
    """Unknowns, factorisations, and CPU seconds of assembly, of factorisation and back-substitution, and in all."""
    case = hemisphere.case(cells=cells, form=form)
    path = fx.Path(case.scene, case.control, case.until)
    seconds, before = path.clock.seconds, path.tracer.total_factorisations
    seconds.clear()
    start = time.process_time()
    *_, last = path
    total = time.process_time() - start
    assert last.step == 2
    return (path.unknowns, path.tracer.total_factorisations - before, seconds["assembly"],
            seconds["factorisation"] + seconds["solve"], total)


# %%
results = {}
print(f"{'form':12s}{'unknowns':>9s}{'factorisations':>16s}{'CPU s':>9s}{'assembly':>10s}{'solver':>8s}{'rest':>7s}")
for form, cells in CELLS.items():
    measure(form, 2)  # compiles
    results[form] = [measure(form, n) for n in cells]
    for size, count, assembly, solver, total in results[form]:
        print(f"{form:12s}{size:9d}{count:16d}{total:9.2f}{assembly / total:10.1%}{solver / total:8.1%}"
              f"{1 - (assembly + solver) / total:7.1%}")

# %%
figure, (left, right) = plt.subplots(1, 2, figsize=(10.5, 4.4), layout="constrained")
for (form, rows), style in zip(results.items(), ("C0o-", "C1s-"), strict=True):
    sizes = [row[0] for row in rows]
    left.loglog(sizes, [row[4] / row[1] for row in rows], style, label=form)
    right.semilogx(sizes, [row[3] / row[4] for row in rows], style, label=form)
left.set(xlabel="unknowns", ylabel="CPU seconds for a Newton step")
right.set(xlabel="unknowns", ylabel="share of factorisation and back-substitution", ylim=(0, 1))
right.axhline(0.6, color="0.6", linestyle="--", linewidth=1, label="target at 25 000 unknowns")
for axes in (left, right):
    axes.grid(alpha=0.3, which="both")
    axes.legend()
figure.savefig("speed.png", dpi=150)

# %%
if not QUICK:
    for form, rows in results.items():
        size, _, _, solver, total = min(rows, key=lambda row: abs(row[0] - 25000))
        print(f"{form}: {solver / total:.2f} of the time at {size} unknowns is the solver's; target 0.6")
        assert solver / total >= 0.5

# %% [markdown]
# ## Against plain Newton
#
# Plain Newton's tangent takes the stress of the current strains, and its radius is the shell's thickness. Here
# it takes the smallest number of equal load steps with which it arrives.


# %%
def factorisations(steps, mixed):
    """Of the path in equal steps, none of which may be cut; None where one does not converge."""
    scene = hemisphere.case(cells=6).scene
    control = fx.LoadControl(step=1 / steps, fixed=True, smallest=1.0)
    try:
        return sum(state.factorisations for state in fx.trace(fx.Case(scene, control, mixed_points=mixed)).states)
    except fx.PathFailure:
        return None


def fewest(mixed):
    """Smallest number of steps, and its factorisations."""
    return next((n, count) for n in (1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64) if (count := factorisations(n, mixed)))


counts = {"mixed points": (2, factorisations(2, True)), "plain Newton": fewest(False)}
for name, (steps, count) in counts.items():
    print(f"{name}: {steps} load steps, {count} factorisations")
ratio = counts["plain Newton"][1] / counts["mixed points"][1]
print(f"plain Newton factors {ratio:.1f} times as often")
assert ratio > 2
