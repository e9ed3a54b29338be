"""Progress of long work."""

from __future__ import annotations

import time

import pytest

from ecyl_ros.cli.progress import progress_bar


def test_a_log_is_told_once_a_minute(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Five minutes of work that is told of every ten seconds leave five lines, and half a minute
    none."""
    now = 0.0
    monkeypatch.setattr(time, "monotonic", lambda: now)
    for seconds, lines in ((300, 5), (30, 0)):
        begin = now
        with progress_bar("diagnosing") as tell:
            while now < begin + seconds:
                now += 10.0
                tell((now - begin) / seconds)
        said = capsys.readouterr()
        assert said.out == "" and len(said.err.splitlines()) == lines
        assert lines == 0 or said.err.startswith("diagnosing: 20 % after 1 min\n")
