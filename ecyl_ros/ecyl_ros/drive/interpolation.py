"""Between two reference samples: the cubic that meets position and velocity at both.

References are published at the telemetry rate and the cascade runs faster, as in the interpolated
position mode of industrial drives (CiA 402). With velocities given the error is (w h)^4 / 384 of
the amplitude at angular frequency w and sample period h: 4e-12 at 1 Hz and 1 kHz.
"""

from __future__ import annotations

import math

from .compiled import kernel


@kernel
def interpolate_reference(phase, period, before, after, out):
    """Fill `out` (float64[2]: m, m/s) at `phase` (0 to 1) between two samples `period` s apart.

    before, after: float64[2], position m and velocity m/s of the neighbouring samples. Where a
    velocity is NaN (a publisher that sends positions only) the line between the positions is used.
    """
    if phase == 0.0:
        out[0] = before[0]
        out[1] = before[1] if not math.isnan(before[1]) else (after[0] - before[0]) / period
        return
    rise = after[0] - before[0]
    if math.isnan(before[1]) or math.isnan(after[1]):
        out[0] = before[0] + phase * rise
        out[1] = rise / period
        return
    start = before[1] * period
    end = after[1] * period
    square = 3.0 * rise - 2.0 * start - end
    cube = start + end - 2.0 * rise
    out[0] = before[0] + phase * (start + phase * (square + phase * cube))
    out[1] = (start + phase * (2.0 * square + phase * 3.0 * cube)) / period
