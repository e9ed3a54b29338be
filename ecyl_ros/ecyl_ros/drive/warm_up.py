"""Compile every kernel once, so that what runs later finds it cached.

`python -m ecyl_ros.drive.warm_up` does it ahead of time.
"""

from __future__ import annotations

import time

import numpy as np

from .cascade import cascade_tick, initial_cascade_state
from .drive_file import load_drive
from .engine import simulate
from .packed import pack
from .parameters import DriveParameters
from .plant import MEASURED, apply_and_measure, apply_voltage, initial_state, measure, voltage_queue


def warm_up(drive: DriveParameters) -> float:
    """Compile (the first time on a machine) or load all kernels; returns the seconds it took."""
    begin = time.perf_counter()
    params = pack(drive)
    plant, pending = initial_state(), voltage_queue(params)
    measured, voltage = np.zeros(len(MEASURED)), np.zeros(2)
    measure(plant, 0, params, measured)
    apply_and_measure(plant, pending, 1, params, measured)
    apply_voltage(plant, pending, params)
    cascade_tick(
        initial_cascade_state(params),
        np.zeros(2),
        np.zeros(2),
        0.0,
        1,
        measured,
        params,
        voltage,
    )
    simulate(drive, lambda index: (0.0, 0.0), 2.0 / drive.controller.rate)
    return time.perf_counter() - begin


if __name__ == "__main__":
    warm_up(load_drive("bench"))
