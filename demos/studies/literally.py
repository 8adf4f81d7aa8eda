"""Commands and snippets of pages, run as they stand and in their order in an empty folder, each with its time.

    python3 demos/studies/literally.py README.md demos/pages/own_weak_form.md demos/pages/your_model.md

It needs what the pages ask for: commands go by `docker/run`, snippets by `docker/run python3`. What makes another
environment, runs the tests, or needs a screen or a file of the reader's is left out and named.
"""

import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LEFT_OUT = re.compile(r"pip |conda |docker build|pytest|jupyter|view |my_scene|truss\.py|git clone|<")
BLOCK = re.compile(r"^```(python|sh)\n(.*?)^```", re.MULTILINE | re.DOTALL)


def commands(page: Path, folder: Path) -> list[str]:
    """What a page has run, in its order; snippets are written into the folder."""
    found = []
    for number, (language, text) in enumerate(BLOCK.findall(page.read_text())):
        if language == "python":
            name = f"{page.stem}_{number}.py"
            (folder / name).write_text(text)
            found.append(f"docker/run python3 {name}")
        else:
            found += [line.partition("  #")[0].strip() for line in text.splitlines() if line and line[0] != "#"]
    return found


def main() -> int:
    missing = [name for name in sys.argv[1:] if not (ROOT / name).is_file()]
    if missing or not sys.argv[1:]:
        print(f"no such page: {', '.join(missing)}" if missing else "name pages, as README.md", file=sys.stderr)
        return 2
    failed, whole = 0, time.monotonic()
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        for page in (ROOT / name for name in sys.argv[1:]):
            for command in commands(page, folder):
                if not command.startswith("docker/run") or LEFT_OUT.search(command):
                    print(f"{page.name:24}  left out  {command}")
                    continue
                begun = time.monotonic()
                done = subprocess.run(f"{ROOT}/{command}", shell=True, cwd=folder, capture_output=True, text=True,
                                      env=os.environ | {"OMP_NUM_THREADS": "1"})
                failed += done.returncode != 0
                said = (done.stdout if done.returncode == 0 else done.stderr).strip().splitlines() or [""]
                print(f"{page.name:24} {time.monotonic() - begun:7.1f} s  {command}")
                print(f"{'':36}{said[-1][:90]}", flush=True)
    print(f"{time.monotonic() - whole:.0f} s in all, {failed} failed")
    return failed


if __name__ == "__main__":
    sys.exit(main())
