"""Descents by least squares: where derivatives are spikes, steps are too short."""

from __future__ import annotations

import numpy as np

from ecyl_ros.gap.fit.newton import Differences, Objective, descend

TIME_S = np.linspace(-4.0, 5.0, 9001)


def _moved(late_s: float) -> np.ndarray:
    """A slow wave, and an impact of 4 ms upon it, both late by so much, less what came in time."""

    def wave(time_s: np.ndarray) -> np.ndarray:
        return np.exp(-0.5 * time_s**2) + 0.5 * np.exp(-0.5 * (time_s / 4e-3) ** 2)

    return wave(TIME_S - late_s) - wave(TIME_S)


def test_a_fit_goes_as_far_as_impacts_have_to_move() -> None:
    """Impacts a second late: each step alone is a hundredth of the way, eight steps reach the end.

    The slow wave shows the way; the impact, which overlaps nothing, only makes the slope steeper.
    """
    tried: list[float] = []

    def attempt(point: np.ndarray) -> np.ndarray:
        tried.append(float(point[0]))
        return _moved(float(point[0]))

    objective = Objective(
        residual=lambda point: _moved(float(point[0])),
        tried=attempt,
        loss_scale=1e3,
        evidence=300.0,
        precision=np.zeros(1),
        low=np.array([-5.0]),
        high=np.array([5.0]),
    )
    slopes = np.empty((1, len(TIME_S)))
    differences = Differences(np.array([1e-4]), central=False)
    descend(objective, np.array([1.0]), slopes, [0], [], differences, most=8, least=1e-9)
    assert abs(tried[1] - 1.0) < 0.05
    nearest = min(tried, key=lambda late: objective.value(_moved(late), np.array([late])))
    assert abs(nearest) < 4e-3
