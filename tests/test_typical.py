"""How large values typically are."""

from __future__ import annotations

import numpy as np
import pytest

from ecyl_ros.typical import typical_rms


def test_the_rms_of_the_bulk_is_told_whatever_a_few_values_do() -> None:
    """Of normal noise its standard deviation, one value in twenty a thousand times as large and one
    missing; about zero, not about the mean."""
    noise = 0.3 * np.random.default_rng(5).standard_normal((4, 5000))
    assert typical_rms(noise) == pytest.approx(0.3, rel=0.02)
    noise[:, ::20] *= 1000.0
    noise[0, 1] = np.nan
    assert typical_rms(noise) == pytest.approx(0.3, rel=0.1)
    assert typical_rms(np.array([2.0, 2.0, -2.0])) == pytest.approx(2.0 * 1.4826)


@pytest.mark.parametrize("count", [1, 2, 3, 10, 2001])
def test_it_is_numpys_median(count: int) -> None:
    """To the last bit, of even and odd numbers of values, a missing one among them."""
    values = np.append(np.random.default_rng(count).standard_normal(count), np.nan)
    assert typical_rms(values) == 1.4826 * float(np.nanmedian(np.abs(values)))
