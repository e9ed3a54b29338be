"""Between two reference samples: the cubic that meets position and velocity at both.

References are published at the telemetry rate and the cascade runs faster, as in the interpolated
position mode of industrial drives (CiA 402). With velocities given the error is (w h)^4 / 384 of
the amplitude at angular frequency w and sample period h: 4e-12 at 1 Hz and 1 kHz.
"""

from __future__ import annotations

import math

from .compiled import kernel


@kernel
def reference_cubic(before, after, period):
    """The way between two samples `period` s apart: seven coefficients c.

    Position m is c[0] + x (c[1] + x (c[2] + x c[3])), velocity m/s c[4] + x (c[5] + x c[6]), where
    x is the phase, 0 to 1.

    before, after: float64[2], position m and velocity m/s of the neighbouring samples. Where a
    velocity is NaN (a publisher that sends positions only) the line between the positions is used.
    """
    rise = after[0] - before[0]
    if math.isnan(before[1]) or math.isnan(after[1]):
        return before[0], rise, 0.0, 0.0, rise / period, 0.0, 0.0
    start = before[1] * period
    end = after[1] * period
    square = 3.0 * rise - 2.0 * start - end
    cube = start + end - 2.0 * rise
    return (
        before[0],
        start,
        square,
        cube,
        before[1],
        2.0 * square / period,
        3.0 * cube / period,
    )


@kernel
def interpolate_reference(phase, cubic):
    """Return (position m, velocity m/s) at `phase` (0 to 1) along a `reference_cubic`."""
    return (
        cubic[0] + phase * (cubic[1] + phase * (cubic[2] + phase * cubic[3])),
        cubic[4] + phase * (cubic[5] + phase * cubic[6]),
    )
