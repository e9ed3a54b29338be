"""What the effects of wrong gains share: a loop's nominal gains and where fits of true ones begin.

Effects give the parallel form, kp + ki/s, whatever form the drive file has. A loop is named as in
the drive file: position, speed or current.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from ..drive.parameters import DriveParameters, Gains
from .effect import Evidence, Start

_PROPORTIONAL = (0.6, 1.5, 0.3, 2.5, 0.85, 1.15)  # times nominal
_INTEGRAL = (0.4, 2.2, 0.1, 5.0, 0.8, 1.25)
_SHARES = (0.1, 0.3, 0.03, 0.01)  # of kp x crossover, where the nominal integral gain is 0


def gains_of(drive: DriveParameters, loop: str) -> Gains:
    """The nominal gains, in the drive file's form."""
    found: Gains = getattr(drive.controller, loop)
    return found


def proportional(loop: str) -> Callable[[DriveParameters], float]:
    """The nominal kp of a drive."""
    return lambda drive: gains_of(drive, loop).kp


def integral(loop: str) -> Callable[[DriveParameters], float]:
    """The nominal ki of a drive, parallel form."""

    def nominal(drive: DriveParameters) -> float:
        gains = gains_of(drive, loop)
        return gains.kp * gains.ki if drive.controller.form == "series" else gains.ki

    return nominal


def put_proportional(record: np.ndarray, loop: str, kp: float, drive: DriveParameters) -> None:
    """Put a true kp into the record; the series form's integral and derivative go with it.

    An integral gain that another effect gives stays as that one has it.
    """
    record[f"{loop}_kp"] = kp
    if drive.controller.form != "series":
        return
    gains = gains_of(drive, loop)
    if f"{loop}_integral_error" not in drive.effects:
        record[f"{loop}_ki"] = kp * gains.ki
    if loop == "position":
        record["position_kd"] = kp * drive.controller.position.kd


def crossover(drive: DriveParameters, loop: str) -> float:
    """About where the loop's gain is one with rotor and load as one inertia, rad/s."""
    motor, kp = drive.motor, gains_of(drive, loop).kp
    if loop == "current":
        return kp / motor.inductance
    acceleration = kp * motor.torque_constant / (motor.rotor_inertia + drive.load.inertia)
    if loop == "speed":
        return acceleration
    if drive.controller.structure == "position_to_current":
        return math.sqrt(acceleration)
    return kp


def proportional_starts(parameter: str, loop: str) -> Callable[[Evidence], Sequence[Start]]:
    """Multiples of the nominal kp; none for a loop that is not there."""

    def starts(evidence: Evidence) -> Sequence[Start]:
        nominal = gains_of(evidence.drive, loop).kp
        return [{parameter: nominal * factor} for factor in _PROPORTIONAL if nominal > 0.0]

    return starts


def integral_starts(parameter: str, loop: str) -> Callable[[Evidence], Sequence[Start]]:
    """Multiples of the nominal ki, or shares of what would cross over with kp where it is 0."""
    nominal_of = integral(loop)

    def starts(evidence: Evidence) -> Sequence[Start]:
        nominal = nominal_of(evidence.drive)
        if nominal > 0.0:
            return [{parameter: nominal * factor} for factor in _INTEGRAL]
        largest = gains_of(evidence.drive, loop).kp * crossover(evidence.drive, loop)
        return [{parameter: largest * share} for share in _SHARES if largest > 0.0]

    return starts
