"""What demos print and draw, which the site shows below them; `demos/pages/make --run [NAME ...]` runs them.

Outputs are kept in site/.outputs, each for one text of its demo; a demo that has changed since is shown without.
"""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
import time
from pathlib import Path

DEMOS = Path(__file__).resolve().parents[1]
KEPT = DEMOS.parent / ("" if DEMOS.name == ".source" else "site") / ".outputs"  # the site is made of a copy
PICTURES = {".png", ".gif"}


def state_of(demo: str) -> str:
    """What tells one text of a demo from another."""
    return hashlib.sha256((DEMOS / f"{demo}.py").read_bytes()).hexdigest()


def is_current(demo: str) -> bool:
    """Whether the outputs that are kept are those of the demo as it is."""
    mark = KEPT / demo / "state"
    return mark.exists() and mark.read_text() == state_of(demo)


def shown(demo: str) -> str:
    """Markdown of the outputs; empty where none are current."""
    if not is_current(demo):
        return ""
    pictures = sorted(file.name for file in (KEPT / demo).iterdir() if file.suffix in PICTURES)
    text = (KEPT / demo / "printed").read_text().rstrip()
    printed = f"\n\n## What it prints\n\n```text\n{text}\n```\n" if text else ""
    return printed + "".join(f"\n![{name}](outputs/{demo}/{name})\n" for name in pictures)


def run(demo: str) -> None:
    """Run a demo in the folder of its outputs.

    Raises
    ------
    subprocess.CalledProcessError
        If it fails.
    """
    folder, begun = KEPT / demo, time.monotonic()
    folder.mkdir(parents=True, exist_ok=True)
    for file in folder.iterdir():
        if file.is_file():
            file.unlink()
    done = subprocess.run([sys.executable, DEMOS / f"{demo}.py"], cwd=folder, env=os.environ | {"MPLBACKEND": "Agg"},
                          stdout=subprocess.PIPE, text=True, check=True)
    (folder / "printed").write_text(done.stdout)
    (folder / "state").write_text(state_of(demo))
    print(f"{demo}: {time.monotonic() - begun:.0f} s", flush=True)


if __name__ == "__main__":
    for name in sys.argv[1:] or sorted(file.stem for file in DEMOS.glob("*.py")):
        if not is_current(name):
            run(name)
