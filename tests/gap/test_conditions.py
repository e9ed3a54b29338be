"""When a gap shows: the instants near a reversal, by hand."""

from __future__ import annotations

import numpy as np
import pytest

from ecyl_ros.gap.locate.conditions import near_reversal, widened


@pytest.mark.parametrize("samples", [5, 224, 241, 2000])
@pytest.mark.parametrize("times", [1, 2])
def test_near_a_reversal_is_within_its_time_however_short_the_recording(
    samples: int, times: int
) -> None:
    """As long as the recording is, 0.06 s to both sides of where the speed changes its sign."""
    step_s = 1e-3
    time_s = np.arange(samples) * step_s
    turn = samples // 2
    speed = np.where(np.arange(samples) < turn, 1.0, -1.0)
    expected = np.abs(time_s - time_s[turn]) < times * 0.06 + 0.5 * step_s
    assert (near_reversal(speed, step_s, times) == expected).all()
    nowhere = np.zeros(samples, dtype=bool)
    assert not widened(nowhere, step_s, times).any()
