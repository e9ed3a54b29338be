"""docs/diagnosis.md against the code it speaks of."""

from __future__ import annotations

from pathlib import Path

from ecyl_ros.gap import split
from ecyl_ros.gap.diagnosis import VERDICTS
from ecyl_ros.gap.judge import verdict

PAGE = (Path(__file__).parents[2] / "docs" / "diagnosis.md").read_text()


def test_the_thresholds_of_the_page_are_those_in_force() -> None:
    """Each verdict is in the page's table with the figures that decide it."""
    rows = {line.split("`")[1]: line for line in PAGE.splitlines() if line.startswith("| `")}
    assert set(rows) == set(VERDICTS)
    assert f" {verdict.NO_GAP_RATIO:g} times its floor" in rows["no_gap"]
    assert f"at least {verdict.EXPLAINED_SHRINK:g} of the gap" in rows["explained"]
    assert f"within {verdict.STRUCTURELESS:g} of a perfect" in rows["explained"]
    assert f"less sure than {verdict.NAMED:g}" in rows["unexplained"]
    assert f"stretches of {split.STRETCH_S:g} s" in PAGE
