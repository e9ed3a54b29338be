"""A small recording with every signal different, and how to compare two."""

from __future__ import annotations

import numpy as np

from ecyl_ros.recording import SIGNALS, Recording


def made(samples: int = 500, *, without: tuple[str, ...] = (), seed: int = 1) -> Recording:
    """Noise on every signal but those left out, at 1 kHz, stamps like a wall clock's."""
    rng = np.random.default_rng(seed)
    signals = {name: rng.normal(size=samples) for name in SIGNALS if name not in without}
    stamps = 1_700_000_000_000_000_000 + np.arange(samples, dtype=np.int64) * 1_000_000
    return Recording(stamp_ns=stamps, **signals)


def assert_same(left: Recording, right: Recording) -> None:
    """All arrays equal, bit for bit but for the kind of NaN."""
    np.testing.assert_array_equal(left.stamp_ns, right.stamp_ns)
    for name in SIGNALS:
        np.testing.assert_array_equal(left.signal(name), right.signal(name), err_msg=name)
