"""References: closed forms, limits and what is refused."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.drive.interpolation import interpolate_reference, reference_cubic
from ecyl_ros.drive.reference.chirp import Chirp
from ecyl_ros.drive.reference.multisine import Multisine
from ecyl_ros.drive.reference.setpoint import SetpointFollower
from ecyl_ros.drive.reference.sine import Sine
from ecyl_ros.drive.reference.spec import make_reference
from ecyl_ros.errors import InputError

SPECS = [
    "sine:amplitude=1e-3,frequency=2,phase=0.3,offset=1e-3",
    "chirp:amplitude=1e-4,start=1,end=20,sweep=3",
    "multisine:amplitude=1e-5,start=1,end=30,base=0.5",
    "moves:positions=0.01;-0.005;0.002,speed=0.05,acceleration=1,jerk=50,dwell=0.1",
]


@pytest.mark.parametrize("spec", SPECS)
def test_velocity_is_the_derivative_of_position(spec: str) -> None:
    """Central differences of the position give the velocity, everywhere."""
    reference = make_reference(spec, load_drive("bench"), 5.0)
    step = 1e-6
    for time in np.linspace(0.01, 4.9, 333):
        before, _ = reference.sample(time - step)
        after, _ = reference.sample(time + step)
        _, velocity = reference.sample(time)
        assert (after - before) / (2 * step) == pytest.approx(velocity, rel=1e-3, abs=2e-5)


def test_chirp_runs_through_its_frequencies() -> None:
    """The chirp completes (start + end)/2 x sweep cycles and goes on at the end frequency."""
    chirp = Chirp(amplitude=1.0, start=1.0, end=3.0, sweep=2.0)
    assert chirp.sample(2.0)[0] == pytest.approx(math.sin(2 * math.pi * 4.0), abs=1e-9)
    assert chirp.sample(2.5)[1] == pytest.approx(2 * math.pi * 3.0 * math.cos(2 * math.pi * 5.5))


def test_multisine_has_the_lines_it_says() -> None:
    """The spectrum over one period holds each line at the amplitude asked for, and no other."""
    multisine = Multisine(amplitude=2e-5, start=1.0, end=10.0, base=0.5)
    values = [multisine.sample(t)[0] for t in np.arange(2000) / 1000.0]
    amplitude = 2 * np.abs(np.fft.rfft(values)) / 2000
    expected = np.zeros_like(amplitude)
    expected[2:21] = 2e-5
    np.testing.assert_allclose(amplitude[1:], expected[1:], atol=1e-12)
    assert values[0] == pytest.approx(0.0, abs=1e-15)


def test_moves_keep_speed_acceleration_and_jerk() -> None:
    """A repeated sequence of moves reaches its positions and never exceeds its limits."""
    reference = make_reference(SPECS[3], load_drive("bench"), 5.0)
    step = 1e-4
    samples = np.array([reference.sample(t) for t in np.arange(0, 8, step)])
    velocity = samples[:, 1]
    acceleration = np.diff(velocity) / step
    jerk = np.diff(acceleration) / step
    assert np.abs(velocity).max() <= 0.05 * (1 + 1e-9)
    assert np.abs(acceleration).max() <= 1.0 * (1 + 1e-6)
    assert np.abs(jerk).max() <= 50.0 * (1 + 1e-2)
    for goal in (0.01, -0.005, 0.002):
        assert np.abs(samples[:, 0] - goal).min() < 1e-9


def test_interpolation_meets_a_cubic_exactly() -> None:
    """Between samples with velocities the cubic through both is reproduced to rounding."""

    def cubic(t: float) -> tuple[float, float]:
        return 1 + 2 * t - 3 * t**2 + 4 * t**3, 2 - 6 * t + 12 * t**2

    made = reference_cubic(np.array(cubic(0.0)), np.array(cubic(0.2)), 0.2)
    for phase in (0.0, 0.25, 0.9):
        assert interpolate_reference(phase, made) == pytest.approx(cubic(0.2 * phase), rel=1e-13)
    made = reference_cubic(np.array([1.0, math.nan]), np.array([2.0, math.nan]), 0.2)
    assert interpolate_reference(0.5, made) == pytest.approx((1.5, 5.0))


def test_interpolated_sine_errs_as_stated() -> None:
    """A sine sampled at 1 kHz is met within (w h)^4 / 384 of its amplitude."""
    sine = Sine(amplitude=1.0, frequency=50.0)
    worst = 0.0
    for index in range(20):
        before, after = (np.array(sine.sample(t * 1e-3)) for t in (index, index + 1))
        made = reference_cubic(before, after, 1e-3)
        worst = max(
            worst, abs(interpolate_reference(0.5, made)[0] - sine.sample((index + 0.5) * 1e-3)[0])
        )
    assert worst == pytest.approx((2 * math.pi * 50 * 1e-3) ** 4 / 384, rel=0.1)


def test_setpoint_is_followed_within_limits() -> None:
    """A far setpoint becomes a motion within speed and acceleration that ends on it."""
    limits = load_drive("bench").limits
    follower = SetpointFollower(limits, 1e-3)
    follower.sample(0.0)
    assert follower.offer(0.05, 1.0) is None
    samples = np.array([follower.sample(i * 1e-3) for i in range(1, 2000)])
    assert np.abs(samples[:, 1]).max() <= limits.speed * (1 + 1e-9)
    assert np.abs(np.diff(samples[:, 1])).max() <= limits.acceleration * 1e-3 * (1 + 1e-6)
    assert samples[-1] == pytest.approx((0.05, 0.0), abs=1e-9)


def test_two_setpoints_within_a_sample_have_that_sample_for_their_way() -> None:
    """Of two at one instant the second counts by its distance over one sample, no less."""
    follower = SetpointFollower(load_drive("bench").limits, 1e-3)
    assert follower.offer(0.01, 1.0) is None
    assert follower.offer(0.01 + 0.4e-3, 1.0) is None
    assert "asks for" in follower.offer(0.01 + 1.2e-3, 1.0)


@pytest.mark.parametrize(
    ("position", "reason"),
    [
        (math.nan, "not finite"),
        (math.inf, "not finite"),
        (-math.inf, "not finite"),
        (0.3, "beyond the stroke"),
        (-1e9, "beyond the stroke"),
        (0.2, "asks for"),
    ],
)
def test_bad_setpoints_are_refused_and_counted(position: float, reason: str) -> None:
    """Not finite, beyond stroke or too fast: counted, and the reference stays where it was."""
    follower = SetpointFollower(load_drive("bench").limits, 1e-3)
    follower.sample(0.0)
    assert reason in follower.offer(position, 0.1)
    assert (follower.refused, follower.accepted) == (1, 0)
    assert follower.sample(1e-3) == (0.0, 0.0)


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        ("sine", "amplitude is missing"),
        ("sine:amplitude=2e-5", "frequency is missing"),
        ("sine:amplitude=abc,frequency=1", "expected a finite number"),
        ("sine:amplitude=nan,frequency=1", "expected a finite number"),
        ("sine:amplitude=1e-5,frequency=-1", "expected more than 0"),
        ("sine:amplitud=1e-5,frequency=1", "did you mean amplitude"),
        ("sine:amplitude", "unknown argument"),
        ("sine:amplitude=0.5,frequency=0.1", "stroke"),
        ("sine:amplitude=0.1,frequency=10", "limits.speed"),
        ("moves:positions=a;b", "expected numbers"),
        ("moves:positions=0.001;1e20", "no move from 0.001 m to 1e"),
        ("moves:speed=0.1", "expected moves:positions=0.01;0.02;0$"),
        ("moves:positions=" + "0.01:" * 100, "expected numbers like 0.01;0.02;0$"),
        ("multisine:amplitude=1e-5,start=2,end=1,base=0.5", "no line"),
        ("waltz:tempo=3", "neither a recording, a motion file, nor one of"),
        ("setpoint:now", "neither a recording"),
    ],
)
def test_bad_specs_say_what_was_expected(spec: str, message: str) -> None:
    """A reference that cannot be made is refused by one line that names it."""
    with pytest.raises(InputError, match=message) as caught:
        make_reference(spec, load_drive("bench"), 10.0)
    assert "\n" not in str(caught.value)
    assert spec[:50] in str(caught.value) and len(str(caught.value)) < 250
