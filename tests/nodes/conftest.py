"""Graphs of their own for every test: a ROS domain per worker and test."""

from __future__ import annotations

import itertools
import os
import subprocess
import sys
from pathlib import Path

import pytest

_COUNTER = itertools.count()
SINE = "sine:amplitude=2e-3,frequency=2"


@pytest.fixture(autouse=True)
def own_domain(monkeypatch: pytest.MonkeyPatch) -> None:
    """A ROS_DOMAIN_ID that no other test and no other worker uses at the time."""
    worker = int(os.environ.get("PYTEST_XDIST_WORKER", "gw0")[2:])
    monkeypatch.setenv("ROS_DOMAIN_ID", str(40 + 25 * (worker % 2) + next(_COUNTER) % 25))


def ecyl(*arguments: object, timeout: float = 120.0) -> subprocess.CompletedProcess:
    """Run `ecyl` to its end and return what it printed."""
    command = [sys.executable, "-m", "ecyl_ros.cli.main", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=timeout, check=False)


def start(*arguments: object) -> subprocess.Popen:
    """Start `ecyl` in the background."""
    command = [sys.executable, "-m", "ecyl_ros.cli.main", *map(str, arguments)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def simulated(path: Path, *arguments: object) -> bytes:
    """Bytes of the recording that `ecyl simulate` makes with these arguments."""
    done = ecyl("simulate", *arguments, "--out", path)
    assert done.returncode == 0, done.stderr
    return path.read_bytes()
