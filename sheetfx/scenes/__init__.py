"""Scenes that `sheetfx run NAME` knows: each module's function `scene` makes a case."""
