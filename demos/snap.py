# %% [markdown]
# # Snaps
#
# This demo illustrates how to find out where a structure falls when it loses stability in a test, how much energy it
# releases, how the path goes on from there, and how its lowest frequency announces the fall.
#
# A heavily damped structure follows the gradient flow of its energy under what the test holds: the load, or the
# displacement. Its implicit steps are $(K + \sigma W)\, \Delta x = -R$, with a damping $\sigma$ that keeps the matrix
# definite and vanishes towards the end, where they are Newton's.

# %%
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
from mpi4py import MPI

import sheetfx as fx
from sheetfx.scenes import lee_frame
from sheetfx.show.snaps import draw_snaps

# %% [markdown]
# ## Lee's frame under a held load and a held displacement
#
# Its path has two limit points of the load and, between them, snaps back. With a rising load the frame falls forward
# from the first limit point. A test that moves the loaded point goes further, until the displacement has its
# maximum; the frame falls at that displacement then, and the load drops.

# %%
case = lee_frame.case(elements=20, to=93.0)
case = replace(case, control=fx.ArcLength(step=0.02, largest=4.0))
record = fx.trace(case)
limit, lower = record.critical_points
before = next(state for state in record.states if state.unstable_modes)
by_load = fx.snap(record.path, before, hold="load")
(by_displacement,) = fx.snaps(record.path, record.states, hold="displacement")
assert by_load.before.load <= limit.load and by_displacement.after.load >= lower.load
for fall in (by_load, by_displacement):
    print(f"held {fall.hold:12s} load {fall.before.load:9.1f} -> {fall.after.load:9.1f}, deflection "
          f"{fall.before.deflection:6.2f} -> {fall.after.deflection:6.2f}, releases {fall.energy_released:9.1f} "
          f"in {fall.iterations} steps")
    energies = [step.energy for step in fall.history]
    assert np.all(np.diff(energies) <= 0)

# %% [markdown]
# The released energy is the area between the path and the line along which the frame falls.

# %%
def area(fall):
    """Work that the held load does beyond the work of the loads along the path, by small steps from end to end."""
    states, fine = [replace(fall.before, next_length=0.01)], fx.ArcLength(step=0.01, largest=1.0)
    for state in fx.Path(case.scene, fine, fx.Until(steps=1000), start=states):
        if state.load > fall.after.load:
            break
        states.append(state)
    missing = [(s.deflection, fall.after.load - s.load) for s in [*states, fall.after]]
    u, load = np.array(missing).T
    return np.trapezoid(load, u)


found = area(by_load)
print(f"area between path and line {found:.1f}, released {by_load.energy_released:.1f}")
assert abs(by_load.energy_released / found - 1) < 2e-4

# %% [markdown]
# ## The path goes on
#
# A new path starts from the state behind the fall: under a growing load, or a growing displacement.

# %%
def further(fall, steps=4):
    """The next states of the test."""
    return list(fx.Path(case.scene, case.control, fx.Until(steps=fall.after.step + steps), start=[fall.after]))


for fall in (by_load, by_displacement):
    states = [fall.after, *further(fall)]
    print(f"after the fall under a held {fall.hold}:", *(f"({s.deflection:.1f}, {s.load:.0f})" for s in states))
    held = [s.load if fall.hold == "load" else s.deflection for s in states]
    assert held == sorted(held)

by_load.save(Path("snap"), MPI.COMM_WORLD)
report = json.loads(Path("snap/snap.json").read_text())
assert report["energy_released"] == by_load.energy_released

# %%
figure = draw_snaps(record, [by_load, by_displacement])
figure.savefig("snap.png", dpi=150)

# %% [markdown]
# ## The frequency that announces it
#
# Small motions about a state satisfy $K \varphi = \omega^2 M \varphi$. Towards a limit point $\omega^2$ falls to zero,
# with a vertical tangent over the load, and beyond it is negative: disturbances grow.

# %%
heavy = fx.Elastic(case.scene.parts[0].material.modulus, 0.3, density=2.5e-4)
part = fx.Beam(case.scene.parts[0].mesh, lee_frame.SECTION, heavy, shear_rigidity=1e3)
scene = fx.Scene([part], case.scene.supports, case.scene.loads, case.scene.monitor)
path = fx.Path(scene, case.control, fx.Until(deflection=58.0))
table = np.array([(s.load, fx.frequencies(path, s, 1)[0].squared) for s in path])
for load, squared in table:
    print(f"load {load:9.1f}   omega^2 {squared:12.4g}")
beyond = table[:, 1] < 0
assert beyond.any() and not beyond[: np.argmax(table[:, 0])].any() and beyond[-1]
