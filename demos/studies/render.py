"""Run demos as notebooks, and keep them with their outputs: `python3 demos/studies/render.py [NAME ...] [-o FOLDER]`.

Each gets NAME.ipynb and NAME.html in the folder (default results/notebooks); names default to arch and double_plate.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import jupytext
import nbformat
from nbconvert import HTMLExporter
from nbconvert.preprocessors import ExecutePreprocessor

DEMOS = Path(__file__).parents[1]


def render(name: str, folder: Path) -> nbformat.NotebookNode:
    """Execute a demo from a fresh kernel and write it into a folder; a cell that fails raises CellExecutionError."""
    folder.mkdir(parents=True, exist_ok=True)
    notebook = jupytext.read(DEMOS / f"{name}.py")
    runner = ExecutePreprocessor(timeout=1800, kernel_name="python3")
    runner.preprocess(notebook, {"metadata": {"path": str(folder)}})
    nbformat.write(notebook, folder / f"{name}.ipynb")
    (folder / f"{name}.html").write_text(HTMLExporter().from_notebook_node(notebook)[0])
    return notebook


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Run demos as notebooks and keep them with their outputs.")
    parser.add_argument("names", nargs="*", default=["arch", "double_plate"], help="of demos, without .py")
    parser.add_argument("-o", "--output", type=Path, default=Path("results/notebooks"), help="folder")
    arguments = parser.parse_args()
    for given in arguments.names:
        render(given, arguments.output)
        print(arguments.output / f"{given}.html")
