"""Linear algebra on one thread, whatever the machine has."""

from __future__ import annotations

from pathlib import Path

import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from ecyl_ros.analysis.one_thread import on_one_thread
from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.recording.reader import read_recording

BAG = Path(__file__).parents[2] / "bags" / "bench_moves.mcap"


def _threads() -> set[int]:
    return {one["num_threads"] for one in threadpool_info() if one["user_api"] == "blas"}


def test_a_diagnosis_takes_one_thread_and_gives_them_back() -> None:
    """With two threads of linear algebra it has one from start to end, and two are there after."""
    seen: set[int] = set()
    with threadpool_limits(2):
        diagnose(
            read_recording(BAG), load_drive("bench"), progress=lambda _: seen.update(_threads())
        )
        assert seen == {1} and _threads() == {2}


def test_threads_are_given_back_after_an_error() -> None:
    """What fails leaves the process as it was."""

    @on_one_thread
    def fails() -> None:
        assert _threads() == {1}
        raise ValueError("as it must")

    with threadpool_limits(2):
        with pytest.raises(ValueError, match="as it must"):
            fails()
        assert _threads() == {2}
