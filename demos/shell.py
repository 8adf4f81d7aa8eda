# %% [markdown]
# # A shell of your own
# This demo illustrates how to state the weak form of a shell and how to exchange its strains and its section law.
# The shell has one director $d = R\, n$, the normal $n$ turned by a finite rotation. With tangents $t_a$ and
# $f_a = t_a + u_{,a}$ Naghdi's strains are $e_{ab} = (f_a \cdot f_b - t_a \cdot t_b) / 2$,
# $k_{ab} = f_{(a} \cdot d_{,b)} - t_{(a} \cdot n_{,b)}$ and $g_a = f_a \cdot d - t_a \cdot n$, and the virtual work is
# $\int N \cdot \delta e + M \cdot \delta k + Q \cdot \delta g\; dA$, plus a term that ties the rotation about the
# normal to the surface's.

# %%
import os
from dataclasses import replace
from functools import partial
from math import pi

import matplotlib.pyplot as plt
import numpy as np
from ufl import as_matrix, as_vector, dot

import sheetfx as fx
from sheetfx.forms.shell import ShellStrains
from sheetfx.scenes import hemisphere
from sheetfx.scenes._benchmark import at_load, read_off

QUICK = bool(os.environ.get("SHEETFX_QUICK"))


def symmetric(m):
    return as_vector([m(0, 0), m(1, 1), m(0, 1) + m(1, 0)])


def naghdi(u, rotation, frame):
    t, n, d = frame.tangents, frame.director, rotation.rotate(frame.director)
    f = [a + frame.along(u, a) for a in t]
    return ShellStrains(
        membrane=symmetric(lambda a, b: (dot(f[a], f[b]) - dot(t[a], t[b])) / 2),
        bending=symmetric(lambda a, b: dot(f[a], frame.along(d, t[b])) - dot(t[a], frame.along(n, t[b]))),
        shear=as_vector([dot(f[a], d) - dot(t[a], n) for a in range(2)]),
        drilling=(dot(f[0], rotation.rotate(t[1])) - dot(f[1], rotation.rotate(t[0]))) / 2)


# %% [markdown]
# ## Pinched hemisphere
# A quarter with R / t = 250, pulled at A and pushed at B, as in `sheetfx run hemisphere`, but with the strains above.

# %%
scene = hemisphere.case().scene
scene = replace(scene, parts=[replace(scene.parts[0], strains=naghdi)])
paths = [fx.trace(fx.Case(scene, fx.LoadControl(step=1 / n, fixed=True))) for n in (2, 6 if QUICK else 20)]
for name, value in at_load(paths[0], hemisphere.READINGS).items():
    print(f"hemisphere: {name} = {value:.4f}, reference {hemisphere.REFERENCE[name]:.4f}")
    assert abs(value / hemisphere.REFERENCE[name] - 1) < 1e-2
factorisations = paths[0].path.tracer.total_factorisations
print(f"{len(paths[0].states) - 1} load steps, {factorisations} factorisations")
assert len(paths[0].states) == 3 and factorisations <= 15

# %% [markdown]
# ## Own strains, own law
# A square plate, simply supported on edges that cannot pull in, under a uniform force. With linear strains it follows
# Navier's series (Timoshenko and Woinowsky-Krieger 1959, article 85); von Karman's add slopes to the membrane
# strains. The orthotropic law is ten times as stiff along x: strains are taken on axes of the material.

# %%
T, LOAD = 1e-2, 40e-8
PLANE = {"isotropic": np.array([[1, 0.3, 0], [0.3, 1, 0], [0, 0, 0.35]]) / 0.91,
         "orthotropic": np.array([[10, 0.3, 0], [0.3, 1, 0], [0, 0, 0.5]])}


