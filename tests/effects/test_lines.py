"""Lines over an angle: the kernel that turns sines step by step against plain least squares."""

import numpy as np
import pytest

from ecyl_ros.effects.lines import explained


@pytest.mark.parametrize("rates", [np.arange(1.0, 20.0, 0.05), np.array([1.0, 7.0, 7.5, 24.0])])
def test_lines_are_those_of_least_squares(rates):
    """Variance, size and phase are those of a fit of constant, slope, sine and cosine."""
    rng = np.random.default_rng(3)
    x = np.cumsum(rng.standard_normal(700)) * 0.4
    g = 1.0 + rng.random(700)
    y = g * 0.7 * np.sin(7.0 * x + 0.4) + 0.1 * rng.standard_normal(700)
    base, _ = np.linalg.qr(np.column_stack([np.ones_like(x), x]))
    y -= base @ (base.T @ y)
    found = explained(y, x, g, base, rates)
    for rate, (variance, size, phase) in zip(rates, found, strict=True):
        line = np.column_stack([g * np.sin(rate * x), g * np.cos(rate * x)])
        fit = np.linalg.lstsq(np.column_stack([base, line]), y, rcond=None)[0]
        left = y - np.column_stack([base, line]) @ fit
        assert variance == pytest.approx(y @ y - left @ left, rel=1e-8, abs=1e-8)
        assert size == pytest.approx(np.hypot(*fit[2:]), rel=1e-8)
        turned = phase - np.arctan2(fit[3], fit[2])
        assert abs(np.exp(1j * turned) - 1.0) < 1e-7
    assert rates[np.argmax(found[:, 0])] == pytest.approx(7.0)


def test_no_rates_no_lines():
    """Nothing asked for, nothing found."""
    ones = np.ones(60)
    assert explained(ones, ones, ones, np.zeros((60, 0)), np.array([])).shape == (0, 3)
