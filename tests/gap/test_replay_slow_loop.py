"""Replays of drives whose control ticks are long beside what the plant does between them."""

from __future__ import annotations

import dataclasses

import numpy as np
from sheets import exact

from ecyl_ros.drive.drive_file import with_rate
from ecyl_ros.drive.engine import simulate
from ecyl_ros.drive.parameters import DriveParameters
from ecyl_ros.drive.telemetry import simulation_recording
from ecyl_ros.gap.replay.replay import Replay
from ecyl_ros.gap.replay.sensor_noise import silent
from ecyl_ros.plan.others import moves
from ecyl_ros.recording.signals import Recording

SECONDS = 3.0


def test_a_tick_of_10_ms_is_replayed_as_finely_as_the_drive_needs() -> None:
    """A loop of 100 Hz, whose ticks take 95 sub-steps: the silent drive's own recording is replayed
    to a third of what its sensors' noise would do to it, in each signal."""
    drive = exact("servo_1khz")
    position, speed, current = (
        dataclasses.replace(one, kp=0.5 * one.kp, ki=0.25 * one.ki)
        for one in (drive.controller.position, drive.controller.speed, drive.controller.current)
    )
    controller = dataclasses.replace(
        drive.controller, position=position, speed=speed, current=current
    )
    drive = with_rate(dataclasses.replace(drive, controller=controller), 100.0, "servo_1khz")
    motion = moves(drive.limits, SECONDS)

    def recorded(machine: DriveParameters) -> Recording:
        run = simulate(machine, lambda index: motion.sample(index / 100.0), SECONDS)
        return simulation_recording(run, machine)

    replay = Replay(recorded(silent(drive)), drive, "a slow loop")
    noisy = Replay(recorded(drive), drive, "the same with noise")
    by_noise = np.std(noisy.recorded - replay.recorded, axis=1)
    left = np.std(replay.recorded - replay.simulate({}), axis=1)
    assert np.all(left < by_noise / 3.0)
