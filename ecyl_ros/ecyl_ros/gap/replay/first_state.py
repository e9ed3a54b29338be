"""In what state a recorded run begins: at rest as asked for, unless the recording says not."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from ...arrays import FloatArray
from ...drive.parameters import DriveParameters
from ...drive.plant import initial_state
from .loop_state import loop_integrals

_STILL = 0.1  # noise floors of the rod's position: a reference that moves by no more rests


def first_state(
    drive: DriveParameters,
    wanted: tuple[float, float],
    first: Mapping[str, float],
    floors: Mapping[str, float],
    rests: int = 1,
) -> tuple[FloatArray, FloatArray | None]:
    """State of the plant, and the integrals of the loops; None for these where it rests.

    wanted: rod position m and velocity m/s asked for. first, floors: first sample and noise floor
    of each recorded signal, SI. rests: samples that the first rod position is the mean of.
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
        if 4.0 * place_unsure(drive, floors, rests) < abs(twist) < half + 20.0 * noise:
            plant[2] = angle - math.copysign(min(abs(twist), half), twist)
    if angle == asked and speed == 0.0 and current == 0.0:
        return plant, None
    if math.isnan(voltage):
        voltage = drive.motor.resistance * current + drive.motor.back_emf_constant * speed
    return plant, loop_integrals(
        angle, rod, speed, asked, wanted[1] / ratio, current, voltage, drive
    )


def place_unsure(drive: DriveParameters, floors: Mapping[str, float], rests: int) -> float:
    """Standard deviation of the load's place in its clearance at the first sample, rad.

    floors: noise floor of each recorded signal, SI. rests: samples of rest that it is told by.
    """
    anywhere = 0.5 * drive.transmission.backlash / math.sqrt(3.0)
    if "rod_position" not in floors:
        return anywhere
    ratio = drive.transmission.rod_per_rotor
    noise = floors["rod_position"] / ratio
    step = drive.sensors.rod_position_resolution / math.sqrt(12.0) / ratio
    # A step is not averaged away.
    return min(max(noise / math.sqrt(rests), min(step, noise)), anywhere)


def resting(
    reference_m: FloatArray, recorded: Mapping[str, FloatArray], floors: Mapping[str, float]
) -> int:
    """How many samples the recording begins with throughout which nothing moves, 1 or more.

    reference_m: float64[n], asked for. recorded: {signal: float64[n]}, SI.
    """
    moves = ~(np.abs(reference_m - reference_m[0]) <= _STILL * floors.get("rod_position", 0.0))
    for name, values in recorded.items():
        if name == "rod_position":
            moves |= ~np.isfinite(values)
        elif name == "rotor_position":
            moves |= ~(np.abs(values - values[0]) <= 10.0 * floors[name])
        elif name == "rotor_velocity":
            moves |= ~(np.abs(values) <= 6.0 * floors[name])
    moves[0] = False
    return int(np.argmax(moves)) if moves.any() else len(moves)


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
