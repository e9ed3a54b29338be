"""The documentation as HTML."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.mark.slow
def test_the_documentation_builds_without_a_warning(tmp_path: Path) -> None:
    """`docs/site/build.py` ends with 0: no warning; every page and every public module is there."""
    pytest.importorskip("rclpy_cyclone.finder", reason="not beside genuine ROS, and it has pages")
    out = tmp_path / "html"
    build = [sys.executable, ROOT / "docs" / "site" / "build.py", out, "--no-sources", "--jobs=1"]
    built = subprocess.run(build, capture_output=True, text=True)
    assert built.returncode == 0, built.stderr[-4000:]
    assert "WARNING" not in built.stderr
    for page in (*(ROOT / "docs").rglob("*.md"), *(ROOT / "docs").rglob("*.ipynb")):
        if page.parent.name != "site":
            assert (out / page.relative_to(ROOT)).with_suffix(".html").exists(), page
    package = ROOT / "ecyl_ros" / "ecyl_ros"
    for module in package.rglob("*.py"):
        if not module.stem.startswith("_"):
            dotted = ".".join(module.relative_to(package.parent).with_suffix("").parts)
            assert (out / "api" / f"{dotted}.html").exists(), dotted
    signature = (out / "api" / "ecyl_ros.gap.diagnose.html").read_text(encoding="utf-8")
    assert "effects that the diagnosis must do without" in signature
    assert "Raises" in signature
    kernel = (out / "api" / "ecyl_ros.effects.cogging_torque.html").read_text(encoding="utf-8")
    assert "rotor_torque" in kernel
