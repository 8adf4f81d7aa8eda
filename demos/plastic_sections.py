# %% [markdown]
# # Plastic sections: moment and curvature, layers and fibres
# A plastic material makes sheetfx integrate von Mises's law over layers of a plate and fibres of a beam. This demo
# bends a rectangle, a tube and a plate to ten times their yield curvature and compares their moments with exact ones,
# for 3 to 11 points and three rules; lets a rectangle go and looks at the stress that stays; and prints how Newton's
# method converges in plastic flow.
#
# With $m = M / M_y$ and $k = \kappa / \kappa_y$ a rectangle of a material with tangent modulus $E_t$ carries
# $m = (E_t/E)\, k + (1 - E_t/E)(3/2 - 1/(2k^2))$. A plate that bends to a cylinder does the same where Poisson's ratio
# is 1/2: its stress along the axis is half of that across, in the plastic range too, so that it yields at
# $2 \sigma_y / \sqrt 3$ (plane strain). A tube is a disc less a smaller one, integrated by adaptive quadrature.

# %%
from math import pi, sqrt
from time import process_time

import matplotlib.pyplot as plt
import numpy as np
from scipy.integrate import quad

import sheetfx as fx
from sheetfx import meshes
from sheetfx.model.plasticity import Fibres, Layers

MODULUS, YIELD = 200e3, 200.0
PERFECT = fx.Plastic(MODULUS, 0.5, yield_stress=YIELD)
HARDENING = fx.Plastic(MODULUS, 0.5, yield_stress=YIELD, hardening=10e3)
TIMES, POINTS = np.linspace(1.01, 10, 60), (3, 5, 7, 9, 11)
RULES = {"gauss": "o-", "lobatto": "s--", "simpson": "^:"}


def moments(law, place, curvatures):
    """Moments of a path of curvatures, each from the history that the last one left; and that history."""
    strains, history, found = np.zeros((1, 9 if isinstance(law, Layers) else 3)), np.zeros((1, law.remembered)), []
    for strains[0, place] in curvatures:
        resultants, _, history = law.update(strains, history)
        found.append(resultants[0, place])
    return np.array(found), history[0]


def bent(section, material):
    """Fibres of a beam's section in the plane; the third strain is the curvature."""
    return Fibres(*section.fibres(), material, section.stiffness(material, 2))


def layered(points, rule, material):
    """A rectangle of unit width and depth whose fibres stand as the layers of a plate."""
    places, weights = fx.Plate(1.0, points=points, rule=rule).layers()
    return Fibres(np.column_stack((places, 0 * places)), weights, material, [MODULUS, 1.0, MODULUS / 12])


# %% [markdown]
# ## Exact moments

# %%
def exact(times, material=PERFECT):
    share = material.hardening / (MODULUS + material.hardening)
    return share * times + (1 - share) * (1.5 - 0.5 / times**2)


def disc(radius, first, curvature):
    """Moment of a disc by adaptive quadrature over its height; fibres beyond `first` flow."""
    def stress(y):
        return MODULUS * curvature * y if y < first else YIELD

    return 4 * quad(lambda y: y * stress(y) * sqrt(radius**2 - y**2), 0, radius,
                    points=[min(first, radius)], limit=200, epsabs=1e-13)[0]


TUBE = fx.Tube(1.0, 0.1)
FIRST = {"rectangle": 2 * YIELD / MODULUS, "plate": 2 * YIELD * 0.75 / MODULUS * 2 / sqrt(3),
         "tube": 2 * YIELD / MODULUS}
LARGEST = {"rectangle": YIELD / 6, "plate": 2 / sqrt(3) * YIELD / 6, "tube": 2 * YIELD * TUBE.second_moments[1]}
TUBES = np.array([disc(0.5, 0.5 / t, t * FIRST["tube"]) - disc(0.4, 0.5 / t, t * FIRST["tube"]) for t in TIMES])
EXACT = {"rectangle": exact(TIMES), "plate": exact(TIMES), "tube": TUBES / LARGEST["tube"]}
assert abs(disc(0.5, 1.0, 1e-3) / (1e-3 * MODULUS * pi / 64) - 1) < 1e-9


def law_of(kind, points, rule="gauss", material=PERFECT):
    if kind == "plate":
        plate = fx.Plate(1.0, points=points, rule=rule)
        return Layers(*plate.layers(), material, plate.stiffness(material)), 3
    if kind == "tube":
        return bent(fx.Tube(1.0, 0.1, points=points), material), 2
    return layered(points, rule, material), 2


def curve(kind, *law):
    return moments(*law_of(kind, *law), TIMES * FIRST[kind])[0] / LARGEST[kind]


