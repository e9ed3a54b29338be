"""Control ticks that a real-time controller left out are left out in the replay, too."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from ecyl_ros.drive import engine
from ecyl_ros.drive.cascade import cascade_tick, initial_cascade_state
from ecyl_ros.drive.drive_file import load_drive, resolve_drive
from ecyl_ros.drive.packed import pack
from ecyl_ros.drive.plant import (
    MEASURED,
    apply_voltage,
    initial_state,
    measure,
    voltage_queue,
)
from ecyl_ros.drive.telemetry import simulation_recording
from ecyl_ros.gap.replay.held import held_samples
from ecyl_ros.gap.replay.replay import Replay
from ecyl_ros.recording.signals import Recording

DRIVE = dataclasses.replace(load_drive(resolve_drive("servo_1khz")), telemetry_rate=1000.0)
TICKS = 2000
HELD = (400, 401, 402, 403, 1100, 1300)


def _moves(tick: int) -> np.ndarray:
    time, rate = tick / DRIVE.controller.rate, 2.0 * math.pi * 0.9
    return np.array([0.012 * (1.0 - math.cos(rate * time)), 0.012 * rate * math.sin(rate * time)])


def _recorded(held: tuple[int, ...]) -> Recording:
    """What plant and controller do, tick by tick, where the controller sleeps through some."""
    params = pack(DRIVE)
    plant, cascade, pending = initial_state(), initial_cascade_state(params), voltage_queue(params)
    measured, samples = np.zeros(len(MEASURED)), np.zeros((TICKS, engine.COLUMNS))
    for tick in range(TICKS):
        measure(plant, tick, params, measured)
        before, after = _moves(tick), _moves(tick + 1)
        if tick not in held:
            cascade_tick(cascade, before, after, 0.0, 1, measured, params, pending[-1])
        samples[tick] = [*before, *pending[-1], *measured, plant[2], plant[3]]
        apply_voltage(plant, pending, params)
    run = engine.Simulation(samples, DRIVE.controller.rate, plant)
    return simulation_recording(run, DRIVE)


def _beyond_noise(replay: Replay) -> float:
    gap, noise = replay.gap({}), replay.healthy
    return float(np.max(np.sqrt(np.mean(gap**2, axis=1) / np.mean(noise**2, axis=1))))


def test_ticks_that_were_left_out_are_no_gap(monkeypatch: pytest.MonkeyPatch) -> None:
    """With them the replay stays at the noise floor and says so, without them it is far above."""
    recording = _recorded(HELD)
    assert held_samples(recording).tolist() == list(HELD)
    replay = Replay(recording, DRIVE, "run")
    assert _beyond_noise(replay) < 1.5
    assert any("left out 6 of 2000 ticks" in note for note in replay.notes)
    monkeypatch.setattr("ecyl_ros.gap.replay.held.held_samples", lambda _: np.zeros(0, int))
    assert _beyond_noise(Replay(recording, DRIVE, "run")) > 5.0


def test_a_command_that_comes_again_for_another_reason_is_no_held_one() -> None:
    """Rounding, a limit, a drive at rest, and a voltage held for longer than drives hold one."""
    sound = _recorded(())
    voltage = sound.voltage_q_v
    rounded = np.round(voltage, 1)
    clipped = np.clip(voltage, -0.5 * voltage.max(), 0.5 * voltage.max())
    shorted = np.concatenate([voltage[:500], np.full(200, voltage[499]), voltage[700:]])
    for values in (voltage, rounded, clipped, shorted):
        assert len(held_samples(dataclasses.replace(sound, voltage_q_v=values))) == 0
    still = np.minimum(np.arange(TICKS), 700)
    at_rest = {
        name: getattr(sound, name)[still]
        for name in ("voltage_q_v", "current_q_a", "rotor_position_rad", "rotor_velocity_rad_per_s")
    }
    assert len(held_samples(dataclasses.replace(sound, **at_rest))) == 0
