"""What every sample of a drive is held against while it plays a motion."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..drive.parameters import DriveParameters, LimitParameters
from ..errors import InputError
from ..plan.healthy import Healthy

# Of the healthy drive's largest tracking error: what no fault that leaves the loops in place comes
# to, and a rod that is held comes to within a few of the loop's time constants.
TIMES_ERROR = 3.0
# Of the controller's current limit: at the limit itself nothing follows any more.
CURRENT_SHARE = 0.95
_SLACK = 1.0 + 1e-6


@dataclass(frozen=True)
class Sample:
    """One sample of the drive: its stamp s; reference m and m/s; rod m; current A (NaN: none)."""

    time_s: float
    reference: float
    velocity: float
    rod: float
    current: float


@dataclass(frozen=True)
class Bounds:
    """limits: of the reference. error_m, current_a: largest that the drive may come to."""

    limits: LimitParameters
    error_m: float
    current_a: float

    def objection(self, one: Sample) -> str | None:
        """What lies beyond the bounds, with the bound; None where nothing does."""
        low, high = self.limits.stroke_min, self.limits.stroke_max
        slack = 1e-6 * (high - low)
        if not low - slack <= one.reference <= high + slack:
            return f"reference of {one.reference:.6g} m, beyond the stroke, {low:g} to {high:g} m"
        if abs(one.velocity) > self.limits.speed * _SLACK:
            return f"reference of {one.velocity:.6g} m/s, beyond {self.limits.speed:g} m/s"
        error = abs(one.reference - one.rod)
        if not error <= self.error_m:
            return f"tracking error of {1e3 * error:.3g} mm, beyond {1e3 * self.error_m:.3g} mm"
        if abs(one.current) > self.current_a:
            return f"current of {abs(one.current):.3g} A, beyond {self.current_a:.3g} A"
        return None


def bounds_for(
    drive: DriveParameters, healthy: Healthy, error_m: float | None, current_a: float | None
) -> Bounds:
    """Bounds of a motion; `error_m` and `current_a` take the place of what follows from the model.

    Raises:
        InputError: a bound that the healthy drive would not keep.
    """
    error = error_m if error_m is not None else TIMES_ERROR * healthy.error_m
    current = current_a if current_a is not None else CURRENT_SHARE * drive.controller.current_limit
    for flag, bound, needed, unit in (
        ("--max-error", error, healthy.error_m, "m"),
        ("--max-current", current, healthy.current_a, "A"),
    ):
        if not (math.isfinite(bound) and bound > needed):
            raise InputError(
                f"{flag} = {bound:g}: the healthy drive needs {needed:.3g} {unit} on this motion; "
                "expected more, or lower --speed or --acceleration"
            )
    return Bounds(drive.limits, error, current)
