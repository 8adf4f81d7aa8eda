# %% [markdown]
# # The dome
#
# This demo illustrates how parts of several kinds meet in one model: a three-way dome of 42 tubes and 24 flat panels,
# span 8 m and rise 1.6 m, under a force at its apex (thesis, section 5.2). Panels and bars lie in one gmsh model, and
# are read as two meshes with common nodes. Full compatibility needs no equation: `fx.Compatible` gives the nodes of
# the bars the unknowns of the panels.
#
# The thesis prints no coordinates; three geometries are likely (`--geometry hex`, `arc`, `plan` of `sheetfx run
# dome`), of which this is the first.

# %%
import os

import numpy as np

import sheetfx as fx

QUICK = bool(os.environ.get("SHEETFX_QUICK"))
DIVISIONS = 2 if QUICK else 4

steel = fx.Elastic(2.1e5, 0.3)
table = fx.meshes.dome("hex")
model = fx.read_mixed(lambda: fx.meshes.structure(table, DIVISIONS, triangles=False), bars=["bars"])
panels = fx.Shell(model.surfaces, fx.Plate(10.0), steel)
bars = fx.Beam(model.curves, fx.Tube(40.0, 2.0), steel)


def under_its_force(*parts, joints=()):
    """The apex of some parts under a force, the corners pinned."""
    mesh = parts[0].mesh
    return fx.Scene(parts, [fx.pin(mesh, "corners")], [fx.PointForce(mesh, "apex", (0.0, 0.0, -1.0))],
                    fx.Monitor(mesh, "apex", "z", -1.0), joints=joints)


coupled = under_its_force(bars, panels, joints=[fx.Compatible(model.curves, model.surfaces)])

# %% [markdown]
# ## What the panels do
#
# `State.reference` holds the work of the first response,
# the reciprocal of the initial stiffness under a unit force.

# %%
stiffness = {}
for name, scene in (("bars", under_its_force(bars)), ("coupled", coupled)):
    first = next(iter(fx.Path(scene)))
    stiffness[name] = 1 / first.reference[1] / 1e3
    print(f"{name}: {stiffness[name]:.2f} kN/mm")
assert 15 < stiffness["coupled"] / stiffness["bars"] < 25
assert abs(stiffness["coupled"] / 59.5 - 1) < 0.03, "converged meshes have 59.5 kN/mm"

# %% [markdown]
# ## The first critical point
#
# The path is followed until something happens: an event of one's own is as good as a bound.

# %%
case = fx.Case(coupled, until=fx.Until(lambda state: bool(state.critical)),
               axes=("deflection of the apex (mm)", "load (N)"))
record = fx.trace(case)
point = record.critical_points[0]
modes = record.critical_modes(point)
in_bars, in_panels = record.energy_shares(modes)
linear = min(b.load for b in record.buckling(record.states[0], count=2) if b.factor > 0)
print(f"{point.title} at {point.load / 1e3:.1f} kN, {point.deflection:.2f} mm; {100 * in_panels:.0f} % of the mode's "
      f"energy in panels; linear buckling load {linear / 1e3:.1f} kN")
assert in_panels > 0.9

# %% [markdown]
# A mode of the panels around the apex, which bulge up and down in turn. The point is an unstable symmetric one: with an
# imperfection the dome fails below it. Koiter's coefficient $b$ says how the branch falls,
# $P = P_c (1 + b\, \xi^2)$ with the mode's largest displacement $\xi$ in mm. The start of the branch is a solution of
# all equations:

# %%
if point.kind == "bifurcation" and point.multiplicity == 1:
    branch = record.branches(point)[0]
    predicted = point.load * (1 + point.curvature * branch.amplitude**2)
    print(f"branch at an amplitude of {branch.amplitude:.2f} mm: {branch.start.load / 1e3:.2f} kN, asymptotic law "
          f"{predicted / 1e3:.2f} kN")
    fall = point.load - branch.start.load
    assert abs(predicted - branch.start.load) < 0.1 * abs(fall)
    assert np.sign(point.curvature) == -np.sign(fall)
