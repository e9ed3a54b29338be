"""Recordings with faults of their own: judged as far as they go, or refused by one clear line."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.drive.engine import simulate
from ecyl_ros.drive.reference.spec import make_reference
from ecyl_ros.drive.telemetry import simulation_recording
from ecyl_ros.errors import InputError
from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.gap.replay.replay import Replay
from ecyl_ros.gap.replay.sensor_noise import roughness
from ecyl_ros.recording.signals import SIGNALS, Recording


@pytest.fixture(scope="module")
def drive():
    """The bench drive; its noise in the recording but not in the loop keeps replays exact."""
    return load_drive("bench")


@pytest.fixture(scope="module")
def recording(drive) -> Recording:
    """4 s of moves by the model itself, noise added afterwards."""
    names = ("rotor_position", "rotor_velocity", "current", "rod_position")
    sensors = dict.fromkeys([f"{name}_noise" for name in names], 0.0)
    quiet = dataclasses.replace(drive, sensors=dataclasses.replace(drive.sensors, **sensors))
    spec = "moves:positions=0.004;-0.002;0.001,speed=0.05,acceleration=1,jerk=50,dwell=0.2"
    reference = make_reference(spec, quiet, 4.0)
    period = 1.0 / quiet.sample_rate
    run = simulate(quiet, lambda index: reference.sample(index * period), 4.0)
    clean = simulation_recording(run, quiet)
    rng = np.random.default_rng(3)
    noisy = {
        "rotor_position_rad": drive.sensors.rotor_position_noise,
        "rotor_velocity_rad_per_s": drive.sensors.rotor_velocity_noise,
        "current_q_a": drive.sensors.current_noise,
        "rod_position_m": drive.sensors.rod_position_noise,
    }
    return dataclasses.replace(
        clean,
        **{
            name: clean.signal(name) + std * rng.standard_normal(len(clean))
            for name, std in noisy.items()
        },
    )


def _kept(recording: Recording, rows) -> Recording:
    arrays = {name: recording.signal(name)[rows] for name in SIGNALS}
    return Recording(stamp_ns=recording.stamp_ns[rows], **arrays)


def test_the_models_own_run_has_no_gap(recording, drive) -> None:
    """Nothing but noise: every signal stands at its floor."""
    result = diagnose(recording, drive)
    assert result.verdict == "no_gap"
    for one in result.signals:
        assert one.gap < 1.15 * one.floor


def test_dropped_samples_are_lived_with(recording, drive) -> None:
    """Every seventh sample missing and a hole of 0.1 s: still no gap, and the hole is noted."""
    rows = np.arange(len(recording)) % 7 != 3
    rows &= ~((recording.time_s > 2.0) & (recording.time_s < 2.1))
    result = diagnose(_kept(recording, rows), drive)
    assert result.verdict == "no_gap"
    assert any("missing for up to 0.1" in note for note in result.notes)


def test_uneven_stamps_are_lived_with(recording, drive) -> None:
    """Samples at uneven instants, interpolated from the run, are compared at those instants."""
    rng = np.random.default_rng(1)
    time = np.sort(rng.uniform(0.0, recording.time_s[-1], 3000))
    time[0] = 0.0
    arrays = {
        name: np.interp(time, recording.time_s, recording.signal(name))
        for name in SIGNALS
        if np.isfinite(recording.signal(name)).all()
    }
    uneven = Recording(stamp_ns=np.round(time * 1e9).astype(np.int64), **arrays)
    replay = Replay(uneven, drive, "test")
    left = replay.gap({})
    position = [one.name for one in replay.signals].index("rotor_position")
    assert np.sqrt(np.mean(left[position] ** 2)) < 2.0


def test_another_rate_is_lived_with(recording, drive) -> None:
    """Every fifth sample (200 Hz): no gap."""
    assert diagnose(_kept(recording, slice(None, None, 5)), drive).verdict == "no_gap"


def test_missing_signals_are_said(recording, drive) -> None:
    """Without voltage and rod the rest is judged, and both are named as not judged."""
    nothing = np.full(len(recording), np.nan)
    less = dataclasses.replace(recording, voltage_q_v=nothing, rod_position_m=nothing)
    result = diagnose(less, drive)
    assert result.verdict == "no_gap"
    assert any("voltage_q, rod_position" in note for note in result.notes)


def test_a_dead_signal_is_not_believed(recording, drive) -> None:
    """A rod scale that stays at one value while the drive moves is left out and named."""
    dead = dataclasses.replace(recording, rod_position_m=np.full(len(recording), 0.001))
    result = diagnose(dead, drive)
    assert result.verdict == "no_gap"
    assert any("rod_position_m is constant" in note for note in result.notes)


def test_lone_outliers_are_left_out(recording, drive) -> None:
    """Ten single samples far off do not make a gap; they are counted."""
    values = np.array(recording.rotor_position_rad)
    values[100::390] += 50.0
    result = diagnose(dataclasses.replace(recording, rotor_position_rad=values), drive)
    assert result.verdict == "no_gap"
    assert any("10 lone outliers" in note for note in result.notes)


def test_a_long_recording_is_judged_on_a_stretch(recording, drive) -> None:
    """Beyond 40 s the liveliest stretch is taken and named."""
    times = 15
    period = round(1e9 / recording.rate_hz)
    stamps = recording.stamp_ns[0] + period * np.arange(times * len(recording))
    arrays = {name: np.tile(recording.signal(name), times) for name in SIGNALS}
    replay = Replay(Recording(stamp_ns=stamps, **arrays), drive, "test")
    assert replay.time_s[-1] < 40.0
    assert any("60 s long: judged from" in note for note in replay.notes)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda r: _kept(r, slice(None, None, 40)), "100 samples, expected at least 200"),
        (lambda r: _kept(r, slice(0, 1000)), "expected at least 1.5 s"),
        (
            lambda r: dataclasses.replace(r, reference_position_m=np.full(len(r), np.nan)),
            "/ecyl/reference holds 0 of 4000",
        ),
        (
            lambda r: Recording(stamp_ns=r.stamp_ns, reference_position_m=r.reference_position_m),
            "no rotor, rod, current or voltage signal",
        ),
        (
            lambda r: dataclasses.replace(r, rod_position_m=5.0 * r.rod_position_m),
            "belongs to another machine",
        ),
    ],
)
def test_the_unusable_is_refused_by_name(recording, drive, change, said) -> None:
    """One line that names the source and what was expected."""
    with pytest.raises(InputError, match=r"^bag: ") as error:
        diagnose(change(recording), drive, source="bag")
    assert said in str(error.value) and "\n" not in str(error.value)


def test_roughness_is_the_noise_not_the_motion() -> None:
    """White noise on a 5 Hz motion sampled at 1 kHz comes out within a tenth."""
    rng = np.random.default_rng(0)
    time = np.arange(5000) * 1e-3
    values = np.sin(2 * np.pi * 5.0 * time) + 1e-3 * rng.standard_normal(time.size)
    assert roughness(values) == pytest.approx(1e-3, rel=0.1)
