"""Work side by side: the same as one after the other, from within such work, too."""

from __future__ import annotations

import os
import threading
import time

import pytest

from ecyl_ros.gap.side_by_side import side_by_side


def test_results_come_in_the_order_of_the_jobs() -> None:
    """However long each takes."""

    def slow(job: int) -> int:
        time.sleep(0.001 * (job % 3))
        return job * job

    assert side_by_side(slow, range(40)) == [job * job for job in range(40)]
    assert side_by_side(slow, []) == []


def test_work_within_work_ends() -> None:
    """Three deep, on more jobs than there are threads: nobody waits for somebody who waits."""

    def sum_of(depth: int) -> int:
        return sum(side_by_side(sum_of, [depth - 1] * 5)) if depth else 1

    assert sum_of(4) == 5**4


@pytest.mark.skipif((os.cpu_count() or 1) < 2, reason="one core has nobody beside")
def test_more_than_one_thread_works() -> None:
    """Two jobs that wait for each other both end."""
    meet = threading.Barrier(2, timeout=10.0)
    side_by_side(lambda _: meet.wait(), range(2))


def test_what_fails_first_in_order_is_raised() -> None:
    """And what has not begun is not begun."""
    begun: list[int] = []

    def fails(job: int) -> int:
        begun.append(job)
        if job >= 3:
            raise ValueError(f"job {job}")
        return job

    with pytest.raises(ValueError, match="job 3"):
        side_by_side(fails, range(1000))
    assert len(begun) < 1000
    assert side_by_side(lambda job: job, range(3)) == [0, 1, 2]


def test_a_forked_process_has_threads_of_its_own() -> None:
    """Threads do not survive a fork; work goes on there all the same."""
    side_by_side(lambda job: job, range(8))
    child = os.fork()
    if child == 0:
        os._exit(0 if side_by_side(lambda job: job + 1, range(8)) == list(range(1, 9)) else 1)
    _, status = os.waitpid(child, 0)
    assert os.waitstatus_to_exitcode(status) == 0
