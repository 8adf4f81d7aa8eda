"""sheetfx: when thin sheet-and-bar structures lose stability, and what happens after.

The names here are all that a script needs; importing them is deferred to their first use, so
that the command line starts fast.
"""

from importlib import import_module as _import_module

try:
    import dolfinx_solver as _first  # noqa: F401  The wheel of DOLFINx 0.11 loads MPI before all other libraries.
except ModuleNotFoundError:  # DOLFINx from another source
    pass

__version__ = "0.1.0"

_ROOMS = {
    "mesh.discs": "Disc",
    "mesh.lines": "Stretch",
    "mesh.reader": "NamedMesh read",
    "mesh.mixed": "MixedMesh read_mixed",
    "mesh.kinds": "MeshesByKind read_kinds",
    "mesh.field_components": "FieldComponent field_components",
    "mesh.nodal_shapes": "NodalShape nodal_shapes",
    "mesh.imperfection": "measured random_field",
    "model.beam": "Bar Beam",
    "model.contact": "Contact",
    "model.joints": "Compatible EdgeFoundation Foundation Joint Spring Uniform",
    "model.coupling": "DistributingCoupling KinematicCoupling",
    "model.given_section": "GivenSection",
    "model.gravity": "Gravity",
    "model.history": "LawWithHistory",
    "model.ilyushin": "Ilyushin",
    "model.initial_strain": "InitialStrain InitialStress StressFree Temperature",
    "model.interface": "Interface bolt hinge link weld",
    "model.loads": "EdgeForce LineForce Load Moment "
                   "ObstacleForce PointForce PrescribedDisplacement PrescribedRotation SurfaceForce",
    "model.mass": "Mass",
    "model.pair_contact": "PairContact",
    "model.surface_contact": "SurfaceContact",
    "model.obstacle_contact": "ObstacleContact",
    "model.obstacles": "RigidCylinder RigidPlane RigidSphere",
    "model.following": "FollowerForce LinePressure Pressure",
    "model.scene": "Monitor Scene Stage",
    "model.plasticity": "Plastic PlasticLaw",
    "model.laminate": "Laminate Ply",
    "model.plate": "GivenPlate Plate ShellStiffness",
    "model.outline": "PolygonSection",
    "model.profiles": "Box CSection ISection LSection TSection ZSection",
    "model.section": "Elastic FibreList Flanged Rectangle Tube effective_width round_bar",
    "model.shell": "Shell ShellForm",
    "model.assembled": "Cells Joining coupled skeleton touching",
    "model.structure": "Members Sheets Structure read_structure",
    "model.stresses": "transverse_shear von_mises",
    "model.supports": "Support clamp pin symmetry",
    "discrete.contribution": "Contribution",
    "discrete.points": "PointWork Trace",
    "continuation.transferred": "transferred",
    "continuation.control": "ArcLength DisplacementControl LoadControl",
    "events.event": "Event",
    "events.sliding": "first_touch slide_off",
    "events.yielding": "first_yield",
    "critical.augmented": "Critical NoCriticalPoint critical",
    "critical.branches": "Branch branches",
    "critical.buckling": "BucklingLoad buckling",
    "events.search": "state_at",
    "critical.curve": "CriticalCurve CurveEnds CurvePoint",
    "studies.curve_by_paths": "CurveByPaths",
    "critical.fall": "SnapFailure",
    "critical.error_bar": "ErrorBar",
    "critical.gradient": "LoadGradient",
    "critical.imperfect": "imperfect",
    "critical.imperfections": "Imperfections",
    "critical.reduced_energy": "ReducedEnergy",
    "critical.remade": "remade",
    "critical.modes": "mode_displacement",
    "critical.shares": "softest_modes",
    "critical.unilateral": "UnilateralBuckling unilateral_buckling",
    "critical.sensitivity": "imperfection_sensitivity limit_of_imperfect",
    "critical.snap": "Snap snap snaps",
    "critical.likely": "LoadQuantile",
    "critical.worst": "ImperfectLoad LoadsByShape",
    "critical.vibration": "Vibration frequencies",
    "path": "Path PathFailure Until",
    "record": "Record",
    "case": "Case run trace",
    "ladder.climb": "Climb",
    "ladder.decision": "Advice Decision",
    "ladder.integration": "integrated_finer",
    "ladder.left_out": "LeftOut",
    "ladder.refined": "Refined Refinement",
    "ladder.coarser_bars": "error_bars_beside",
    "ladder.meshes": "Meshes by_halving by_option halved raised",
    "scenes": "load_case",
}
_HOMES = {name: room for room, names in _ROOMS.items() for name in names.split()}
_MODULES = ("continuation", "forms", "meshes", "show")


def __getattr__(name):
    if name in _MODULES:
        return _import_module(f".{name}", __name__)
    if name in _HOMES:
        return getattr(_import_module(f".{_HOMES[name]}", __name__), name)
    raise AttributeError(f"module 'sheetfx' has no attribute {name!r}")


def __dir__():
    return sorted([*_HOMES, *_MODULES])
