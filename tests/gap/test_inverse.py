"""The inverse of a curvature holds what is known least as well as what is known best."""

from __future__ import annotations

import numpy as np
import pytest

from ecyl_ros.gap.inverse import inverse_of


def test_what_is_hardly_known_stays_open_beside_what_is_known_very_well() -> None:
    """A frequency known 1e16 times as well as a scale: by Schur's complement the scale's variance
    is that of what the sheet alone says; a plain pseudo-inverse makes it certain."""
    columns = np.array([[1e8, 0.0, 0.0], [3e5, 1.0, 1.0], [1e5, 1.0, 1.0]])
    curvature = columns.T @ columns + np.diag([0.0, 4.0, 4.0])
    rest = curvature[1:, 1:] - np.outer(curvature[1:, 0], curvature[0, 1:]) / curvature[0, 0]
    assert inverse_of(curvature)[1:, 1:] == pytest.approx(np.linalg.inv(rest), rel=1e-6)
    plain = np.linalg.pinv(curvature, rcond=1e-12, hermitian=True)
    assert plain[1, 1] < 1e-3 * inverse_of(curvature)[1, 1]


def test_of_what_nothing_is_known_of_nothing_is_said() -> None:
    """A coordinate without curvature has none of the inverse, as in a pseudo-inverse."""
    found = inverse_of(np.diag([4.0, 0.0]))
    assert found == pytest.approx(np.diag([0.25, 0.0]))