errors = {}
for kind, rules in (("rectangle", RULES), ("plate", RULES), ("tube", ("gauss",))):
    for rule in rules:
        errors[kind, rule] = [float(np.abs(curve(kind, n, rule) / EXACT[kind] - 1).max()) for n in POINTS]
        print(f"{kind:9} {rule:8}", *(f"{n}: {e:.2%} " for n, e in zip(POINTS, errors[kind, rule], strict=True)))
hardened = np.abs(curve("plate", 11, "gauss", HARDENING) / exact(TIMES, HARDENING) - 1).max()
print(f"plate that hardens, 11 layers: {hardened:.2%}")

# %% [markdown]
# Errors fall with about the square of the number of points, and a plate errs as the rectangle does.

# %%
BOUNDS = {"gauss": (0.15, 0.06, 0.015), "lobatto": (0.34, 0.09, 0.015), "simpson": (0.34, 0.09, 0.015)}
for kind in ("rectangle", "plate"):
    for rule, bounds in BOUNDS.items():
        assert all(errors[kind, rule][n] < bound for n, bound in zip((0, 1, 4), bounds, strict=True)), (kind, rule)
    order = np.log(errors[kind, "gauss"][0] / errors[kind, "gauss"][-1]) / np.log(POINTS[-1] / POINTS[0])
    assert order > 1.7
assert np.allclose(errors["plate", "gauss"], errors["rectangle", "gauss"], rtol=1e-6)
assert errors["tube", "gauss"][0] < 0.03 and errors["tube", "gauss"][-1] < 2e-3 and hardened < 0.015

# %% [markdown]
# ## Unloading and reloading
# A rectangle is bent to three times its yield curvature, let go, and bent to five times. It unloads along $EI$, so that
# the stress $\sigma - M y / I$ stays, and comes back to the curve where it left it.

# %%
def after_unloading(points):
    """Curvature that stays, places of the layers, residual stresses, and moments on the way back up."""
    law, place = law_of("rectangle", points)
    bent_to = 3 * FIRST["rectangle"]
    (moment,), _ = moments(law, place, [bent_to])
    left = bent_to - moment / law.update(np.zeros((1, 3)), np.zeros((1, law.remembered)))[1][0, 2, 2]
    found, history = moments(law, place, [bent_to, left])
    again, _ = moments(law, place, [bent_to, left, (left + bent_to) / 2, bent_to, 5 * FIRST["rectangle"]])
    straight, _ = moments(law, place, [5 * FIRST["rectangle"]])
    assert abs(found[1]) < 1e-12 * moment and abs(again[2] - moment / 2) < 1e-12 * moment
    assert abs(again[3] - moment) < 1e-12 * moment and abs(again[4] - straight[0]) < 1e-12 * moment
    places = fx.Plate(1.0, points=points).layers()[0]
    return left / FIRST["rectangle"], places, MODULUS * (places * left + history[::3])


def residual(y, times=3.0):
    """Exact stress over the yield stress that stays at a distance from the axis of a rectangle of unit depth."""
    return np.clip(2 * times * y, -1, 1) - exact(times) * 2 * y


unloaded = {n: after_unloading(n) for n in (5, 11, 41)}
for n, (left, places, stresses) in unloaded.items():
    off = np.abs(stresses / YIELD - residual(places)).max()
    print(f"{n} layers: {left:.4f} of the yield curvature stays (exact {3 - exact(3.0):.4f}); "
          f"largest error of the residual stress {off:.2%} of the yield stress")
    assert off < {5: 0.03, 11: 0.005, 41: 1e-3}[n] and abs(left - 3 + exact(3.0)) < {5: 0.03, 11: 0.005, 41: 1e-3}[n]

# %% [markdown]
# ## Newton's method in plastic flow
# Moduli are the derivatives of the stresses that the return mapping gives, so that each iteration with a new tangent
# doubles the digits: a cantilever whose fibres have begun to flow, the residuals of its last load step over the load.
# The last correction keeps the tangent before, which is good enough for the rest.

# %%
mesh = fx.read(lambda: meshes.frame({"base": (0, 0), "tip": (1, 0)}, {"beam": ("base", "tip", 8)}), 2)
beam = fx.Beam(mesh, fx.Rectangle(0.1, 0.1), fx.Plastic(1e3, 0.3, yield_stress=1.0, hardening=10.0))
scene = fx.Scene([beam], [fx.clamp(mesh, "base")], [fx.PointForce(mesh, "tip", (0.0, 1.0))],
                 fx.Monitor(mesh, "tip", "y"))
path = fx.Path(scene, fx.LoadControl(step=1e-4, target=3e-4, fixed=True), mixed_points=False)
residuals = [list(path.tracer.stepper.history) for state in path if state.step][-1]
print("residuals of the last step:", *(f"{r:.1e}" for r in residuals))
first, second, last = residuals[-3:]
assert last < max(100 * second**2, 1e-9) and second < 0.1

