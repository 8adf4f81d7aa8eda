"""Linear problems of thin shells in Kratos Multiphysics, on as many nodes as demos/triangles.py has for degree 2.

docker/run python3 demos/peers/kratos_linear.py

It prints a table: errors in percent of the converged values there, positive where a structure is too soft, of
quadrilaterals (MITC4) and of triangles (discrete Kirchhoff, Batoz 1982, with drilling) with 16 and 32 cells a side.
"""

from __future__ import annotations

import sys
from math import pi, radians
from pathlib import Path

import numpy as np

sys.path.append(str(Path(__file__).parents[2] / ".peers"))

import KratosMultiphysics as Kratos
from kratos import FORCES, LINEAR_MITC4, Shell, at

ELEMENTS = {"quadrilaterals": LINEAR_MITC4, "triangles": "ShellThinElement3D3N"}
ALL = "x y z rx ry rz"
PLANES = {"x": "x ry rz", "y": "y rx rz", "z": "z rx ry"}  # of symmetry, by their normals


def solved(shell, forces):
    """Solve for forces {node: vector}; half their work."""
    for node in forces:
        shell.load(node, "x", 1.0)  # a condition of a node applies all of its components
    controls = [(node, FORCES[axis], value) for node, force in forces.items()
                for axis, value in zip("xyz", force, strict=True)]
    shell.prepare("sparse_lu", 1e-6, 2)
    shell.advance(1, controls, 1.0)
    return sum(at(node, axis) * value for node, force in forces.items()
               for axis, value in zip("xyz", force, strict=True)) / 2


def on_surface(shell, force):
    """Forces at nodes from one per area, a function of places (n, 3), by 2 x 2 points of each quadrilateral."""
    lines = [shell.line(i=i) for i in range(shell.cells[0] + 1)]
    x = np.array([[(node.X0, node.Y0, node.Z0) for node in line] for line in lines])
    corners = [x[:-1, :-1], x[1:, :-1], x[1:, 1:], x[:-1, 1:]]
    found = np.zeros_like(x)
    for r, s in np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) / 3**0.5:
        shares = [(1 - r) * (1 - s) / 4, (1 + r) * (1 - s) / 4, (1 + r) * (1 + s) / 4, (1 - r) * (1 + s) / 4]
        along = ((1 - s) * (corners[1] - corners[0]) + (1 + s) * (corners[2] - corners[3])) / 4
        across = ((1 - r) * (corners[3] - corners[0]) + (1 + r) * (corners[2] - corners[1])) / 4
        area = np.linalg.norm(np.cross(along, across), axis=2, keepdims=True)
        here = area * force(sum(w * c for w, c in zip(shares, corners, strict=True)))
        for w, (i, j) in zip(shares, ((0, 0), (1, 0), (1, 1), (0, 1)), strict=True):
            found[i:i + x.shape[0] - 1, j:j + x.shape[1] - 1] += w * here
    return {node: value for line, values in zip(lines, found, strict=True)
            for node, value in zip(line, values, strict=True)}


