"""The floor where a drive file says less of its sensors than their noise."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from sheets import exact

from ecyl_ros.drive.parameters import SensorParameters
from ecyl_ros.gap.replay.replay import Replay
from ecyl_ros.gap.replay.sensor_noise import coarse_step
from ecyl_ros.gap.study.case import Case
from ecyl_ros.gap.study.cylinder.cases import record_case
from ecyl_ros.recording.signals import Recording

DRIVE = exact("bench")
STEP_RAD, STEP_M = 2.0 * np.pi / 4096, 1e-6


@pytest.fixture(scope="module")
def healthy() -> Recording:
    """Of a machine as the file has it, with noise of its sensors."""
    return record_case(Case(0, 5, "none", {}), DRIVE).slice(0.0, 2.0)


def floors(recording: Recording, sensors: SensorParameters) -> dict[str, float]:
    """By signal."""
    replay = Replay(recording, dataclasses.replace(DRIVE, sensors=sensors), "recording")
    return dict(zip((one.name for one in replay.signals), replay.floor.tolist(), strict=True))


def test_a_step_is_told_where_it_is_coarser_than_the_noise() -> None:
    """Of a staircase it is the step; where noise is more than a step, it is none."""
    rng = np.random.default_rng(4)
    smooth = np.sin(np.linspace(0.0, 7.0, 4000))
    assert coarse_step(0.01 * np.round(smooth / 0.01)) == pytest.approx(0.01)
    noisy = smooth + rng.normal(0.0, 0.05, smooth.size)
    assert coarse_step(0.01 * np.round(noisy / 0.01)) == 0.0
    assert coarse_step(noisy) == 0.0
    assert coarse_step(np.full(100, 2.0)) == 0.0


def test_a_resolution_is_not_taken_for_all_of_the_noise(healthy) -> None:
    """A file with resolutions alone has the floors of the recording, as one without sensors has."""
    true = DRIVE.sensors
    found = floors(
        healthy, SensorParameters(rotor_position_resolution=1e-6, rod_position_resolution=1e-8)
    )
    bare = floors(healthy, SensorParameters())
    for name, noise in (
        ("rotor_position", true.rotor_position_noise),
        ("rotor_velocity", true.rotor_velocity_noise),
        ("current_q", true.current_noise),
        ("rod_position", true.rod_position_noise),
    ):
        assert 0.9 * noise < found[name] < 2.0 * noise, name
    assert found == pytest.approx(bare, rel=0.02)


def test_no_floor_is_below_the_steps_that_values_are_rounded_to(healthy) -> None:
    """An encoder of 4096 counts and a scale of 1 um whose file states nothing: a step over the root
    of 12, not the roughness of a staircase, which is none."""
    rounded = dataclasses.replace(
        healthy,
        rotor_position_rad=STEP_RAD * np.round(healthy.rotor_position_rad / STEP_RAD),
        rod_position_m=5.0 * STEP_M * np.round(healthy.rod_position_m / (5.0 * STEP_M)),
    )
    found = floors(rounded, SensorParameters())
    assert found["rotor_position"] == pytest.approx(STEP_RAD / np.sqrt(12.0), rel=0.2)
    assert found["rod_position"] == pytest.approx(5.0 * STEP_M / np.sqrt(12.0), rel=0.2)
