"""A cause of a place is named where the motion went beyond both of its ends."""

from __future__ import annotations

import dataclasses
import math

import pytest
from sheets import exact
from small_field import without_all_but

from ecyl_ros.drive.engine import simulate
from ecyl_ros.drive.telemetry import simulation_recording
from ecyl_ros.gap.diagnose import diagnose

DRIVE = exact("bench")
SECONDS = 5.0
REACH_M = 4e-3  # of the motion, from 0
WITHOUT = without_all_but(
    "local_jam",
    "load_coulomb_friction",
    "rotor_coulomb_friction",
    "load_viscous_friction",
    "constant_load",
    "spring_load",
)


def _wanted(index: int) -> tuple[float, float]:
    rate = 2.0 * math.pi * 0.6
    angle = rate * index / DRIVE.sample_rate
    return 0.5 * REACH_M * (1.0 - math.cos(angle)), 0.5 * REACH_M * rate * math.sin(angle)


@pytest.mark.parametrize(("middle_m", "named"), [(2e-3, True), (4e-3, False)])
def test_a_jam_that_goes_on_to_where_the_motion_turns_is_none(middle_m: float, named: bool) -> None:
    """Drag of 0.6 N m on 1.2 mm: a jam amid the stroke, at its end only a drag that sets in."""
    jam = {"coulomb_nm": 0.6, "position_m": middle_m, "width_m": 1.2e-3, "edge_m": 1e-4}
    machine = dataclasses.replace(DRIVE, effects={"local_jam": jam})
    recording = simulation_recording(simulate(machine, _wanted, SECONDS), machine)
    found = diagnose(recording, DRIVE, without=WITHOUT)
    assert ("local_jam" in [one.effect for one in found.causes]) is named
    assert any("within its place" in note for note in found.notes) is not named
