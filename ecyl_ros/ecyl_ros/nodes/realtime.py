"""Keeping the wall clock: which ticks are due, how late they came, which commands were missing."""

from __future__ import annotations

import array
import contextlib
import dataclasses
import os
from pathlib import Path
from typing import Any

import numpy as np

from ..drive.parameters import DriveParameters

MAX_KEPT = 4_000_000  # lateness values kept: an hour at 1 kHz
RECENT = 1000  # of them, for the figures while running

# How long input may stay away until the drive is brought to rest: what fieldbus drives commonly
# wait, and more than a hiccup of a desktop's scheduler; at a low control rate some ticks at least.
WATCHDOG_S = 0.1
WATCHDOG_TICKS = 5


def watchdog_ns(rate: float) -> int:
    """The watchdog's time at this control rate (Hz), ns."""
    return round(max(WATCHDOG_S, WATCHDOG_TICKS / rate) * 1e9)


# SCHED_FIFO's lowest priority: before all ordinary threads, behind every other real-time one.
_PRIORITY = 1


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


def with_transport_delay(drive: DriveParameters, logger: Any = None) -> DriveParameters:
    """The drive with at least the one tick of delay that a command on a topic has.

    logger: of a node, which says so where the drive file has none.
    """
    if drive.controller.delay_ticks >= 1:
        return drive
    if logger is not None:
        logger.warning(
            "controller.delay_ticks = 0: in real time a command acts one tick after its "
            "measurement; running with 1"
        )
    return dataclasses.replace(
        drive, controller=dataclasses.replace(drive.controller, delay_ticks=1)
    )


class TickTiming:
    """Counts of a real-time run.

    A tick is *late* when the plant woke more than one period after its instant, and *stale* when
    the command for it had not come; a tick that is neither is met. Jitter is the time from a
    tick's instant to the wake-up that served it.
    """

    def __init__(self, rate: float) -> None:
        """rate: control rate, Hz."""
        self.rate = rate
        self.late = 0
        self.stale = 0
        self.missed = 0
        self.shorted = 0  # times the watchdog took the voltage away
        self.jitter_s = array.array("d")
        self._begin = 0.0
        self._command_ns = -1
        self._due = 0
        self._largest_s = 0.0

    def start(self, instant: float) -> None:
        """instant: of tick 0 on the monotonic clock, s."""
        self._begin = instant

    def wake(self, now: float, tick: int) -> int:
        """Number of ticks due at `now`, `tick` being the first not yet served; notes jitter."""
        due = int((now - self._begin) * self.rate) + 1 - tick
        for behind in range(max(due, 0)):
            lateness = now - (self._begin + (tick + behind) / self.rate)
            if len(self.jitter_s) < MAX_KEPT:
                self.jitter_s.append(lateness)
        self._due = due
        return max(due, 0)

    def command(self, stamp_ns: int) -> None:
        """Note the stamp of the newest command, ns."""
        self._command_ns = stamp_ns

    def latch(self, wanted_ns: int) -> None:
        """Serve one due tick, whose command should be the one stamped `wanted_ns`."""
        late = self._due > 1
        stale = self._command_ns < wanted_ns
        self.late += late
        self.stale += stale
        self.missed += late or stale
        self._due -= 1

    def _counts(self, ticks: int, jitter: np.ndarray) -> dict:
        p50, p99, p999 = np.quantile(jitter, (0.5, 0.99, 0.999)).tolist()
        return {
            "late_ticks": self.late,
            "stale_ticks": self.stale,
            "missed_ticks": self.missed,
            "voltage_losses": self.shorted,
            "met_share": 1.0 - self.missed / max(ticks, 1),
            "jitter_p50_s": p50,
            "jitter_p99_s": p99,
            "jitter_p999_s": p999,
            "jitter_max_s": self._largest_s,
        }

    def running_figures(self, ticks: int) -> dict:
        """Counts and largest jitter so far, jitter quantiles of the last `RECENT` ticks, s.

        Cheap enough to be asked for between two ticks.
        """
        recent = np.array(self.jitter_s[-RECENT:] or [0.0])
        self._largest_s = max(self._largest_s, float(recent.max()))
        return self._counts(ticks, recent)

    def figures(self, ticks: int) -> dict:
        """The same over the whole run, and a histogram of jitter (edges in s, counts)."""
        jitter = np.array(self.jitter_s or [0.0])
        self._largest_s = float(jitter.max())
        edges = np.concatenate([[0.0], np.logspace(-5, -1, 41), [np.inf]])
        counts, _ = np.histogram(np.maximum(jitter, 0.0), edges)
        histogram = {"edges_s": edges[1:-1].tolist(), "counts": counts.tolist()}
        return self._counts(ticks, jitter) | {"jitter_histogram": histogram}