# %% [markdown]
# ## Without layers
# `fx.Shell(mesh, plate, steel, law=fx.Ilyushin(plate, steel))` lets the section flow as a whole, by Ilyushin's
# condition for stress resultants. Force and moment of a fully plastic strip obey $m = 1 - n^2$; his surface is within
# 4 % of that. The price is the way there: a bent section stays elastic until all of it flows. Strains grow in
# proportion here, to a hundred times the first yield's.

# %%
PLATE = fx.Plate(1.0)
LAWS = {"Ilyushin": fx.Ilyushin(PLATE, PERFECT)} | {f"{n} layers": law_of("plate", n)[0] for n in (5, 11)}
SIZES = 2 / sqrt(3) * YIELD * np.array([1, 1 / 4])


def interaction(law):
    """Force and moment over the fully plastic section's, in proportions from pure bending to stretching."""
    strains, ways = np.zeros((81, 9)), np.linspace(0, pi / 2, 81)
    strains[:, 0], strains[:, 3] = 0.1 * np.sin(ways) ** 3, 0.4 * np.cos(ways)
    return law.update(strains, np.zeros((81, law.remembered)))[0][:, [0, 3]] / SIZES


def beyond(pairs):
    """How far pairs lie beyond m = 1 - n^2, along the ray from the origin."""
    n, m = pairs.T
    return (m + np.sqrt(m**2 + 4 * n**2)) / 2 - 1


def seconds(law, points=4000):
    """CPU time of an evaluation at points that flow."""
    strains, history = np.random.default_rng(1).uniform(-4e-3, 4e-3, (points, 9)), np.zeros((points, law.remembered))
    law.update(strains[:1], history[:1])
    times = []
    for _ in range(5):
        start = process_time()
        law.update(strains, history)
        times.append(process_time() - start)
    return np.median(times) / points


surface, costs = {name: interaction(law) for name, law in LAWS.items()}, {n: seconds(law) for n, law in LAWS.items()}
for name, pairs in surface.items():
    off = np.abs(beyond(pairs)).max()
    print(f"{name:10} off the exact surface by {off:.2%}; {1e6 * costs[name]:.1f} microseconds at each point")
    assert off < {"Ilyushin": 0.04, "5 layers": 0.06, "11 layers": 0.02}[name]
assert costs["Ilyushin"] < 0.6 * costs["5 layers"]

# %%
figure, (left, middle, right, last) = plt.subplots(1, 4, figsize=(19.0, 4.6), layout="constrained")
for name, pairs in surface.items():
    last.plot(*pairs.T, label=f"{name}: {costs[name] / costs['5 layers']:.2f} of the time")
forces = np.linspace(0, 1, 101)
last.plot(forces, 1 - forces**2, "k--", linewidth=1, label="exact")
last.set(xlabel="force / largest force", ylabel="moment / largest moment", title="fully plastic strip")
for n, colour in ((3, "C3"), (5, "C1"), (11, "C2")):
    left.plot(TIMES, curve("rectangle", n), colour, label=f"{n} layers")
left.plot(TIMES, EXACT["rectangle"], "k--", linewidth=1, label="exact: rectangle, plate")
left.plot(TIMES, curve("tube", 3), "C0", label="tube, 3 fibres a quarter")
left.plot(TIMES, EXACT["tube"], "k:", linewidth=1, label="exact: tube")
left.set(xlabel="curvature / yield curvature", ylabel="moment / yield moment", title="perfect plasticity")
for (kind, rule), found in errors.items():
    if kind != "plate":
        middle.loglog(POINTS, found, RULES[rule], label=f"{kind}, {rule}")
middle.set_xticks(POINTS, [str(n) for n in POINTS], minor=False)
middle.minorticks_off()
middle.set(xlabel="points: layers, or fibres on a quarter", ylabel="largest error of the moment",
           title="up to ten times the yield curvature")
heights = np.linspace(-0.5, 0.5, 401)
right.plot(residual(heights), heights, "k--", linewidth=1, label="exact")
for (n, (_, places, stresses)), mark in zip(unloaded.items(), ("o", "s", "."), strict=True):
    right.plot(stresses / YIELD, places, mark, markerfacecolor="none", label=f"{n} layers")
right.set(xlabel="residual stress / yield stress", ylabel="height / depth", title="let go at 3 yield curvatures")
for axes in (left, middle, right, last):
    axes.grid(color="#dddddd", linewidth=0.6)
    axes.legend(fontsize=9, frameon=False)
figure.savefig("plastic_sections.png", dpi=100)