def von_karman(u, rotation, frame, slopes=1.0):
    t, n = frame.tangents, frame.director
    d, rate = rotation.rotate(n), [frame.along(u, a) for a in t]
    return ShellStrains(
        membrane=symmetric(lambda a, b: dot(rate[a], t[b]) + slopes * dot(rate[a], n) * dot(rate[b], n) / 2),
        bending=symmetric(lambda a, b: dot(frame.along(d, t[b]), t[a])),
        shear=as_vector([dot(rate[a], n) + dot(d, t[a]) for a in range(2)]),
        drilling=dot(rotation.rotate(t[1]), t[0]) + (dot(rate[0], t[1]) - dot(rate[1], t[0])) / 2)


def section(strains, stiffness, plane):
    e, k, g = (as_vector([strains[i] for i in part]) for part in ((0, 1, 2), (3, 4, 5), (6, 7)))
    n, m = (c * as_matrix(plane.tolist()) * x for c, x in ((T, e), (T**3 / 12, k)))
    return as_vector([*n, *m, *(as_matrix(stiffness.shear) * g), stiffness.drilling * strains[8]])


def deflections(measure, plane):
    mesh, axes = fx.read(lambda: fx.meshes.rectangle((6, 6), (0.5, 0.5)), 3, order=2), np.eye(3).tolist()
    plate = fx.Shell(mesh, fx.Plate(T), fx.Elastic(1.0, 0.3), law=partial(section, plane=plane),
                     strains=lambda u, r, frame: measure(u, r, replace(frame, axes=[*map(as_vector, axes)])))
    held = [fx.Support(mesh, "west", "x y z rx"), fx.Support(mesh, "south", "x y z ry"),
            fx.symmetry(mesh, "east", "x"), fx.symmetry(mesh, "north", "y")]
    bent = fx.Scene([plate], held, [fx.SurfaceForce(plate, (0.0, 0.0, LOAD))], fx.Monitor(mesh, "north-east", "z"))
    return [state.deflection / T for state in fx.Path(bent, fx.LoadControl(step=0.2, fixed=True))]


def navier(c):
    m, n = np.meshgrid(*2 * [np.arange(1, 60, 2)])
    bending = c[0, 0] * m**4 + 2 * (c[0, 1] + 2 * c[2, 2]) * (m * n) ** 2 + c[1, 1] * n**4
    return 192 * LOAD / T**4 / pi**6 * np.sum((-1.0) ** ((m + n) // 2 - 1) / m / n / bending)


MEASURES = {"linear": partial(von_karman, slopes=0.0), "von Karman": von_karman, "Naghdi": naghdi}
plates = {(law, name): deflections(m, plane) for law, plane in PLANE.items() for name, m in MEASURES.items()}
for law, plane in PLANE.items():
    linear, moderate, finite = (plates[law, name][-1] for name in MEASURES)
    print(f"{law} plate, w/t: {linear:.4f}, Navier {navier(plane):.4f}; von Karman {moderate:.4f}, Naghdi {finite:.4f}")
    assert abs(linear / navier(plane) - 1) < 5e-3 and abs(moderate / finite - 1) < 5e-3

# %%
figure, (left, right) = plt.subplots(1, 2, figsize=(10.5, 4.6), layout="constrained")
for record, style in zip(paths, ("o", "-"), strict=True):
    rows = [read_off(record, hemisphere.READINGS, i) for i in range(len(record.states))]
    for i, name in enumerate(hemisphere.READINGS):
        u, label = [row[name] for row in rows], f"{name}, {len(rows) - 1} steps"
        left.plot(u, np.linspace(0, 400, len(rows)), f"C{i}{style}", label=label)
left.set(xlabel="displacement", ylabel="each force", title="pinched hemisphere of radius 10")
for (law, name), w in plates.items():
    right.plot(w, np.linspace(0, 40, 6), {"linear": "--", "von Karman": "-", "Naghdi": "o"}[name],
               color=f"C{law == 'isotropic':d}", label=f"{name}, {law}")
right.set(xlabel="deflection of the centre / thickness", ylabel="$q a^4 / E t^4$", title="simply supported plate")
left.legend()
right.legend(fontsize=9)
figure.savefig("shell.png", dpi=150)
