"""In what state a replay begins: the load's place in its clearance, as the rod scale tells it."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from sheets import exact

from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.gap.replay.first_state import first_state, resting
from ecyl_ros.gap.replay.replay import Replay
from ecyl_ros.gap.replay.sensor_noise import declared_noise
from ecyl_ros.gap.study.cylinder.machine import record_machine
from ecyl_ros.gap.study.cylinder.nuisances import Nuisances
from ecyl_ros.gap.study.cylinder.physics import nominal_physics

DRIVE = load_drive("bench")
FLOORS = declared_noise(DRIVE)
RATIO = DRIVE.transmission.rod_per_rotor


def _recorded(samples: int, moves_at: int) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Reference m, and noise about rest but for a motion that begins at a sample."""
    rng = np.random.default_rng(8)
    way = np.maximum(np.arange(samples) - moves_at + 1.0, 0.0) ** 2 * 1e-6
    recorded = {
        "rotor_position": way / RATIO,
        "rotor_velocity": np.diff(way, prepend=0.0) / RATIO / 1e-3,
        "rod_position": np.zeros(samples),
    }
    noisy = {name: one + FLOORS[name] * rng.normal(size=samples) for name, one in recorded.items()}
    return way, noisy


def test_rest_lasts_until_something_moves() -> None:
    """Noise does not end it; the reference does, and so does a rotor that moves without one."""
    way, recorded = _recorded(400, moves_at=150)
    still = np.zeros(400)
    assert resting(way, recorded, FLOORS) == 150
    assert 150 <= resting(still, recorded, FLOORS) < 160
    assert resting(still, {"rod_position": recorded["rod_position"]}, FLOORS) == 400
    recorded["rod_position"][90] = np.nan
    assert resting(way, recorded, FLOORS) == 90
    assert resting(np.arange(5.0), {}, FLOORS) == 1


def test_a_long_rest_tells_where_in_its_clearance_the_load_is() -> None:
    """Two noise floors off the middle is within the noise of one sample, and clear of that of 100:
    the load begins there, to a fifth of a floor; a step of the scale is not averaged away."""
    off = 2.0 * FLOORS["rod_position"]
    first = {"rotor_position": 0.0, "rod_position": off}
    places = {
        rests: first_state(DRIVE, (0.0, 0.0), first, FLOORS, rests)[0][2] for rests in (1, 100)
    }
    assert places[1] == 0.0
    assert places[100] == pytest.approx(off / RATIO, abs=0.2 * FLOORS["rod_position"] / RATIO)
    sensors = dataclasses.replace(DRIVE.sensors, rod_position_resolution=0.0)
    coarse = dataclasses.replace(sensors, rod_position_noise=0.0, rod_position_resolution=2e-6)
    rough = dataclasses.replace(DRIVE, sensors=coarse)
    said = first_state(
        rough, (0.0, 0.0), first | {"rod_position": 1e-6}, declared_noise(rough), 100
    )
    assert said[0][2] == 0.0


@pytest.mark.parametrize("rod", [True, False])
@pytest.mark.parametrize("place", [0.6, -0.4])
def test_a_sound_drive_whose_load_begins_off_the_middle_has_no_gap(place: float, rod: bool) -> None:
    """What the first impact shows by many floors, as it comes early or late, is left out, however
    short the rest before it, and whether the rod was recorded or not; the next impacts count."""
    half = 0.5 * DRIVE.transmission.backlash
    machine = dataclasses.replace(nominal_physics(DRIVE), load_angle=place * half)
    time = np.arange(20_000) / DRIVE.controller.rate
    rate = 2.0 * np.pi * 1.5
    reference = 1.5e-3 * (1.0 - np.cos(rate * time)), 1.5e-3 * rate * np.sin(rate * time)
    recording = record_machine(machine, Nuisances(10, 0.0, 0.0, 0, 4), DRIVE, reference)
    if not rod:
        unknown = np.full(len(recording), np.nan)
        recording = dataclasses.replace(recording, rod_position_m=unknown)
    assert diagnose(recording, exact("bench")).verdict == "no_gap"
    left_out = ~Replay(recording, DRIVE, "here").usable
    assert 0 < np.count_nonzero(left_out) < 400 and not left_out[500:].any()
