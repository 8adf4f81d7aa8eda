"""Shell benchmarks of Sze, Liu and Lo (2004), and a plastic one, in Kratos Multiphysics, for the charts of sheetfx.

python3 kratos.py hemisphere --cells 24 --steps 10 --solver amgcl

The last line of output that starts with a brace reports the run: quantities, unknowns, iterations,
and the CPU seconds of the loop over the steps.
"""

from __future__ import annotations

import argparse
import json
import time
from math import cos, pi, radians, sin

import KratosMultiphysics as Kratos
import KratosMultiphysics.LinearSolversApplication
import KratosMultiphysics.StructuralMechanicsApplication as Structural
import numpy as np
from KratosMultiphysics.python_linear_solver_factory import ConstructSolver
from scipy.interpolate import CubicSpline

MITC4, LINEAR_MITC4 = "ShellThickElementCorotational3D4N", "ShellThickElement3D4N"
LAYERED_MITC4 = "MITCThickShellCorotationalElement3D4N"  # since 10.4
SOLVERS = {"amgcl": "amgcl", "sparse_lu": "LinearSolversApplication.sparse_lu"}
MOST_ITERATIONS = 50  # of a load step
MOST_OF_A_DEFLECTION = 12  # iterations; where Newton's method diverges, plastic ones take long
MOST_FAILURES = 5  # deflections in a row at which Newton's method may fail before a path ends
LARGEST_PLASTIC_STRAIN = 0.5  # that the hardening curve is given to
FREEDOMS = {
    "x": Kratos.DISPLACEMENT_X, "y": Kratos.DISPLACEMENT_Y, "z": Kratos.DISPLACEMENT_Z,
    "rx": Kratos.ROTATION_X, "ry": Kratos.ROTATION_Y, "rz": Kratos.ROTATION_Z}
FORCES = {"x": Structural.POINT_LOAD_X, "y": Structural.POINT_LOAD_Y, "z": Structural.POINT_LOAD_Z}


class Shell:
    """A shell on a grid of quadrilaterals, or of triangles, two in the place of each.

    Parameters
    ----------
    cells : along the two directions of the grid
    place : function (s, t) -> coordinates, for s and t from 0 to 1
    material : Young's modulus, Poisson's ratio, thickness
    element : Kratos's name of the element
    plastic : yield stress, hardening by plastic strain, and number of points through the thickness; None: elastic
    """

    def __init__(self, cells, place, material, element=MITC4, plastic=None):
        self.cells, self.iterations = cells, 0
        self._model = Kratos.Model()
        self.part = self._model.CreateModelPart("shell", 2)
        for variable in (Kratos.DISPLACEMENT, Kratos.REACTION, Kratos.ROTATION, Kratos.REACTION_MOMENT,
                         Kratos.VOLUME_ACCELERATION, Structural.POINT_LOAD):
            self.part.AddNodalSolutionStepVariable(variable)
        self.part.ProcessInfo[Kratos.DOMAIN_SIZE] = 3
        self._properties = (_properties(self.part, material, element) if plastic is None else
                            _layers(self.part, material, *plastic))
        self._build_mesh(place, element)
        for axis in "XYZ":
            for freedom, reaction in (("DISPLACEMENT_", "REACTION_"), ("ROTATION_", "REACTION_MOMENT_")):
                Kratos.VariableUtils().AddDof(
                    getattr(Kratos, freedom + axis), getattr(Kratos, reaction + axis), self.part)

    def _number(self, i, j):
        return 1 + j + i * (self.cells[1] + 1)

    def _build_mesh(self, place, element):
        along, across = self.cells
        for i in range(along + 1):
            for j in range(across + 1):
                self.part.CreateNewNode(self._number(i, j), *place(i / along, j / across))
        corners = ((0, 0), (1, 0), (1, 1), (0, 1))
        for i in range(along):
            for j in range(across):
                nodes = [self._number(i + di, j + dj) for di, dj in corners]
                for cell in (nodes,) if element.endswith("4N") else (nodes[:2] + nodes[3:], nodes[1:]):
                    self.part.CreateNewElement(element, 1 + self.part.NumberOfElements(), cell, self._properties)

    def node(self, i, j):
        """Node by its place in the grid; negative numbers count from the end."""
        return self.part.Nodes[self._number(i % (self.cells[0] + 1), j % (self.cells[1] + 1))]

    def line(self, i=None, j=None):
        """Nodes of the grid line with the given first or second number."""
        if i is not None:
            return [self.node(i, k) for k in range(self.cells[1] + 1)]
        return [self.node(k, j) for k in range(self.cells[0] + 1)]

    def fix(self, nodes, freedoms):
        """Fix the named freedoms of nodes, for example "x ry rz"."""
        for node in nodes:
            for name in freedoms.split():
                node.Fix(FREEDOMS[name])

    def load(self, node, component, force):
        """Make a point load; returns what `advance` scales."""
        number = self.part.NumberOfConditions() + 1
        self.part.CreateNewCondition("PointLoadCondition3D1N", number, [node.Id], self._properties)
        return node, FORCES[component], force

    def prepare(self, solver, tolerance, iterations, reactions=False):
        """Set up Newton's method with convergence to a relative change of displacements."""
        self._builder = Kratos.ResidualBasedBlockBuilderAndSolver(
            ConstructSolver(Kratos.Parameters(json.dumps({"solver_type": SOLVERS[solver]}))))
        criterion = Kratos.DisplacementCriteria(tolerance, 1e-12)
        criterion.SetEchoLevel(0)
        self._newton = Kratos.ResidualBasedNewtonRaphsonStrategy(
            self.part, Kratos.ResidualBasedIncrementalUpdateStaticScheme(), criterion, self._builder,
            iterations, reactions, False, True)
        self._newton.SetEchoLevel(0)
        self._newton.Initialize()
        self._newton.Check()

    def advance(self, step, controls, factor):
        """Solve the next step under all controls (node, variable, value) times a factor."""
        self.part.CloneTimeStep(float(step))
        self.part.ProcessInfo[Kratos.STEP] = step
        for node, variable, value in controls:
            node.SetSolutionStepValue(variable, 0, factor * value)
        self._newton.InitializeSolutionStep()
        self._newton.Predict()
        converged = self._newton.SolveSolutionStep()
        self.iterations += self.part.ProcessInfo[Kratos.NL_ITERATION_NUMBER]
        if not converged:
            self._take_back()
            raise ArithmeticError(f"no convergence in step {step}")
        self._newton.FinalizeSolutionStep()

    def _take_back(self):
        """Return to the step before; laws have not accepted this one, and the next one starts elements anew."""
        for node in self.part.Nodes:
            for variable in FREEDOMS.values():
                node.SetSolutionStepValue(variable, 0, node.GetSolutionStepValue(variable, 1))
        self._newton.Clear()

    @property
    def unknowns(self):
        return self._builder.GetEquationSystemSize()


