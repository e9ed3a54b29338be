"""Whether to look for something new for a while before going to sleep.

Waking a sleeping process costs more than many looks, so that two processes which answer each other
gain from it, as long as nobody else wants the processors. ``RCLPY_CYCLONE_SPIN_US`` sets how long
to look, in microseconds; 0 switches it off.
"""

from __future__ import annotations

import os

DEFAULT_US = 50.0
_CHECK_NS = 20_000_000  # how long a look at the machine's load holds good


def _wanted() -> int:
    text = os.environ.get("RCLPY_CYCLONE_SPIN_US", "")
    try:
        return int(float(text or DEFAULT_US) * 1000)
    except ValueError:
        raise ValueError(f"RCLPY_CYCLONE_SPIN_US={text!r} is not a number") from None


_cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
SPIN_NS = _wanted() if _cores > 1 else 0
_crowded = True
_checked = 0


def allowed(now: int) -> bool:
    """Say whether there is a processor to spare.

    :param now: the time by the monotonic clock, in nanoseconds.
    """
    global _crowded, _checked
    if now - _checked > _CHECK_NS:
        _checked = now
        _crowded = _runnable() > _cores
    return not _crowded


def _runnable() -> float:
    """Return how many threads want a processor at this moment."""
    try:
        with open("/proc/loadavg", encoding="ascii") as file:
            return int(file.read().split()[3].split("/")[0])
    except (OSError, IndexError, ValueError):
        pass
    return os.getloadavg()[0] if hasattr(os, "getloadavg") else float("inf")
