"""A known force on a full cylinder's rod is no gap."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from sheets import exact
from small_field import without_all_but

from ecyl_ros.drive.engine import simulate
from ecyl_ros.drive.telemetry import simulation_recording
from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.gap.replay.replay import Replay
from ecyl_ros.recording.signals import Recording

DRIVE = exact("bench")
FORCE_N, HERTZ = 250.0, 3.7


def _moves(tick: int) -> tuple[float, float]:
    time, rate = tick / DRIVE.controller.rate, 2.0 * math.pi * 0.9
    return 0.012 * (1.0 - math.cos(rate * time)), 0.012 * rate * math.sin(rate * time)


def _pushed(effects: dict[str, dict[str, float]]) -> Recording:
    """A run under a force that swings and is recorded."""
    swing = {"amplitude_n": FORCE_N, "frequency_hz": HERTZ, "phase_rad": 0.0}
    drive = dataclasses.replace(DRIVE, effects={"periodic_disturbance": swing, **effects})
    run = simulate(drive, _moves, 4.0)
    recording = simulation_recording(run, drive)
    force = FORCE_N * np.sin(2.0 * np.pi * HERTZ * recording.time_s)
    return dataclasses.replace(recording, injected_force_n=force)


def test_a_force_that_was_injected_and_recorded_is_no_gap() -> None:
    """The replay with the recorded force stays at the noise floor, without it far above."""
    recording = _pushed({})
    blind = dataclasses.replace(recording, injected_force_n=np.full(len(recording), np.nan))
    # Samples that are missing are filled in.
    force = np.where(np.arange(len(recording)) % 3 == 1, np.nan, recording.injected_force_n)
    holed = dataclasses.replace(recording, injected_force_n=force)
    for one, low, high in ((recording, 0.8, 1.2), (holed, 0.8, 1.2), (blind, 10.0, np.inf)):
        replay = Replay(one, DRIVE, "run")
        beyond_noise = _size(replay.gap({})) / _size(replay.healthy)
        assert low < beyond_noise.max() < high


def _size(gap: np.ndarray) -> np.ndarray:
    return np.sqrt(np.mean(gap**2, axis=1))


@pytest.mark.slow
def test_a_fault_beside_an_injected_force_is_named() -> None:
    """Friction of the load under a known force is named with its value, and no disturbance."""
    named = "load_coulomb_friction"
    others = ("periodic_disturbance", "constant_load", "rotor_coulomb_friction", "spring_load")
    recording = _pushed({named: {"coulomb_nm": 0.2}})
    found = diagnose(recording, DRIVE, without=without_all_but(named, *others))
    assert [one.effect for one in found.causes] == [named]
    assert found.causes[0].parameters[0].value == pytest.approx(0.2, rel=0.02)
    assert any("injected" in note for note in found.notes)
