"""Second tested structure of the thesis (section 5.4.2): a hexagonal dome of 37 nodes, 90 bars and 54 panels of 0.7 mm.

The thesis prints measured coordinates alone: ideal ones are those of a sphere over a plan of equilateral triangles. Its
steel is Q235, with nominal values of 2.06e5 MPa, 0.3 and 235 MPa for bars and panels here. Welds, gap and friction as
for M1.
"""

from __future__ import annotations

from ._structures import from_file

case = from_file("m2", "Dome M2 of the thesis: its limit load.", 3.0, "m2")
