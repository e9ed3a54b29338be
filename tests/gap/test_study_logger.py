"""How the study's rigid drives are logged: steps, lags, noise, stretches that stand still."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from ecyl_ros.gap.study.rigid.logger import Logger, record

PLAIN = Logger(100.0, 1e-5, "missing", True, 0.0, (0.0, 30.0), 0.0, ())


def _recorded(logger: Logger, effort=None, ticks=2000):
    time = np.arange(ticks) * 1e-3
    position = 0.05 * np.sin(3.0 * time)
    return record(
        logger,
        np.random.default_rng(1),
        linear=True,
        effort_signal="rod_force_n",
        position=position,
        speed=np.gradient(position, 1e-3),
        effort=100.0 * time if effort is None else effort,
        reference=position,
    ), position


def test_positions_come_in_steps_of_the_encoder() -> None:
    """Logged positions are whole steps and never further than half a step from the true one."""
    recording, position = _recorded(dataclasses.replace(PLAIN, resolution=4e-4))
    steps = recording.rod_position_m / 4e-4
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-9)
    off = np.abs(recording.rod_position_m - position[::10])
    assert 1.5e-4 < np.max(off) <= 2e-4 * (1.0 + 1e-9)
    assert recording.rate_hz == pytest.approx(100.0)


def test_effort_is_logged_late_by_its_lag_and_noisy_by_its_noise() -> None:
    """A ramp of 100 N/s logged 1.5 samples late is 1.5 N lower; noise, ripple have their size."""
    late, _ = _recorded(dataclasses.replace(PLAIN, lag_samples=1.5))
    prompt, _ = _recorded(PLAIN)
    np.testing.assert_allclose((prompt.rod_force_n - late.rod_force_n)[5:], 1.5, rtol=1e-9)
    flat = np.zeros(20_000)
    noisy, _ = _recorded(
        dataclasses.replace(PLAIN, effort_noise=2.0, ripple=(3.0, 37.0)), flat, 20_000
    )
    assert np.std(noisy.rod_force_n) == pytest.approx(
        math.hypot(2.0, 3.0 / math.sqrt(2.0)), rel=0.05
    )
    spectrum = np.abs(np.fft.rfft(noisy.rod_force_n)) / 1000.0
    assert np.argmax(spectrum) == pytest.approx(37.0 * 20.0, abs=1)


def test_frozen_stretches_keep_the_last_value_while_stamps_go_on() -> None:
    """From 0.5 s to 0.8 s every signal stands still; before and after it moves."""
    recording, _ = _recorded(dataclasses.replace(PLAIN, frozen=((0.5, 0.3),)))
    assert np.ptp(recording.rod_position_m[50:80]) == np.ptp(recording.rod_force_n[50:80]) == 0.0
    assert np.ptp(recording.rod_position_m[80:110]) > 0.0
    assert np.all(np.diff(recording.stamp_ns) > 0)


def test_a_speed_is_missing_differenced_or_the_drives_own() -> None:
    """Differences are those of the counts; a drive's own speed is near the true one."""
    assert not _recorded(PLAIN)[0].has("rod_velocity_m_per_s")
    made, _ = _recorded(dataclasses.replace(PLAIN, speed="differences", resolution=1e-4))
    np.testing.assert_allclose(
        np.cumsum(made.rod_velocity_m_per_s) / 100.0 + made.rod_position_m[0],
        made.rod_position_m,
        atol=1e-12,
    )
    own, position = _recorded(dataclasses.replace(PLAIN, speed="own"))
    true = np.gradient(position, 1e-3)[::10]
    assert np.std(own.rod_velocity_m_per_s - true) < 0.01 * np.max(np.abs(true))
