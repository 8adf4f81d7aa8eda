"""Every demo runs in its short form and its assertions hold."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

DEMOS = sorted((Path(__file__).parents[1] / "demos").glob("*.py"))


@pytest.mark.parametrize("demo", DEMOS, ids=lambda d: d.stem)
def test_demo(demo, tmp_path):
    environment = os.environ | {"SHEETFX_QUICK": "1", "MPLBACKEND": "Agg"}
    result = subprocess.run([sys.executable, str(demo)], cwd=tmp_path, env=environment,
                            capture_output=True, text=True, timeout=600)
    assert result.returncode == 0, result.stdout + result.stderr
