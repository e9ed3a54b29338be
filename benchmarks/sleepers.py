"""Bare 1 kHz loops: how punctual processes wake on this machine when they do nothing else.

`python sleepers.py SECONDS RATE` sleeps to absolute deadlines and prints the latenesses' histogram
as JSON, in the same bins as a real-time run's.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time

import numpy as np

EDGES_S = np.concatenate([[0.0], np.logspace(-5, -1, 41), [np.inf]])


def sleep_loop(seconds: float, rate: float) -> np.ndarray:
    """Lateness of every wake-up behind its instant, s; sleeps to absolute deadlines."""
    lateness = np.zeros(round(seconds * rate))
    begin = time.monotonic() + 0.1
    for tick in range(len(lateness)):
        instant = begin + tick / rate
        left = instant - time.monotonic()
        if left > 0.0:
            time.sleep(left)
        lateness[tick] = time.monotonic() - instant
    return lateness


def figures(lateness_s: np.ndarray, rate: float) -> dict:
    """Quantiles and histogram, under the names that the plant's summary has."""
    return {
        "late_share": float(np.mean(lateness_s > 1.0 / rate)),
        "jitter_p50_s": float(np.quantile(lateness_s, 0.5)),
        "jitter_p99_s": float(np.quantile(lateness_s, 0.99)),
        "jitter_p999_s": float(np.quantile(lateness_s, 0.999)),
        "jitter_max_s": float(lateness_s.max()),
        "counts": np.histogram(np.maximum(lateness_s, 0.0), EDGES_S)[0].tolist(),
    }


def five_at_once(seconds: float, rate: float, processes: int = 5) -> list[dict]:
    """Figures of as many sleeping loops at the same time as the graph has processes."""
    command = [sys.executable, __file__, str(seconds), str(rate)]
    running = [
        subprocess.Popen(command, stdout=subprocess.PIPE, text=True) for _ in range(processes)
    ]
    return [json.loads(process.communicate()[0]) for process in running]


def main() -> None:
    """One loop."""
    seconds, rate = float(sys.argv[1]), float(sys.argv[2])
    print(json.dumps(figures(sleep_loop(seconds, rate), rate)))


if __name__ == "__main__":
    main()
