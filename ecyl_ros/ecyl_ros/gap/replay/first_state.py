"""In what state a recorded run begins: at rest as asked for, unless the recording says not."""

from __future__ import annotations

import math
from collections.abc import Mapping

from ...arrays import FloatArray
from ...drive.parameters import DriveParameters
from ...drive.plant import initial_state
from .loop_state import loop_integrals


def first_state(
    drive: DriveParameters,
    wanted: tuple[float, float],
    first: Mapping[str, float],
    floors: Mapping[str, float],
) -> tuple[FloatArray, FloatArray | None]:
    """State of the plant, and the integrals of the loops; None for these where it rests.

    wanted: rod position m and velocity m/s asked for. first, floors: first sample and noise floor
    of each recorded signal, SI.
    """
    ratio = drive.transmission.rod_per_rotor
    plant = initial_state()
    asked = wanted[0] / ratio
    angle = first.get("rotor_position", math.nan)
    if math.isnan(angle):
        angle = first.get("rod_position", math.nan) / ratio
    if math.isnan(angle) or abs(angle - asked) < 10.0 * floors.get("rotor_position", 0.0):
        angle = asked
    speed = first.get("rotor_velocity", 0.0)
    current = first.get("current_q", 0.0)
    if not abs(speed) > 6.0 * floors.get("rotor_velocity", 0.0):
        speed = 0.0
    if not abs(current) > 6.0 * floors.get("current_q", 0.0):
        current = 0.0
    voltage = first.get("voltage_q", math.nan)
    if speed == 0.0 and angle == asked and _answered(current, voltage, floors, drive):
        current = 0.0
    plant[0] = plant[2] = angle
    plant[1] = plant[3] = speed
    plant[5] = current
    rod = first.get("rod_position", math.nan) / ratio
    if math.isfinite(rod):
        twist = angle - rod
        half = 0.5 * drive.transmission.backlash
        noise = floors["rod_position"] / ratio
        if abs(twist) > 4.0 * noise and abs(twist) < half + 20.0 * noise:
            plant[2] = angle - math.copysign(min(abs(twist), half), twist)
    if angle == asked and speed == 0.0 and current == 0.0:
        return plant, None
    if math.isnan(voltage):
        voltage = drive.motor.resistance * current + drive.motor.back_emf_constant * speed
    return plant, loop_integrals(
        angle, rod, speed, asked, wanted[1] / ratio, current, voltage, drive
    )


def _answered(
    current: float, voltage: float, floors: Mapping[str, float], drive: DriveParameters
) -> bool:
    """Whether the voltage is the answer of a current loop that has just begun to a current of zero.

    Then the reading is off zero, not the current: to hold one the loop would need its integral,
    and a voltage of the current's own sign.
    """
    if current == 0.0 or math.isnan(voltage):
        return False
    controller = drive.controller
    gains = controller.current
    integral = gains.parallel_ki(controller.form) / controller.rate
    noise = 6.0 * max(floors.get("voltage_q", 0.0), gains.kp * floors.get("current_q", 0.0))
    answer = -gains.kp * current
    more = abs(integral * current) + noise
    return abs(answer) > noise and abs(voltage - answer) <= more
