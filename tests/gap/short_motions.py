"""Short recordings of the bench drive on three motions, with effects of known size."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.drive.engine import simulate
from ecyl_ros.drive.reference.sine import Sine
from ecyl_ros.drive.telemetry import simulation_recording
from ecyl_ros.recording.signals import Recording

DRIVE = load_drive("bench")
MOTIONS = [Sine(amplitude=3e-3, frequency=f) for f in (1.0, 1.7, 0.8)]
SECONDS = 1.8


def recorded(
    number: int, effects: Mapping[str, Mapping[str, float]], off: float = 1.0
) -> Recording:
    """A motion of the bench drive with effects on it; off: factor of its torque constant."""
    motor = dataclasses.replace(DRIVE.motor, torque_constant=off * DRIVE.motor.torque_constant)
    sensors = dataclasses.replace(DRIVE.sensors, noise_seed=100 + number)
    drive = dataclasses.replace(DRIVE, motor=motor, sensors=sensors, effects=effects)
    motion = MOTIONS[number]
    run = simulate(drive, lambda i: motion.sample(i / drive.sample_rate), SECONDS)
    return simulation_recording(run, drive)
