"""Pictures and files of traced paths, for `Case.pictures` and for scripts.

Each picture is a function of a record and the folder that it writes into. A run draws by the functions in `STANDARD`
where its case does not say otherwise. Importing them is deferred to their first use.
"""

from importlib import import_module as _import_module

_ROOMS = {
    "standard": "STANDARD buckling_modes",
    "curves": "curve_points draw_branches draw_path path_curve",
    "pictures": "shapes",
    "files": "paraview",
    "modes": "draw_modes mode_files",
    "critical_modes": "draw_critical_modes",
    "animating": "animation",
    "snaps": "falls_curve",
    "bodies": "solids",
    "plastic": "plastic_zones",
    "pairs": "pair_history",
    "contact": "contact_history tractions",
    "viewer": "view_folder",
}
_HOMES = {name: room for room, names in _ROOMS.items() for name in names.split()}


def __getattr__(name):
    if name in _HOMES:
        return getattr(_import_module(f".{_HOMES[name]}", __name__), name)
    raise AttributeError(f"module 'sheetfx.show' has no attribute {name!r}")


def __dir__():
    return sorted(_HOMES)
