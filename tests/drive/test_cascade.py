"""The sampled cascade: PI forms, limits, anti-windup, feedback."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from ecyl_ros.drive.cascade import cascade_step, initial_cascade_state
from ecyl_ros.drive.drive_file import drive_from_flat, drive_to_flat, load_drive
from ecyl_ros.drive.engine import VOLTAGE, simulate
from ecyl_ros.drive.packed import pack
from ecyl_ros.drive.parameters import Gains, PositionGains
from ecyl_ros.drive.plant import MEASURED
from ecyl_ros.errors import InputError

from .python_cascade import PythonCascade, commands_of, plain_numbers

# No speed loop: the gains that the bench's position and speed loop come to.
DIRECT = {
    "structure": "position_to_current",
    "position": PositionGains(kp=32.0, ki=100.0, kd=0.8),
    "speed": Gains(kp=0.0),
}


def _with(drive, **changes):
    return dataclasses.replace(drive, controller=dataclasses.replace(drive.controller, **changes))


def _step(drive, state, reference=0.0, velocity=0.0, **measured):
    values = np.zeros(len(MEASURED))
    for name, value in measured.items():
        values[MEASURED.index(name)] = value
    voltage = np.zeros(2)
    cascade_step(state, reference, velocity, values, pack(drive), voltage)
    return voltage


@pytest.fixture
def drive():
    """The bench drive with an integral in every loop."""
    return _with(load_drive("bench"), position=PositionGains(kp=40.0, ki=5.0))


def test_one_tick_by_hand(drive) -> None:
    """From rest, u_q is the product of proportional gains; the integrals take one tick's error."""
    state = initial_cascade_state(pack(drive))
    error = 1e-4 / drive.transmission.rod_per_rotor
    speed, current = 40.0 * error, 0.8 * 40.0 * error
    _, u_q = _step(drive, state, reference=1e-4)
    assert u_q == pytest.approx(7.0 * current, rel=1e-12)
    assert state[0] == pytest.approx([error / 1e4, speed / 1e4, current / 1e4], rel=1e-12)
    _, u_q = _step(drive, state, reference=1e-4)
    speed2 = 40.0 * error + 5.0 * error / 1e4
    current2 = 0.8 * speed2 + 24.0 * speed / 1e4
    assert u_q == pytest.approx(7.0 * current2 + 2260.0 * current / 1e4, rel=1e-12)


def test_series_form_multiplies_the_gains(drive) -> None:
    """Equation (6): the series form with (kp, ki) is the parallel form with (kp, kp ki)."""
    series = _with(drive, form="series")
    parallel = _with(
        drive,
        **{
            loop: dataclasses.replace(gains, ki=gains.kp * gains.ki)
            for loop in ("position", "speed", "current")
            for gains in [getattr(drive.controller, loop)]
        },
    )
    states = initial_cascade_state(pack(drive)), initial_cascade_state(pack(drive))
    for tick in range(20):
        reference = 1e-5 * math.sin(tick)
        one = _step(series, states[0], reference, rotor_velocity_rad_per_s=0.01 * tick)
        other = _step(parallel, states[1], reference, rotor_velocity_rad_per_s=0.01 * tick)
        assert one == pytest.approx(other, rel=1e-12)


@pytest.mark.parametrize(
    ("limits", "held"),
    [
        ({"speed_limit": 1.0}, 0),
        ({"current_limit": 0.5}, 1),
        ({"voltage_limit": 2.0}, 2),
    ],
)
def test_an_integral_holds_while_its_limit_acts(drive, limits: dict, held: int) -> None:
    """In saturation the loop's own integral stands still and the output is the limit."""
    limited = _with(drive, **limits)
    for sign in (1.0, -1.0):
        state = initial_cascade_state(pack(drive))
        for _ in range(50):
            voltage = _step(limited, state, reference=sign * 1e-3)
        assert state[0][held] == 0.0
        assert np.all(np.delete(state[0], held) * sign > 0.0)
        if held == 2:
            assert voltage[1] == sign * 2.0


