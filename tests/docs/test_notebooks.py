"""The notebooks in docs: what they hold is what running them gives."""

from __future__ import annotations

import contextlib
import io
import json
import re
from pathlib import Path
from typing import Any

import pytest

HERE = Path(__file__).parents[2] / "docs" / "notebooks"
NAMES = ("my_bag", "half_the_clearance")


def _cells(name: str) -> list[dict[str, Any]]:
    cells: list[dict[str, Any]] = json.loads((HERE / f"{name}.ipynb").read_text())["cells"]
    return [cell for cell in cells if cell["cell_type"] == "code"]


def _words(text: str) -> list[str]:
    """What a text says beside its numbers."""
    return re.findall(r"[^\W\d_]{2,}", text)


def _printed(cell: dict[str, Any]) -> str:
    return "".join(
        "".join(one["text"]) for one in cell["outputs"] if one["output_type"] == "stream"
    )


def test_the_notebooks_were_run_to_their_end() -> None:
    """Every cell has been executed in order, none failed, and results and pictures are kept."""
    for name in NAMES:
        cells = _cells(name)
        assert [cell["execution_count"] for cell in cells] == list(range(1, len(cells) + 1))
        outputs = [one for cell in cells for one in cell["outputs"]]
        assert not [one for one in outputs if one["output_type"] == "error"]
        kinds = {kind for one in outputs for kind in one.get("data", {})}
        assert {"text/html", "image/png"} <= kinds, name
        text = (HERE / f"{name}.ipynb").read_text()
        assert "/home/" not in text and "/work" not in text


@pytest.mark.parametrize("name", NAMES)
def test_a_notebook_still_runs_and_prints_the_same(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its cells run in order, but those that take minutes; what is printed has the same words."""
    monkeypatch.chdir(HERE)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    namespace: dict[str, Any] = {}
    for cell in _cells(name):
        if "slow" in cell["metadata"].get("tags", []):
            continue
        code = "".join(line for line in cell["source"] if not line.startswith("%"))
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(compile(code, f"{name}.ipynb", "exec"), namespace)
        assert _words(printed.getvalue()) == _words(_printed(cell)), code
