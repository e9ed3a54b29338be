"""Robust mean squares, summed by products of many terms, against the sum of their logarithms."""

import math

import numpy as np
import pytest

from ecyl_ros.gap.fit.robust import cost, robust_mean_square, robust_squares


@pytest.mark.parametrize("scale", [3.0, 0.7, 300.0])
def test_mean_is_that_of_single_squares(scale):
    """From far below the floor to a loop that has run away, whatever the order."""
    rng = np.random.default_rng(5)
    values = rng.standard_normal(40_000) * rng.choice([1e-6, 1.0, 40.0, 1e6], 40_000)
    wanted = float(np.mean(robust_squares(values, scale)))
    assert robust_mean_square(values, scale) == pytest.approx(wanted, rel=1e-12)


def test_what_is_far_below_the_floor_is_not_rounded_off() -> None:
    """A noise-free fit at its end still knows which way is down."""
    values = np.full(1000, 3e-9)
    assert robust_mean_square(values) == pytest.approx(9e-18, rel=1e-6)


def test_cost_is_of_the_rows_chosen():
    """Rows that are left out do not count, not even where nothing is known there."""
    rng = np.random.default_rng(6)
    gap = 5.0 * rng.standard_normal((3, 900))
    rows = rng.random(900) < 0.4
    gap[:, ~rows] = math.nan
    assert cost(gap, rows) == pytest.approx(float(np.mean(robust_squares(gap[:, rows]))), rel=1e-12)
    assert math.isnan(cost(gap, np.zeros(900, dtype=bool)))


def test_what_is_not_finite_is_no_good_fit():
    """A difference beyond all bounds costs infinitely, an unknown one is unknown."""
    assert robust_mean_square(np.array([1.0, math.inf])) == math.inf
    assert math.isnan(robust_mean_square(np.array([1.0, math.nan, 1e200])))
