# %% [markdown]
# # Convergence of the beam elements
#
# This demo illustrates how the limit load of a clamped shallow arch converges with the mesh. With as
# many Gauss points as its degree an element of degree $k$ is free of shear and membrane locking, and
# the limit load converges with the power $2k$ of the element's length (superconvergence of reduced
# integrated Timoshenko beams, Arnold 1981).

# %%
import os

import matplotlib.pyplot as plt
import numpy as np

import sheetfx as fx
from sheetfx.scenes.arch import case as arch_case
from sheetfx.scenes.arch import quantities

QUICK = bool(os.environ.get("SHEETFX_QUICK"))


def limit_load(elements, degree):
    case = arch_case(no_punch=True, elements=elements, degree=degree, to=12.0)
    return quantities(fx.trace(case), 4.7625)["limit_load"]


# %%
exact = limit_load(160, 2)
meshes = [5, 10, 20] if QUICK else [5, 10, 20, 40, 80]
figure, axes = plt.subplots(figsize=(6, 4.5), layout="constrained")
for degree, marker in ((1, "o"), (2, "s")):
    errors = [abs(limit_load(n, degree) / exact - 1) for n in meshes[: 4 if degree == 2 else None]]
    counts = meshes[: len(errors)]
    axes.loglog(counts, errors, "C0" + marker, label=f"degree {degree}")
    axes.loglog(counts, errors[-1] * (counts[-1] / np.array(counts)) ** (2 * degree), "k--", linewidth=0.8,
                label=f"order {2 * degree}")
    order = np.log2(errors[1] / errors[2])
    print(f"degree {degree}: errors {', '.join(f'{e:.1e}' for e in errors)}; order {order:.2f}")
    assert abs(order - 2 * degree) < 0.3
axes.set(xlabel="elements on half the arch", ylabel="relative error of the limit load")
axes.grid(alpha=0.3, which="both")
axes.legend()
figure.savefig("convergence.png", dpi=150)
