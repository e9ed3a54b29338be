"""The model beside a drive without a node around it: where it begins, what it leaves out."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.gap.live.monitor import MEASURED_TOPICS, REFERENCE, REFERENCE_SIGNALS, Monitor
from ecyl_ros.gap.replay.sensor_noise import silent
from ecyl_ros.recording.signals import Recording

from .monitor_bench import CHUNK, recorded


def feed(monitor: Monitor, recording: Recording) -> None:
    """Send a recording to a monitor, a few samples at a time."""
    for start in range(0, len(recording), CHUNK):
        part = slice(start, start + CHUNK)
        now = (start + CHUNK) * 1e-3
        for key, names in {REFERENCE: REFERENCE_SIGNALS, **MEASURED_TOPICS}.items():
            values = np.column_stack([recording.signal(name)[part] for name in names])
            monitor.put(key, recording.stamp_ns[part], values, now)
        monitor.step(now)


@pytest.mark.parametrize("profile", ["bench", "servo_1khz"])
def test_a_drive_joined_in_motion_shows_no_gap(profile: str) -> None:
    """Begun from one sample in motion, the twin comes to the machine's track: no gap."""
    drive = load_drive(profile)
    monitor = Monitor(drive, 4.0)
    feed(monitor, recorded(drive, 12.0).slice(1.37))
    gap = monitor.judge()
    assert gap is not None and not gap.is_gap, gap
    assert monitor.beginnings == 1


def test_stamps_between_ticks_are_compared_at_their_instants() -> None:
    """300 Hz on a 10 kHz loop, stamps off its ticks: residuals as a spline of the run gives."""
    drive = silent(load_drive("bench"))
    fast = dataclasses.replace(drive, telemetry_rate=drive.controller.rate)
    run = recorded(fast, 3.0)
    stamps = (np.arange(1, 895) * 1e9 / 300.3).astype(np.int64)
    # The reference keeps its own stamps.
    signals = {
        name: CubicSpline(run.time_s, run.signal(name))(stamps * 1e-9)
        for names in MEASURED_TOPICS.values()
        for name in names
    }
    monitor = Monitor(drive, 4.0)
    left: list[np.ndarray] = []
    measured = {"rotor": 0, "rod": 3}
    for second in range(30):
        span = slice(second * 1000, (second + 1) * 1000)
        rows = slice(*np.searchsorted(stamps, [second * 10**8, (second + 1) * 10**8]))
        columns = [run.signal(name)[span][::10] for name in REFERENCE_SIGNALS]
        monitor.put(REFERENCE, run.stamp_ns[span][::10], np.column_stack(columns), 0.1 * second)
        for key, names in MEASURED_TOPICS.items():
            values = np.column_stack([signals[name][rows] for name in names])
            monitor.put(key, stamps[rows], values, 0.1 * second)
        found = monitor.step(0.1 * second)
        if "joint_states" in found:
            left.append(found["joint_states"][1])
    residual = np.concatenate(left)
    assert len(residual) >= 880
    assert monitor.settled_ns is not None
    settled = stamps[: len(residual)] > monitor.settled_ns
    # What is left is less than noise would be, by far; at impacts two interpolations differ.
    rms = np.sqrt(np.mean(residual[settled] ** 2, axis=0))
    noise = load_drive("bench").sensors
    assert rms[measured["rotor"]] < 0.2 * noise.rotor_position_noise
    assert rms[measured["rod"]] < 0.2 * noise.rod_position_noise


def test_topics_of_an_old_run_do_not_mix_with_a_new_one() -> None:
    """Voltages of the old run that come after joint states of the new one are left out."""
    drive = load_drive("bench")
    run = recorded(drive, 2.0)
    monitor = Monitor(drive, 2.0)
    late = slice(1900, 2000)
    voltage = np.column_stack([run.voltage_d_v, run.voltage_q_v])
    for start, stop in ((0, 1900), (1900, 2000)):
        for key, names in {REFERENCE: REFERENCE_SIGNALS, **MEASURED_TOPICS}.items():
            if key == "voltage" and start == 1900:
                continue
            values = np.column_stack([run.signal(name)[start:stop] for name in names])
            monitor.put(key, run.stamp_ns[start:stop], values, 0.0)
    joints = np.column_stack([run.signal(name) for name in MEASURED_TOPICS["joint_states"]])
    monitor.put("joint_states", run.stamp_ns[:100], joints[:100], 0.1)
    monitor.put("voltage", run.stamp_ns[late], voltage[late], 0.1)
    assert set(monitor.streams.of_run()) == {"joint_states"}
    monitor.put("voltage", run.stamp_ns[:100], voltage[:100], 0.1)
    assert set(monitor.streams.of_run()) == {"joint_states", "voltage"}
    assert monitor.streams.by_key["voltage"].stamp_ns.tolist() == run.stamp_ns[:100].tolist()
    assert monitor.streams.run == 1


def test_a_twin_that_runs_away_starts_again() -> None:
    """A machine off by more than its stroke: the twin starts again from what is measured."""
    drive = load_drive("bench")
    run = recorded(drive, 2.0)
    far = dataclasses.replace(
        run, rod_position_m=run.rod_position_m + np.where(run.time_s > 1.0, 1.0, 0.0)
    )
    monitor = Monitor(drive, 2.0)
    feed(monitor, far)
    assert monitor.beginnings > 1 and "ran away" in monitor.why
