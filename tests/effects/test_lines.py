"""Lines over an angle: the kernel that turns sines step by step against plain least squares."""

import math

import numpy as np
import pytest

from ecyl_ros.effects.lines import explained
from ecyl_ros.effects.passed import Passed
from ecyl_ros.effects.starts import angular_orders, strongest
from ecyl_ros.gap.replay.evidence import Smoother


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


def test_a_line_that_the_filter_cuts_in_fast_motion_keeps_its_order_and_size() -> None:
    """12 periods a turn up to 350 Hz, behind the filter of the evidence at 500 Hz: with what that
    leaves at each speed the order and 97 % of the size are found, without it neither."""
    time = np.arange(6000) / 500.0
    rate = 2.0 * math.pi * 0.8
    angle, speed = -183.0 / rate * np.cos(rate * time), 183.0 * np.sin(rate * time)
    smooth = Smoother(time)
    signal = smooth(0.1 * np.sin(12.0 * angle + 0.4))
    orders, every = angular_orders(angle, 96.0), np.ones_like(angle)
    passed = Passed(speed, smooth.step, smooth.response)
    ((order, size, _), *_) = strongest(signal, angle, orders, 1, every, passed=passed)
    assert order == pytest.approx(12.0, abs=0.02)
    assert size == pytest.approx(0.1, rel=0.03)
    ((order, *_), *_) = strongest(signal, angle, orders, 1, every)
    assert abs(order - 12.0) > 1.0


def test_a_whole_order_is_tried_beside_a_line_that_noise_has_moved_off_it() -> None:
    """36 waves a turn of which a slow part of the motion tells: noise moves the strongest line off
    by up to a wave; among the whole orders it is one of the best two."""
    angle = 40.0 * np.sin(np.linspace(0.0, 6.0, 3000))
    wave = 0.5 * np.sin(36.0 * angle) * np.exp(-((angle / 4.0) ** 2))
    orders, every = angular_orders(angle, 96.0), np.ones_like(angle)
    moved = 0
    for seed in range(20):
        signal = wave + 0.1 * np.random.default_rng(seed).standard_normal(3000)
        lines = [order for order, *_ in strongest(signal, angle, orders, 4, every)]
        told = [order for order, *_ in strongest(signal, angle, orders, 4, every, whole=2)]
        moved += all(abs(order - 36.0) > 0.02 for order in lines)
        assert any(abs(order - 36.0) <= 0.02 for order in told)
        assert told[0] == lines[0] and set(lines) <= set(told)
    assert moved >= 10
