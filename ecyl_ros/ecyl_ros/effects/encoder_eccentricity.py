"""Eccentric encoder disc: the angle errs once per rotor revolution."""

from __future__ import annotations

import math

from ..drive.compiled import kernel
from .effect import Effect, Evidence, Quantity, Start, phase


def starts(evidence: Evidence) -> list[Start]:
    """Small: the response is close to linear in size and phase."""
    return [{"amplitude_rad": 0.01, "phase_rad": 0.0}]


EFFECT = Effect(
    name="encoder_eccentricity",
    block="sensor",
    title="encoder eccentricity",
    summary="The encoder's angle and speed have an error with one period per rotor turn; the loop "
    "makes the rotor follow the error, and the rod shows it.",
    excitation="travel over a good part of a rotor turn, and a recorded rod position",
    parameters=(
        Quantity(name="amplitude_rad", unit="rad", low=0.0, high=1.0, meaning="peak angle error"),
        phase("of the sine at rotor angle zero"),
    ),
    starts=starts,
)


@kernel
def rotor_angle_error(p, angle):
    """A sine of the rotor angle."""
    if p.encoder_eccentricity_amplitude_rad == 0.0:
        return 0.0
    return p.encoder_eccentricity_amplitude_rad * math.sin(angle + p.encoder_eccentricity_phase_rad)


@kernel
def rotor_speed_error(p, angle, speed):
    """The rate of the angle's error."""
    if p.encoder_eccentricity_amplitude_rad == 0.0:
        return 0.0
    return (
        p.encoder_eccentricity_amplitude_rad
        * speed
        * math.cos(angle + p.encoder_eccentricity_phase_rad)
    )
