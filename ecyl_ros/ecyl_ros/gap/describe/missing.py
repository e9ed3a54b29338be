"""The missing quantity: what each balance of the drive leaves over time, with its band.

A balance of measured signals holds whatever the loop does around it: torque on rotor and load
together while the flanks touch, voltage of the winding, rod against rotor. What one leaves, the
constants free within their sheet, is what acts at its ports beyond the model.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.signal import savgol_coeffs

from ...arrays import BoolArray, FloatArray
from ..replay.evidence import Smoother
from ..replay.replay import Replay
from ..sheet import Sheet
from .motion import Motion

TORQUE, VOLTAGE, ROD = "torque", "voltage", "rod"


@dataclass(frozen=True, eq=False)
class Missing:
    """What one balance leaves.

    Attributes:
        balance: TORQUE, VOLTAGE or ROD. unit: of it.
        values: float64[n], smoothed; what the model lacks is positive where it drives (torque,
            voltage) or is read too large (rod, as rotor angle).
        noise: standard deviation of `values` that the sensors' noise makes.
        known: bool[n]; elsewhere it cannot be known.
        rows: int64[m], known ones far enough apart that their noise is independent.
        columns: float64[k, n], what a pull of 1 of each of `pulled` adds to `values`.
        pulled: rows of the sheet.
        growth: float64[k], by what the logarithm of `noise` grows with a pull of 1 of each: larger
            constants make more of the same sensors' noise.
    """

    balance: str
    unit: str
    values: FloatArray
    noise: float
    known: BoolArray
    rows: np.ndarray
    columns: FloatArray
    pulled: tuple[int, ...]
    growth: FloatArray


def _gain(smooth: Smoother, derivative: int = 0) -> float:
    """Standard deviation of the filter's output for white noise of 1."""
    taps = savgol_coeffs(smooth.points, 2, deriv=derivative, delta=smooth.step)
    return float(np.sqrt(np.sum(taps**2)))


def missing(motion: Motion, sheet: Sheet) -> dict[str, Missing]:
    """All balances that the recorded signals allow, by name."""
    replay = motion.replay
    names = [one.name for one in replay.signals]
    floor = dict(zip(names, replay.floor, strict=True))
    moves = "rotor_velocity" in names or "rotor_position" in names
    found = {}
    if moves and "current_q" in names:
        found[TORQUE] = _torque(motion, sheet, floor)
        if "voltage_q" in names:
            found[VOLTAGE] = _voltage(motion, sheet, floor)
    if "rod_position" in names and "rotor_position" in names:
        found[ROD] = _rod(motion, sheet, floor)
    return found


def _torque(motion: Motion, sheet: Sheet, floor: Mapping[str, float]) -> Missing:
    drive, smooth = motion.replay.drive, motion.smooth
    inertia = drive.motor.rotor_inertia + drive.load.inertia
    viscous = drive.motor.viscous_friction + drive.load.viscous_friction
    gain = drive.motor.torque_constant
    values = inertia * motion.acceleration + viscous * motion.speed - gain * motion.current
    per_unit = {
        "motor.rotor_inertia": motion.acceleration,
        "load.inertia": motion.acceleration,
        "motor.viscous_friction": motion.speed,
        "load.viscous_friction": motion.speed,
        "motor.torque_constant": -motion.current,
    }
    of_current = floor["current_q"] * _gain(smooth)
    of_acceleration = _speed_noise(motion.replay, floor) * _gain(smooth, 1)
    squares = {
        "motor.rotor_inertia": inertia * of_acceleration**2,
        "load.inertia": inertia * of_acceleration**2,
        "motor.torque_constant": gain * of_current**2,
    }
    noise = float(np.hypot(gain * of_current, inertia * of_acceleration))
    known = motion.contact & motion.moving & motion.replay.usable
    return _made(TORQUE, "N m", values, noise, known, motion, sheet, per_unit, squares)


