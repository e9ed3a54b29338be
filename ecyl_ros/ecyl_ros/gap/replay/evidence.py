"""What a recording shows beside a replay, in the terms effects look for their starts in.

Torque balance of rotor and load together, J dw/dt + B w - K_t i, from recorded and from replayed
signals alike, through the same filter: the difference is torque that the model does not explain,
while the flanks are in contact.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import savgol_coeffs, savgol_filter

from ...arrays import BoolArray, FloatArray
from ...drive.engine import LOAD
from ...drive.parameters import DriveParameters
from ...effects.passed import Passed
from .replay import SIGNALS, Effects, Replay

_WINDOW_S = 0.02
_ORDER = 2
_FREQUENCIES = 257


@dataclass(frozen=True)
class ReplayEvidence:
    """See `effects.effect.Evidence`."""

    drive: DriveParameters
    time_s: FloatArray
    rotor_angle_rad: FloatArray
    rotor_speed_rad_s: FloatArray
    current_a: FloatArray
    voltage_v: FloatArray
    torque_nm: FloatArray
    torque_over_angle: Passed
    current_error_a: FloatArray
    rotor_speed_error_rad_s: FloatArray
    rod_error_rad: FloatArray


class Smoother:
    """Savitzky-Golay value and derivative on the recording's (nearly even) samples."""

    def __init__(self, time_s: FloatArray) -> None:
        self.step = float(np.median(np.diff(time_s)))
        points = max(5, 2 * round(0.5 * _WINDOW_S / self.step) + 1)
        self.points = min(points, 2 * ((len(time_s) - 1) // 2) - 1)

    def __call__(self, values: FloatArray, derivative: int = 0) -> FloatArray:
        filled = values
        bad = ~np.isfinite(values)
        if bad.any() and not bad.all():
            rows = np.arange(len(values))
            filled = np.interp(rows, rows[~bad], values[~bad])
        smooth: FloatArray = savgol_filter(
            filled, self.points, _ORDER, deriv=derivative, delta=self.step
        )
        return smooth

    @property
    def response(self) -> FloatArray:
        """Share of a sine's value that is left, float64[m], from 0 Hz to half the sampling rate."""
        turns = np.linspace(0.0, np.pi, _FREQUENCIES)
        index = np.arange(self.points) - self.points // 2
        left: FloatArray = np.cos(np.outer(turns, index)) @ savgol_coeffs(self.points, _ORDER)
        return left


def _balance(
    drive: DriveParameters, smooth: Smoother, speed: FloatArray, current: FloatArray
) -> FloatArray:
    inertia = drive.motor.rotor_inertia + drive.load.inertia
    viscous = drive.motor.viscous_friction + drive.load.viscous_friction
    return (
        inertia * smooth(speed, 1)
        + viscous * smooth(speed)
        - drive.motor.torque_constant * smooth(current)
    )


def in_contact(replay: Replay, columns: FloatArray) -> BoolArray:
    """Where the replay's flanks touch, and have for a filter's window: bool[n]."""
    smooth = Smoother(replay.time_s)
    angle = columns[next(one.column for one in SIGNALS if one.name == "rotor_position")]
    apart = np.abs(angle - columns[LOAD]) < 0.5 * replay.drive.transmission.backlash
    near = np.convolve(apart.astype(float), np.ones(smooth.points), mode="same") > 0.5
    return ~near


def _unexplained(
    replay: Replay, columns: FloatArray, speed: FloatArray, current: FloatArray
) -> FloatArray:
    """Torque that recorded speed and current show beyond a replay; NaN with the flanks apart."""
    smooth = Smoother(replay.time_s)
    simulated = {one.name: columns[one.column] for one in SIGNALS}
    torque = _balance(replay.drive, smooth, speed, current)
    torque = torque - _balance(
        replay.drive, smooth, simulated["rotor_velocity"], simulated["current_q"]
    )
    known: FloatArray = np.where(in_contact(replay, columns) & replay.usable, torque, np.nan)
    return known


def missing_torque(replay: Replay, columns: FloatArray) -> FloatArray:
    """Torque on rotor and load together that a replay leaves unexplained, N m: float64[n].

    columns: of the replay, of a recording with rotor speed and current. Straight lines where the
    flanks are apart, 0 where they never touch.
    """
    recorded = dict(zip((one.name for one in replay.signals), replay.recorded, strict=True))
    torque = _unexplained(replay, columns, recorded["rotor_velocity"], recorded["current_q"])
    known = np.flatnonzero(np.isfinite(torque))
    if not known.size:
        return np.zeros(len(torque))
    filled: FloatArray = np.interp(np.arange(len(torque)), known, torque[known])
    return filled


def gather(replay: Replay, effects: Effects) -> ReplayEvidence:
    """Evidence on what the nominal drive with `effects` leaves unexplained."""
    columns = replay.full(effects)
    simulated = {one.name: columns[one.column] for one in SIGNALS}
    nothing = np.full(len(replay.time_s), np.nan)
    recorded = {one.name: nothing for one in SIGNALS}
    recorded |= {
        one.name: values for one, values in zip(replay.signals, replay.recorded, strict=True)
    }
    smooth = Smoother(replay.time_s)
    if np.isnan(recorded["rotor_velocity"]).all() and replay.recording.has("rotor_position_rad"):
        recorded["rotor_velocity"] = smooth(recorded["rotor_position"], 1)
    drive = replay.drive
    torque = nothing
    if not (np.isnan(recorded["current_q"]).all() or np.isnan(recorded["rotor_velocity"]).all()):
        torque = _unexplained(replay, columns, recorded["rotor_velocity"], recorded["current_q"])
    ratio = drive.transmission.rod_per_rotor
    rod = recorded["rod_position"] / ratio - recorded["rotor_position"]
    rod = rod - (simulated["rod_position"] / ratio - simulated["rotor_position"])
    angle = recorded["rotor_position"]
    if np.isnan(angle).all():
        angle = simulated["rotor_position"]
    speed = recorded["rotor_velocity"]
    if np.isnan(speed).all():
        speed = simulated["rotor_velocity"]
    return ReplayEvidence(
        drive,
        replay.time_s,
        angle,
        speed,
        recorded["current_q"],
        recorded["voltage_q"],
        torque,
        Passed(smooth(speed), smooth.step, smooth.response),
        np.where(replay.usable, recorded["current_q"] - simulated["current_q"], np.nan),
        np.where(replay.usable, speed - simulated["rotor_velocity"], np.nan),
        rod,
    )