def _properties(part, material, element):
    """MITC4 takes a law for all eight resultants, the other elements one for plane stress."""
    properties = part.CreateNewProperties(1)
    _give_elasticity(properties, material)
    of_resultants = element in (MITC4, LINEAR_MITC4)
    properties[Kratos.CONSTITUTIVE_LAW] = (Structural.ReissnerMindlinShellElasticConstitutiveLaw() if of_resultants
                                           else Structural.LinearElasticPlaneStress2DLaw())
    return properties


def _give_elasticity(properties, material):
    """Young's modulus, Poisson's ratio and thickness; Kratos also asks for a density."""
    for variable, value in zip((Kratos.YOUNG_MODULUS, Kratos.POISSON_RATIO, Kratos.THICKNESS), material, strict=True):
        properties[variable] = value
    properties[Kratos.DENSITY] = 1.0


def _layers(part, material, yield_stress, hardening, points):
    """Von Mises's plasticity with linear isotropic hardening, by Simpson's rule through the thickness.

    Its return ends within 1e-4 of the yield stress, so that Newton's method finds no smaller changes of displacements
    than about 1e-5; it is explicit in the direction of flow, so that large steps flow under too large stresses.
    """
    from KratosMultiphysics import ConstitutiveLawsApplication as Laws

    shell, layer = part.CreateNewProperties(1), part.CreateNewProperties(2)
    for properties in (shell, layer):
        _give_elasticity(properties, material)
    harder = yield_stress + hardening * LARGEST_PLASTIC_STRAIN
    layer[Kratos.YIELD_STRESS], layer[Kratos.FRACTURE_ENERGY] = yield_stress, 1e9
    layer[Laws.HARDENING_CURVE] = 6  # by points
    layer[Laws.EQUIVALENT_STRESS_VECTOR_PLASTICITY_POINT_CURVE] = Kratos.Vector([yield_stress, harder])
    layer[Laws.TOTAL_STRAIN_VECTOR_PLASTICITY_POINT_CURVE] = Kratos.Vector(
        [yield_stress / material[0], harder / material[0] + LARGEST_PLASTIC_STRAIN])
    layer[Kratos.CONSTITUTIVE_LAW] = Laws.SmallStrainIsotropicPlasticityPlaneStressVonMisesVonMises()
    shell.AddSubProperties(layer)
    shell[Kratos.CONSTITUTIVE_LAW] = Laws.ThicknessIntegratedIsotropicConstitutiveLaw().Create(
        Kratos.Parameters(json.dumps({"thickness_integration_points": points})))
    return shell


