# %% [markdown]
# # Two plates that slide on each other
# Each of two steel plates, 80 x 20 x 0.7 mm, is clamped at one end. A force presses the free end of the upper plate
# onto the lower one, which reaches back towards it. The thesis (section 4.5.1) describes the path: at A the plates
# touch and it stiffens sharply; at B it softens, as the upper plate begins to slide and is bent and compressed; it
# stiffens again, until at C the upper plate slides off. Its figure of the layout is missing, so that the gap of 20 mm
# and the overlap of 40 mm are a choice that shows all of these. `sheetfx run double-plate` is the same with options.

# %%
import os

import numpy as np
import ufl

import sheetfx as fx
from sheetfx import meshes
from sheetfx.scenes._stages import draw_stages, touches

QUICK = bool(os.environ.get("SHEETFX_QUICK"))
LENGTH, WIDTH, THICKNESS, GAP, OVERLAP = 80.0, 20.0, 0.7, 20.0, 40.0
MODULUS, POISSON, YIELD = 1.92e5, 0.3, 195.0
CELLS = 6 if QUICK else 16


# %% [markdown]
# ## The law of contact
# Pressure and traction follow from the gap along the normal of the lower plate and from the slip, which is how far the
# closest point has moved along it. Pressures are multipliers that are augmented until nothing penetrates. Write another
# law here: cohesion, a pressure that grows with the gap closed, a friction that falls with the slip.

# %%
def law(gap, slips, pressure, tractions, parameters):
    """Unilateral contact with Coulomb friction."""
    normal, tangential, friction = parameters[0], parameters[1], parameters[2]
    pressed = ufl.max_value(pressure - normal * gap, 0)
    if not slips:
        return pressed, []
    trial = [t + tangential * s for t, s in zip(tractions, slips, strict=True)]
    size = ufl.sqrt(sum(t * t for t in trial) + 1e-30)
    share = ufl.conditional(ufl.lt(size, friction * pressed), 1.0, friction * pressed / size)
    return pressed, [share * t for t in trial]


# %% [markdown]
# ## The plates
# Half of both is modelled. Events are functions of a state that pass zero; the path ends at C.

# %%
def plate(x, z):
    across = max(1, CELLS // 8)
    return fx.read(lambda: meshes.rectangle((CELLS, across), (LENGTH, WIDTH / 2), name="plate"), 3, 1,
                   lambda places: places + np.array([x, 0.0, z]))


def case(material, friction=0.0, distance=THICKNESS):
    upper, lower = plate(0.0, GAP + distance), plate(LENGTH - OVERLAP, 0.0)
    contact = fx.SurfaceContact(upper, "east", (lower, None), distance=distance, friction=friction, law=law)
    scene = fx.Scene(
        [fx.Shell(mesh, fx.Plate(THICKNESS), material) for mesh in (upper, lower)],
        [fx.clamp(upper, "west"), fx.clamp(lower, "east"),
         fx.symmetry(upper, "south", "y"), fx.symmetry(lower, "south", "y")],
        [fx.EdgeForce(upper, "east", (0.0, 0.0, -1 / WIDTH))], fx.Monitor(upper, "south-east", "z", -1.0),
        symmetry_factor=2, joints=[contact])
    return fx.Case(scene, fx.ArcLength(step=0.01, largest=2.5), fx.Until(event=fx.slide_off(scene, contact)),
                   events=[fx.first_touch()], axes=("deflection of the free end (mm)", "force (N)"))


def report(record):
    for point in record.critical_points:
        print(f"{point.title:24} {point.load:7.2f} N at {point.deflection:6.2f} mm")
    forces = [touch.force for touch in touches(record)]
    print(f"contact force: at most {max(forces):.2f} N, {forces[-1]:.2f} N at last")
    return forces


# %% [markdown]
# ## Against two elasticas
# As strips that do not contract laterally, and that touch with their middle lines, elastic plates without friction are
# two inextensible elasticas, for which an independent solution by shooting is known: they touch at 15.115 N, the
# contact force is 39.39 N at most, and the upper one slides off at 81.62 N and a deflection of 55.66 mm.

# %%
strips = fx.trace(case(fx.Elastic(MODULUS / (1 - POISSON**2), 0.0), distance=0.0))
forces = report(strips)
first, last = (p for p in strips.critical_points if p.kind == "event")
accuracy = 0.02 if QUICK else 2e-3
assert np.allclose([first.load, max(forces), last.load, last.deflection, forces[-1]],
                   [15.115, 39.39, 81.62, 55.66, 27.31], rtol=accuracy)

# %%
figure = draw_stages(strips)

# %% [markdown]
# ## Friction and yielding
# Friction resists the slide: from A on the load is higher. Yielding begins at 4.3 N, before the plates touch, and makes
# B a limit point: past it the load falls while the upper plate is bent further about its clamp, and rises hardly again
# before C. All stages that the thesis describes are on the elastic path; of the plastic one the last stiffening is
# missing.

# %%
if not QUICK:
    rough = fx.trace(case(fx.Elastic(MODULUS, POISSON), friction=0.2))
    report(rough)
    plastic = fx.trace(case(fx.Plastic(MODULUS, POISSON, yield_stress=YIELD), friction=0.2))
    report(plastic)
    draw_stages(plastic)

# %% [markdown]
# ## Exercises
# - With `GAP = 5.0` the elastic path has a limit point at B. At which gap does it appear?
# - Let friction fall with the slip. Does the plate stick and slip?
# - Give the lower plate half the thickness. Which plate carries the contact force at C?
