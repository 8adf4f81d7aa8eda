# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: percent
# ---

# %% [markdown]
# # What it costs to find partners
# Points on the edges of panels slide along the bars of a dome. In each configuration every point needs its partner:
# the closest point of the bars. The thesis (section 3.5.3) searches nodes in two ways, *exhaustively* by the matrix of
# all distances, and by a *sieve*, which stores no matrix and passes over points farther away along one coordinate
# than the least distance so far. (As printed, the sieve compares the difference of two candidates' coordinates with
# the root of a distance, so that its answer hangs on the unit of length; here that of candidate and point, with the
# distance itself. Candidates here are cells, on whose inside partners lie.) The package looks the first partners up in
# a KD-tree (`mesh.projection.Cells`), and after that goes on from where each partner was last
# (`discrete.partners.Partners`). All four must find the same points.
#
# The dome's plan has 42 straight bars and 72 edges of panels that lie 30 mm above them; there are as many pairs on
# an edge as cells in a bar.
#
# ![CPU time of the four searches against the number of pairs](pair_search.png)

# %%
import os
import time

import matplotlib.pyplot as plt
import numba
import numpy as np

import sheetfx as fx
from sheetfx.discrete.nodal_field import AdditiveField
from sheetfx.discrete.partners import Partners
from sheetfx.mesh.projection import Cells

QUICK = bool(os.environ.get("SHEETFX_QUICK"))
COUNTS = (2, 8) if QUICK else (2, 4, 8, 16, 32, 64)  # of pairs on an edge
STEPS, SLIDE, ABOVE = 5, 0.07, (0.0, 0.0, 30.0)  # configurations; slide in each, in spacings of pairs
TABLE = fx.meshes.dome("hex")
NODES = {name: (*place[:2], 0.0) for name, place in TABLE.nodes.items()}
EDGES = [TABLE.named_bars[name.split(" of ")[0].replace("edge", "bar")]
         for name in fx.meshes.edges_of(TABLE, separate=True)]


# %% [markdown]
# ## The two searches of the thesis
# Compiled, over the same straight cells. Both return the closest point of all cells, and how many distances they took.

# %%
@numba.njit
def closest_on(a, b, point):
    """Where on the straight line between two places (0 to 1) a point's closest point is, and the distance."""
    along = length = distance = 0.0
    for k in range(3):
        along += (point[k] - a[k]) * (b[k] - a[k])
        length += (b[k] - a[k]) ** 2
    t = min(max(along / length, 0.0), 1.0)
    for k in range(3):
        distance += (a[k] + t * (b[k] - a[k]) - point[k]) ** 2
    return t, np.sqrt(distance)


@numba.njit
def exhaustive(points, starts, ends):
    distances, t = np.empty((len(points), len(starts))), np.empty((len(points), len(starts)))
    for i in range(len(points)):
        for j in range(len(starts)):
            t[i, j], distances[i, j] = closest_on(starts[j], ends[j], points[i])
    places = np.empty_like(points)
    for i in range(len(points)):
        j = np.argmin(distances[i])
        places[i] = starts[j] + t[i, j] * (ends[j] - starts[j])
    return places, distances.size


@numba.njit
def sieve(points, starts, ends):
    places, taken = np.empty_like(points), 0
    for i in range(len(points)):
        least = np.inf
        for j in range(len(starts)):
            far = False
            for k in range(3):
                low, high = min(starts[j, k], ends[j, k]), max(starts[j, k], ends[j, k])
                far = far or points[i, k] - high >= least or low - points[i, k] >= least
            if not far:
                taken += 1
                t, distance = closest_on(starts[j], ends[j], points[i])
                if distance < least:
                    least, places[i] = distance, starts[j] + t * (ends[j] - starts[j])
    return places, taken


# %% [markdown]
# ## The same points, four times
# CPU time is the median of the configurations. The tree is built anew in each, as bars that move would need it.

# %%
def timed(search, *arguments):
    begin = time.process_time()
    found = search(*arguments)
    return time.process_time() - begin, found


def by_tree(mesh, points):
    cells = Cells(mesh, mesh.group(None))
    which, reference, _ = cells.closest(points)
    return cells.places(which, reference), which, reference


