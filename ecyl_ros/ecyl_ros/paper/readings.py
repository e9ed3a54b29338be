"""The readings of the paper, as drives."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

from ..drive.drive_file import load_drive
from ..drive.parameters import DriveParameters

DAMPING = 1e-4  # N m s/rad in contact; the paper gives none


@dataclass(frozen=True)
class Reading:
    """One way to read the paper: a name, what it means, the drive it gives."""

    key: str
    name: str
    meaning: str
    drive: DriveParameters


def readings() -> tuple[Reading, ...]:
    """As published, as published with a trace of contact damping, and in SI."""
    paper, si = load_drive("paper"), load_drive("si")
    return (
        Reading("published", "as published", "1.89 taken as N m/rad", paper),
        Reading(
            "damped",
            "as published, damped",
            "the same with 1e-4 N m s/rad in contact",
            with_transmission(paper, contact_damping=DAMPING),
        ),
        Reading("si", "in SI", "1.89 N m/arcmin = 6499 N m/rad", si),
    )


def with_transmission(drive: DriveParameters, **values: object) -> DriveParameters:
    """The drive with some values of its transmission changed."""
    return dataclasses.replace(
        drive,
        transmission=dataclasses.replace(drive.transmission, **values),  # type: ignore[arg-type]
    )


def with_controller(drive: DriveParameters, **values: object) -> DriveParameters:
    """The drive with some values of its controller changed."""
    return dataclasses.replace(
        drive,
        controller=dataclasses.replace(drive.controller, **values),  # type: ignore[arg-type]
    )


def with_stiffness(drive: DriveParameters, share: float) -> DriveParameters:
    """All segments times `share`."""
    return with_transmission(
        drive, stiffness=tuple(share * one for one in drive.transmission.stiffness)
    )


def with_clearance(drive: DriveParameters, share: float) -> DriveParameters:
    """The backlash times `share`."""
    return with_transmission(drive, backlash=share * drive.transmission.backlash)


def half_clearance_m(drive: DriveParameters) -> float:
    """Half the backlash, seen at the rod."""
    return 0.5 * drive.transmission.backlash * drive.transmission.rod_per_rotor


def largest_twist_rad(drive: DriveParameters, torque_nm: float) -> float:
    """Relative angle at which the first segment of an undamped flank carries a torque, rad."""
    return 0.5 * drive.transmission.backlash + torque_nm / drive.transmission.stiffness[0]


def swing_hz(drive: DriveParameters, twist_rad: float) -> float:
    """Frequency of the load swinging freely against a rotor that stands still, Hz.

    Half an oscillation on the spring of either flank, the clearance crossed at constant speed in
    between, twice a period: 1/f = 2 pi sqrt(J/C) + 2 alpha / v, v = sqrt(C/J) (twist - alpha/2).
    NaN for a twist that does not reach the flanks.
    """
    clearance = drive.transmission.backlash
    rate = math.sqrt(drive.transmission.stiffness[0] / drive.load.inertia)
    speed = rate * (twist_rad - 0.5 * clearance)
    if speed <= 0.0:
        return math.nan
    return 1.0 / (2.0 * math.pi / rate + 2.0 * clearance / speed)


def swing_twist_rad(drive: DriveParameters, frequency_hz: float) -> float:
    """The twist at which the load swings freely at a frequency, rad: the inverse of `swing_hz`.

    NaN above the frequency of the spring alone.
    """
    clearance = drive.transmission.backlash
    rate = 2.0 * math.pi * spring_hz(drive)
    rest_s = 1.0 / frequency_hz - 2.0 * math.pi / rate
    return 0.5 * clearance + 2.0 * clearance / (rate * rest_s) if rest_s > 0.0 else math.nan


def spring_hz(drive: DriveParameters) -> float:
    """Frequency of the load on the first segment alone, Hz."""
    return math.sqrt(drive.transmission.stiffness[0] / drive.load.inertia) / (2.0 * math.pi)
