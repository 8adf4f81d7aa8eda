"""Every demo runs in its short form and its assertions hold, the notebooks cell by cell from a fresh kernel."""

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import pytest

DEMOS = sorted((Path(__file__).parents[1] / "demos").glob("*.py"))
NOTEBOOKS = "arch", "double_plate"
LONG = ("arch", "bolted_panel", "branches", "buckling", "convergence", "dome", "double_plate", "enforcement",
        "foundation", "imperfections", "large_steps", "moving_pairs", "pair_search", "panel", "plastic_column",
        "plastic_sections", "shell", "snap", "snap_surface", "speed", "thin_limit", "triangles")
WITH_JUPYTER = all(importlib.util.find_spec(name) for name in ("jupytext", "nbconvert", "ipykernel"))


@pytest.mark.parametrize("demo", [pytest.param(d, id=d.stem, marks=[pytest.mark.slow] * (d.stem in LONG))
                                  for d in DEMOS])
def test_demo(demo, tmp_path):
    environment = os.environ | {"SHEETFX_QUICK": "1"}
    command = [str(demo)]
    if demo.stem in NOTEBOOKS and WITH_JUPYTER:
        command = [str(demo.parent / "studies" / "render.py"), demo.stem, "-o", str(tmp_path)]
    else:
        environment["MPLBACKEND"] = "Agg"
    result = subprocess.run([sys.executable, *command], cwd=tmp_path, env=environment,
                            capture_output=True, text=True, timeout=600)
    assert result.returncode == 0, result.stdout + result.stderr
    if command[0] != str(demo):
        assert (tmp_path / f"{demo.stem}.html").read_text().count("data:image/png") >= 3
