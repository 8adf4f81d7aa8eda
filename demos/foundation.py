# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: percent
# ---

# %% [markdown]
# # A compressed beam on an elastic foundation
# Two contributions of one's own: a Winkler foundation by its weak form, and a hardening spring by its forces and
# stiffness at a node. A hinged beam on the foundation buckles at P = EI (n pi / L)^2 + k (L / n pi)^2, least over the
# number n of half-waves (Hetenyi 1946, section 42); the spring at the middle leaves modes with a node there alone.

# %%
import numpy as np

import sheetfx as fx


class Winkler(fx.Joint):                                # virtual work against a motion: k u . variation of u
    def __init__(self, beam, modulus):
        self.beam, self.modulus = beam, modulus

    def work(self, fields):
        u = fields.displacement(self.beam.mesh)[1]
        return self.modulus * u * fields.vary(u) * self.beam.measure()


class Hardening(fx.Joint):                              # force k v + c v^3 and its derivative at a node
    def __init__(self, mesh, at, linear, cubic):
        self.mesh, self.at, self.linear, self.cubic = mesh, at, linear, cubic

    def contributions(self, fields):
        def law(u):
            force, stiffness, v = np.zeros_like(u), np.zeros((*u.shape, 2)), u[:, 1]
            force[:, 1], stiffness[:, 1, 1] = self.linear * v + self.cubic * v**3, self.linear + 3 * self.cubic * v**2
            return force, stiffness
        yield fx.PointWork(fields.unknowns, [fields.trace(self.mesh, fields.nodes(self.mesh, self.at))], law)


def beam_on_foundation(modulus, linear=0.0, cubic=0.0):
    nodes = {"base": (0.0, 0.0), "middle": (0.5, 0.0), "tip": (1.0, 0.0)}
    mesh = fx.read(lambda: fx.meshes.frame(nodes, {"left": ("base", "middle", 16), "right": ("middle", "tip", 16)}), 2)
    beam = fx.Beam(mesh, fx.Rectangle(1.0, 0.001), fx.Elastic(12e9))           # EI = 1
    scene = fx.Scene([beam], [fx.pin(mesh, "base"), fx.Support(mesh, "tip", "y")],
                     [fx.PointForce(mesh, "tip", (-1.0, 0.0))], fx.Monitor(mesh, "middle", "y"),
                     joints=[Winkler(beam, modulus), Hardening(mesh, "middle", linear, cubic)])
    return fx.trace(fx.Case(scene, fx.LoadControl(20.0, target=130.0)))


# %% [markdown]
# ## Hetenyi's closed form
# With k = 2000 the beam buckles in two half-waves first.

# %%
modulus = 2000.0
exact = sorted((n * np.pi) ** 2 + modulus / (n * np.pi) ** 2 for n in range(1, 6))
found = [p for p in beam_on_foundation(modulus).critical_points if p.kind == "bifurcation"]
for point, load in zip(found, exact, strict=False):
    print(f"{point.title}: {point.load:.4f}, closed form {load:.4f}")
    assert abs(point.load / load - 1) < 1e-3
assert len(found) == sum(load < 130.0 for load in exact) == 2

# %% [markdown]
# ## With the spring
# A spring at the middle cannot hinder the mode of two half-waves, whose middle stays; its cubic part enters Koiter's b
# of the symmetric modes alone.

# %%
held = [p for p in beam_on_foundation(modulus, linear=200.0).critical_points if p.kind == "bifurcation"]
assert abs(held[0].load / exact[0] - 1) < 1e-3 and held[1].load > 1.01 * exact[1]
curvatures = [[p.curvature for p in beam_on_foundation(modulus, 200.0, cubic).critical_points[:2]]
              for cubic in (0.0, 1e6)]
print("Koiter's b without and with the cubic part:", curvatures)
assert abs(curvatures[1][0] - curvatures[0][0]) < 1e-3 * abs(curvatures[0][0])
assert curvatures[1][1] > 2 * curvatures[0][1]
