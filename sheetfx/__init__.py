"""sheetfx: when thin sheet-and-bar structures lose stability, and what happens after.

The names here are all that a script needs; importing them is deferred to their first use, so
that the command line starts fast.
"""

from importlib import import_module as _import_module

_HOMES = {
    "Bar": "beam", "Beam": "beam", "Contact": "scene", "LineForce": "loads", "Moment": "loads",
    "Monitor": "scene", "Motion": "loads", "PointForce": "loads", "Push": "loads",
    "EdgeForce": "loads", "SurfaceForce": "loads", "Pressure": "loads", "Shell": "shell", "ShellForm": "shell",
    "Plate": "section", "GivenPlate": "section", "ShellStiffness": "section", "RigidCylinder": "obstacles",
    "RigidPlane": "obstacles", "Scene": "scene", "Support": "scene", "clamp": "scene", "pin": "scene",
    "symmetry": "scene", "Elastic": "section", "Rectangle": "section", "Tube": "section", "round_bar": "section",
    "Path": "path", "PathFailure": "path", "Until": "path", "Case": "case", "Record": "case", "trace": "case",
    "run": "case", "read": "mesh.reader", "ArcLength": "solve.control", "DisplacementControl": "solve.control",
    "LoadControl": "solve.control", "buckling": "solve.buckling", "BucklingLoad": "solve.buckling",
    "mode_displacement": "solve.modes", "imperfect": "mesh.imperfection", "branches": "solve.branches",
    "Branch": "solve.branches", "frequencies": "solve.vibration", "Vibration": "solve.vibration",
    "snap": "solve.snap", "snaps": "solve.snap", "Snap": "solve.snap", "SnapFailure": "solve.descent",
    "limit_of_imperfect": "solve.sensitivity", "imperfection_sensitivity": "solve.sensitivity",
    "state_at": "solve.critical", "measured": "mesh.imperfection", "random_field": "mesh.imperfection",
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
