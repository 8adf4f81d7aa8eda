# %% [markdown]
# # Triangles
# This demo illustrates how far shells of triangles are off: linear problems that are known for locking and for strains
# that are left out, on regular, crossed, unstructured and distorted meshes, beside quadrilaterals.
#
# Errors are in percent of a converged value, positive where the structure is too soft. `naghdi-t2` and `naghdi-t3`
# interpolate membrane strains in Regge's space and transverse shear strains in Nedelec's
# (`sheetfx/model/interpolation.py`).

# %%
import os
from functools import partial
from math import pi, radians

import gmsh
import numpy as np
import ufl

import sheetfx as fx
from sheetfx.model.shell import FORMS, TRIANGLE

QUICK = bool(os.environ.get("SHEETFX_QUICK"))


# %% [markdown]
# ## Meshes of the unit square

# %%
def grid(nx, ny, kind, distortion=0.0):
    """Vertices and cells: "quad", "left", "right" (diagonals) or "cross"; inner vertices moved at random.

    Those at half the height stay there, where problems change the size of their cells.
    """
    places = np.stack(np.meshgrid(np.linspace(0, 1, nx + 1), np.linspace(0, 1, ny + 1), indexing="ij"), axis=-1)
    moved = np.random.default_rng(3).uniform(-1, 1, places.shape) * distortion / np.array([nx, ny])
    moved[[0, -1], :, 0] = moved[:, [0, ny // 2, -1], 1] = 0.0
    places, cells = list((places + moved).reshape(-1, 2)), []
    for i in range(nx):
        for j in range(ny):
            a, b, c, d = ((i + k) * (ny + 1) + j + m for k, m in ((0, 0), (1, 0), (0, 1), (1, 1)))
            if kind == "quad":
                cells.append((a, b, d, c))
            elif kind == "cross":
                places.append(np.mean([places[n] for n in (a, b, c, d)], axis=0))
                cells += [(*edge, len(places) - 1) for edge in ((a, b), (b, d), (d, c), (c, a))]
            else:
                cells += [(a, b, c), (b, d, c)] if kind == "left" else [(a, b, d), (a, d, c)]
    return np.array(places), np.array(cells)


def build(places, cells):
    """The grid as a gmsh model, with its edges and corners named."""
    corners = {"south-west": (0, 0), "south-east": (1, 0), "north-east": (1, 1), "north-west": (0, 1)}
    numbers = {name: int(np.argmin(((places - at) ** 2).sum(axis=1))) for name, at in corners.items()}
    model = gmsh.model
    for tag, (name, number) in enumerate(numbers.items(), 1):
        model.addDiscreteEntity(0, tag)
        model.mesh.addNodes(0, tag, [number + 1], [*places[number], 0.0])
        model.mesh.addElementsByType(tag, 15, [], [number + 1])
        model.addPhysicalGroup(0, [tag], name=name)
    for tag, (name, axis, value) in enumerate((("south", 1, 0), ("east", 0, 1), ("north", 1, 1), ("west", 0, 0)), 1):
        on = np.flatnonzero(np.abs(places[:, axis] - value) < 1e-12)
        on = on[np.argsort(places[on, 1 - axis])]
        model.addDiscreteEntity(1, tag)
        model.mesh.addNodes(1, tag, on[1:-1] + 1, np.column_stack((places[on[1:-1]], 0 * on[1:-1])).ravel())
        model.mesh.addElementsByType(tag, 1, [], np.column_stack((on[:-1], on[1:])).ravel() + 1)
        model.addPhysicalGroup(1, [tag], name=name)
    inside = np.flatnonzero(((places > 1e-12) & (places < 1 - 1e-12)).all(axis=1))
    model.addDiscreteEntity(2, 1)
    model.mesh.addNodes(2, 1, inside + 1, np.column_stack((places[inside], 0 * inside)).ravel())
    model.mesh.addElementsByType(1, 2 if cells.shape[1] == 3 else 3, [], cells.ravel() + 1)
    model.addPhysicalGroup(2, [1], name="surface")


def unstructured(nx, ny):
    """Triangles as gmsh makes them by default, in a lower and an upper half of a rectangle nx by ny, of size 1."""
    geo = gmsh.model.geo
    places = [(0, 0), (nx, 0), (nx, ny / 2), (nx, ny), (0, ny), (0, ny / 2)]
    points = [geo.addPoint(*at, 0, 1.0) for at in places]
    lines = [geo.addLine(points[i], points[(i + 1) % 6]) for i in range(6)]
    middle = geo.addLine(points[2], points[5])
    halves = [geo.addPlaneSurface([geo.addCurveLoop(loop)])
              for loop in ([*lines[:2], middle, lines[5]], [*lines[2:5], -middle])]
    geo.synchronize()
    gmsh.model.addPhysicalGroup(2, halves, name="surface")
    for name, of in {"south": [0], "east": [1, 2], "north": [3], "west": [4, 5]}.items():
        gmsh.model.addPhysicalGroup(1, [lines[n] for n in of], name=name)
    for name, n in {"south-west": 0, "south-east": 1, "north-east": 3, "north-west": 4}.items():
        gmsh.model.addPhysicalGroup(0, [points[n]], name=name)


def surface(form, nx, ny, kind, place):
    """The unit square in cells of a form, placed in space by a function of an array (n, 2)."""
    shape = FORMS[form]
    kind, distortion = ("left" if kind == "distorted" else kind, 0.25 if kind == "distorted" else 0.0)
    kind = kind if shape.cell == TRIANGLE else "quad"
    make, unit = partial(build, *grid(nx, ny, "left" if kind == "gmsh" else kind, distortion)), np.ones(2)
    if kind == "gmsh":
        make, unit = partial(unstructured, nx, ny), np.array([nx, ny])
    return fx.read(make, 3, shape.displacement[1], lambda x: place(x[:, :2] / unit))


# %% [markdown]
# ## Problems
# Each gives a deflection or an energy by linear theory.

# %%
def response(shell, supports, loads, at, component, sign=1.0):
    scene = fx.Scene([shell], supports, loads, fx.Monitor(shell.mesh, at, component, sign))
    path = fx.Path(scene)
    _, places = path.discretisation.monitored(scene.monitor)
    return sign * float(path.tracer.state.response[places].sum())


def work(shell, supports, loads, at):
    """Half the work of the loads by linear theory."""
    scene = fx.Scene([shell], supports, loads, fx.Monitor(shell.mesh, at, "x"))
    path = fx.Path(scene)
    system, state = path.discretisation.system, path.tracer.state
    found = system.create_vector()
    found.array[:] = state.response
    along = found.duplicate()
    system.matrix.mult(found, along)
    return along.dot(found) / 2


def strip(form, n, kind="left", t=0.0032):
    """Strip twisted by 90 degrees, 3 n cells long (MacNeal and Harder 1985): deflection by a force at its end."""
    def place(p):
        y, a = (p[:, 1] - 0.5) * 1.1, p[:, 0] * pi / 2
        return np.column_stack((12 * p[:, 0], y * np.cos(a), y * np.sin(a)))

    mesh, force = surface(form, 3 * n, max(2, n // 4), kind, place), 1.0 if t > 0.1 else 1e-6
    shell = fx.Shell(mesh, fx.Plate(t), fx.Elastic(29e6, 0.22), form=form)
    load = fx.EdgeForce(mesh, "east", (0.0, 0.0, force / 1.1))
    return response(shell, [fx.clamp(mesh, "west")], [load], "south-east", "z") / force


def pinched(form, n, kind="left", t=3.0):
    """Pinched cylinder with diaphragms, radius 300 (Belytschko et al. 1985): deflection under the force."""
    def place(p):
        return 300 * np.column_stack((p[:, 0], np.sin(p[:, 1] * pi / 2), np.cos(p[:, 1] * pi / 2)))

    mesh = surface(form, n, n, kind, place)
    shell = fx.Shell(mesh, fx.Plate(t), fx.Elastic(3e6, 0.3), form=form)
    held = [fx.symmetry(mesh, "west", "x"), fx.symmetry(mesh, "south", "y"), fx.symmetry(mesh, "north", "z"),
            fx.Support(mesh, "east", "y z")]
    return response(shell, held, [fx.PointForce(mesh, "south-west", (0.0, 0.0, -0.25))], "south-west", "z", -1.0)


def saddle(form, n, kind="left", t=1e-3):
    """Hyperbolic paraboloid, one edge clamped, by its weight (Bathe, Iosilevich and Chapelle 2000): its free edge."""
    def place(p):
        x, y = p[:, 0] - 0.5, 0.5 * p[:, 1]
        return np.column_stack((x, y, x**2 - y**2))

    mesh = surface(form, n, max(n // 2, 1), kind, place)
    shell = fx.Shell(mesh, fx.Plate(t), fx.Elastic(2e11, 0.3), form=form)
    held = [fx.clamp(mesh, "west"), fx.symmetry(mesh, "south", "y")]
    return response(shell, held, [fx.SurfaceForce(shell, (0.0, 0.0, -8 * t))], "south-east", "z", -1.0) * 1e3


def roof(form, n, kind="left"):
    """Roof between diaphragms under its weight (Scordelis and Lo 1964): deflection of its free edge."""
    angle = radians(40)

    def place(p):
        return 25 * np.column_stack((p[:, 0], np.sin(angle * p[:, 1]), np.cos(angle * p[:, 1])))

    mesh = surface(form, n, n, kind, place)
    shell = fx.Shell(mesh, fx.Plate(0.25), fx.Elastic(4.32e8, 0.0), form=form)
    held = [fx.symmetry(mesh, "east", "x"), fx.symmetry(mesh, "south", "y"), fx.Support(mesh, "west", "y z")]
    return response(shell, held, [fx.SurfaceForce(shell, (0.0, 0.0, -90.0))], "north-east", "z", -1.0)


def hemisphere(form, n, kind="left", t=0.04):
    """Pinched hemisphere with a hole (MacNeal and Harder 1985): deflection times (0.04 / t)^3."""
    def place(p):
        a, h = pi / 2 * p[:, 0], radians(72) * p[:, 1]
        return 10 * np.column_stack((np.cos(h) * np.cos(a), np.cos(h) * np.sin(a), np.sin(h)))

    mesh, force = surface(form, n, n, kind, place), (t / 0.04) ** 3
    shell = fx.Shell(mesh, fx.Plate(t), fx.Elastic(6.825e7, 0.3), form=form)
    held = [fx.symmetry(mesh, "west", "y"), fx.symmetry(mesh, "east", "x"), fx.Support(mesh, "south-west", "z")]
    loads = [fx.PointForce(mesh, "south-west", (force, 0.0, 0.0)),
             fx.PointForce(mesh, "south-east", (0.0, -force, 0.0))]
    return response(shell, held, loads, "south-west", "x")


def plate(form, n, kind="left", t=1e-3):
    """Clamped square plate under pressure: deflection of its centre times D / q a^4."""
    mesh = surface(form, n, n, kind, lambda p: np.column_stack((p / 2, 0 * p[:, 0])))
    shell = fx.Shell(mesh, fx.Plate(t), fx.Elastic(1.0, 0.3), form=form)
    held = [fx.clamp(mesh, "west"), fx.clamp(mesh, "south"), fx.symmetry(mesh, "east", "x"),
            fx.symmetry(mesh, "north", "y")]
    return response(shell, held, [fx.SurfaceForce(shell, (0.0, 0.0, t**3 / 12 / 0.91))], "north-east", "z")


def hyperboloid(form, n, kind="left", t=1e-3, clamped=True):
    """Hyperboloid under a pressure of cos 2 theta (Hiller and Bathe 2003): energy; cells graded to a clamped end."""
    layer = min(0.5, 6 * t**0.5) if clamped else 0.5  # that half of the cells are in

    def place(p):
        y = np.where(p[:, 1] < 0.5, 2 * p[:, 1] * (1 - layer), 1 - layer + (2 * p[:, 1] - 1) * layer)
        r, a = np.sqrt(1 + y**2), p[:, 0] * pi / 2
        return np.column_stack((r * np.cos(a), y, r * np.sin(a)))

    mesh, force = surface(form, n, n, kind, place), 1e6 * (t if clamped else t**3)

    def pressure(x):
        r = ufl.sqrt(x[0] ** 2 + x[2] ** 2)
        normal = ufl.as_vector([x[0], -x[1], x[2]]) / ufl.sqrt(r**2 + x[1] ** 2)
        return force * (x[0] ** 2 - x[2] ** 2) / r**2 * normal

    shell = fx.Shell(mesh, fx.Plate(t), fx.Elastic(2e11, 1 / 3), form=form)
    held = [fx.symmetry(mesh, "south", "y"), fx.symmetry(mesh, "west", "z"), fx.symmetry(mesh, "east", "x")]
    held += [fx.clamp(mesh, "north")] if clamped else []
    return work(shell, held, [fx.SurfaceForce(shell, pressure)], "south-west")


# %% [markdown]
# ## Converged values
# By `naghdi-q3` on 32 cells a side, which `naghdi-t3` confirms to 0.4 %; of the plate by series (Taylor and Auricchio
# 1993), of the saddle published (Bathe, Iosilevich and Chapelle 2000).

# %%
PROBLEMS = {
    "strip, t/L 3e-2": (partial(strip, t=0.32), 5.41707e-3),
    "strip, t/L 3e-4": (strip, 5249.88),
    "pinched cylinder, t/R 1e-2": (pinched, 1.8590e-5),
    "saddle, t/L 1e-2": (partial(saddle, t=1e-2), 9.3355e-5),
    "saddle, t/L 1e-3": (saddle, 6.3941e-3),
    "saddle, t/L 1e-4": (partial(saddle, t=1e-4), 0.52988),
    "roof, t/R 1e-2": (roof, 0.302005),
    "hemisphere, t/R 1e-1": (partial(hemisphere, t=1.0), 0.11004),
    "hemisphere, t/R 4e-3": (hemisphere, 0.093734),
    "hemisphere, t/R 1e-5": (partial(hemisphere, t=1e-4), 0.0908),
    "plate, t/L 1e-1": (partial(plate, t=0.1), 1.504626e-3),
    "plate, t/L 1e-3": (plate, 1.265345e-3),
    "plate, t/L 1e-5": (partial(plate, t=1e-5), 1.265319e-3),
    "clamped hyperboloid, t/R 1e-2": (partial(hyperboloid, t=1e-2), 5.39113e-2),
    "clamped hyperboloid, t/R 1e-4": (partial(hyperboloid, t=1e-4), 6.18987e-4),
    "free hyperboloid, t/R 1e-2": (partial(hyperboloid, t=1e-2, clamped=False), 4.52884e-7),
    "free hyperboloid, t/R 1e-4": (partial(hyperboloid, t=1e-4, clamped=False), 4.48531e-13),
}
KINDS = {"naghdi-q2": ("quad", "distorted"), "naghdi-q3": ("quad",),
         "naghdi-t2": ("left", "right", "cross", "gmsh", "distorted"),
         "naghdi-t3": ("left", "right", "cross", "gmsh", "distorted")}


def off(name, form, n, kind):
    """Error in percent, positive where the structure is too soft."""
    solve, converged = PROBLEMS[name]
    return 100 * (solve(form, n, kind) / converged - 1)


# %% [markdown]
# ## Errors with 8 and 16 cells a side

# %%
if __name__ == "__main__":
    chosen, sizes = (list(PROBLEMS)[:2], (4,)) if QUICK else (PROBLEMS, (8, 16))
    for form, kinds in KINDS.items():
        print(f"\n| {form} | {' | '.join(kinds)} |\n|{'---|' * (1 + len(kinds))}")
        for name in chosen:
            cells = (", ".join(f"{off(name, form, n, kind):+.2f}" for n in sizes) for kind in kinds)
            print(f"| {name} | {' | '.join(cells)} |", flush=True)
