"""Trajectories that the drive follows beside setpoints."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest
from scipy.interpolate import BPoly

from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.drive.reference.leg import Leg
from ecyl_ros.drive.reference.planned import Planned
from ecyl_ros.drive.reference.setpoint import SetpointFollower
from ecyl_ros.drive.reference.trajectory import Point, made
from ecyl_ros.plan.trajectory import trajectory

LIMITS = load_drive("servo_1khz").limits
REST = (0.0, 0.0, 0.0)
PERIOD = 1e-3


def _follower() -> SetpointFollower:
    return SetpointFollower(LIMITS, PERIOD)


def _said(follower: SetpointFollower, first: int, count: int) -> np.ndarray:
    return np.array([follower.sample(k * PERIOD) for k in range(first, first + count)])


def test_splines_are_those_of_scipy() -> None:
    """Quintics and cubics against scipy's Bernstein polynomials through the same derivatives."""
    knots = [0.0, 0.3, 1.0, 1.4]
    states = [[0.0, 0.0, 0.0], [0.01, 0.02, -0.1], [-0.02, 0.0, 0.3], [0.005, 0.0, 0.0]]
    times = np.linspace(0.001, 1.399, 57)  # not at a knot, where a cubic's acceleration steps
    for order in (3, 2):
        points = [
            Point(time, state[0], state[1], state[2] if order == 3 else None)
            for time, state in zip(knots[1:], states[1:], strict=True)
        ]
        spline = made(points, REST, 5.0, 5.0)
        true = BPoly.from_derivatives(knots, [state[:order] for state in states])
        for derivative, values in enumerate(spline.states(times + 5.0)):
            np.testing.assert_allclose(values, true(times, derivative), rtol=1e-6, atol=1e-9)


def test_a_planned_motion_comes_back_from_its_trajectory() -> None:
    """Points at the switches of jerk, quintics between: the motion itself, to a nanometre."""
    motion = Planned(
        (Leg(0.01, LIMITS.speed, LIMITS.acceleration, LIMITS.jerk, 0.1), Leg(0.0, 0.02, 1.0, 20.0)),
        1.9,
    )
    points = [
        Point(
            one["time_from_start"]["sec"] + 1e-9 * one["time_from_start"]["nanosec"],
            one["positions"][0],
            one["velocities"][0],
            one["accelerations"][0],
        )
        for one in trajectory(motion, "rod")["points"]
    ]
    follower = _follower()
    assert follower.offer_trajectory(points, REST, 0.25, 0.25) is None
    said = _said(follower, 250, 2100)
    wanted = np.array([motion.sample(k * PERIOD) for k in range(2100)])
    np.testing.assert_allclose(said[:, 0], wanted[:, 0], atol=1e-9)
    np.testing.assert_allclose(said[:, 1], wanted[:, 1], atol=1e-6)


def test_positions_alone_are_joined_smoothly_and_end_at_rest() -> None:
    """One point is a rest-to-rest cubic: three halves of the mean speed in its middle."""
    follower = _follower()
    assert follower.offer_trajectory([Point(2.0, 0.01)], REST, 0.0, 0.0) is None
    said = _said(follower, 0, 2500)
    assert said[1000, 1] == pytest.approx(1.5 * 0.01 / 2.0)
    assert said[-1] == pytest.approx([0.01, 0.0])


@pytest.mark.parametrize(
    ("points", "said"),
    [
        ([Point(1.0, math.nan)], "position = nan is not finite"),
        ([Point(1.0, 0.01, math.inf)], "velocity = inf is not finite"),
        ([Point(100.0, 9.0)], "the stroke"),
        ([Point(0.6, 0.24)], "asks for .* m/s .* after its start, expected at most"),
        ([Point(0.01, 1e-4)], r"m/s\^2"),
        ([Point(1.0, 0.01), Point(1.0, 0.02)], "point 2: time_from_start"),
        ([Point(1.0, 0.01, 0.0), Point(2.0, 0.02)], "velocity at every point or at none"),
        ([Point(1.0, 0.01, 0.01)], "expected 0 m/s at its last point"),
        ([Point(1.0, 0.01, None, 0.0)], "expected a velocity beside acceleration"),
    ],
)
def test_what_the_drive_cannot_keep_is_refused_as_a_whole(points: list[Point], said: str) -> None:
    """Refused, counted, and not a sample of it is followed."""
    follower = _follower()
    reason = follower.offer_trajectory(points, REST, 0.0, 0.0)
    assert reason is not None and re.search(said, reason), reason
    assert (follower.trajectories_refused, follower.trajectories_accepted) == (1, 0)
    assert not _said(follower, 0, 50).any()


def test_one_that_is_over_is_refused_and_points_gone_by_are_left_out() -> None:
    """As a joint_trajectory_controller does with a stamp in the past."""
    follower = _follower()
    points = [Point(1.0, 0.0), Point(3.0, 0.01)]
    assert "over already" in (follower.offer_trajectory(points, REST, 9.0, 5.0) or "")
    assert follower.offer_trajectory(points, REST, 6.5, 5.0) is None
    assert _said(follower, 8000, 1)[0] == pytest.approx([0.01, 0.0])


def test_an_empty_trajectory_brings_the_rod_to_rest_within_the_limits() -> None:
    """From the middle of a move: no sample beyond speed, acceleration, jerk; soon at rest."""
    follower = _follower()
    assert follower.offer_trajectory([Point(2.0, 0.1)], REST, 0.0, 0.0) is None
    before = _said(follower, 0, 1001)
    assert follower.offer_trajectory([], follower.state, 1.0, 1.0) is None
    after = _said(follower, 1001, 1500)
    speed = np.concatenate([before[-1:, 1], after[:, 1]])
    assert after[-1, 1] == pytest.approx(0.0, abs=1e-9)
    assert after[-1, 0] < 0.1 and speed.max() <= before[-1, 1] * (1.0 + 1e-3)
    assert np.abs(np.diff(speed) / PERIOD).max() <= LIMITS.acceleration * (1.0 + 1e-6)


def test_a_setpoint_ends_a_trajectory_and_goes_on_from_there() -> None:
    """No step in position or speed where one takes over from the other."""
    follower = _follower()
    assert follower.offer_trajectory([Point(2.0, 0.02)], REST, 0.0, 0.0) is None
    _said(follower, 0, 1001)
    assert follower.offer(-0.01, 1.0) is None
    said = _said(follower, 1001, 4000)
    assert said[-1, 0] == pytest.approx(-0.01)
    assert np.abs(np.diff(said[:, 1])).max() <= LIMITS.acceleration * PERIOD * (1.0 + 1e-6)
