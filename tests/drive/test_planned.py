"""Planned motions: the file, and the limits that they keep."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.drive.reference.leg import Leg
from ecyl_ros.drive.reference.planned import Planned, read_planned
from ecyl_ros.drive.reference.spec import make_reference
from ecyl_ros.errors import InputError

LEGS = (
    Leg(0.004, 0.05, 1.0, 50.0, 0.1),
    Leg(-0.002, 0.02, 0.5, 50.0),
    Leg(0.0, 0.05, 1.0, 50.0),
)


def test_a_motion_comes_back_from_its_file(tmp_path: Path) -> None:
    """What was written is what is played, at any time."""
    motion = Planned(LEGS, 2.0)
    path = tmp_path / "motion.yaml"
    path.write_text(motion.as_file({"drive": "bench.yaml"}))
    played = make_reference(str(path), load_drive("bench"), 2.0)
    for time in np.linspace(0.0, 2.5, 50):
        assert played.sample(time) == pytest.approx(motion.sample(time), abs=1e-9)


def test_a_motion_keeps_the_limits_of_its_legs() -> None:
    """Positions join; speed, acceleration and jerk by differences stay within what is asked."""
    motion = Planned(LEGS, 2.0)
    step = 1e-4
    times = np.arange(0.0, motion.moving_s, step)
    position, speed = np.array([motion.sample(one) for one in times]).T
    faster = np.diff(speed) / step
    assert np.allclose(np.diff(position) / step, 0.5 * (speed[1:] + speed[:-1]), atol=1e-5)
    assert np.abs(speed).max() <= 0.05 + 1e-9
    assert np.abs(faster).max() <= 1.0 + 1e-6
    assert np.abs(np.diff(faster) / step).max() <= 50.0 * 1.01 + 1e-3
    assert np.allclose(motion.accelerations(times[:-1].tolist()), faster, atol=0.02)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("nothing: 1\n", "expected a motion"),
        ("motion: {schema: ecyl.motion/1, legs: []}\n", "motion.legs is missing or empty"),
        (
            "motion: {schema: ecyl.motion/1, legs: [{to_m: .nan, speed: 1, acceleration: 1, "
            "jerk: 1}]}\n",
            "number 1: to_m = nan, expected a finite number",
        ),
        (
            "motion: {schema: ecyl.motion/1, legs: [{to_m: 0, speed: 0, acceleration: 1, "
            "jerk: 1}]}\n",
            "speed = 0, expected more than 0",
        ),
        (
            "motion: {schema: ecyl.motion/1, legs: [{to_m: 1.0e+20, speed: 1, acceleration: 1, "
            "jerk: 1}]}\n",
            r"motion\.yaml: no move from 0 m to 1e\+20 m",
        ),
        (
            "motion: {schema: ecyl.motion/1, legs: [{to_m: 0, speed: 1, acceleration: 1, "
            f"jerk: {10**400}}}]}}\n",
            "expected a finite number",
        ),
        ("motion: {schema: ecyl.motion/1, legs: [{to: 0}]}\n", "unknown key to"),
        ("[\n", "cannot be read as YAML"),
    ],
)
def test_a_bad_motion_is_one_clear_line(tmp_path: Path, text: str, said: str) -> None:
    """The message names file, leg and field."""
    path = tmp_path / "motion.yaml"
    path.write_text(text)
    with pytest.raises(InputError, match=said):
        read_planned(path)


def test_a_motion_for_another_drive_is_refused(tmp_path: Path) -> None:
    """A drive that is slower than the motion asks for does not play it."""
    drive = load_drive("bench")
    slow = dataclasses.replace(drive, limits=dataclasses.replace(drive.limits, speed=0.01))
    path = tmp_path / "motion.yaml"
    path.write_text(Planned(LEGS, 2.0).as_file())
    with pytest.raises(InputError, match=r"limits\.speed = 0\.01 of this drive"):
        make_reference(str(path), slow, 2.0)
