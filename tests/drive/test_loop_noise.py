"""Noise in what the cascade commands, against noise sent through the cascade."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.drive.loop_noise import current_command_noise, speed_feedback_noise
from ecyl_ros.drive.parameters import Gains, PositionGains

from .python_cascade import PythonCascade, plain_numbers

DIRECT = {
    "structure": "position_to_current",
    "position": PositionGains(kp=32.0, kd=0.8),
    "speed": Gains(kp=0.0),
}
CASES = {
    "plain": ({}, {}),
    "filters": (
        {"speed_filter": 8e-4, "current_command_filter": 4e-4},
        {"speed_filter": 8e-4, "current_command_filter": 4e-4},
    ),
    "differences": (
        {"speed_source": "differences", "speed_filter": 5e-4},
        {"differences": True, "speed_filter": 5e-4},
    ),
    "rod": (
        {"feedback": "rod", "speed_source": "differences"},
        {"feedback_rod": True, "differences": True},
    ),
    "no speed loop": (DIRECT, {"speed": None, "position": (32.0, 0.0, 0.8)}),
}


@pytest.mark.parametrize("case", CASES)
def test_the_current_asked_for_is_as_noisy_as_said(case) -> None:
    """White noise of the stated size into the Python cascade at rest, without integrals: the
    standard deviation of what it asks for is the one worked out, within 3 %."""
    keys, told = CASES[case]
    drive = load_drive("bench")
    control = dataclasses.replace(
        drive.controller, **{"speed": Gains(kp=0.8), "current": Gains(kp=1.0)} | keys
    )
    drive = dataclasses.replace(drive, controller=control)
    cascade = PythonCascade(**plain_numbers(drive) | told)
    sensors, count = drive.sensors, 20_000
    rng = np.random.default_rng(4)
    angle = sensors.rotor_position_noise * rng.standard_normal(count)
    step = sensors.rotor_position_resolution
    angle = step * np.round(angle / step)
    speed = sensors.rotor_velocity_noise * rng.standard_normal(count)
    rod = sensors.rod_position_noise * rng.standard_normal(count)
    asked = [
        cascade.tick(0.0, 0.0, *reading, 0.0)[1]
        for reading in zip(angle.tolist(), speed.tolist(), rod.tolist(), strict=True)
    ]
    assert np.std(asked[100:]) == pytest.approx(current_command_noise(drive), rel=0.03)


def test_the_steps_of_the_encoder_are_noisier_than_the_reading() -> None:
    """Two readings' noise over one tick: sqrt(2) x noise x rate."""
    drive = load_drive("bench")
    assert speed_feedback_noise(drive) == drive.sensors.rotor_velocity_noise
    control = dataclasses.replace(drive.controller, speed_source="differences")
    sensors = dataclasses.replace(drive.sensors, rotor_position_resolution=0.0)
    noisy = dataclasses.replace(drive, controller=control, sensors=sensors)
    assert speed_feedback_noise(noisy) == pytest.approx(2.0**0.5 * 1e-5 * 1e4)
