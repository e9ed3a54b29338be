"""Run the notebooks again, in place: `python docs/notebooks/execute.py [NAME ...]`.

Cells are run in order in a fresh kernel, in this folder; what they print and draw is kept with
them. What differs from run to run (times, kernel versions) is left out, so that a second run
changes nothing that the code did not change.
"""

from __future__ import annotations

import sys
from pathlib import Path

import nbformat
from nbclient import NotebookClient

HERE = Path(__file__).resolve().parent
LONGEST_S = 1800  # of one cell, on a busy machine
KERNEL = {"display_name": "Python 3", "language": "python", "name": "python3"}


def execute(path: Path) -> None:
    """Run one notebook and write it with its outputs."""
    notebook = nbformat.read(path, as_version=4)
    client = NotebookClient(
        notebook, timeout=LONGEST_S, resources={"metadata": {"path": str(HERE)}}
    )
    client.execute()
    notebook.metadata = {"kernelspec": KERNEL, "language_info": {"name": "python"}}
    for number, cell in enumerate(notebook.cells):
        cell["id"] = f"cell-{number}"
        cell.metadata.pop("execution", None)
    nbformat.write(notebook, path)


if __name__ == "__main__":
    for name in sys.argv[1:] or sorted(path.stem for path in HERE.glob("*.ipynb")):
        print(name, flush=True)
        execute(HERE / f"{name}.ipynb")
