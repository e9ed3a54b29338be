"""Wheels and source archives of both packages, as somebody without the repository gets them."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import xml.etree.ElementTree as ElementTree
import zipfile
from pathlib import Path

import pytest

import ecyl_ros

pytest.importorskip("rclpy_cyclone.finder", reason="scripts/setup leaves it out beside genuine ROS")

import rclpy_cyclone

ROOT = Path(__file__).parents[2]
PROJECTS = ("ecyl_ros", "rclpy_cyclone")
OURS = (*PROJECTS, "__editable__", "_virtualenv", "distutils-precedence")


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the archives of both packages, built without network."""
    out = tmp_path_factory.mktemp("dist")
    plain = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}
    for project in PROJECTS:
        done = subprocess.run(
            [sys.executable, "-m", "build", "--no-isolation", "--outdir", out, ROOT / project],
            capture_output=True,
            text=True,
            env=plain,
        )
        said = done.stdout + done.stderr
        assert done.returncode == 0, said[-3000:]
        assert not [line for line in said.splitlines() if "warning" in line.lower()], project
    return out


def test_the_archives_hold_what_the_package_needs(built: Path) -> None:
    """Both packages build without a warning, each as wheel and source archive with its licence."""
    licence = (ROOT / "LICENSE").read_text(encoding="utf-8")
    for project in PROJECTS:
        (wheel,) = built.glob(f"{project}-*.whl")
        with zipfile.ZipFile(wheel) as archive:
            names = archive.namelist()
            (name,) = (one for one in names if one.endswith("licenses/LICENSE"))
            assert archive.read(name).decode() == licence
            assert f"{project}/py.typed" in names
            assert not [one for one in names if one.startswith(("tests/", "build/"))]
        (source,) = built.glob(f"{project}-*.tar.gz")
        with tarfile.open(source) as archive:
            members = {one.partition("/")[2] for one in archive.getnames()}
        assert {"LICENSE", "README.md", "pyproject.toml"} <= members


@pytest.fixture(scope="module")
def dependencies(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with what both packages need, and nothing of ours: by links, which is quick."""
    there = tmp_path_factory.mktemp("dependencies")
    for path in Path(sysconfig.get_path("purelib")).iterdir():
        if not path.name.startswith(OURS):
            (there / path.name).symlink_to(path)
    return there


@pytest.mark.parametrize("kind", ["whl", "tar.gz"])
def test_the_archives_work_without_the_repository(
    built: Path, dependencies: Path, tmp_path: Path, kind: str
) -> None:
    """Wheels, or source archives alone, installed into an empty environment: both work."""
    home = tmp_path / "venv"
    system = "include-system-site-packages = true" in Path(sys.prefix, "pyvenv.cfg").read_text()
    options = ["--system-site-packages"] if system else []
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", *options, home], check=True)
    python = home / "bin" / "python"
    empty = tmp_path / "empty"
    empty.mkdir()
    environment = os.environ | {"PYTHONPATH": str(dependencies)}
    # A source archive is built with the tools that are here: an environment for it needs a network.
    install = ["install", "--quiet", "--no-deps", "--no-index", "--no-build-isolation"]
    subprocess.run(
        [sys.executable, "-m", "pip", "--python", python, *install, *built.glob(f"*.{kind}")],
        cwd=empty,
        env=environment,
        check=True,
    )
    smoke = shutil.copy(ROOT / "tests" / "packaging" / "smoke.py", empty)
    done = subprocess.run(
        [python, smoke], cwd=empty, env=environment, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr[-3000:]


def test_versions_and_licences_agree() -> None:
    """Version and licence stand alike in package, package.xml, changelog and licence files."""
    manifest = ElementTree.parse(ROOT / "ecyl_ros" / "package.xml").getroot()
    assert manifest.findtext("version") == ecyl_ros.__version__ == rclpy_cyclone.__version__
    changes = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert f"## {ecyl_ros.__version__}" in changes
    licence = (ROOT / "LICENSE").read_bytes()
    for project in PROJECTS:
        assert (ROOT / project / "LICENSE").read_bytes() == licence
    assert manifest.findtext("license") == "Apache-2.0"


def test_the_graph_says_what_it_needs(tmp_path: Path) -> None:
    """Where there is no rclpy, `ecyl run` says in one line what to install, and ends with 2."""
    program = (
        "import sys, rclpy_cyclone; rclpy_cyclone.uninstall()\n"
        "from ecyl_ros.cli.main import main\n"
        f"sys.exit(main({['run', '--drive', 'bench', '--reference', 'setpoint', '--out', 'x']}))"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True
    )
    assert done.returncode == 2 and done.stderr.count("\n") == 1
    assert "rclpy_cyclone" in done.stderr and not list(tmp_path.iterdir())
