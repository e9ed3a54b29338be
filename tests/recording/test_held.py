"""A position that is refreshed more slowly than it is logged."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ecyl_ros.recording.load import load_recording
from ecyl_ros.recording.map_file import parse_map

RATE_HZ, HELD = 200.0, 10
TIME_S = np.arange(0.0, 12.0, 1.0 / RATE_HZ)
MOTION = 3.0 * np.sin(2.0 * TIME_S) + 0.5 * np.sin(5.3 * TIME_S)
SIGNALS = {"time": {"field": "t", "unit": "s"}}
POSITION = {"rotor_position": {"field": "q", "unit": "rad"}, "effort": {"field": "u", "unit": "V"}}


def held(values: np.ndarray) -> np.ndarray:
    """As a logger writes what it is told every tenth row."""
    return values[np.arange(values.size) // HELD * HELD]


def read(folder: Path, signals: dict[str, dict[str, str]], **columns: np.ndarray):
    """A table of these columns beside time and voltage, read with a map."""
    columns = {"t": TIME_S, "u": np.cos(2.0 * TIME_S), **columns}
    table = np.column_stack(list(columns.values()))
    header = ",".join(columns)
    np.savetxt(folder / "a.csv", table, delimiter=",", header=header, comments="", fmt="%.9g")
    return load_recording(folder / "a.csv", parse_map({**SIGNALS, "signals": signals}, "m"))


def test_rows_that_repeat_the_position_are_left_out(tmp_path: Path) -> None:
    """Of 200 rows in a second the 20 where it is new are kept, and a note says so."""
    recording = read(tmp_path, POSITION, q=held(MOTION))
    assert recording.rate_hz == pytest.approx(RATE_HZ / HELD, rel=0.01)
    at = np.searchsorted(TIME_S, recording.time_s + HELD / RATE_HZ - 1e-6)
    np.testing.assert_allclose(recording.rotor_position_rad, MOTION[at], atol=1e-8)
    assert any("the position is new only every 50 ms" in note for note in recording.notes)


@pytest.mark.parametrize(
    ("more", "column"),
    [
        ({"rotor_velocity": {"field": "w", "unit": "rad/s"}}, {"w": np.gradient(MOTION, TIME_S)}),
        ({"reference_position": {"field": "w", "unit": "rad"}}, {"w": MOTION}),
    ],
)
def test_with_a_speed_or_a_reference_all_rows_stay(tmp_path: Path, more, column) -> None:
    """A speed that is new in every row tells the motion in between; a loop needs its reference."""
    recording = read(tmp_path, {**POSITION, **more}, q=held(MOTION), **column)
    assert recording.rate_hz == pytest.approx(RATE_HZ, rel=0.01)


def test_a_coarse_encoder_is_not_held(tmp_path: Path) -> None:
    """It turns evenly and waits ten rows for each of its counts: every row is true."""
    count = 0.05
    even = np.floor(TIME_S / count * (RATE_HZ / HELD) * count) * count
    recording = read(tmp_path, POSITION, q=even)
    assert recording.rate_hz == pytest.approx(RATE_HZ, rel=0.01)