def _voltage(motion: Motion, sheet: Sheet, floor: Mapping[str, float]) -> Missing:
    motor, smooth = motion.replay.drive.motor, motion.smooth
    slope = smooth(motion.raw_current, 1)
    values = (
        motor.resistance * motion.current
        + motor.inductance * slope
        + motor.back_emf_constant * motion.speed
        - smooth(motion.voltage)
    )
    per_unit = {
        "motor.resistance": motion.current,
        "motor.inductance": slope,
        "motor.back_emf_constant": motion.speed,
    }
    of_current, of_slope = (floor["current_q"] * _gain(smooth, one) for one in (0, 1))
    noise = math.hypot(
        motor.resistance * of_current,
        motor.inductance * of_slope,
        floor["voltage_q"] * _gain(smooth),
    )
    squares = {
        "motor.resistance": motor.resistance * of_current**2,
        "motor.inductance": motor.inductance * of_slope**2,
    }
    known = motion.replay.usable & ~_shaken(motion)
    return _made(VOLTAGE, "V", values, noise, known, motion, sheet, per_unit, squares)


def _rod(motion: Motion, sheet: Sheet, floor: Mapping[str, float]) -> Missing:
    drive, smooth = motion.replay.drive, motion.smooth
    ratio = drive.transmission.rod_per_rotor
    carried = motion.torque(on_load=False) / drive.transmission.stiffness[0]
    seated = motion.side * 0.5 * drive.transmission.backlash + carried
    values = smooth(motion.load_angle - motion.angle) + seated
    per_unit = {
        "transmission.lead": -motion.load_angle / drive.transmission.lead,
        "transmission.gear_ratio": motion.load_angle / drive.transmission.gear_ratio,
        "transmission.backlash": 0.5 * motion.side,
        "transmission.stiffness": -carried / drive.transmission.stiffness[0],
    }
    of_rod, of_rotor = (floor[one] * _gain(smooth) for one in ("rod_position", "rotor_position"))
    squares = {
        "transmission.lead": -((of_rod / ratio) ** 2) / drive.transmission.lead,
        "transmission.gear_ratio": (of_rod / ratio) ** 2 / drive.transmission.gear_ratio,
    }
    noise = math.hypot(of_rod / ratio, of_rotor)
    known = motion.contact & motion.moving & motion.replay.usable
    return _made(ROD, "rad", values, noise, known, motion, sheet, per_unit, squares)


def _shaken(motion: Motion) -> BoolArray:
    """Where an impact of the flanks lies within the filter's window."""
    moved = np.concatenate([[False], motion.contact[1:] != motion.contact[:-1]])
    near: BoolArray = np.convolve(moved, np.ones(motion.smooth.points), mode="same") > 0.5
    return near


def _speed_noise(replay: Replay, floor: Mapping[str, float]) -> float:
    """Of the speed as `Motion` has it: measured, or the encoder's steps through the filter."""
    if "rotor_velocity" in floor:
        return float(floor["rotor_velocity"])
    return float(floor["rotor_position"]) * _gain(Smoother(replay.time_s), 1)


def _made(
    balance: str,
    unit: str,
    values: FloatArray,
    noise: float,
    known: BoolArray,
    motion: Motion,
    sheet: Sheet,
    per_unit: Mapping[str, FloatArray],
    squares: Mapping[str, float],
) -> Missing:
    """Of a balance, by key of its constants: per_unit, its derivative, float64[n]; squares, half
    the derivative of its noise squared."""
    known = known & np.isfinite(values)
    pulled = [row for row, key in enumerate(sheet.keys) if key in per_unit]
    # A constant above its nominal value takes from what the nominal one leaves.
    columns = [-per_unit[sheet.keys[row]] * sheet.tolerance[row] for row in pulled]
    growth = [squares.get(sheet.keys[row], 0.0) * sheet.tolerance[row] for row in pulled]
    step = max(1, motion.smooth.points // 2)
    rows = np.flatnonzero(known)
    # One row in so many, wherever a known stretch begins.
    rows = rows[np.unique(rows // step, return_index=True)[1]]
    return Missing(
        balance,
        unit,
        values,
        noise,
        known,
        rows,
        np.array(columns).reshape(len(pulled), len(values)),
        tuple(pulled),
        np.array(growth) / noise**2,
    )
