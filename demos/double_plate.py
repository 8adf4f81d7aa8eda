# %% [markdown]
# # Two plates that slide on each other
# Each of two steel plates, 80 x 20 x 0.7 mm, is clamped at one end. A force presses the free end of the upper plate
# onto the lower one, which reaches back towards it. The thesis that sheetfx starts from (2006, section 4.5.1) describes
# the path in words; its figure of the layout is missing, and no numbers of its curve survive:
#
# 1. the upper plate bends until it touches the lower one: **A**;
# 2. both together are much stiffer, until the upper plate slides and is bent and compressed: it softens, **B**;
# 3. it stiffens again, and the run ends just before the upper plate slides off the lower one: **C**;
# 4. the contact force is largest when the tip of the upper plate is perpendicular to the lower one.
#
# The gap of 20 mm and the overlap of 40 mm are a choice that shows all of these. Which model shows which stage is the
# question of this notebook. `sheetfx run double-plate` is the same with options; [double_plate.md](double_plate.md) has
# which figures are converged.

# %%
import os
from contextlib import suppress

import matplotlib.pyplot as plt
import numpy as np
import ufl

import sheetfx as fx
from sheetfx import meshes
from sheetfx.forms.shell import ShellStrains
from sheetfx.scenes._stages import draw_stages, touches

QUICK = bool(os.environ.get("SHEETFX_QUICK"))
LENGTH, WIDTH, THICKNESS, GAP, OVERLAP = 80.0, 20.0, 0.7, 20.0, 40.0
MODULUS, POISSON, YIELD = 1.92e5, 0.3, 195.0
CELLS = 4 if QUICK else 16


# %% [markdown]
# ## The weak form of the plates
# A point of the mid-surface goes to $\varphi = x + u$, and its axes $t_1, t_2, n$ turn by the finite rotation $R$. With
# $f_a = t_a + u_{,a}$ and $d = R n$, strains on the turned axes are
# $e_{ab} = \mathrm{sym}(f_a \cdot R t_b) - \delta_{ab}$, $k_{ab} = \mathrm{sym}(d_{,a} \cdot R t_b)$ and
# $\gamma_a = f_a \cdot d$; the virtual work is $\int N \cdot \delta e + M \cdot \delta k + Q \cdot \delta\gamma\, dA$,
# and a term that ties the rotation about the normal to the surface's. Naghdi's strains, which are the default of
# `fx.Shell`, are the same as long as strains are small. In a plastic hinge as short as the plate is thick they are
# not: there $k_{ab} = f_a \cdot d_{,b}$ has the stretch as a factor, the moment brings a force along the plate, and the
# hinge grows weaker the finer the mesh is. Change the function and run the notebook again.

# %%
def strains(u, rotation, frame):
    """Of a flat plate, on axes that turn with it."""
    t, d = frame.tangents, rotation.rotate(frame.director)
    turned, bent = [rotation.rotate(a) for a in t], [frame.along(d, a) for a in t]
    f = [a + frame.along(u, a) for a in t]

    def symmetric(rows, start):
        m = [[ufl.dot(rows[a], turned[b]) - start * (a == b) for b in range(2)] for a in range(2)]
        return ufl.as_vector([m[0][0], m[1][1], m[0][1] + m[1][0]])

    return ShellStrains(membrane=symmetric(f, 1.0), bending=symmetric(bent, 0.0),
                        shear=ufl.as_vector([ufl.dot(f[0], d), ufl.dot(f[1], d)]),
                        drilling=(ufl.dot(f[0], turned[1]) - ufl.dot(f[1], turned[0])) / 2)


# %% [markdown]
# ## The law of contact
# Each point of the free edge has a closest point $y(\xi)$ on the lower plate as it is now. The gap is its distance
# along the normal there, less the thickness; the slip is how far $y$ has travelled along the plate. The virtual work is
# $\int -p\, \delta g + \tau \cdot \delta s\; ds$; the law gives pressure and traction from gap, slip, and the pressure
# and traction of the last augmentation and step. Pressures are augmented until nothing penetrates. Write another law
# here: cohesion, a friction that falls with the slip.

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
# Half of both is modelled, by symmetry about the long axis. The cell next to each clamp is divided, because a plastic
# hinge forms there. The load is a line along the free end, or a force at its middle. Events are functions of a state
# that pass zero: the plates touch, and they slide off, where the path ends. B is where the tangent is no stiffer than
# it was just before A.

# %%
DIVIDED = (0.0, 0.4) if QUICK else (0.0, 0.1, 0.25, 0.45, 0.7)