def test_position_feedback_from_rotor_or_rod(drive) -> None:
    """The position error is taken from the encoder or, with feedback rod, from the scale."""
    rod = _with(drive, feedback="rod")
    factor = drive.transmission.rod_per_rotor
    one = _step(
        drive, initial_cascade_state(pack(drive)), rotor_position_rad=0.3, rod_position_m=9.0
    )
    other = _step(
        rod, initial_cascade_state(pack(drive)), rotor_position_rad=9.0, rod_position_m=0.3 * factor
    )
    assert one == pytest.approx(other, rel=1e-12)
    assert one[1] < 0.0


def test_feedforward_adds_the_reference_velocity(drive) -> None:
    """At the wanted position and speed full feedforward asks for no correction."""
    forward = _with(drive, velocity_feedforward=1.0)
    speed = 0.01 / drive.transmission.rod_per_rotor
    u_d, u_q = _step(
        forward, initial_cascade_state(pack(drive)), velocity=0.01, rotor_velocity_rad_per_s=speed
    )
    assert u_q == pytest.approx(0.0, abs=1e-12)
    assert u_d == 0.0


def _every_tick(drive, duration_s, **controller):
    """Samples of a run on a wavy reference, one for each tick."""
    drive = _with(dataclasses.replace(drive, telemetry_rate=drive.controller.rate), **controller)
    rate = 2.0 * math.pi * 6.0
    size = 1e-3 if drive.controller.rate < 50e3 else 2e-5

    def reference(index):
        time = index / drive.sample_rate
        return size * (1.0 - math.cos(rate * time)), size * rate * math.sin(rate * time)

    return simulate(drive, reference, duration_s).samples


@pytest.mark.parametrize(
    ("profile", "duration_s", "controller"),
    [
        ("bench", 0.4, {}),
        ("bench", 0.4, {"feedback": "rod", "current_limit": 1.0, "speed_limit": 12.0}),
        ("servo_1khz", 1.0, {"form": "series"}),
        ("paper", 0.05, {}),
    ],
)
def test_a_drive_without_the_extras_is_the_plain_cascade_to_the_last_bit(
    profile, duration_s, controller
) -> None:
    """Without filters, derivative and acceleration feedforward every command of a run equals the
    three PI loops written in Python, bit for bit, and nothing is remembered from tick to tick."""
    drive = load_drive(profile)
    samples = _every_tick(drive, duration_s, **controller)
    changed = _with(drive, **controller)
    commands = commands_of(PythonCascade(**plain_numbers(changed)), samples)
    assert np.array_equal(np.array(commands), samples[:, VOLTAGE : VOLTAGE + 2])
    assert initial_cascade_state(pack(changed))[1:] == (None, None)
    assert np.ptp(samples[:, VOLTAGE + 1]) > 0.01


EXTRAS = {
    "setpoint filter": ({"setpoint_filter": 4e-3, "velocity_feedforward": 0.7}, {}),
    "current filter": ({"current_command_filter": 4e-4}, {}),
    "speed filter": ({"speed_filter": 5e-4}, {}),
    "differences": ({"speed_source": "differences", "speed_filter": 4e-4}, {"differences": True}),
    "acceleration": ({"acceleration_feedforward": 2e-3}, {}),
    "derivative": (
        {"position": PositionGains(kp=40.0, ki=3.0, kd=0.2)},
        {"position": (40.0, 3.0, 0.2)},
    ),
    "series": (
        {"form": "series", "position": PositionGains(kp=40.0, ki=0.1, kd=5e-3)},
        {"position": (40.0, 4.0, 0.2)},
    ),
    "no speed loop": (DIRECT, {"position": (32.0, 100.0, 0.8), "speed": None}),
    "all at once": (
        DIRECT
        | {
            "setpoint_filter": 4e-3,
            "acceleration_feedforward": 2e-3,
            "current_command_filter": 2e-4,
            "speed_filter": 3e-4,
            "feedback": "rod",
            "current_limit": 2.0,
        },
        {"position": (32.0, 100.0, 0.8), "speed": None},
    ),
}
ALIKE = (  # keys that the Python cascade has under the same name
    "setpoint_filter",
    "current_command_filter",
    "speed_filter",
    "acceleration_feedforward",
)


