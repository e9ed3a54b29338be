"""Transmission error: kinematic ripple between screw angle and rod position."""

from __future__ import annotations

import math

import numpy as np

from ..drive.compiled import kernel
from ..drive.parameters import DriveParameters
from .effect import Effect, Evidence, Quantity, Start, phase
from .starts import angular_orders, strongest


def starts(evidence: Evidence) -> list[Start]:
    """The strongest lines of the rod's error over the screw angle; once and twice per turn, too.

    So a screw runs out of true, and over a turn or two of travel that looks much like a slope.
    """
    screw = evidence.rotor_angle_rad / evidence.drive.transmission.gear_ratio
    lines = strongest(
        evidence.rod_error_rad,
        screw,
        angular_orders(screw, 60.0),
        4,
        np.ones_like(screw),
        at=(1.0, 2.0),
    )
    return [
        {"amplitude_rad": size, "periods_per_screw_rev": order, "phase_rad": shift}
        for order, size, shift in lines
    ]


def _period_m(values: Start, drive: DriveParameters) -> float:
    """Travel of the rod in one wave."""
    return drive.transmission.lead / values["periods_per_screw_rev"]


EFFECT = Effect(
    name="transmission_error",
    block="transmission",
    title="kinematic transmission error",
    summary="The rod position has an error that repeats with the screw's turn (runout, pitch "
    "error), while the rotor moves as in the model.",
    excitation="travel over a good part of a screw turn, and a recorded rod position",
    parameters=(
        Quantity(
            name="amplitude_rad", unit="rad", low=0.0, high=10.0, meaning="peak, at the rotor"
        ),
        Quantity(
            name="periods_per_screw_rev", unit="1", low=0.9, high=1e3, meaning="periods per turn"
        ),
        phase("of the sine at screw angle zero"),
    ),
    starts=starts,
    period_m=_period_m,
    one_curve_with=("lead_error",),
)


@kernel
def rod_error(p, angle):
    """A sine of the screw angle."""
    if p.transmission_error_amplitude_rad == 0.0:
        return 0.0
    return p.transmission_error_amplitude_rad * math.sin(
        p.transmission_error_periods_per_screw_rev * angle / p.gear_ratio
        + p.transmission_error_phase_rad
    )