def plate(x, z, clamped):
    across, lines = max(1, CELLS // 8), np.array([*DIVIDED, *range(1, CELLS + 1)]) * LENGTH / CELLS
    count = len(lines) - 1

    def place(places):
        off = np.interp(np.abs(places[:, 0] - clamped) * count / LENGTH, np.arange(count + 1), lines)
        return np.column_stack((np.abs(off - clamped), places[:, 1:])) + [x, 0.0, z]

    return fx.read(lambda: meshes.rectangle((count, across), (LENGTH, WIDTH / 2), name="plate"), 3, 1, place)


def case(material, friction=0.0, distance=THICKNESS, gap=GAP, line=False, until=None):
    upper, lower = plate(0.0, gap + distance, 0.0), plate(LENGTH - OVERLAP, 0.0, LENGTH)
    contact = fx.SurfaceContact(upper, "east", (lower, None), distance=distance, friction=friction, law=law)
    scene = fx.Scene(
        [fx.Shell(mesh, fx.Plate(THICKNESS, points=10), material, strains=strains) for mesh in (upper, lower)],
        [fx.clamp(upper, "west"), fx.clamp(lower, "east"),
         fx.symmetry(upper, "south", "y"), fx.symmetry(lower, "south", "y")],
        [fx.EdgeForce(upper, "east", (0.0, 0.0, -1 / WIDTH)) if line
         else fx.PointForce(upper, "south-east", (0.0, 0.0, -0.5))],
        fx.Monitor(upper, "south-east", "z", -1.0), symmetry_factor=2, joints=[contact])
    return fx.Case(scene, fx.ArcLength(step=0.03 if QUICK else 0.01, largest=2.5),
                   until or fx.Until(event=fx.slide_off(scene, contact)), events=[fx.first_touch()],
                   axes=("deflection of the free end (mm)", "force (N)"))


def softens(record):
    """Load and deflection at which the tangent is as soft again as it was just before the plates touched."""
    touched = [s.contact_points > 0 for s in record.states]
    first = touched.index(True)
    stiffness = np.array([s.current_stiffness for s in record.states])
    after = next((i for i in range(first + 1, len(touched)) if stiffness[i] < stiffness[first - 1]), None)
    return (record.states[after].load, record.states[after].deflection) if after else None


def report(record):
    for point in record.critical_points:
        print(f"{point.title:24} {point.load:7.2f} N at {point.deflection:6.2f} mm")
    if soft := softens(record):
        print(f"{'B, softens before':24} {soft[0]:7.2f} N at {soft[1]:6.2f} mm")
    forces = [touch.force for touch in touches(record)]
    print(f"contact force: at most {max(forces):.2f} N, {forces[-1]:.2f} N at last")
    return forces


def draw(record):
    draw_stages(record, plt.figure(figsize=(10, 7.5), layout="constrained"))


# %% [markdown]
# ## Against two elasticas
# As strips that do not contract laterally, and that touch with their middle lines, elastic plates without friction are
# two inextensible elasticas, for which an independent solution by shooting is known: they touch at 15.115 N, the
# contact force is 39.39 N at most, and the upper one slides off at 81.62 N and a deflection of 55.66 mm, with a contact
# force of 27.31 N.

# %%
strips = fx.trace(case(fx.Elastic(MODULUS / (1 - POISSON**2), 0.0), distance=0.0, line=True))
forces = report(strips)
first, last = (p for p in strips.critical_points if p.kind == "event")
accuracy = 0.02 if QUICK else 3e-3
assert np.allclose([first.load, max(forces), last.load, last.deflection, forces[-1]],
                   [15.115, 39.39, 81.62, 55.66, 27.31], rtol=accuracy)

# %%
draw(strips)

# %% [markdown]
# ## Friction
# Friction resists the slide: from A on the load is higher. All stages that the thesis describes are on the elastic
# path.

# %%
rough = fx.trace(case(fx.Elastic(MODULUS, POISSON), friction=0.2, until=fx.Until(deflection=21.0) if QUICK else None))
report(rough)
draw(rough)

# %% [markdown]
# ## Yielding
# The thesis's material yields at 195 MPa without hardening. That begins at 3.8 N, before the plates touch: A is at half
# the load of elastic plates. B becomes a limit point at a third of the elastic load: past it the upper plate turns
# about a plastic hinge at its clamp, and the load falls to C. The last stiffening of the thesis is missing, or is a
# rise of less than a thousandth just before C: what the thesis describes is the path of plates that hardly yield.

# %%
steel = fx.Plastic(MODULUS, POISSON, yield_stress=YIELD)
plastic = fx.trace(case(steel, friction=0.2, until=fx.Until(deflection=21.0) if QUICK else None))
report(plastic)
touched = next(p for p in plastic.critical_points if p.kind == "event")
assert 0.9 * 7.09 < touched.load < 1.1 * 7.09
draw(plastic)

# %% [markdown]
# ## A gap of 5 mm
# Where the plates are close from the start, B is followed by a limit point: the load falls from 55 N to 40 N while the
# upper plate slides, and rises again before C.

# %%
if not QUICK:
    close = fx.trace(case(fx.Elastic(MODULUS, POISSON), gap=5.0))
    report(close)
    draw(close)
    assert [p.title for p in close.critical_points if p.kind == "limit"] == ["limit point (maximum)",
                                                                             "limit point (minimum)"]

# %% [markdown]
# ## By hand
# A figure, and two sliders where `ipywidgets` is installed. Paths end at 30 mm. At which gap does B become a limit
# point, and what does friction change in it?


# %%
def path_with(gap=5.0, friction=0.2):
    """The path of elastic plates."""
    return fx.trace(case(fx.Elastic(MODULUS, POISSON), friction, gap=gap, until=fx.Until(deflection=30.0))).curve()


path_with()

# %%
with suppress(ImportError):
    from ipywidgets import interact

    interact(path_with, gap=(5.0, 20.0, 2.5), friction=(0.0, 0.4, 0.1))

# %% [markdown]
# ## Exercises
# - At which gap between 5 and 20 mm does the limit point appear? `fx.Until(deflection=...)` keeps runs short.
# - Give `fx.Shell` no `strains` (Naghdi's), and divide the cell at the clamp more: what becomes of the load at C?
# - Let friction fall with the slip in `law`. Do the plates stick and slip?
# - Give the lower plate half the thickness. Which plate carries the contact force at C?
# - A little hardening, `fx.Plastic(..., hardening=2000.0)`: is B still a limit point?
