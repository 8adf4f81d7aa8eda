"""A structure of bars and sheets of one's own, from one file with its sections, materials, supports and loads.

`sheetfx run structure --data mine.json`; the format is that of `fx.read_structure`. By default it is M1 of the thesis.
"""

from __future__ import annotations

from ._structures import from_file

case = from_file("structure", "Structure of bars and panels from a JSON file (--data): its critical loads.", 5.0)
