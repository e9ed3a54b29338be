"""A loop that swings by itself: its delay is found by the spectrum."""

from __future__ import annotations

import dataclasses
import math

import pytest
from sheets import exact

from ecyl_ros.drive.engine import simulate
from ecyl_ros.drive.telemetry import simulation_recording
from ecyl_ros.gap.compete.ringing import Ringing
from ecyl_ros.gap.fit.fit import Fitter
from ecyl_ros.gap.replay.replay import Replay
from ecyl_ros.gap.split import held_out

DRIVE = exact("bench")


def _fitter(effects) -> Fitter:
    def wanted(index: int) -> tuple[float, float]:
        angle = 2.0 * math.pi * 0.7 * index / DRIVE.sample_rate
        return 2e-3 * (1.0 - math.cos(angle)), 2e-3 * 2.0 * math.pi * 0.7 * math.sin(angle)

    drive = dataclasses.replace(DRIVE, effects=effects)
    replay = Replay(simulation_recording(simulate(drive, wanted, 6.0), drive), DRIVE, "ringing")
    return Fitter(replay, held_out(replay.time_s))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "delay_s", "near"),
    [("actuation_delay", 1.63e-4, 2e-3), ("measurement_delay", 2.57e-4, 3e-2)],
)
def test_the_delay_of_a_ringing_loop_is_found(name, delay_s, near) -> None:
    """A delay that makes the loop swing is found; nearer where noise does not begin the ringing."""
    fitter = _fitter({name: {"delay_s": delay_s}})
    beside = fitter.evaluate({name: {"delay_s": 1.02 * delay_s}})
    assert beside.fitted > 5.0 * fitter.perfect**2
    (start,) = Ringing(fitter).starts(fitter.nominal, name)
    assert start[name]["delay_s"] == pytest.approx(delay_s, rel=near)


def test_a_drive_that_does_not_ring_is_not_listened_to() -> None:
    """A constant load: no delay is proposed."""
    fitter = _fitter({"constant_load": {"force_n": 100.0}})
    ringing = Ringing(fitter)
    assert ringing.starts(fitter.nominal, "actuation_delay") == []
    assert ringing.starts(fitter.nominal, "rotor_coulomb_friction") == []
