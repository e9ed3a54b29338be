"""The state in which the twin begins: at rest, or what one sample says of a drive in motion."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray
from ...drive.parameters import DriveParameters
from ...drive.plant import initial_state
from ...drive.stability import closed_loop_matrix
from ..replay.loop_state import loop_integrals

_NEAR = 10.0  # noise standard deviations within which the rod is where it is wanted
_STILL = 6.0  # the same for speed and current that are zero
_SEEN = 4.0
_BEYOND_FLANK = 20.0

_DECAYS = 10.0  # time constants of the slowest pole until a wrong start no longer counts
_SHORTEST_S, _LONGEST_S = 0.3, 15.0


@dataclass(frozen=True)
class State:
    """plant: float64[STATE_SIZE]. integrals: float64[3] of the cascade. voltage: float64[2], V."""

    plant: FloatArray
    integrals: FloatArray
    voltage: FloatArray
    at_rest: bool


def settling_time_s(drive: DriveParameters) -> float:
    """How long a wrong start is to be seen: ten time constants of the slowest closed-loop pole.

    Between 0.3 and 15 s. Integrators that no gain uses (poles at one) do not count.
    """
    slowest = math.inf
    for stiffness in (0.0, *drive.transmission.stiffness):
        radius = np.abs(np.linalg.eigvals(closed_loop_matrix(drive, stiffness)))
        decay = -np.log(np.maximum(radius, 1e-300)) * drive.controller.rate
        # A pole at one comes out of the solver as one but for rounding.
        slowest = min(slowest, float(decay[decay > 1e-4].min(initial=math.inf)))
    return min(max(_DECAYS / slowest, _SHORTEST_S), _LONGEST_S)


def state_from(
    first: Mapping[str, float],
    wanted_m: float,
    wanted_m_per_s: float,
    drive: DriveParameters,
    noise: Mapping[str, float],
) -> State:
    """The state that one sample shows.

    first: signals by their names in `Recording`, NaN where unknown. wanted_m, wanted_m_per_s: the
    reference at that instant. noise: standard deviations by the names of
    `gap.replay.replay.SIGNALS`. What is not measured is taken as it would be on the way the
    reference goes.
    """
    ratio = drive.transmission.rod_per_rotor
    wanted, wanted_speed = wanted_m / ratio, wanted_m_per_s / ratio
    rod = first["rod_position_m"] / ratio
    angle = _first_finite(first["rotor_position_rad"], rod, wanted)
    speed = _first_finite(first["rotor_velocity_rad_per_s"], 0.0)
    current = _first_finite(
        first["current_q_a"], first["rotor_torque_nm"] / drive.motor.torque_constant, 0.0
    )
    near = max(noise["rotor_position"], noise["rod_position"] / ratio)
    at_rest = (
        abs(angle - wanted) <= _NEAR * near
        and abs(speed) <= _STILL * noise["rotor_velocity"]
        and abs(current) <= _STILL * noise["current_q"]
    )
    plant = initial_state()
    plant[0] = plant[2] = wanted if at_rest else angle
    if not math.isnan(rod):
        plant[2] = _load_angle(float(plant[0]), rod, drive, noise["rod_position"] / ratio)
    if at_rest:
        return State(plant, np.zeros(3), np.zeros(2), True)

    if math.isnan(first["rotor_velocity_rad_per_s"]):
        speed = wanted_speed
    if math.isnan(rod) and speed != 0.0:
        # Drag keeps the load behind, at the flank that pushes.
        plant[2] = angle - math.copysign(0.5 * drive.transmission.backlash, speed)
    plant[1] = plant[3] = speed
    plant[4] = _first_finite(first["current_d_a"], 0.0)
    plant[5] = current
    steady = drive.motor.resistance * current + drive.motor.back_emf_constant * speed
    voltage = np.array(
        [_first_finite(first["voltage_d_v"], 0.0), _first_finite(first["voltage_q_v"], steady)]
    )
    return State(
        plant,
        loop_integrals(angle, rod, speed, wanted, wanted_speed, current, float(voltage[1]), drive),
        voltage,
        False,
    )


def _load_angle(angle: float, rod: float, drive: DriveParameters, noise: float) -> float:
    """The load's angle as the rod shows it, within what the clearance allows."""
    twist = angle - rod
    half = 0.5 * drive.transmission.backlash
    if not _SEEN * noise < abs(twist) < half + _BEYOND_FLANK * noise:
        return angle
    return angle - math.copysign(min(abs(twist), half), twist)


def _first_finite(*values: float) -> float:
    return next((value for value in values if math.isfinite(value)), 0.0)
