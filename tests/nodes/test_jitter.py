"""What a real-time run tells of its jitter, against numpy on all of it."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from ecyl_ros.nodes.realtime import TickTiming

RATE = 1000.0


def test_counted_jitter_has_the_quantiles_of_all_of_it() -> None:
    """Median, 99th and 99.9th percentile within 1.2 %, the largest exactly, all ticks counted."""
    timing = TickTiming(RATE)
    timing.start(0.0)
    jitter = np.minimum(np.random.default_rng(1).lognormal(np.log(6e-5), 0.6, 30_000), 9e-4)
    jitter[7], jitter[11] = 3e-7, 0.0  # below all bins
    for tick, late_s in enumerate(jitter.tolist()):
        assert timing.wake(tick / RATE + late_s, tick) == 1
    told = timing.figures(len(jitter))
    for quantile, key in ((0.5, "p50"), (0.99, "p99"), (0.999, "p999")):
        expected = np.quantile(jitter, quantile)
        assert told[f"jitter_{key}_s"] == pytest.approx(expected, rel=0.012)
    assert told["jitter_max_s"] == pytest.approx(jitter.max(), abs=1e-9)
    edges = [0.0, *told["jitter_histogram"]["edges_s"], np.inf]
    counts, _ = np.histogram(jitter, edges)
    # A value on an edge may count on its other side: that of the clock's reading, 1e-12 s off.
    assert np.abs(np.cumsum(counts) - np.cumsum(told["jitter_histogram"]["counts"])).max() <= 1
    assert sum(told["jitter_histogram"]["counts"]) == len(jitter)


def test_a_longer_run_takes_no_more_memory() -> None:
    """Of a hundred times as many ticks no more is kept."""
    sizes = []
    timing = TickTiming(RATE)
    timing.start(0.0)
    for tick in range(200_000):
        timing.wake(tick / RATE + 1e-5, tick)
        if tick in (2_000, 199_999):
            kept = vars(timing).values()
            sizes.append(sum(len(one) for one in kept if hasattr(one, "__len__")))
            assert all(sys.getsizeof(one) < 50_000 for one in kept)
    assert sizes[0] == sizes[1]


def test_a_run_that_misses_most_ticks_for_long_is_given_up() -> None:
    """Half the ticks of ten seconds missed is no reason to end, more is; a good second ends it."""
    timing = TickTiming(RATE)
    second = round(RATE)
    for count in range(1, 12):
        timing.missed += second // 2
        assert timing.since_last(count * second) == 0.5
        assert timing.too_many() is None
    timing.missed += second // 2 + 1
    assert timing.since_last(12 * second) > 0.5
    assert timing.too_many() == f"{5 * second + 1} of the latest {10 * second} ticks were missed"
    assert timing.since_last(13 * second) == 0.0
    assert timing.too_many() is None
