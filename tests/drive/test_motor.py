"""The motor alone: equations (1) to (4) in closed form."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.drive.motor import current_derivatives, rotor_torque
from ecyl_ros.drive.packed import pack
from ecyl_ros.drive.plant import CURRENT_D, CURRENT_Q, ROTOR_SPEED, STATE_SIZE, plant_step


@pytest.fixture
def free_motor():
    """A rotor far from its flanks, sampled at 1 kHz."""
    drive = load_drive("paper")
    transmission = dataclasses.replace(drive.transmission, backlash=1.0)
    controller = dataclasses.replace(drive.controller, rate=1000.0)
    return dataclasses.replace(drive, transmission=transmission, controller=controller)


def test_voltage_equation_balances(free_motor) -> None:
    """Inserting the derivatives into equation (1) gives back the voltages, cross terms included."""
    p = pack(free_motor)
    i_d, i_q, speed, u_d, u_q = 1.3, -2.1, 40.0, 5.0, -7.0
    slope_d, slope_q = current_derivatives(i_d, i_q, speed, u_d, u_q, p[0])
    motor = free_motor.motor
    electrical = motor.pole_pairs * speed
    r, inductance = motor.resistance, motor.inductance
    back = r * i_q + inductance * slope_q + electrical * inductance * i_d
    assert back + motor.back_emf_constant * speed == pytest.approx(u_q, rel=1e-12)
    assert r * i_d + inductance * slope_d - electrical * inductance * i_q == pytest.approx(u_d)


def test_torque_equation(free_motor) -> None:
    """Equation (2): torque is K_t i_q less viscous drag."""
    p = pack(load_drive("bench"))
    assert rotor_torque(2.0, 10.0, p[0]) == pytest.approx(0.716 * 2.0 - 2.0e-3 * 10.0)


def test_locked_rotor_current_rises_as_equation_4(free_motor) -> None:
    """With the rotor locked, i_q after a voltage step is (u/R)(1 - exp(-R t/L)), equation (4)."""
    motor = dataclasses.replace(free_motor.motor, rotor_inertia=10.0, torque_constant=1e-4)
    p = pack(dataclasses.replace(free_motor, motor=motor), substeps=200)
    state = np.zeros(STATE_SIZE)
    for _ in range(3):
        plant_step(state, 0.0, 10.0, p)
    tau = motor.inductance / motor.resistance
    assert state[CURRENT_Q] == pytest.approx(10.0 / motor.resistance * (1 - np.exp(-3e-3 / tau)))


def test_decoupling_voltage_holds_the_d_current_at_zero(free_motor) -> None:
    """u_d = -w_e L i_q keeps i_d = 0 at constant speed and current, equation (3)."""
    motor = free_motor.motor
    i_q, speed = 3.0, 50.0
    u_d = -motor.pole_pairs * speed * motor.inductance * i_q
    p = pack(free_motor)
    slope_d, _ = current_derivatives(0.0, i_q, speed, u_d, 0.0, p[0])
    assert slope_d == pytest.approx(0.0, abs=1e-9)
    without, _ = current_derivatives(0.0, i_q, speed, 0.0, 0.0, p[0])
    assert abs(without) > 100.0


def test_no_load_speed(free_motor) -> None:
    """A free motor at constant voltage ends at u / K_e, its current at zero."""
    p = pack(free_motor)
    p["pole_pairs"] = 0.0
    state = np.zeros(STATE_SIZE)
    state[2] = 0.0
    for _ in range(5000):
        state[2] = state[0]  # the load stays between the flanks
        plant_step(state, 0.0, 5.0, p)
    assert state[ROTOR_SPEED] == pytest.approx(5.0 / free_motor.motor.back_emf_constant, rel=1e-9)
    assert state[CURRENT_Q] == pytest.approx(0.0, abs=1e-9)
    assert state[CURRENT_D] == 0.0
