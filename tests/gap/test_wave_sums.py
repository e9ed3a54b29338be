"""Sums of waves at evenly spaced rates, the values anywhere."""

from __future__ import annotations

import numpy as np
import pytest

from ecyl_ros.gap.rigid.wave_sums import wave_sums


@pytest.mark.parametrize(
    ("values", "first", "spacing", "count"),
    [(2000, 1.0, 1.0, 300), (700, 5.0, 1e-3, 21), (900, 2.3, 0.1, 1), (500, -3.0, 0.4, 50)],
)
def test_they_are_those_that_adding_up_gives(values, first, spacing, count) -> None:
    """Within 1e-10 of the RMS of as many values, whatever the rates: whole, close by, one alone."""
    rng = np.random.default_rng(4)
    along, size = rng.uniform(-30.0, 50.0, values), rng.normal(size=values)
    rates = first + spacing * np.arange(count)
    expected = np.exp(1j * rates[:, None] * along) @ size
    found = wave_sums(size, along, first, spacing, count)
    assert np.abs(found - expected).max() < 1e-10 * np.sqrt(np.sum(size**2))