def at(node, component):
    return node.GetSolutionStepValue(FREEDOMS[component])


def spread(shell, nodes, component, total):
    """Line load along an edge, as its nodes carry it."""
    shares = [0.5 if node in (nodes[0], nodes[-1]) else 1.0 for node in nodes]
    return [shell.load(node, component, total * share / sum(shares)) for node, share in zip(nodes, shares, strict=True)]


def by_load(shell, options, controls):
    """Reach the full load in equal steps; CPU seconds of it."""
    shell.prepare(options.solver, options.tolerance, MOST_ITERATIONS)
    start = time.process_time()
    for step in range(1, options.steps + 1):
        shell.advance(step, controls, step / options.steps)
    return time.process_time() - start


def by_deflection(shell, node, options, last):
    """Push a node down by equal steps; its deflections and forces, and CPU seconds.

    A deflection at which Newton's method fails is left out; the path may jump there.
    """
    shell.prepare(options.solver, options.tolerance, MOST_OF_A_DEFLECTION, reactions=True)
    path, failures, start = [(0.0, 0.0)], 0, time.process_time()
    for step in range(1, round(last / options.step) + 1):
        try:
            shell.advance(step, [(node, FREEDOMS["z"], -1.0)], options.step * step)
        except ArithmeticError as failure:
            print(f"{failure} of {options.step}")
            failures += 1
            if failures > MOST_FAILURES:
                break
            continue
        failures = 0
        path.append((options.step * step, -node.GetSolutionStepValue(Kratos.REACTION_Z)))
    return np.array(path).T, time.process_time() - start


def hemisphere(options):
    """Quarter of the pinched hemisphere with a hole of 18 degrees: radius 10, force 400."""
    def place(s, t):
        azimuth, height = s * pi / 2, t * radians(72.0)
        return 10.0 * cos(height) * cos(azimuth), 10.0 * cos(height) * sin(azimuth), 10.0 * sin(height)

    shell = Shell((options.cells, options.across or options.cells), place, (6.825e7, 0.3, 0.04), options.element)
    outward, inward = shell.node(0, 0), shell.node(-1, 0)
    shell.fix(shell.line(i=0), "y rx rz")
    shell.fix(shell.line(i=-1), "x ry rz")
    shell.fix([outward], "z")
    cpu = by_load(shell, options, [shell.load(outward, "x", 200.0), shell.load(inward, "y", -200.0)])
    return shell, cpu, {"u_A": at(outward, "x"), "u_B": -at(inward, "y")}