def search_all(count):
    """Number of pairs, median seconds of each search, distances that the thesis's took."""
    from dolfinx import fem  # a wheel's libraries are found once sheetfx is there

    mesh = fx.read(lambda: fx.meshes.frame(NODES, {f"bar {a}-{b}": (a, b, count) for a, b in TABLE.bars}), 3)
    cells = Cells(mesh, mesh.group(None))
    starts, ends = (np.ascontiguousarray(cells.nodes[:, k]) for k in (0, 1))
    fractions = (np.arange(count) + 0.3) / count
    begins, bars = (np.repeat([v(*(np.array(NODES[n]) for n in edge)) for edge in EDGES], count, axis=0)
                    for v in (lambda a, b: a, lambda a, b: b - a))
    along = bars / np.linalg.norm(bars, axis=1)[:, None]
    fractions = np.tile(fractions, len(EDGES))[:, None]

    displacement = fem.Function(fem.functionspace(mesh.domain, ("Lagrange", 1, (3,))))
    _, which, reference = by_tree(mesh, begins + fractions * bars + ABOVE)
    partners = Partners(AdditiveField(displacement, np.arange(len(displacement.x.array)), 1.0), 0, cells, which,
                        reference)
    seconds, taken = [], []
    for step in range(1, STEPS + 1):
        points = begins + (fractions + step * SLIDE / count) * bars + ABOVE
        results = [timed(exhaustive, points, starts, ends), timed(sieve, points, starts, ends),
                   timed(by_tree, mesh, points), timed(partners.follow, points, along)]
        (first, distances), (second, sieved), (third, *_), _ = (found for _, found in results)
        assert partners.on.all()
        for places in (second, third, partners.geometry()[0]):
            assert np.abs(places - first).max() < 1e-9 * mesh.size
        seconds.append([spent for spent, _ in results])
        taken.append((distances, sieved))
    return len(points), *np.median(seconds, axis=0), *np.median(taken, axis=0)


search_all(1)  # compiles
NAMES = "exhaustive", "sieve", "KD-tree", "following"
pairs, *rows = np.array([search_all(count) for count in COUNTS]).T
seconds, (distances, sieved) = dict(zip(NAMES, rows, strict=False)), rows[len(NAMES):]
print(f"{'pairs':>6s}" + "".join(f"{name + ' ms':>15s}" for name in NAMES) + f"{'sieved':>9s}")
for n, *row, share in zip(pairs, *seconds.values(), sieved / distances, strict=True):
    print(f"{n:6.0f}" + "".join(f"{1e3 * s:15.2f}" for s in row) + f"{share:9.1%}")
assert np.all(distances == pairs * pairs * len(TABLE.bars) / len(EDGES)) and np.all(sieved < distances / 4)

# %% [markdown]
# Both searches of the thesis look at every cell for every point; the sieve does so by comparisons, most of the time.
# With the tree and with following the cost grows with the number of pairs alone. Compiled, the sieve is cheaper than
# the tree up to some 800 pairs; at 4608 pairs it takes some 30 times as long as following, the exhaustive search over a
# hundred times.

# %%
if not QUICK:
    orders = {name: np.polyfit(np.log(pairs[-3:]), np.log(s[-3:]), 1)[0] for name, s in seconds.items()}
    print("grows with the power", {name: round(float(order), 2) for name, order in orders.items()})
    assert min(orders["exhaustive"], orders["sieve"]) > 1.6 > 1.3 > max(orders["KD-tree"], orders["following"])
    assert seconds["following"][-1] < seconds["KD-tree"][-1] < seconds["exhaustive"][-1]

# %%
figure, axes = plt.subplots(figsize=(6.5, 4.2), layout="constrained")
for name, marker in zip(NAMES, "sv.o", strict=True):
    axes.loglog(pairs, 1e3 * seconds[name], marker=marker, label=name)
axes.set(xlabel="number of pairs", ylabel="CPU time of a search (ms)")
axes.grid(alpha=0.3)
axes.legend(frameon=False)
figure.savefig("pair_search.png", dpi=100)
