"""The controller of a rigid drive's file, one tick at a time.

    u = kp_v (kp_p (r - q) + f dr/dt - dq/dt) + ki_v x integral of that error

held to the limit; the integral rests while the limit acts. A loop without a position gain follows
the reference speed. Where no speed was recorded it is the backward difference of the mean of two
samples, as encoders are commonly read.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...arrays import FloatArray
from ..compiled import kernel
from .machine import Machine


class Gains(NamedTuple):
    """Of the loop, its effort in the unit that the balance is in.

    speed_ki per travel, `command_limit` inf where there is none.
    """

    position_kp: float
    speed_kp: float
    speed_ki: float
    feedforward: float
    command_limit: float


def gains_of(machine: Machine) -> Gains:
    """The loop of a drive file that has one."""
    factor = machine.gain or 1.0
    limit = math.inf if machine.command_limit is None else machine.command_limit
    return Gains(
        position_kp=machine.position_kp or 0.0,
        speed_kp=factor * (machine.speed_kp or 0.0),
        speed_ki=factor * machine.speed_ki,
        feedforward=machine.feedforward,
        command_limit=factor * limit,
    )


@kernel
def ask(gains, reference, wanted, position, speed, integral, period):
    """Effort asked for, and the integral after a tick of `period` s; NaN where an input is."""
    error = wanted - speed
    if gains.position_kp > 0.0:
        error = gains.position_kp * (reference - position) + gains.feedforward * wanted - speed
    summed = integral + error * period
    command = gains.speed_kp * error + gains.speed_ki * summed
    limit = gains.command_limit
    if abs(command) > limit:
        return math.copysign(limit, command), integral
    return command, summed if summed == summed else integral


@kernel
def _along(gains, reference, wanted, position, speed, period, out):
    integral = 0.0
    for index in range(out.shape[0]):
        out[index], integral = ask(
            gains, reference[index], wanted[index], position[index], speed[index], integral, period
        )


def asked_along(
    machine: Machine,
    reference: FloatArray,
    wanted: FloatArray,
    position: FloatArray,
    speed: FloatArray,
    rate_hz: float,
) -> FloatArray:
    """What the loop asks for along a recorded motion, late by its delay; all float64[n].

    wanted: reference speed. speed: NaN throughout where it was not recorded.
    """
    if not np.isfinite(speed).any():
        speed = np.empty_like(position)
        speed[2:] = 0.5 * rate_hz * (position[2:] - position[:-2])
        speed[:2] = speed[2]
    made = np.empty_like(position)
    wanted = reference_speed(machine, reference, wanted, rate_hz)
    _along(gains_of(machine), reference, wanted, position, speed, 1.0 / rate_hz, made)
    late = round(machine.delay_s * rate_hz)
    return np.concatenate([np.full(late, np.nan), made[: made.size - late]]) if late else made


def reference_speed(
    machine: Machine, reference: FloatArray, wanted: FloatArray, rate_hz: float
) -> FloatArray:
    """What was recorded, else the slope of the reference position where that is what is followed.

    Nought where nothing feeds it forward, so that a gap in it cannot matter.
    """
    if not machine.position_kp:
        return wanted
    if not machine.feedforward:
        return np.zeros_like(reference)
    slope = np.gradient(reference, 1.0 / rate_hz)
    return np.where(np.isfinite(wanted), wanted, slope)
