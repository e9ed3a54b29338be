"""A cause of a place is named where the motion went beyond both of its ends; a wave, beside what it
is one curve with, where it was seen to repeat."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from sheets import exact
from small_field import without_all_but

from ecyl_ros.drive.engine import simulate
from ecyl_ros.drive.law import Law
from ecyl_ros.drive.parameters import DriveParameters
from ecyl_ros.drive.telemetry import simulation_recording
from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.recording.signals import Recording

DRIVE = exact("bench")
SECONDS = 3.5
REACH_M = 4e-3  # of the motion, from 0
WITHOUT = without_all_but(
    "local_jam",
    "load_coulomb_friction",
    "rotor_coulomb_friction",
    "load_viscous_friction",
    "constant_load",
    "spring_load",
)


def _recorded(
    machine: DriveParameters, reach_m: float = REACH_M, seconds: float = SECONDS
) -> Recording:
    rate = 2.0 * math.pi * 0.6

    def wanted(index: int) -> tuple[float, float]:
        angle = rate * index / DRIVE.sample_rate
        return 0.5 * reach_m * (1.0 - math.cos(angle)), 0.5 * reach_m * rate * math.sin(angle)

    return simulation_recording(simulate(machine, wanted, seconds), machine)


@pytest.mark.parametrize(("middle_m", "named"), [(2e-3, True), (4e-3, False)])
def test_a_jam_that_goes_on_to_where_the_motion_turns_is_none(middle_m: float, named: bool) -> None:
    """Drag of 0.6 N m on 1.2 mm: a jam amid the stroke, at its end only a drag that sets in."""
    jam = {"coulomb_nm": 0.6, "position_m": middle_m, "width_m": 1.2e-3, "edge_m": 1e-4}
    machine = dataclasses.replace(DRIVE, effects={"local_jam": jam})
    found = diagnose(_recorded(machine), DRIVE, without=WITHOUT)
    assert ("local_jam" in [one.effect for one in found.causes]) is named
    assert any("within its place" in note for note in found.notes) is not named


SCREW = without_all_but("lead_error", "transmission_error", "backlash_error")


@pytest.mark.parametrize(("seconds", "told"), [(6.0, True), (4.0, False)])
def test_a_lead_and_a_wave_that_never_repeats_are_one_curve(seconds: float, told: bool) -> None:
    """A scale that bends over 7 mm of a lead of 20 mm: no lead and runout, but that curve; where
    too few stretches tell it from chance, only a note names it."""
    at = np.linspace(-0.001, 0.013, 15)
    law = Law("rod_error", ("position",), (tuple(at),), tuple(200.0 * at**2))
    machine = dataclasses.replace(DRIVE, learned=law)
    found = diagnose(_recorded(machine, 7e-3, seconds), DRIVE, without=SCREW)
    assert not found.causes
    assert any("together they are one curve" in note for note in found.notes)
    if told:
        assert found.law is not None
        assert (found.law.law.port, found.law.law.of) == ("rod_error", ("position",))
    else:
        assert found.verdict == "unexplained"
        (note,) = (one for one in found.notes if one.startswith("closest law, not described"))
        assert "error of the rod's scale that depends on position" in note
        assert "by chance (at most 1 %); a longer recording could tell" in note


def test_a_wave_alone_is_named_from_a_part_of_it() -> None:
    """Runout once per turn, of which 12 mm of travel see 0.6."""
    values = {"amplitude_rad": 0.02, "periods_per_screw_rev": 1.0, "phase_rad": 0.4}
    machine = dataclasses.replace(DRIVE, effects={"transmission_error": values})
    found = diagnose(_recorded(machine, 12e-3), DRIVE, without=SCREW)
    assert [one.effect for one in found.causes] == ["transmission_error"]
