"""Whether a recorded drive holds i_d at 0 by a loop, or leaves what decoupling alone leaves.

The paper's controller has no loop for i_d: its voltage u_d takes away what turns i_q into the
other axis, a tick or a delay late, and leaves some i_d. Drives have a loop: then i_d is next to
nothing, whatever the rest of the drive does, and what is read of it is noise.
"""

from __future__ import annotations

import math

import numpy as np

from ...arrays import BoolArray, FloatArray
from ...drive.parameters import DriveParameters
from ...recording.signals import Recording
from ...typical import typical_rms

_SHARE = 0.5  # of what a loop would make of the noise of i_d: less in u_d, and there is none
_ROUNDED = 1e-6  # of u_d: by so much the same product may differ


def has_d_loop(recording: Recording, drive: DriveParameters) -> bool | None:
    """Whether u_d holds more than the decoupling of what was read; None where it is not recorded.

    A loop answers the noise of i_d by its gain, which is taken to be that of the loop of i_q, and
    at all times: samples at which the voltage was held count for no more than their number.
    """
    voltage, read = recording.voltage_d_v, recording.current_d_a
    turned = recording.rotor_velocity_rad_per_s * recording.current_q_a
    known = np.isfinite(voltage) & np.isfinite(turned) & np.isfinite(read)
    if known.sum() < 3 or not turned[known].any():
        return None
    voltage, turned, read = voltage[known], turned[known], read[known]
    beyond = typical_rms(voltage - _ratio(voltage, turned) * turned)
    noise = typical_rms(np.diff(read, 2)) / math.sqrt(6.0)
    return beyond > max(
        _SHARE * drive.controller.current.kp * noise, _ROUNDED * float(np.std(voltage))
    )


def _ratio(voltage: FloatArray, turned: FloatArray) -> float:
    """By which `turned` comes nearest to `voltage`: the median of their ratios, weighed by what
    each says (least absolute deviations)."""
    moving = turned != 0.0
    ratios, weights = voltage[moving] / turned[moving], np.abs(turned[moving])
    order = np.argsort(ratios)
    said = np.cumsum(weights[order])
    return float(ratios[order][np.searchsorted(said, 0.5 * said[-1])])


def follows(read: FloatArray, left: FloatArray, usable: BoolArray) -> bool:
    """Whether a recorded i_d is nearer to what decoupling leaves, float64[n], than to nothing."""
    known = np.isfinite(read) & usable
    return bool(read[known] @ left[known] >= 0.5 * (left[known] @ left[known]))
