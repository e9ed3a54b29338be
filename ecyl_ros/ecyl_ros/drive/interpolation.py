"""Between two reference samples: the cubic that meets position and velocity at both.

References are published at the telemetry rate and the cascade runs faster, as in the interpolated
position mode of industrial drives (CiA 402). With velocities given the error is (w h)^4 / 384 of
the amplitude at angular frequency w and sample period h: 4e-12 at 1 Hz and 1 kHz.
"""

from __future__ import annotations

import math

from .compiled import kernel

# float64[CUBIC]: position m as c[0] + x (c[1] + x (c[2] + x c[3])), velocity m/s as
# c[4] + x (c[5] + x c[6]), where x is the phase, 0 to 1.
CUBIC = 7


@kernel
def reference_cubic(before, after, period, cubic):
    """Fill `cubic` (float64[CUBIC]) for the way between two samples `period` s apart.

    before, after: float64[2], position m and velocity m/s of the neighbouring samples. Where a
    velocity is NaN (a publisher that sends positions only) the line between the positions is used.
    """
    rise = after[0] - before[0]
    cubic[0] = before[0]
    if math.isnan(before[1]) or math.isnan(after[1]):
        cubic[1] = rise
        cubic[2] = cubic[3] = cubic[5] = cubic[6] = 0.0
        cubic[4] = rise / period
        return
    start = before[1] * period
    end = after[1] * period
    square = 3.0 * rise - 2.0 * start - end
    cube = start + end - 2.0 * rise
    cubic[1] = start
    cubic[2] = square
    cubic[3] = cube
    cubic[4] = before[1]
    cubic[5] = 2.0 * square / period
    cubic[6] = 3.0 * cube / period


@kernel
def interpolate_reference(phase, cubic):
    """Return (position m, velocity m/s) at `phase` (0 to 1) between the two samples."""
    return (
        cubic[0] + phase * (cubic[1] + phase * (cubic[2] + phase * cubic[3])),
        cubic[4] + phase * (cubic[5] + phase * cubic[6]),
    )
