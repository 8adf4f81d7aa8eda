# %% [markdown]
# # Eight bolts with a radius
#
# The engineer's panel with bolts that hold over the area of their washers: the forces of all bolts along the path, the
# stress at the hole, and the reaction curve as a table. The geometry is taken from `panel.py`.

# %%
import csv
import os

import numpy as np
import panel

import sheetfx as fx

SIZE, RADIUS = 80.0 if os.environ.get("SHEETFX_QUICK") else 60.0, 6.0  # of cells and of washers, mm

skin, hat = panel.meshes(SIZE, 3.0, 4)
parts = [fx.Shell(skin, fx.Plate(t), panel.STEEL, group=group)
         for group, t in (("plate", 4.0), ("web", 3.0), ("flange", 3.0))]
parts.append(fx.Shell(hat, fx.Plate(2.0), panel.STEEL))
bolts = {name: fx.bolt(hat, fx.Disc(name, RADIUS), (skin, "plate"), reach=3.1) for name in sorted(hat.points)}
held = {"west plate": "x z", "west ribs": "x", "east plate": "z", "sides": "z", "south-west": "y", "south-east": "y"}
ends = [fx.PrescribedDisplacement(skin, f"east {of}", "x", -1.0) for of in ("plate", "ribs")]
scene = fx.Scene(parts, [fx.Support(skin, at, fixed) for at, fixed in held.items()], ends,
                 fx.Monitor(skin, "south-east", "x", -1.0), joints=list(bolts.values()))
record = fx.trace(fx.Case(scene, fx.LoadControl(0.1, target=1.5)))

# %%
forces = {name: record.joint_forces(bolt).force for name, bolt in bolts.items()}  # on the plate, in all states
for name, force in forces.items():
    print(f"{name}: shear {np.hypot(*force[-1][:2]):6.0f} N, along its axis {force[-1][2]:5.0f} N")
record.show(record.states[-1])
rim = panel.HOLE_AT[0], panel.HOLE_AT[1] + panel.HOLE, 0.0
for face, height in (("lower", -2.0), ("upper", 2.0)):
    stress = record.value_at(parts[0], record.stresses(parts[0], height), rim)
    print(f"von Mises stress at the hole, {face} face: {fx.von_mises(stress):.0f} MPa")
west, east = (sum(record.reactions(f"{end} {of}").force[:, 0] for of in ("plate", "ribs")) for end in ("west", "east"))
with open("bolted_panel.csv", "w", newline="") as stream:
    writer = csv.writer(stream)
    writer.writerow(["shortening (mm)", "reaction (N)", *(f"{name} (N)" for name in bolts)])
    writer.writerows([state.deflection, reaction, *(np.linalg.norm(force[n]) for force in forces.values())]
                     for n, (state, reaction) in enumerate(zip(record.states, west, strict=True)))
print(f"reaction at {record.states[-1].deflection:.1f} mm: {west[-1] / 1000:.1f} kN")
assert abs(west[-1] + east[-1]) < 1e-6 * west[-1]
assert np.linalg.norm(sum(force[-1] for force in forces.values())[:2]) < 1e-3 * max(
    np.linalg.norm(force[-1]) for force in forces.values())  # nothing else holds the hat
