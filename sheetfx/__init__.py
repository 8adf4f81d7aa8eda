"""sheetfx: when thin sheet-and-bar structures lose stability, and what happens after.

The names here are all that a script needs; importing them is deferred to their first use, so
that the command line starts fast.
"""

from importlib import import_module as _import_module

_HOMES = {
    "Bar": "model.beam", "Beam": "model.beam", "Contact": "model.scene", "LineForce": "model.loads", "Moment": "model.loads",
    "Monitor": "model.scene", "Motion": "model.loads", "PointForce": "model.loads", "Push": "model.loads",
    "EdgeForce": "model.loads", "SurfaceForce": "model.loads", "Pressure": "model.loads", "Shell": "model.shell", "ShellForm": "model.shell",
    "Plate": "model.section", "GivenPlate": "model.section", "ShellStiffness": "model.section", "RigidCylinder": "model.obstacles",
    "RigidPlane": "model.obstacles", "Scene": "model.scene", "Support": "model.scene", "clamp": "model.scene", "pin": "model.scene",
    "symmetry": "model.scene", "Elastic": "model.section", "Rectangle": "model.section", "Tube": "model.section", "round_bar": "model.section",
    "Path": "path", "PathFailure": "path", "Until": "path", "Case": "case", "Record": "case", "trace": "case",
    "run": "case", "read": "mesh.reader", "ArcLength": "continuation.control", "DisplacementControl": "continuation.control",
    "LoadControl": "continuation.control", "buckling": "stability.buckling", "BucklingLoad": "stability.buckling",
    "mode_displacement": "stability.modes", "imperfect": "mesh.imperfection", "branches": "stability.branches",
    "Branch": "stability.branches", "frequencies": "stability.vibration", "Vibration": "stability.vibration",
    "snap": "stability.snap", "snaps": "stability.snap", "Snap": "stability.snap", "SnapFailure": "stability.descent",
    "limit_of_imperfect": "stability.sensitivity", "imperfection_sensitivity": "stability.sensitivity",
    "state_at": "stability.critical", "measured": "mesh.imperfection", "random_field": "mesh.imperfection",
}
_MODULES = ("forms", "meshes", "show")


def __getattr__(name):
    if name in _MODULES:
        return _import_module(f".{name}", __name__)
    if name in _HOMES:
        return getattr(_import_module(f".{_HOMES[name]}", __name__), name)
    raise AttributeError(f"module 'sheetfx' has no attribute {name!r}")


def __dir__():
    return sorted([*_HOMES, *_MODULES])
