"""What the healthy drive takes on a motion, and whether that leaves its controller room."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..drive.engine import simulate
from ..drive.parameters import DriveParameters
from ..drive.reference.base import Reference
from ..drive.telemetry import simulation_recording
from ..recording.signals import Recording

LIMIT_SHARE = 0.8  # of current and voltage limit that the healthy drive may take on a motion


def healthy_run(drive: DriveParameters, motion: Reference, duration_s: float) -> Recording:
    """What the drive file's model records on a motion, the noise of its sensors included."""
    rate = drive.sample_rate
    run = simulate(drive, lambda index: motion.sample(index / rate), duration_s)
    return simulation_recording(run, drive)


@dataclass(frozen=True)
class Healthy:
    """Peaks of the healthy drive on a motion: tracking error m, current A, voltage V."""

    error_m: float
    current_a: float
    voltage_v: float

    @classmethod
    def on(cls, drive: DriveParameters, motion: Reference, duration_s: float) -> Healthy:
        """Of the whole motion."""
        return cls.between(healthy_run(drive, motion, duration_s))

    @classmethod
    def between(cls, run: Recording, begin_s: float = 0.0, end_s: float = np.inf) -> Healthy:
        """Of the part of a `healthy_run` from `begin_s` to before `end_s`."""
        rows = (run.time_s >= begin_s) & (run.time_s < end_s)

        def peak(values: np.ndarray) -> float:
            return float(np.nanmax(np.abs(values[rows]), initial=0.0))

        return cls(
            peak(run.reference_position_m - run.rod_position_m),
            peak(run.current_q_a),
            peak(run.voltage_q_v),
        )

    def excess(self, drive: DriveParameters) -> str | None:
        """Which limit of the controller the healthy drive comes too close to, or None."""
        control = drive.controller
        for name, value in (("current_limit", self.current_a), ("voltage_limit", self.voltage_v)):
            most = LIMIT_SHARE * getattr(control, name)
            if not value <= most:
                return f"{value:.3g} of at most {most:.3g}, four fifths of controller.{name}"
        return None
