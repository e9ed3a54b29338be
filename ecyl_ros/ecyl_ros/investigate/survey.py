"""The first motion: a little of everything, before anything is known of the machine."""

from __future__ import annotations

import dataclasses

from ..drive.parameters import DriveParameters, LimitParameters
from ..drive.reference.leg import Leg
from ..drive.reference.planned import Planned
from ..errors import InputError
from ..plan.blocks import Block, check_room, widest
from ..plan.healthy import Healthy
from ..plan.others import moves

_MOVES_SHARE = 0.5  # of the time: moves at the limits; the rest slow, small and tiny
# Reach, of the widest that fits; speed and acceleration, of the limits; rest at the turns, s.
_BLOCKS = ((0.3, 0.25, 0.5, 0.1), (0.1, 0.05, 1.0, 0.0), (0.01, 0.25, 1.0, 0.1))
_LEAST_REACH = 10.0  # in the noise of position: so much of a motion has to be seen
_SOFTER, _TRIES = 0.7, 8


def survey(drive: DriveParameters, duration_s: float) -> tuple[Planned, Healthy]:
    """Moves at the limits, then out and back slower and smaller; and what the healthy drive does.

    Where the healthy drive would come close to its limits of current or voltage, speed and
    acceleration are lowered until it does not.

    Raises:
        InputError: limits that leave no motion.
    """
    check_room(drive.limits)
    limits = drive.limits
    for _ in range(_TRIES):
        motion = _made(limits, duration_s)
        healthy = Healthy.on(drive, motion, duration_s)
        _check_seen(drive, motion)
        excess = healthy.excess(drive)
        if excess is None:
            return motion, healthy
        limits = dataclasses.replace(
            limits, speed=_SOFTER * limits.speed, acceleration=_SOFTER * limits.acceleration
        )
    raise InputError(
        f"limits: no motion leaves the healthy drive room: it takes {excess}; expected lower "
        "limits.speed or limits.acceleration"
    )


def _check_seen(drive: DriveParameters, motion: Planned) -> None:
    """Refuse a motion that drowns in what the sensors make of a drive at rest."""
    sensors = drive.sensors
    noise = max(
        sensors.rod_position_noise,
        sensors.rod_position_resolution,
        drive.transmission.rod_per_rotor
        * max(sensors.rotor_position_noise, sensors.rotor_position_resolution),
    )
    reach = max(abs(leg.to_m) for leg in motion.legs if isinstance(leg, Leg))
    if reach < _LEAST_REACH * noise:
        raise InputError(
            f"limits: motions come to {reach:.3g} m at the most, the sensors' noise and resolution "
            f"to {noise:.3g} m; expected limits.stroke_min, stroke_max and speed to leave a motion "
            f"{_LEAST_REACH:g} times as large"
        )


def _made(limits: LimitParameters, duration_s: float) -> Planned:
    legs = moves(limits, _MOVES_SHARE * duration_s).legs
    reach = widest(limits, duration_s / 8.0)
    for share, speed, acceleration, rest in _BLOCKS:
        block = Block(share * reach, speed * limits.speed, acceleration * limits.acceleration, rest)
        left = (duration_s - Planned(legs, duration_s).moving_s) * 0.5
        more = block.legs(limits, left)
        if Planned((*legs, *more), duration_s).moving_s <= duration_s:
            legs = (*legs, *more)
    if not legs:
        raise InputError(
            f"limits: no move fits {duration_s:.3g} s; expected a longer --duration, or more "
            "speed, acceleration or jerk"
        )
    return Planned(legs, duration_s)
