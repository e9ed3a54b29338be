"""Worker processes of a study: they share the work, and none outlives it."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import pytest

from ecyl_ros.analysis.ended_together import ended_together
from ecyl_ros.analysis.parallel import cores
from ecyl_ros.gap.study.workers import WorkerDied, in_processes

PROGRAM = """
    import os, sys, time
    from ecyl_ros.analysis.ended_together import ended_together
    from ecyl_ros.gap.study.workers import in_processes

    def work(seconds):
        if seconds:
            time.sleep(seconds)
        return os.getpid()

    with ended_together():
        for worker in in_processes(work, [0, 0, 0, 0, 60, 60], 2):
            print(worker, flush=True)
"""


OVER = """
    import os, sys, time
    from ecyl_ros.analysis.parallel import over

    def work(seconds):
        os.write(1, b"%d\\n" % os.getpid())  # whole lines, whoever writes
        time.sleep(seconds)

    over(work, [0, 0, 0, 0, 60, 60], jobs=2)
"""


def _alive(pid: int) -> bool:
    """Whether a process runs; one that has ended and waits to be collected does not."""
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return False
    return state != "Z"


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="reads the states of processes from /proc")
@pytest.mark.parametrize(
    ("program", "number"),
    [(PROGRAM, signal.SIGTERM), (PROGRAM, signal.SIGINT), (OVER, signal.SIGTERM)],
    ids=["study, SIGTERM", "study, Ctrl-C", "sweep, SIGTERM"],
)
def test_no_worker_outlives_a_study_that_is_ended(program, number) -> None:
    """SIGTERM and Ctrl-C end the workers in the middle of their work, within seconds."""
    source = Path(__file__).parents[2] / "ecyl_ros"
    study = subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(program)],
        env=dict(os.environ, PYTHONPATH=str(source)),
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        # A shell may have told its children to ignore Ctrl-C.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    assert study.stdout is not None
    workers = {int(study.stdout.readline()) for _ in range(4)}
    assert study.pid not in workers and all(_alive(pid) for pid in workers)
    study.send_signal(number)
    study.wait(timeout=60)
    deadline = time.monotonic() + 10.0
    while any(_alive(pid) for pid in workers) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not any(_alive(pid) for pid in workers)
    study.stdout.close()


def _square_or_die(value: int) -> int:
    if value < 0:
        os.kill(os.getpid(), signal.SIGKILL)
    return value * value


def test_all_results_come_and_a_killed_worker_is_said() -> None:
    """Every item's result once, in any order; a worker that is killed ends the work with a word."""
    with ended_together():
        assert sorted(in_processes(_square_or_die, [1, 2, 3, 4], 2)) == [1, 4, 9, 16]
        assert list(in_processes(_square_or_die, [], 2)) == []
        with pytest.raises(WorkerDied):
            list(in_processes(_square_or_die, [1, -1, 2], 2))


def _cores_seen(item: int) -> int:
    return cores()


def test_workers_share_the_cores_out(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each of two workers counts half of this process's cores as its own, and this process all."""
    monkeypatch.setenv("LOKY_MAX_CPU_COUNT", "4")
    here = cores()
    with ended_together():
        assert set(in_processes(_cores_seen, range(4), 2)) == {max(1, here // 2)}
    assert cores() == here
