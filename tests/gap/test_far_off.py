"""A constant so far off its sheet that the sheet, held back by its price, goes another way."""

from __future__ import annotations

import dataclasses

import pytest
from small_field import without_all_but

from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.drive.engine import simulate
from ecyl_ros.drive.reference.sine import Sine
from ecyl_ros.drive.telemetry import simulation_recording
from ecyl_ros.gap.compete import compete
from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.gap.diagnosis import Diagnosis

SHEET = dataclasses.replace(load_drive("bench"), tolerances={})
STIFFNESS = SHEET.transmission.stiffness[0]
MOTION = Sine(amplitude=3e-3, frequency=1.0)


def _diagnosed(share: float) -> Diagnosis:
    """A machine with so much of the sheet's stiffness, its torque constant 1 % off."""
    springs = tuple(share * one for one in SHEET.transmission.stiffness)
    machine = dataclasses.replace(
        SHEET,
        transmission=dataclasses.replace(SHEET.transmission, stiffness=springs),
        motor=dataclasses.replace(SHEET.motor, torque_constant=1.01 * SHEET.motor.torque_constant),
    )
    run = simulate(machine, lambda index: MOTION.sample(index / machine.sample_rate), 4.0)
    few = without_all_but("stiffness_error", "backlash_error", "load_inertia_error")
    return diagnose(simulation_recording(run, machine), SHEET, without=few)


def test_a_stiffness_of_a_third_is_named_where_only_impacts_tell_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """It was `within_sheet`, as a softer, better damped contact; its interval holds the truth. A
    stiffness within its tolerance of 20 % stays within the sheet."""
    found = _diagnosed(0.35)
    assert found.verdict == "explained"
    assert [one.effect for one in found.causes] == ["stiffness_error"]
    (value,) = found.causes[0].parameters
    assert value.low < 0.35 * STIFFNESS < value.high < 0.5 * STIFFNESS
    assert _diagnosed(0.9).verdict in ("no_gap", "within_sheet")
    monkeypatch.setattr(compete, "far_off", lambda field: [])
    assert _diagnosed(0.35).verdict == "within_sheet"
