"""Shell benchmarks of Sze, Liu and Lo (2004) in OpenSees, for the charts of sheetfx.

python3 opensees.py hemisphere --cells 16 --steps 20

The last line of output that starts with a brace reports the run: quantities, unknowns, iterations,
and the CPU seconds of the loop over the steps.
"""

from __future__ import annotations

import argparse
import json
import time
from math import cos, pi, radians, sin, sqrt

import openseespy.opensees as ops
from scipy.interpolate import CubicSpline

ELEMENTS = {"ASDShellQ4": ["-corotational"], "ShellNLDKGQ": []}
FREEDOMS = ("x", "y", "z", "rx", "ry", "rz")
MOST_ITERATIONS = 50
SMALLEST_CUT = 1 / 64


class Shell:
    """A shell on a grid of quadrilaterals.

    Parameters
    ----------
    cells : along both directions of the grid
    place : function (s, t) -> coordinates, for s and t from 0 to 1
    material : Young's modulus, Poisson's ratio, thickness
    element : OpenSees's name of the element
    """

    def __init__(self, cells, place, material, element):
        self.cells, self.iterations = cells, 0
        self._fixed = {}
        ops.wipe()
        ops.model("basic", "-ndm", 3, "-ndf", 6)
        for i in range(cells + 1):
            for j in range(cells + 1):
                ops.node(self.node(i, j), *place(i / cells, j / cells))
        ops.section("ElasticMembranePlateSection", 1, *material, 0.0)
        corners = ((0, 0), (1, 0), (1, 1), (0, 1))
        for i in range(cells):
            for j in range(cells):
                nodes = [self.node(i + di, j + dj) for di, dj in corners]
                ops.element(element, 1 + j + i * cells, *nodes, 1, *ELEMENTS[element])

    def node(self, i, j):
        """Number of a node by its place in the grid; negative numbers count from the end."""
        side = self.cells + 1
        return 1 + j % side + i % side * side

    def line(self, i=None, j=None):
        """Nodes of the grid line with the given first or second number."""
        return [self.node(k if i is None else i, k if j is None else j) for k in range(self.cells + 1)]

    def fix(self, nodes, freedoms):
        """Fix the named freedoms of nodes, for example "x ry rz", as soon as loads follow."""
        for node in nodes:
            self._fixed.setdefault(node, set()).update(freedoms.split())

    def load(self, forces, tolerance, algorithm):
        """Apply supports and point loads {(node, component): force}, and set up the iteration."""
        for node, names in self._fixed.items():
            ops.fix(node, *(int(name in names) for name in FREEDOMS))
        ops.timeSeries("Linear", 1)
        ops.pattern("Plain", 1, 1)
        for (node, component), force in forces.items():
            ops.load(node, *(force if name == component else 0.0 for name in FREEDOMS))
        ops.constraints("Plain")
        ops.numberer("RCM")
        ops.system("UmfPack")
        ops.test("NormDispIncr", tolerance * (self.cells + 1), MOST_ITERATIONS, 0)
        ops.algorithm(algorithm)

    def advance(self, integrate, length, first):
        """Solve one step, cut where Newton's method fails; returns the length that it got."""
        while True:
            integrate(length)
            if first and not self.iterations:
                ops.analysis("Static")
            failed = ops.analyze(1) != 0
            self.iterations += ops.testIter()
            if not failed:
                return length
            length /= 2
            if length < first * SMALLEST_CUT:
                raise ArithmeticError(f"no convergence with steps down to {length:.3g}")


def hemisphere(options):
    """Quarter of the pinched hemisphere with a hole of 18 degrees: radius 10, force 400."""
    def place(s, t):
        azimuth, height = s * pi / 2, t * radians(72.0)
        return 10.0 * cos(height) * cos(azimuth), 10.0 * cos(height) * sin(azimuth), 10.0 * sin(height)

    shell = Shell(options.cells, place, (6.825e7, 0.3, 0.04), options.element)
    outward, inward = shell.node(0, 0), shell.node(-1, 0)
    shell.fix(shell.line(i=0), "y rx rz")
    shell.fix(shell.line(i=-1), "x ry rz")
    shell.fix([outward], "z")
    shell.load({(outward, "x"): 200.0, (inward, "y"): -200.0}, options.tolerance, options.algorithm)
    reached, longest = 0.0, 1 / options.steps
    length = longest
    start = time.process_time()
    while reached < 1 - 1e-12:
        length = shell.advance(lambda d: ops.integrator("LoadControl", d), min(length, 1 - reached), longest)
        reached, length = ops.getLoadFactor(1), min(longest, 1.5 * length)
    cpu = time.process_time() - start
    return shell, cpu, {"u_A": ops.nodeDisp(outward, 1), "u_B": -ops.nodeDisp(inward, 2)}


def roof(options):
    """Quarter of the hinged cylindrical roof under a point load, by arc length."""
    def place(s, t):
        return 254.0 * s, 2540.0 * sin(0.1 * t), 2540.0 * (cos(0.1 * t) - 1.0)

    shell = Shell(options.cells, place, (3102.75, 0.3, options.thickness), options.element)
    crown = shell.node(0, 0)
    shell.fix(shell.line(i=0), "x ry rz")
    shell.fix(shell.line(j=0), "y rx rz")
    shell.fix(shell.line(j=-1), "x y z")
    shell.load({(crown, "z"): -250.0}, options.tolerance, options.algorithm)
    path, lengths = [(0.0, 0.0)], [0.0]
    longest = length = options.step * (options.cells + 1)
    start = time.process_time()
    while path[-1][0] < options.to:
        length = shell.advance(lambda s: ops.integrator("ArcLength", s, 0.0), length, longest)
        path.append((-ops.nodeDisp(crown, 3), 1000.0 * ops.getLoadFactor(1)))
        (w0, p0), (w1, p1) = path[-2:]
        lengths.append(lengths[-1] + sqrt(((w1 - w0) / 10.0) ** 2 + ((p1 - p0) / 1000.0) ** 2))
        length = min(longest, 1.5 * length)
    cpu = time.process_time() - start
    curve = CubicSpline(lengths, [load for _, load in path])
    extrema = [float(curve(s)) for s in sorted(curve.derivative().roots(extrapolate=False))]
    return shell, cpu, dict(zip(("limit_load", "lower_limit_load"), extrema, strict=False))


BENCHMARKS = {"hemisphere": hemisphere, "roof": roof}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("benchmark", choices=BENCHMARKS)
    parser.add_argument("--cells", type=int, default=16, help="along both directions of the grid")
    parser.add_argument("--steps", type=int, default=20, help="hemisphere: load steps")
    parser.add_argument("--step", type=float, default=0.7, help="roof: arc length over the root of the nodes, in mm")
    parser.add_argument("--to", type=float, default=30.0, help="roof: last deflection of the crown in mm")
    parser.add_argument("--thickness", type=float, default=12.7, help="of the roof in mm")
    parser.add_argument("--element", choices=ELEMENTS, default="ASDShellQ4")
    parser.add_argument("--algorithm", choices=("Newton", "KrylovNewton"), default="Newton")
    parser.add_argument("--tolerance", type=float, default=1e-5, help="change of displacements over root of the nodes")
    options = parser.parse_args()
    shell, cpu, quantities = BENCHMARKS[options.benchmark](options)
    print(json.dumps({"peer": f"OpenSees {options.element}", "unknowns": ops.systemSize(),
                      "iterations": shell.iterations, "cpu_s": cpu, "quantities": quantities}), flush=True)


if __name__ == "__main__":
    main()
