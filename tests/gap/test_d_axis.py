"""A loop for i_d shows in u_d, and its absence too."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.drive.engine import simulate
from ecyl_ros.drive.telemetry import simulation_recording
from ecyl_ros.gap.replay.d_axis import follows, has_d_loop
from ecyl_ros.recording.signals import Recording

DRIVE = load_drive("bench")
NOISE_A = 5e-3


def _decoupled() -> Recording:
    """The engine's own: u_d is the decoupling of what was read with noise, and no more."""
    sensors = dataclasses.replace(DRIVE.sensors, current_noise=NOISE_A)
    drive = dataclasses.replace(DRIVE, sensors=sensors)
    run = simulate(drive, lambda k: (3e-3 * (1.0 - math.cos(k * 2e-3)), 0.0), 2.0)
    return simulation_recording(run, drive)


def test_a_loop_answers_the_noise_of_i_d() -> None:
    """Decoupling alone is told from a loop whose gain puts the noise of i_d into u_d; without u_d
    nothing is told."""
    recording = _decoupled()
    noise = NOISE_A * np.random.default_rng(3).normal(size=len(recording))
    looped = dataclasses.replace(
        recording,
        current_d_a=noise,
        voltage_d_v=recording.voltage_d_v - DRIVE.controller.current.kp * noise,
    )
    silent = dataclasses.replace(recording, voltage_d_v=np.full(len(recording), np.nan))
    assert has_d_loop(recording, DRIVE) is False
    assert has_d_loop(looped, DRIVE) is True
    assert has_d_loop(silent, DRIVE) is None


def test_a_voltage_held_now_and_then_is_no_loop() -> None:
    """Where the controller left out every fiftieth tick, u_d is still decoupling alone."""
    recording = _decoupled()
    voltage = np.array(recording.voltage_d_v)
    voltage[50::50] = voltage[49:-1:50]
    assert has_d_loop(dataclasses.replace(recording, voltage_d_v=voltage), DRIVE) is False


def test_without_u_d_it_counts_what_i_d_is_nearer_to() -> None:
    """What decoupling leaves is seen ten times below the noise; noise alone follows nothing."""
    left = np.sin(np.arange(5000) * 0.01)
    noise = 10.0 * np.random.default_rng(4).normal(size=left.size)
    every = np.ones(left.size, dtype=bool)
    assert follows(left + noise, left, every) and not follows(noise, left, every)
