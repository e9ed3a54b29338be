"""Drives known by their loop alone: noise of the encoder that goes round it."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from ecyl_ros.drive.rigid.machine import Machine
from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.recording.signals import Recording

RATE_HZ, INERTIA, BANDWIDTH = 1000.0, 20.0, 2.0 * np.pi * 20.0
LOOP = Machine(
    kind="rigid",
    output="linear",
    actuation="loop",
    gain=1.0,
    inertia=INERTIA,
    viscous=30.0,
    rate_hz=RATE_HZ,
    position_kp=0.25 * BANDWIDTH,
    speed_kp=INERTIA * BANDWIDTH,
    tolerances={"all": "exact"},
)


def _played(noise_m: float, late_ticks: int = 0, mass: float = INERTIA) -> Recording:
    """A mass in that loop, stepped 20 times a tick; its encoder's noise is seen by the loop."""
    rng = np.random.default_rng(5)
    time = np.arange(20_000) / RATE_HZ
    reference = 0.05 * np.sin(2.0 * np.pi * 0.4 * time) + 0.01 * np.sin(2.0 * np.pi * 1.7 * time)
    seen, efforts = np.zeros(time.size), np.zeros(time.size)
    position = speed = 0.0
    for tick in range(time.size):
        seen[tick] = position + noise_m * rng.normal()
        rate = 0.5 * RATE_HZ * (seen[tick] - seen[max(tick - 2, 0)])
        kp, kv = LOOP.position_kp or 0.0, LOOP.speed_kp or 0.0
        efforts[tick] = kv * (kp * (reference[tick] - seen[tick]) - rate)
        effort = efforts[max(tick - late_ticks, 0)]
        for _ in range(20):
            step = 0.05 / RATE_HZ
            speed += step * (effort - 30.0 * speed) / mass
            position += step * speed
    return Recording(
        stamp_ns=np.round(time * 1e9).astype(np.int64),
        rod_position_m=seen,
        reference_position_m=reference,
    )


@pytest.mark.parametrize("noise_m", [1e-7, 2e-5])
def test_noise_round_a_loop_is_no_delay(noise_m) -> None:
    """A mass 20 % up beside little and much noise of the encoder: it alone is named, within 3 %."""
    result = diagnose(_played(noise_m, mass=1.2 * INERTIA), LOOP)
    assert [one.effect for one in result.causes] == ["load_inertia_error"]
    assert result.causes[0].parameters[0].value == pytest.approx(1.2 * INERTIA, rel=0.03)


def test_a_true_delay_of_a_loop_is_still_named() -> None:
    """Five ticks late, with noise: the delay, within one tick and a half."""
    result = diagnose(_played(1e-7, late_ticks=5), LOOP)
    assert "actuation_delay" in [one.effect for one in result.causes]
    delay = next(one for one in result.causes if one.effect == "actuation_delay")
    assert delay.parameters[0].value == pytest.approx(5e-3, abs=1.5e-3)


def test_a_healthy_loop_has_no_gap() -> None:
    """Noise of the encoder alone, with a sheet that is right: no cause, and no gap."""
    sheet = dataclasses.replace(LOOP, tolerances={"all": 0.1})
    assert diagnose(_played(1e-5), sheet).verdict in ("no_gap", "within_sheet")