def strip(element, n, t):
    def place(s, p):
        y, a = (p - 0.5) * 1.1, s * pi / 2
        return 12 * s, y * np.cos(a), y * np.sin(a)

    shell = Shell((3 * n, max(4, n // 4)), place, (29e6, 0.22, t), element)
    shell.fix(shell.line(i=0), ALL)
    end = shell.line(i=-1)
    solved(shell, {node: (0, 0, (0.5 if node in (end[0], end[-1]) else 1.0) / (len(end) - 1)) for node in end})
    return at(end[0], "z")


def pinched(element, n, t=3.0):
    shell = Shell((n, n), lambda s, p: (300 * s, 300 * np.sin(p * pi / 2), 300 * np.cos(p * pi / 2)), (3e6, 0.3, t),
                  element)
    shell.fix(shell.line(i=0), PLANES["x"])
    shell.fix(shell.line(j=0), PLANES["y"])
    shell.fix(shell.line(j=-1), PLANES["z"])
    shell.fix(shell.line(i=-1), "y z")
    solved(shell, {shell.node(0, 0): (0, 0, -0.25)})
    return -at(shell.node(0, 0), "z")


def saddle(element, n, t):
    def place(s, p):
        x, y = s - 0.5, 0.5 * p
        return x, y, x**2 - y**2

    shell = Shell((n, n // 2), place, (2e11, 0.3, t), element)
    shell.fix(shell.line(i=0), ALL)
    shell.fix(shell.line(j=0), PLANES["y"])
    solved(shell, on_surface(shell, lambda x: np.array([0, 0, -8 * t])))
    return -1e3 * at(shell.node(-1, 0), "z")


def roof(element, n):
    angle = radians(40)
    shell = Shell((n, n), lambda s, p: (25 * s, 25 * np.sin(angle * p), 25 * np.cos(angle * p)), (4.32e8, 0.0, 0.25),
                  element)
    shell.fix(shell.line(i=-1), PLANES["x"])
    shell.fix(shell.line(j=0), PLANES["y"])
    shell.fix(shell.line(i=0), "y z")
    solved(shell, on_surface(shell, lambda x: np.array([0, 0, -90.0])))
    return -at(shell.node(-1, -1), "z")


def hemisphere(element, n, t):
    def place(s, p):
        a, h = pi / 2 * s, radians(72) * p
        return 10 * np.cos(h) * np.cos(a), 10 * np.cos(h) * np.sin(a), 10 * np.sin(h)

    shell, force = Shell((n, n), place, (6.825e7, 0.3, t), element), (t / 0.04) ** 3
    shell.fix(shell.line(i=0), PLANES["y"])
    shell.fix(shell.line(i=-1), PLANES["x"])
    shell.fix([shell.node(0, 0)], "z")
    solved(shell, {shell.node(0, 0): (force, 0, 0), shell.node(-1, 0): (0, -force, 0)})
    return at(shell.node(0, 0), "x")


def plate(element, n, t):
    shell = Shell((n, n), lambda s, p: (s / 2, p / 2, 0.0), (1.0, 0.3, t), element)
    shell.fix([*shell.line(i=0), *shell.line(j=0)], ALL)
    shell.fix(shell.line(i=-1), PLANES["x"])
    shell.fix(shell.line(j=-1), PLANES["y"])
    solved(shell, on_surface(shell, lambda x: np.array([0, 0, t**3 / 12 / 0.91])))
    return at(shell.node(-1, -1), "z")


def hyperboloid(element, n, t, clamped):
    layer = min(0.5, 6 * t**0.5) if clamped else 0.5

    def place(s, p):
        y = 2 * p * (1 - layer) if p < 0.5 else 1 - layer + (2 * p - 1) * layer
        r, a = np.sqrt(1 + y**2), s * pi / 2
        return r * np.cos(a), y, r * np.sin(a)

    def pressure(x):
        r = np.hypot(x[..., 0], x[..., 2])
        normal = x * (1, -1, 1) / np.linalg.norm(x, axis=-1, keepdims=True)
        return (force * (x[..., 0] ** 2 - x[..., 2] ** 2) / r**2)[..., None] * normal

    shell, force = Shell((n, n), place, (2e11, 1 / 3, t), element), 1e6 * (t if clamped else t**3)
    shell.fix(shell.line(j=0), PLANES["y"])
    shell.fix(shell.line(i=0), PLANES["z"])
    shell.fix(shell.line(i=-1), PLANES["x"])
    if clamped:
        shell.fix(shell.line(j=-1), ALL)
    return solved(shell, on_surface(shell, pressure))


PROBLEMS = {
    "strip, t/L 3e-2": (lambda *a: strip(*a, 0.32), 5.41707e-3),
    "strip, t/L 3e-4": (lambda *a: strip(*a, 0.0032), 5249.88),
    "pinched cylinder, t/R 1e-2": (pinched, 1.8590e-5),
    "saddle, t/L 1e-2": (lambda *a: saddle(*a, 1e-2), 9.3355e-5),
    "saddle, t/L 1e-3": (lambda *a: saddle(*a, 1e-3), 6.3941e-3),
    "saddle, t/L 1e-4": (lambda *a: saddle(*a, 1e-4), 0.52988),
    "roof, t/R 1e-2": (roof, 0.302005),
    "hemisphere, t/R 1e-1": (lambda *a: hemisphere(*a, 1.0), 0.11004),
    "hemisphere, t/R 4e-3": (lambda *a: hemisphere(*a, 0.04), 0.093734),
    "hemisphere, t/R 1e-5": (lambda *a: hemisphere(*a, 1e-4), 0.0908),
    "plate, t/L 1e-1": (lambda *a: plate(*a, 0.1), 1.504626e-3),
    "plate, t/L 1e-3": (lambda *a: plate(*a, 1e-3), 1.265345e-3),
    "plate, t/L 1e-5": (lambda *a: plate(*a, 1e-5), 1.265319e-3),
    "clamped hyperboloid, t/R 1e-2": (lambda *a: hyperboloid(*a, 1e-2, True), 5.39113e-2),
    "clamped hyperboloid, t/R 1e-4": (lambda *a: hyperboloid(*a, 1e-4, True), 6.18987e-4),
    "free hyperboloid, t/R 1e-2": (lambda *a: hyperboloid(*a, 1e-2, False), 4.52884e-7),
    "free hyperboloid, t/R 1e-4": (lambda *a: hyperboloid(*a, 1e-4, False), 4.48531e-13),
}


if __name__ == "__main__":
    Kratos.Logger.GetDefaultOutput().SetSeverity(Kratos.Logger.Severity.WARNING)
    print(f"| Kratos | {' | '.join(ELEMENTS)} |\n|{'---|' * (1 + len(ELEMENTS))}")
    for name, (solve, converged) in PROBLEMS.items():
        errors = (", ".join(f"{100 * (solve(element, n) / converged - 1):+.2f}" for n in (16, 32))
                  for element in ELEMENTS.values())
        print(f"| {name} | {' | '.join(errors)} |", flush=True)
