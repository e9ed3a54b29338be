"""Swings: multisines from rest to rest, within a drive's limits."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import BPoly

from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.drive.reference.leg import Leg
from ecyl_ros.drive.reference.planned import Planned, read_planned
from ecyl_ros.drive.reference.spec import make_reference
from ecyl_ros.drive.reference.swing import Swing
from ecyl_ros.errors import InputError
from ecyl_ros.plan.trajectory import trajectory

LIMITS = load_drive("bench").limits
UNIT = Swing(1.0, 0.5, 4.0, 0.25, 4.0, 0.5, 0.1)
SWING = dataclasses.replace(UNIT, amplitude_m=UNIT.largest(LIMITS))
MOTION = Planned((Leg(0.01, 0.1, 2.0, 100.0), SWING, Leg(0.0, 0.1, 2.0, 100.0)), 6.0)


def test_a_swing_is_the_faded_sum_of_its_lines() -> None:
    """Against the sum written out: Schroeder's phases, a septic step in and out."""
    times = np.linspace(0.0, 4.0, 401)
    lines = 0.25 * np.arange(2, 17)
    phases = -np.pi * np.arange(15) * np.arange(1, 16) / 15
    plain = np.sin(2.0 * np.pi * np.outer(times, lines) + phases).sum(axis=1)
    step = np.clip(np.minimum(times, 4.0 - times) / 0.5, 0.0, 1.0)
    fade = np.polynomial.Polynomial([0, 0, 0, 0, 35, -84, 70, -20])(step)
    wanted = 0.02 + SWING.amplitude_m * fade * plain
    played = SWING.begun_at(0.02).derivatives(times)[0]
    assert np.allclose(played, wanted, atol=1e-14)


def test_a_swing_goes_from_rest_to_rest_within_the_limits() -> None:
    """Speed, acceleration and jerk by differences of position; the largest comes close to one."""
    step = 1e-4
    times = np.arange(-2, 40003) * step
    position = SWING.begun_at(0.0).derivatives(np.clip(times, 0.0, 4.0))[0]
    tops = [float(np.abs(np.diff(position, order)).max()) / step**order for order in (1, 2, 3)]
    most = (LIMITS.speed, LIMITS.acceleration, LIMITS.jerk)
    shares = [top / one for top, one in zip(tops, most, strict=True)]
    assert 0.99 < max(shares) < 1.003
    assert position[0] == position[-1] == 0.0
    SWING.check(LIMITS, 0.0, "here")
    larger = dataclasses.replace(SWING, amplitude_m=1.01 * SWING.amplitude_m)
    with pytest.raises(
        InputError, match=r"here: amplitude_m = .* comes to accel.* limits\.acceleration"
    ):
        larger.check(LIMITS, 0.0, "here")


def test_a_swing_stays_within_the_stroke() -> None:
    """About a place near its end the same swing is refused, and is smaller about 0."""
    short = dataclasses.replace(LIMITS, stroke_max=0.002, stroke_min=-0.01)
    assert UNIT.largest(short) < 0.25 * UNIT.largest(LIMITS)
    with pytest.raises(InputError, match=r"swings from .* limits\.stroke_max = 0\.25 m"):
        SWING.check(LIMITS, 0.249, "here")


def test_a_motion_with_a_swing_comes_back_from_its_file(tmp_path: Path) -> None:
    """What was written is what is played; it begins where the leg before it ended."""
    path = tmp_path / "motion.yaml"
    path.write_text(MOTION.as_file())
    played = make_reference(str(path), load_drive("bench"), 6.0)
    for time in np.linspace(0.0, 6.5, 60):
        assert played.sample(time) == pytest.approx(MOTION.sample(time), abs=1e-9)
    assert MOTION.sample(MOTION.moving_s)[0] == pytest.approx(0.0, abs=1e-12)
    begins = Planned(MOTION.legs[:1], 6.0).moving_s
    assert MOTION.sample(begins) == pytest.approx((0.01, 0.0), abs=1e-12)


def test_splines_through_the_points_of_a_swing_are_the_swing() -> None:
    """Quintics through the message's points, by scipy, to a nanometre."""
    points = trajectory(MOTION, "rod")["points"]
    times = [
        one["time_from_start"]["sec"] + 1e-9 * one["time_from_start"]["nanosec"] for one in points
    ]
    states = [
        [one[key][0] for key in ("positions", "velocities", "accelerations")] for one in points
    ]
    spline = BPoly.from_derivatives(times, states)
    looked = np.linspace(0.0, times[-1], 3001)
    wanted = np.array([MOTION.sample(one)[0] for one in looked.tolist()])
    assert np.abs(spline(looked) - wanted).max() < 1e-9


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"fade_s": 2.5}, "fade_s = 2.5, expected more than 0 s and at most half of length_s"),
        ({"start_hz": 5.0}, "end_hz = 4, expected at least start_hz and base_hz"),
        ({"base_hz": 5.0}, "end_hz = 4, expected at least start_hz and base_hz"),
        ({"base_hz": 1e-3}, "base_hz = 0.001, expected a thousandth of end_hz = 4"),
        ({"base_hz": 3.0, "start_hz": 3.5}, "expected a multiple of it between start_hz = 3.5"),
        ({"length_s": 1e9}, r"length_s = 1e\+09, expected fewer periods of end_hz"),
        ({"amplitude_m": 0.0}, "amplitude_m = 0, expected more than 0"),
        ({"lines": 3}, "unknown key lines; expected amplitude_m, start_hz"),
        ({"end_hz": None}, "end_hz = None, expected a finite number"),
    ],
)
def test_a_bad_swing_is_one_clear_line(tmp_path: Path, change: dict, said: str) -> None:
    """The message names file, leg and field."""
    path = tmp_path / "motion.yaml"
    fields = {**dataclasses.asdict(UNIT), **change}
    path.write_text(f"motion: {{schema: ecyl.motion/1, legs: [{fields}]}}".replace("None", "null"))
    with pytest.raises(InputError, match=rf"motion\.yaml: legs, number 1: .*{said}"):
        read_planned(path)
