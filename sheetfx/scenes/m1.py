"""First tested structure of the thesis (section 5.4.1): a dome of 25 nodes, 56 bars and 40 panels of 0.8 mm.

Its table has the printed sections, moduli and yield stresses, ideal and measured coordinates. The thesis does not print
Poisson's ratio (0.3), hardening (none), which bars there are (deduced from the coordinates), places of the screws, the
length of welds (20 mm at the joints), the gap (0.01 mm) and the coefficient of friction (0.2): values in brackets are
taken here.
"""

from __future__ import annotations

from ._structures import from_file

case = from_file("m1", "Dome M1 of the thesis, with ideal or measured coordinates: its limit load.", 5.0)
