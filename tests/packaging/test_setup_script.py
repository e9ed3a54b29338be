"""scripts/setup leaves an environment alone that is up to date, from wherever it is called."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import venv
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
_READ = (
    "scripts/setup",
    "ecyl_ros/setup.py",
    "rclpy_cyclone/pyproject.toml",
    "requirements-dev.txt",
)


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """What scripts/setup reads, beside an environment that it has made and whose rclpy is ours."""
    for name in _READ:
        (tmp_path / name).parent.mkdir(exist_ok=True)
        shutil.copy(ROOT / name, tmp_path / name)
    made = _environment(tmp_path / ".venv", "rclpy")
    sums = subprocess.run(
        ["bash", "-c", f"cat {' '.join(_READ[1:3])} {_READ[0]} | cksum"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
    )
    (made / "made-with").write_text("none\n", encoding="utf-8")
    (made / "made-from").write_text(f"{sums.stdout.strip()} none\n", encoding="utf-8")
    return tmp_path


def _environment(folder: Path, *modules: str) -> Path:
    """A virtual one with empty modules."""
    venv.create(folder, symlinks=True)
    version = f"python{sys.version_info.major}.{sys.version_info.minor}"
    for name in modules:
        (folder / "lib" / version / "site-packages" / f"{name}.py").touch()
    return folder


def _without_environments() -> dict[str, str]:
    """This process's environment without the virtual one that its tests run in."""
    path = os.environ["PATH"].split(os.pathsep)
    outside = [part for part in path if Path(part) != Path(sys.prefix) / "bin"]
    unset = ("PYTHON", "PYTHONPATH", "VIRTUAL_ENV")
    kept = {name: value for name, value in os.environ.items() if name not in unset}
    return kept | {"PATH": os.pathsep.join(outside)}


@pytest.mark.parametrize("active", [None, ".venv", "other"])
def test_setup_keeps_an_environment_that_is_up_to_date(checkout: Path, active: str | None) -> None:
    """Nothing is made anew, whether no environment is active, its own (where its own rclpy is seen)
    or that of another checkout, which has the stand-in's rclpy."""
    environment = _without_environments()
    if active is not None:
        folder = checkout / active
        if active == "other":
            _environment(folder, "rclpy", "rclpy_cyclone")
        environment |= {
            "VIRTUAL_ENV": str(folder),
            "PATH": f"{folder / 'bin'}{os.pathsep}{environment['PATH']}",
        }
    ran = subprocess.run(
        ["bash", "scripts/setup"], cwd=checkout, env=environment, capture_output=True, text=True
    )
    assert (ran.returncode, ran.stdout, ran.stderr) == (0, "", "")
    assert (checkout / ".venv" / "made-from").exists()
