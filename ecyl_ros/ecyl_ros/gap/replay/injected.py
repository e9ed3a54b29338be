"""A force or torque that was put on the drive on purpose and recorded, as the replay takes it."""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray
from ...drive.parameters import DriveParameters
from ...recording.signals import Recording


def injected(recording: Recording, drive: DriveParameters) -> tuple[FloatArray, FloatArray] | None:
    """Times float64[n] in s from the first stamp, and torque float64[2, n] on rotor and load, N m.

    A force on the rod, positive in its forward direction, acts on the load. Straight lines where a
    sample is missing, none before the first and after the last. None where nothing was injected.
    """
    torque = np.zeros((2, len(recording)))
    given = (
        (0, "injected_torque_nm", 1.0),
        (1, "injected_force_n", drive.transmission.rod_per_rotor),
    )
    for side, name, per in given:
        values = recording.signal(name)
        known = np.isfinite(values)
        if known.any():
            time = recording.time_s
            torque[side] = per * np.interp(time, time[known], values[known], 0.0, 0.0)
    return (np.asarray(recording.time_s), torque) if torque.any() else None
