"""Table 1 of the paper and the rest of what its section 3 says of the bench, in SI units."""

from __future__ import annotations

import dataclasses

from ...drive.drive_file import load_drive
from ...drive.parameters import DriveParameters
from .units import ARCMIN, ARCSEC

K1 = 14.725 * ARCMIN  # rad / (N m)
K2 = 0.529 * ARCMIN
K3 = 0.348 * ARCMIN
T1 = 1.491  # N m
T2 = 17.23
CLEARANCE = 20.15 * ARCMIN  # rad, total, as section 3.3 and Table 2 have it
RATED_TORQUE = 50.0  # N m; 3 % of it is the T1 of Table 1
RATED_SHARE = 0.03
SHAFT_TWIST = 0.94 * ARCSEC  # rad at RATED_TORQUE, input gear to angle sensor (section 3.2)
SHAFT_TWIST_LARGEST = 1.362 * ARCSEC  # rad, input gear to the far end of the shaft


def table_1_drive() -> DriveParameters:
    """Profile `si` with the transmission that Table 1 describes as it stands.

    The first line, 14.7 arcmin/(N m) up to T1, is no dead zone: the measured clearance has a slope.
    So there is a soft first segment in place of the backlash.
    """
    drive = load_drive("si")
    transmission = dataclasses.replace(
        drive.transmission,
        backlash=0.0,
        stiffness=(1.0 / K1, 1.0 / K2, 1.0 / K3),
        stiffness_breaks=(T1, T2),
    )
    return dataclasses.replace(drive, transmission=transmission)
