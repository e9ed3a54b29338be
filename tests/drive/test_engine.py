"""The engine: what is sampled when, delays, determinism, and noise."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.drive.engine import VOLTAGE, sample_count, simulate
from ecyl_ros.drive.noise import gaussian
from ecyl_ros.drive.reference.sine import Sine

SINE = Sine(amplitude=2e-3, frequency=2.0)


def _run(drive, duration=0.5, **options):
    return simulate(drive, lambda i: SINE.sample(i / drive.sample_rate), duration, **options)


def _with(drive, **changes):
    return dataclasses.replace(drive, controller=dataclasses.replace(drive.controller, **changes))


def test_samples_are_those_of_the_control_ticks() -> None:
    """Telemetry at a tenth of the control rate is every tenth sample of telemetry at full rate."""
    drive = load_drive("bench")
    full = dataclasses.replace(drive, telemetry_rate=10_000.0)
    # The same reference for both: a line, which any sampling interpolates exactly.
    slow = simulate(drive, lambda i: (1e-2 * i / 1e3, 1e-2), 0.2)
    fast = simulate(full, lambda i: (1e-2 * i / 1e4, 1e-2), 0.2)
    np.testing.assert_allclose(slow.samples, fast.samples[::10], rtol=1e-6, atol=1e-8)


def test_delay_holds_the_voltage_back_by_whole_ticks() -> None:
    """With d ticks of delay the plant does not move before tick d + 1, however far it should."""
    for delay in (0, 1, 3):
        drive = _with(load_drive("bench"), delay_ticks=delay)
        drive = dataclasses.replace(drive, telemetry_rate=10_000.0, sensors=type(drive.sensors)())
        run = simulate(drive, lambda i: (1e-4, 0.0), 0.001)
        assert run.samples[0, VOLTAGE + 1] > 0.0
        current = run.signal("current_q_a")
        assert np.all(current[: delay + 1] == 0.0)
        assert current[delay + 1] > 0.0


@pytest.mark.parametrize("rate", [1500.0, 3333.0, 7000.0, 12_345.0])
def test_any_control_rate_gives_whole_numbers_of_ticks_per_sample(rate: float) -> None:
    """The sample rate is the control rate over the nearest whole number; counts agree."""
    drive = _with(load_drive("servo_1khz"), rate=rate)
    assert drive.sample_rate == rate / drive.telemetry_every
    run = _run(drive)
    assert len(run.samples) == sample_count(drive, 0.5)
    assert len(run.samples) == pytest.approx(0.5 * drive.sample_rate, abs=1.0)
    assert np.isfinite(run.samples).all()


def test_runs_repeat_to_the_last_bit() -> None:
    """Two runs agree bit for bit, also when one reports progress and so runs in blocks."""
    drive = load_drive("bench")
    shares: list[float] = []
    first, second = _run(drive), _run(drive, progress=shares.append)
    assert np.array_equal(first.samples, second.samples)
    assert shares[-1] == 1.0 and len(shares) > 10


def test_noise_is_standard_normal_and_white() -> None:
    """Mean, spread, fourth moment and neighbours' correlation are those of white normal noise."""
    values = np.array([gaussian(7, tick, 2) for tick in range(200_000)])
    assert values.mean() == pytest.approx(0.0, abs=0.01)
    assert values.std() == pytest.approx(1.0, abs=0.01)
    assert (values**4).mean() == pytest.approx(3.0, abs=0.1)
    assert np.corrcoef(values[1:], values[:-1])[0, 1] == pytest.approx(0.0, abs=0.01)
    other = np.array([gaussian(7, tick, 3) for tick in range(200_000)])
    assert np.corrcoef(values, other)[0, 1] == pytest.approx(0.0, abs=0.01)


def test_sensor_noise_has_the_spread_the_file_says() -> None:
    """At rest the measured signals scatter as the drive file says, on their resolution's grid."""
    drive = load_drive("bench")
    drive = _with(
        drive,
        **{
            loop: type(drive.controller.position)(kp=0.0)
            for loop in ("position", "speed", "current")
        },
    )
    run = simulate(drive, lambda i: (0.0, 0.0), 20.0)
    sensors = drive.sensors
    for name, std in (
        ("rotor_velocity_rad_per_s", sensors.rotor_velocity_noise),
        ("current_q_a", sensors.current_noise),
        ("rotor_position_rad", np.hypot(1e-5, sensors.rotor_position_resolution / 12**0.5)),
        ("rod_position_m", np.hypot(5e-7, sensors.rod_position_resolution / 12**0.5)),
    ):
        assert run.signal(name).std() == pytest.approx(std, rel=0.03), name
    steps = run.signal("rod_position_m") / sensors.rod_position_resolution
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-6)