@pytest.mark.parametrize("extra", EXTRAS)
def test_each_extra_commands_what_it_does_in_plain_python(extra) -> None:
    """Every command of a run with filters, feedforward, differences, derivative or no speed loop
    is the one of the cascade written in Python, and is not the plain cascade's."""
    keys, told = EXTRAS[extra]
    drive = load_drive("bench")
    samples = _every_tick(drive, 0.3, **keys)
    numbers = plain_numbers(_with(drive, **keys))
    numbers |= {key: value for key, value in keys.items() if key in ALIKE} | told
    commands = np.array(commands_of(PythonCascade(**numbers), samples))
    largest = np.abs(commands[:, 1]).max()
    assert np.abs(commands - samples[:, VOLTAGE : VOLTAGE + 2]).max() < 1e-9 * largest
    plain = np.array(commands_of(PythonCascade(**plain_numbers(drive)), samples))
    assert np.abs(commands - plain).max() > 1e-2 * largest


def _proportional(drive, **changes):
    """The drive with no integral gain, so that u_q is a product of what comes in."""
    return _with(
        drive,
        position=PositionGains(kp=40.0),
        speed=Gains(kp=0.8),
        current=Gains(kp=7.0),
        **changes,
    )


@pytest.mark.parametrize(
    ("key", "step", "full"),
    [
        ("setpoint_filter", "reference", 7.0 * 0.8 * 40.0),
        ("speed_filter", "rotor_velocity_rad_per_s", -7.0 * 0.8),
        ("current_command_filter", "reference", 7.0 * 0.8 * 40.0),
    ],
)
def test_a_filter_answers_a_step_with_one_less_an_exponential(drive, key, step, full) -> None:
    """k ticks after a step the command has gone 1 - exp(-k T / tau) of the way."""
    tau = 3e-3
    filtered = _proportional(drive, **{key: tau})
    state = initial_cascade_state(pack(filtered))
    _step(filtered, state)  # at rest first
    size = 1e-4 if step == "reference" else 0.3
    rise = size / drive.transmission.rod_per_rotor if step == "reference" else size
    for tick in range(1, 100):
        _, u_q = _step(filtered, state, **{step: size})
        gone = 1.0 - math.exp(-tick * 1e-4 / tau)
        assert u_q == pytest.approx(full * rise * gone, rel=1e-9)


def test_differences_give_the_speed_of_the_encoder(drive) -> None:
    """At constant speed the encoder's steps stand for the speed reading, which is not looked at."""
    plain = _proportional(drive)
    steps = _proportional(drive, speed_source="differences")
    state = initial_cascade_state(pack(steps))
    for tick in range(5):
        angle = 2.5 * tick * 1e-4
        one = _step(steps, state, rotor_position_rad=angle, rotor_velocity_rad_per_s=99.0)
    other = _step(
        plain,
        initial_cascade_state(pack(plain)),
        rotor_position_rad=angle,
        rotor_velocity_rad_per_s=2.5,
    )
    assert one == pytest.approx(other, rel=1e-9)


def test_acceleration_feedforward_asks_for_current(drive) -> None:
    """Velocity that grows by a T each tick asks for gain x a more amperes, from the second on."""
    forward = _proportional(drive, acceleration_feedforward=2e-3)
    state = initial_cascade_state(pack(forward))
    for tick in range(4):
        _, u_q = _step(forward, state, velocity=0.3 * tick * 1e-4)
        expected = 7.0 * 2e-3 * 0.3 / drive.transmission.rod_per_rotor if tick else 0.0
        assert u_q == pytest.approx(expected, rel=1e-9)


def test_a_speed_loop_that_is_not_there_has_no_values() -> None:
    """With position_to_current gains of the speed loop and its feedforward are refused by name."""
    flat = drive_to_flat(load_drive("bench")) | {"controller.structure": "position_to_current"}
    with pytest.raises(InputError, match=r"f: controller\.speed\.kp = 0.8, expected 0"):
        drive_from_flat(flat, "f")
    flat |= {"controller.speed.kp": 0.0, "controller.speed.ki": 0.0}
    drive = drive_from_flat(flat, "f")
    assert drive_from_flat(drive_to_flat(drive), "f") == drive
    with pytest.raises(InputError, match=r"controller\.speed_limit = 3, expected none"):
        drive_from_flat(flat | {"controller.speed_limit": 3.0}, "f")
