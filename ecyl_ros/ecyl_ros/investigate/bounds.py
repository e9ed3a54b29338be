"""What every sample of a drive is held against while it plays a motion."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..drive.engine import simulate
from ..drive.parameters import DriveParameters, LimitParameters
from ..drive.reference.base import Reference
from ..drive.telemetry import simulation_recording
from ..errors import InputError

# Of the healthy drive's largest tracking error: what no fault that leaves the loops in place comes
# to, and a rod that is held comes to within a few of the loop's time constants.
TIMES_ERROR = 3.0
# Of the controller's current limit: at the limit itself nothing follows any more.
CURRENT_SHARE = 0.95
SOUND_SHARE = 0.8  # of current and voltage limit that the healthy drive may take on a motion
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


@dataclass(frozen=True)
class Sound:
    """Peaks of the healthy drive on a motion: tracking error m, current A, voltage V."""

    error_m: float
    current_a: float
    voltage_v: float

    @classmethod
    def on(cls, drive: DriveParameters, motion: Reference, duration_s: float) -> Sound:
        """Of the drive file's model, the noise of its sensors included."""
        rate = drive.sample_rate
        run = simulate(drive, lambda index: motion.sample(index / rate), duration_s)
        shown = simulation_recording(run, drive)

        def peak(values: np.ndarray) -> float:
            return float(np.nanmax(np.abs(values)))

        return cls(
            peak(shown.reference_position_m - shown.rod_position_m),
            peak(shown.current_q_a),
            peak(shown.voltage_q_v),
        )

    def excess(self, drive: DriveParameters) -> str | None:
        """Which limit of the controller the healthy drive comes too close to, or None."""
        control = drive.controller
        for name, value in (("current_limit", self.current_a), ("voltage_limit", self.voltage_v)):
            most = SOUND_SHARE * getattr(control, name)
            if not value <= most:
                return f"{value:.3g} of at most {most:.3g}, four fifths of controller.{name}"
        return None


def bounds_for(
    drive: DriveParameters, sound: Sound, error_m: float | None, current_a: float | None
) -> Bounds:
    """Bounds of a motion; `error_m` and `current_a` take the place of what follows from the model.

    Raises:
        InputError: a bound that the healthy drive would not keep.
    """
    error = error_m if error_m is not None else TIMES_ERROR * sound.error_m
    current = current_a if current_a is not None else CURRENT_SHARE * drive.controller.current_limit
    for flag, bound, needed, unit in (
        ("--max-error", error, sound.error_m, "m"),
        ("--max-current", current, sound.current_a, "A"),
    ):
        if not (math.isfinite(bound) and bound > needed):
            raise InputError(
                f"{flag} = {bound:g}: the healthy drive needs {needed:.3g} {unit} on this motion; "
                "expected more, or lower --speed or --acceleration"
            )
    return Bounds(drive.limits, error, current)
