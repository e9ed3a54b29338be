"""Parameters that a recording shows as they are: where a recorded command is cut off."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from small_field import without_all_but

from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.drive.engine import simulate
from ecyl_ros.drive.reference.sine import Sine
from ecyl_ros.drive.telemetry import simulation_recording
from ecyl_ros.effects.starts import plateau
from ecyl_ros.gap.diagnose import diagnose

SHEET = dataclasses.replace(load_drive("bench"), tolerances={})
TIME = np.arange(4000) * 1e-3
WAVE = 10.0 * np.sin(2.0 * np.pi * TIME)


@pytest.mark.parametrize(
    ("values", "limit"),
    [
        (np.clip(WAVE, -8.0, 8.0), 8.0),
        (np.minimum(WAVE, 7.5) * np.where(WAVE > 0.0, 1.0, 0.5), 7.5),
        (np.where(TIME < 1.0, np.nan, np.clip(WAVE, -8.0, 8.0)), 8.0),
        (WAVE, None),
        (np.round(np.clip(WAVE, -8.0, 8.0), 0), None),  # so coarse that all commands stay
        (np.zeros(50), None),
        (np.full(50, np.nan), None),
    ],
)
def test_a_command_that_stays_at_its_largest_value_is_cut_off(values, limit) -> None:
    """On both sides, on one, with gaps; a sine, a coarse log, nothing at all are not."""
    assert plateau(values) == limit


def test_a_recorded_voltage_limit_is_read_off_the_command() -> None:
    """To a thousandth, and the back-EMF beside it within its interval: both scaled by one factor
    fit nearly as well, and the fit of both was 2 % off."""
    motor = dataclasses.replace(
        SHEET.motor,
        back_emf_constant=0.98 * SHEET.motor.back_emf_constant,
        resistance=1.01 * SHEET.motor.resistance,
    )
    machine = dataclasses.replace(SHEET, motor=motor, effects={"voltage_limit": {"voltage_v": 5.0}})
    motion = Sine(amplitude=6e-3, frequency=1.3)
    run = simulate(machine, lambda index: motion.sample(index / machine.sample_rate), 3.0)
    recording = simulation_recording(run, machine)
    cut = float(np.max(np.abs(recording.voltage_q_v)))
    few = without_all_but("voltage_limit", "back_emf_error", "torque_constant_error")
    found = diagnose(recording, SHEET, without=few)
    assert [one.effect for one in found.causes] == ["voltage_limit"]
    (limit,) = found.causes[0].parameters
    assert limit.value == cut == pytest.approx(5.0, rel=1e-6)
    assert (limit.low, limit.high) == pytest.approx((0.999 * cut, 1.001 * cut))
    (emf,) = (one for one in found.sheet if one.parameter == "motor.back_emf_constant")
    assert emf.value == pytest.approx(motor.back_emf_constant, rel=2e-3)
