"""A gain makes up for no inertia that the effort denies: values keep to the file's gain."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from rigid_machines import ROTARY, Motion, recorded
from scipy.signal import butter, lfilter

from ecyl_ros.gap.diagnose import diagnose

RATE_HZ, DURATION_S = 160.0, 40.0
GRAVITY_NM, PHASE_RAD = 1.24, 2.42
ARM = replace(ROTARY, actuation="current", gain=1.0, inertia=0.02)


def _shaped(white: np.ndarray, cutoff_hz: float, order: int, size: float) -> np.ndarray:
    """Noise of standard deviation `size`, low-passed."""
    low, high = butter(order, cutoff_hz, fs=RATE_HZ)
    made = lfilter(low, high, white)
    return made * size / made.std()


def test_the_weight_of_a_slow_arm_is_counted_by_the_gain_of_the_file() -> None:
    """An arm so slow that its inertia is nothing beside its weight, and a position whose noise, not
    white, asks for more effort than was there: no inertia explains that, and ten times the gain
    would have the stated one be nothing. The weight is named, its true size within the interval,
    and not ten times as large."""
    rng = np.random.default_rng(2)
    t = np.arange(round(DURATION_S * RATE_HZ)) / RATE_HZ
    true = 1.1 * np.sin(2 * np.pi * t / 13.0) + 0.15 * np.sin(2 * np.pi * 0.31 * t) - 0.2
    slow = _shaped(rng.standard_normal(t.size), 0.02 * RATE_HZ / 2, 1, 0.08)
    q = true + _shaped(rng.standard_normal(t.size), 12.0, 2, 3e-3)
    v = np.gradient(q, t)
    effort = GRAVITY_NM * np.sin(true + PHASE_RAD) + slow
    shown = recorded(Motion(t, q, v, np.gradient(v, t)), effort, ARM, 0.0, 1e-5)
    result = diagnose(shown, ARM)
    (cause,) = result.causes
    amplitude = cause.parameters[0]
    assert cause.effect == "gravity_on_arm"
    assert amplitude.low <= GRAVITY_NM <= amplitude.high
    assert amplitude.high - amplitude.low < GRAVITY_NM
