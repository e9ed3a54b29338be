"""The controller's state in the middle of a run, from what was measured."""

from __future__ import annotations

import math

import numpy as np

from ...arrays import FloatArray
from ...drive.parameters import DriveParameters


def loop_integrals(
    angle: float,
    rod: float,
    speed: float,
    wanted: float,
    wanted_speed: float,
    current: float,
    voltage: float,
    drive: DriveParameters,
) -> FloatArray:
    """What the integrals of position, speed and current loop hold, if the current is as wanted.

    Args:
        angle, rod, speed: measured rotor angle and rod position, as rotor angle, rad (the rod's may
            be NaN); rotor speed, rad/s.
        wanted, wanted_speed: reference, as rotor angle rad, and its rate rad/s.
        current, voltage: i_q A, u_q V.
        drive: with its controller.
    """
    controller = drive.controller
    series = controller.form == "series"

    measured = rod if controller.feedback == "rod" and not math.isnan(rod) else angle
    position = controller.position
    derivative = position.kd * (position.kp if series else 1.0) * (wanted_speed - speed)
    asked = position.kp * (wanted - measured) + derivative
    integrals = np.zeros(3)
    if controller.structure == "position_to_current":
        if position.ki > 0.0:
            integrals[0] = (current - asked) / position.parallel_ki(controller.form)
    elif controller.speed.ki > 0.0:
        speed_wanted = asked + controller.velocity_feedforward * wanted_speed
        limit = controller.speed_limit
        speed_wanted = min(max(speed_wanted, -limit), limit)
        proportional = controller.speed.kp * (speed_wanted - speed)
        integrals[1] = (current - proportional) / controller.speed.parallel_ki(controller.form)
    if controller.current.ki > 0.0:
        integrals[2] = voltage / controller.current.parallel_ki(controller.form)
    return integrals
