"""The sampled cascade: PI forms, limits, anti-windup, feedback."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from ecyl_ros.drive.cascade import cascade_step, initial_cascade_state
from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.drive.packed import pack
from ecyl_ros.drive.parameters import Gains
from ecyl_ros.drive.plant import MEASURED


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
    return _with(load_drive("bench"), position=Gains(kp=40.0, ki=5.0))


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
            loop: Gains(kp=gains.kp, ki=gains.kp * gains.ki)
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
