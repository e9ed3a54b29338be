"""Processors do not sleep between ticks while a real-time run holds the kernel's request."""

from __future__ import annotations

from pathlib import Path

import pytest

from ecyl_ros.nodes import scheduling


def test_the_request_is_no_latency_and_stands_until_it_is_taken_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A 32-bit zero is written, as the kernel's PM QoS wants it, and the file stays open."""
    file = tmp_path / "cpu_dma_latency"
    file.touch()
    monkeypatch.setattr(scheduling, "_LATENCY_FILE", str(file))
    awake = scheduling.Awake()
    opened = {path.resolve() for path in Path("/proc/self/fd").iterdir()}
    assert awake.held and file in opened
    assert file.read_bytes() == bytes(4)
    awake.end()
    assert not awake.held
    assert file not in {path.resolve() for path in Path("/proc/self/fd").iterdir()}
    awake.end()  # a run may end twice


def test_where_the_system_has_no_such_request_the_run_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """No file, no request, no error."""
    monkeypatch.setattr(scheduling, "_LATENCY_FILE", str(tmp_path / "none"))
    awake = scheduling.Awake()
    assert not awake.held
    awake.end()


def test_a_request_that_the_system_refuses_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    """Opened, but not to be written to (a full device): no request, no error, no open file."""
    monkeypatch.setattr(scheduling, "_LATENCY_FILE", "/dev/full")
    awake = scheduling.Awake()
    assert not awake.held
    assert Path("/dev/full") not in {one.resolve() for one in Path("/proc/self/fd").iterdir()}
