"""A filter of which few samples are wanted, against SciPy's own of all samples."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import butter, sosfiltfilt

from ecyl_ros.gap.rigid.decimated import decimated

RATE = 1000.0
SIDE = 400


@pytest.mark.parametrize("step", [1, 4, 15])
def test_the_wanted_samples_are_those_of_the_whole_filter(step: int) -> None:
    """Of drifting and of mostly empty columns, at the ends too, to a millionth of the largest."""
    sos = butter(2, 100.0, fs=RATE, output="sos")
    alone = np.zeros(2 * SIDE + 1)
    alone[SIDE] = 1.0
    response = sosfiltfilt(sos, alone)
    rng = np.random.default_rng(3)
    columns = np.zeros((2, 3, 2003))
    columns[0] = np.cumsum(rng.normal(size=(3, 2003)), axis=1)
    columns[1, :, 500:520] = rng.normal(size=(3, 20))
    expected = sosfiltfilt(sos, columns, padlen=1000)[..., step // 2 :: step]
    found = decimated(columns, response, step)
    assert found.shape == expected.shape
    assert np.abs(found - expected).max() < 1e-6 * np.abs(expected).max()


def test_a_column_shorter_than_the_response_is_filtered_too() -> None:
    """A constant stays what it is, however few samples there are of it."""
    response = np.hanning(803)
    response /= response.sum()
    found = decimated(np.full(50, 2.5), response, 7)
    assert found == pytest.approx(np.full(7, 2.5))
