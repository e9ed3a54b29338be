"""The drive's closed loop in continuous time, as a right-hand side for scipy's solvers.

Written in plain Python, as one writes it for scipy, and apart from the engine's own code. It covers
drives without limits, feedforward, delay, friction, contact damping and sensor noise, closed on the
rotor with parallel PI gains: profile `paper`.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from ecyl_ros.drive.parameters import DriveParameters
from ecyl_ros.drive.reference.sine import Sine

STATES = 9  # rotor angle, speed; load angle, speed; i_d, i_q; integrals of the three loops' errors
ROTOR_ANGLE, LOAD_ANGLE = 0, 2


def closed_loop(drive: DriveParameters, sine: Sine) -> Callable[[float, np.ndarray], np.ndarray]:
    """dy/dt of the drive following `sine` at the rod."""
    motor, transmission, controller = drive.motor, drive.transmission, drive.controller
    resistance, inductance, pole_pairs = motor.resistance, motor.inductance, motor.pole_pairs
    torque_constant, back_emf = motor.torque_constant, motor.back_emf_constant
    rotor_inertia, load_inertia = motor.rotor_inertia, drive.load.inertia
    half_backlash = transmission.backlash / 2
    soft, hard = transmission.stiffness
    torque_2 = transmission.stiffness_breaks[0]
    overlap_2 = torque_2 / soft
    amplitude = sine.amplitude / transmission.rod_per_rotor
    omega = 2 * math.pi * sine.frequency
    position_kp, position_ki = controller.position.kp, controller.position.ki
    speed_kp, speed_ki = controller.speed.kp, controller.speed.ki
    current_kp, current_ki = controller.current.kp, controller.current.ki

    def slopes(time_s, y):
        rotor, speed, load, load_speed, i_d, i_q, position_sum, speed_sum, current_sum = y
        overlap = abs(rotor - load) - half_backlash
        if overlap <= 0:
            torque = 0.0
        elif overlap <= overlap_2:
            torque = soft * overlap
        else:
            torque = torque_2 + hard * (overlap - overlap_2)
        if rotor < load:
            torque = -torque
        position_error = amplitude * math.sin(omega * time_s) - rotor
        speed_error = position_kp * position_error + position_ki * position_sum - speed
        current_error = speed_kp * speed_error + speed_ki * speed_sum - i_q
        u_q = current_kp * current_error + current_ki * current_sum
        u_d = -pole_pairs * speed * inductance * i_q
        cross = pole_pairs * speed * inductance
        return np.array(
            [
                speed,
                (torque_constant * i_q - torque) / rotor_inertia,
                load_speed,
                torque / load_inertia,
                (u_d - resistance * i_d + cross * i_q) / inductance,
                (u_q - resistance * i_q - cross * i_d - back_emf * speed) / inductance,
                position_error,
                speed_error,
                current_error,
            ]
        )

    return slopes
