"""The lockstep graph against the engine: the same bytes, whatever runs it."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

import pytest
import yaml

from ecyl_ros.drive.drive_file import drive_to_flat, load_drive

from .conftest import SINE, ecyl_here, simulated, start


def _drive_file(path: Path, profile: str, **changes: object) -> Path:
    flat = drive_to_flat(load_drive(profile)) | changes
    flat = {key: value for key, value in flat.items() if value != []}
    path.write_text(yaml.safe_dump({"/**": {"ros__parameters": flat}}))
    return path


VARIANTS = {
    "bench": ("bench", {}),
    "rod feedback": ("bench", {"controller.feedback": "rod"}),
    "two ticks of delay": ("servo_1khz", {"controller.delay_ticks": 2, "controller.speed.kp": 0.1}),
    "odd rate": ("bench", {"controller.rate": 7777.0}),
    "telemetry at every tick": ("bench", {"telemetry_rate": 10000.0}),
    "paper": ("paper", {}),
    "filters and feedforward": (
        "bench",
        {
            "controller.setpoint_filter": 4e-3,
            "controller.speed_source": "differences",
            "controller.speed_filter": 5e-4,
            "controller.current_command_filter": 2e-4,
            "controller.velocity_feedforward": 0.6,
            "controller.acceleration_feedforward": 2e-3,
        },
    ),
    "no speed loop": (
        "bench",
        {
            "controller.structure": "position_to_current",
            "controller.position.kp": 32.0,
            "controller.position.ki": 100.0,
            "controller.position.kd": 0.8,
            "controller.speed.kp": 0.0,
            "controller.speed.ki": 0.0,
        },
    ),
    "a learned law": (
        "bench",
        {
            "effects.learned.port": "load_friction",
            "effects.learned.of": ["position", "heat"],
            "effects.learned.time_constant": 0.5,
            "effects.learned.table.at": [-1e-4, 0.0, 2e-5, 1e-4],
            "effects.learned.table.at_2": [0.0, 2.0],
            "effects.learned.table.values": [0.1, 0.3, 0.0, 0.2, 0.4, 0.1, 0.2, 0.2],
        },
    ),
    "effects of the controller": (
        "bench",
        {
            "effects.command_filter.time_constant_s": 4e-3,
            "effects.speed_gain_error.kp_a_s_per_rad": 0.6,
        },
    ),
}


@pytest.mark.parametrize("variant", VARIANTS)
def test_graph_in_one_process_writes_the_engines_bytes(variant: str, tmp_path: Path) -> None:
    """All nodes in one process, in lockstep: the file equals `ecyl simulate`'s byte for byte."""
    profile, changes = VARIANTS[variant]
    drive = _drive_file(tmp_path / "drive.yaml", profile, **changes)
    duration = 0.05 if profile == "paper" else 0.3
    arguments = ("--drive", drive, "--reference", SINE, "--duration", duration)
    done = ecyl_here("run", *arguments, "--out", tmp_path / "graph.mcap", "--in-process")
    assert done.returncode == 0, done.stderr
    engine = simulated(tmp_path / "engine.mcap", *arguments)
    assert (tmp_path / "graph.mcap").read_bytes() == engine


def test_separate_processes_under_load_write_the_engines_bytes(tmp_path: Path) -> None:
    """One process per node on a machine with more to do than it can: the same bytes."""
    arguments = ("--drive", "servo_1khz", "--reference", SINE, "--duration", 1.0)
    engine = simulated(tmp_path / "engine.mcap", *arguments)
    out = tmp_path / "graph.mcap"
    graph = start("run", *arguments, "--out", out)
    load: list[subprocess.Popen] = []
    try:
        while not out.exists() and graph.poll() is None:  # its nodes have started
            time.sleep(0.02)
        load += [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(3)]
        _, errors = graph.communicate(timeout=300)
    finally:
        for process in load:
            process.kill()
            process.wait()
    assert graph.returncode == 0, errors
    assert out.read_bytes() == engine


def test_a_recordings_reference_plays_again_to_the_same_bytes(tmp_path: Path) -> None:
    """Run with a recording as reference, the drive repeats that recording byte for byte."""
    moves = "moves:positions=0.002;-0.001,speed=0.05,acceleration=1,jerk=50,dwell=0.05"
    first = simulated(
        tmp_path / "a.mcap", "--drive", "bench", "--reference", moves, "--duration", 0.5
    )
    again = ("--drive", "bench", "--reference", tmp_path / "a.mcap", "--duration", 0.499)
    simulated(tmp_path / "b.mcap", *again)
    done = ecyl_here("run", *again, "--out", tmp_path / "c.mcap", "--in-process")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "b.mcap").read_bytes() == (tmp_path / "c.mcap").read_bytes()
    from ecyl_ros.recording.reader import read_recording

    one, two = read_recording(tmp_path / "a.mcap"), read_recording(tmp_path / "c.mcap")
    assert len(first) > 0 and len(two) == 499
    assert (one.rotor_position_rad[:499] == two.rotor_position_rad).all()
    assert (one.voltage_q_v[:499] == two.voltage_q_v).all()
