"""The replay against equations of its own hand, on machines that are off their sheet."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.drive.engine import simulate
from ecyl_ros.drive.telemetry import simulation_recording
from ecyl_ros.gap.replay.replay import Replay
from ecyl_ros.gap.study.cylinder.excitation import draw_reference
from ecyl_ros.gap.study.cylinder.machine import record_machine
from ecyl_ros.gap.study.cylinder.nuisances import Nuisances
from ecyl_ros.gap.study.cylinder.physics import nominal_physics
from ecyl_ros.gap.study.cylinder.sheet import UNCERTAIN, off_sheet, true_constants

DURATION_S, SPEED_RAD_S = 4.0, 120.0  # where the axes of the motor couple clearly


def _left(key: str, delay_s: float = 0.0, i_d_noise_a: float = 0.0) -> dict[str, float]:
    """Noise floors that a replay with its true constant leaves, by signal.

    i_d_noise_a: of what is recorded as i_d, which is 0.
    """
    drive = load_drive("bench")
    assert drive.motor.pole_pairs > 1
    machine = off_sheet(nominal_physics(drive), {key: 0.03})
    machine = dataclasses.replace(machine, actuation_delay_s=delay_s)
    tick_s = 1.0 / drive.controller.rate
    rng = np.random.default_rng(5)
    speed = SPEED_RAD_S * drive.transmission.rod_per_rotor
    reference = draw_reference(rng, DURATION_S, tick_s, speed)
    recording = record_machine(machine, Nuisances(10, 0.0, 0.0, 0, 1), drive, reference)
    read = i_d_noise_a * rng.normal(size=len(recording))
    recording = dataclasses.replace(recording, current_d_a=read)
    replay = Replay(recording, drive, "machine")
    effects = {"actuation_delay": {"delay_s": delay_s}} if delay_s else {}
    shown = replay.simulate(effects, {key: true_constants(machine, drive)[key]})
    gap = (shown - replay.recorded) / replay.floor[:, None]
    rms = np.sqrt(np.mean(gap[:, replay.usable] ** 2, axis=1))
    return dict(zip([one.name for one in replay.signals], rms.tolist(), strict=True))


@pytest.mark.parametrize("key", UNCERTAIN)
def test_a_replay_at_the_true_constants_leaves_noise(key: str) -> None:
    """Whatever constant is off: no more than the noise of the sensors in any signal."""
    assert max(_left(key).values()) < 1.1


@pytest.mark.parametrize("noise_a", [0.0, 5e-3])
def test_no_current_turns_into_the_other_axis_behind_a_delay(noise_a: float) -> None:
    """A drive that holds i_d at zero does so with a late voltage, too, and where a sensor reads it
    with noise."""
    assert max(_left("motor.inductance", delay_s=1e-4, i_d_noise_a=noise_a).values()) < 1.2


def test_i_d_that_decoupling_leaves_is_seen_in_the_noise_of_its_sensor() -> None:
    """Of a drive without a loop for i_d, ten times below the noise: replayed as the engine has it,
    and nothing is left of it."""
    drive = load_drive("bench")
    late = dataclasses.replace(drive, effects={"actuation_delay": {"delay_s": 1e-4}})
    speed = SPEED_RAD_S * drive.transmission.rod_per_rotor / 20.0
    run = simulate(late, lambda k: (speed * (1.0 - math.cos(k * 2e-3)), 0.0), DURATION_S)
    recording = simulation_recording(run, late)
    left = recording.current_d_a
    noise = 10.0 * float(np.std(left)) * np.random.default_rng(6).normal(size=left.size)
    recording = dataclasses.replace(recording, current_d_a=left + noise)
    replay = Replay(recording, drive, "machine")
    assert np.std(left) > 0.0 and not replay._holds_i_d


def test_a_sensor_that_is_off_at_rest_is_no_current() -> None:
    """The first voltage answers the reading: the loops begin, and the replay at rest with them."""
    drive = load_drive("bench")
    off = dataclasses.replace(drive, effects={"current_sensor_offset": {"offset_a": 0.4}})
    run = simulate(off, lambda index: (1e-3 * (1.0 - math.cos(index * 0.01)), 0.0), 1.0)
    replay = Replay(simulation_recording(run, off), drive, "offset")
    assert replay.recorded[[one.name for one in replay.signals].index("current_q"), 0] > 0.3
    assert not any("begin at rest" in note for note in replay.notes)
    assert not replay._integrals.any() and not replay._plant[:6].any()