def slit_annulus(options):
    """Slit annular plate, radii 6 and 10, lifted along one side of the slit by 0.8 per length."""
    def place(s, t):
        radius, angle = 6.0 + 4.0 * t, 2 * pi * s
        return radius * cos(angle), radius * sin(angle), 0.0

    cells = options.cells, options.across or max(2, options.cells // 5)
    shell = Shell(cells, place, (21e6, 0.0, 0.03), options.element)
    shell.fix(shell.line(i=-1), "x y z rx ry rz")
    cpu = by_load(shell, options, spread(shell, shell.line(i=0), "z", 3.2))
    return shell, cpu, {"w_A": at(shell.node(0, 0), "z"), "w_B": at(shell.node(0, -1), "z")}


def cantilever(options):
    """Cantilever strip 10 x 1 x 0.1 under an end shear of 4."""
    shell = Shell((options.cells, options.across or 1), lambda s, t: (10.0 * s, t, 0.0), (1.2e6, 0.0, 0.1),
                  options.element)
    shell.fix(shell.line(i=0), "x y z rx ry rz")
    cpu = by_load(shell, options, spread(shell, shell.line(i=-1), "z", 4.0))
    return shell, cpu, {"u_tip": -at(shell.node(-1, 0), "x"), "w_tip": at(shell.node(-1, 0), "z")}


def roof(options):
    """Quarter of the hinged cylindrical roof, pushed down at its crown by equal steps."""
    def place(s, t):
        return 254.0 * s, 2540.0 * sin(0.1 * t), 2540.0 * (cos(0.1 * t) - 1.0)

    shell = Shell((options.cells, options.across or options.cells), place, (3102.75, 0.3, options.thickness),
                  options.element)
    crown = shell.node(0, 0)
    shell.fix(shell.line(i=0), "x ry rz")
    shell.fix(shell.line(j=0), "y rx rz")
    shell.fix(shell.line(j=-1), "x y z")
    shell.fix([crown], "z")
    (deflections, loads), cpu = by_deflection(shell, crown, options, options.to)
    curve = CubicSpline(deflections, 4 * loads)
    extrema = [float(curve(w)) for w in sorted(curve.derivative().roots(extrapolate=False))]
    return shell, cpu, dict(zip(("limit_load", "lower_limit_load"), extrema, strict=False))


def channel(options):
    """Channel-section cantilever: web 6, flanges 2, length 36, pushed down at its upper corner by equal steps."""
    def place(s, t):
        along = 10.0 * t  # from the edge of the upper flange over the web to that of the lower one
        flange = max(2.0 - along, along - 8.0, 0.0)
        return 36.0 * s, flange, 6.0 - min(max(along - 2.0, 0.0), 6.0)

    across = options.across or 10 * round(options.cells / 36)
    shell = Shell((options.cells, across), place, (1e7, 0.333, 0.05), options.element)
    corner = shell.node(-1, across // 5)
    shell.fix(shell.line(i=0), "x y z rx ry rz")
    shell.fix([corner], "z")
    (deflections, loads), cpu = by_deflection(shell, corner, options, 0.4)
    curve = CubicSpline(deflections, loads)
    first = next(w for w in curve.derivative().roots(extrapolate=False) if curve(w, 2) < 0)
    return shell, cpu, {"limit_load": float(curve(first)), "deflection": float(first)}


def plastic_cylinder(options):
    """Eighth of an elastic-plastic cylinder with end diaphragms, pinched by equal steps of the deflection."""
    def place(s, t):
        return 300.0 * s, 300.0 * sin(t * pi / 2), 300.0 * cos(t * pi / 2)

    shell = Shell((options.cells, options.across or options.cells), place, (3000.0, 0.3, 3.0), LAYERED_MITC4,
                  (24.3, 300.0, options.layers))
    pinched = shell.node(0, 0)
    shell.fix(shell.line(i=0), "x ry rz")
    shell.fix(shell.line(j=0), "y rx rz")
    shell.fix(shell.line(j=-1), "z rx ry")
    shell.fix(shell.line(i=-1), "y z")
    shell.fix([pinched], "z")
    (deflections, forces), cpu = by_deflection(shell, pinched, options, 200.0 + MOST_FAILURES * options.step)
    return shell, cpu, {f"force_at_{w}": 4 * float(np.interp(w, deflections, forces)) for w in (50, 100, 150, 200)
                        if w <= deflections[-1]}


BENCHMARKS = {"hemisphere": hemisphere, "slit-annulus": slit_annulus, "cantilever": cantilever, "roof": roof,
              "channel": channel, "plastic-cylinder": plastic_cylinder}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("benchmark", choices=BENCHMARKS)
    parser.add_argument("--cells", type=int, default=16, help="along the first direction of the grid")
    parser.add_argument("--across", type=int, help="cells in the other direction")
    parser.add_argument("--steps", type=int, default=10, help="load steps")
    parser.add_argument("--step", type=float, default=2.0, help="of the deflection, where that is prescribed")
    parser.add_argument("--to", type=float, default=30.0, help="roof: last deflection of the crown in mm")
    parser.add_argument("--thickness", type=float, default=12.7, help="of the roof in mm")
    parser.add_argument("--layers", type=int, default=11, help="plastic-cylinder: points through the thickness")
    parser.add_argument("--solver", choices=SOLVERS, default="amgcl")
    parser.add_argument("--element", default=MITC4)
    parser.add_argument("--tolerance", type=float, default=1e-6, help="relative change of displacements")
    options = parser.parse_args()
    Kratos.Logger.GetDefaultOutput().SetSeverity(Kratos.Logger.Severity.WARNING)
    shell, cpu, quantities = BENCHMARKS[options.benchmark](options)
    name = "Kratos MITC4" if options.element == MITC4 else f"Kratos {options.element}"
    print(json.dumps({"peer": name, "unknowns": shell.unknowns, "iterations": shell.iterations,
                      "cpu_s": cpu, "quantities": quantities}), flush=True)


if __name__ == "__main__":
    main()
