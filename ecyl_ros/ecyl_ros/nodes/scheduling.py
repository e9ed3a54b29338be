"""Where and how soon this process runs: its processors, its priority, and their sleep."""

from __future__ import annotations

import contextlib
import os
import sys
from pathlib import Path

# SCHED_FIFO's lowest priority: before all ordinary threads, behind every other real-time one.
_PRIORITY = 1
# Linux: the longest that waking a processor may take, us, for as long as the file is held open.
_LATENCY_FILE = "/dev/cpu_dma_latency"


def run_first() -> bool:
    """Have the kernel run this process's threads before ordinary ones; False if refused.

    For when a run begins: at start-up there is much to do that nobody waits for. Only where the
    launcher has given plant and controller a processor: elsewhere, as on a machine that has but
    one, they could keep the others from running.
    """
    given = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 0
    if given != 1 or os.cpu_count() == 1:
        return True
    return _schedule("SCHED_FIFO", _PRIORITY)


def run_on(processors: set[int]) -> None:
    """Have this process's threads run on these processors alone, where the system can.

    Raises OSError or ValueError where there are no such processors.
    """
    if not hasattr(os, "sched_setaffinity"):
        return
    for task in Path("/proc/self/task").iterdir():
        with contextlib.suppress(ProcessLookupError):  # a thread that has just ended
            os.sched_setaffinity(int(task.name), processors)


def run_as_others() -> None:
    """Undo `run_first`."""
    _schedule("SCHED_OTHER", 0)


class Awake:
    """Processors that do not sleep between two ticks, until `end`.

    To wake a sleeping processor takes as long as a round trip, on a virtual machine often many
    ticks. They poll instead, at the power that takes. `held` is False where the kernel has no such
    request or refuses it (the file is commonly root's).
    """

    def __init__(self) -> None:
        self._file: int | None = None
        try:
            self._file = os.open(_LATENCY_FILE, os.O_WRONLY)
            os.write(self._file, (0).to_bytes(4, sys.byteorder))
        except OSError:
            self.end()

    @property
    def held(self) -> bool:
        """Whether the request stands."""
        return self._file is not None

    def end(self) -> None:
        """Take the request back; a process that is killed does so, too."""
        if self._file is not None:
            os.close(self._file)
            self._file = None


def _schedule(policy: str, priority: int) -> bool:
    if not hasattr(os, policy):
        return False  # not Linux
    flags = getattr(os, policy) | (os.SCHED_RESET_ON_FORK if priority else 0)
    for task in Path("/proc/self/task").iterdir():
        try:
            os.sched_setscheduler(int(task.name), flags, os.sched_param(priority))
        except PermissionError:
            return False
        except ProcessLookupError:
            pass  # a thread that has just ended
    return True
