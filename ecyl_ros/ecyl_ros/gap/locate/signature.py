"""What a gap goes with: a level held, the current, the rotor's angle. Each points to a block."""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import nnls

from ...arrays import FloatArray
from ..replay.evidence import ReplayEvidence, Smoother
from ..replay.replay import Replay

_BEYOND, _AT = 10.0, 3.0  # noise floors: clearly beyond a level, and at it
_HELD = 30  # samples at the level at least, and beyond it in the replay
_PILED = 4.0  # times as many as as near beside the level
_LOWEST = 0.3  # of the largest value: a level below that limits nothing
_ENCODER_HARMONICS, _SCREW_HARMONICS = 4, 6
_STEPS = 16  # of the stroke, each with a slope of its own
_RIDES = 0.6  # share of the rod error that must go with the rotor's angle
_NO_BETTER = 0.6  # times what the encoder's harmonics leave: the screw's explain it no better


def limit_reached(replay: Replay) -> bool:
    """Whether values of current or voltage pile up at a level that the replay goes beyond."""
    simulated = replay.simulate({})
    for index, one in enumerate(replay.signals):
        if one.name not in ("current_q", "voltage_q"):
            continue
        recorded, floor = np.abs(replay.recorded[index]), replay.floor[index]
        known = np.sort(recorded[replay.usable & np.isfinite(recorded)])
        beyond = np.sort(np.abs(simulated[index][replay.usable]))
        if known.size and _piled_up(known, beyond, floor):
            return True
    return False


def _piled_up(recorded: FloatArray, simulated: FloatArray, floor: float) -> bool:
    """Whether many of `recorded` lie at one level that `simulated` goes beyond; both sorted."""
    levels = recorded[recorded >= _LOWEST * recorded[-1]]

    def within(low: FloatArray, high: FloatArray) -> FloatArray:
        return (np.searchsorted(recorded, high) - np.searchsorted(recorded, low)).astype(float)

    width = _AT * floor
    held = within(levels - width, levels + width)
    beside = np.maximum(
        within(levels - 3.0 * width, levels - width), within(levels + width, levels + 3.0 * width)
    )
    higher = recorded.size - np.searchsorted(recorded, levels + width)
    missed = simulated.size - np.searchsorted(simulated, levels + _BEYOND * floor)
    return bool(
        np.any((held >= np.maximum(_HELD, _PILED * beside)) & (held >= higher) & (missed >= _HELD))
    )


def _explained(values: FloatArray, by: list[FloatArray]) -> float:
    """Share of the energy of `values` that a sum of `by` explains, where all are known."""
    known = np.isfinite(values) & np.all(np.isfinite(by), axis=0)
    total = float(values[known] @ values[known])
    if known.sum() <= 2 * len(by) or total <= 0.0:
        return 0.0
    columns = np.column_stack([one[known] for one in by])
    found, *_ = np.linalg.lstsq(columns, values[known], rcond=None)
    rest = values[known] - columns @ found
    return 1.0 - float(rest @ rest) / total


def goes_with_current(evidence: ReplayEvidence) -> float:
    """Share of the missing torque that is in proportion to the current."""
    smooth = Smoother(evidence.time_s)
    return _explained(evidence.torque_nm, [smooth(evidence.current_a)])


def goes_with_current_reading(evidence: ReplayEvidence) -> float:
    """Share of the missing torque that a gain and an offset of the current sensor would make."""
    smooth = Smoother(evidence.time_s)
    current = smooth(evidence.current_a)
    return _explained(evidence.torque_nm, [current, np.ones_like(current)])


def goes_with_acceleration(evidence: ReplayEvidence) -> float:
    """Share of the missing torque that is in proportion to the rotor's acceleration."""
    smooth = Smoother(evidence.time_s)
    return _explained(evidence.torque_nm, [smooth(evidence.rotor_speed_rad_s, 1)])


def goes_with_carried_torque(evidence: ReplayEvidence) -> float:
    """Share of the missing torque that opposes motion in proportion to the torque handed on.

    Friction of gears and screw; the torque is the motor's less what turns the rotor itself.
    """
    smooth = Smoother(evidence.time_s)
    motor = evidence.drive.motor
    speed = smooth(evidence.rotor_speed_rad_s)
    carried = (
        motor.torque_constant * smooth(evidence.current_a)
        - motor.rotor_inertia * smooth(evidence.rotor_speed_rad_s, 1)
        - motor.viscous_friction * speed
    )
    return _explained(evidence.torque_nm, [np.abs(carried) * np.sign(speed)])


def goes_along_stroke(evidence: ReplayEvidence) -> float:
    """Share of the missing torque's variance that only rises, or only falls, along the stroke.

    Springs, stops and whatever else stands beside the rod push back so; what a rotor makes repeats
    with its turn.
    """
    known = np.isfinite(evidence.torque_nm) & np.isfinite(evidence.rotor_angle_rad)
    angle = evidence.rotor_angle_rad[known]
    torque = evidence.torque_nm[known] - np.mean(evidence.torque_nm[known])
    total = float(torque @ torque)
    if known.sum() <= 2 * _STEPS or total <= 0.0:
        return 0.0
    ends = np.linspace(angle.min(), angle.max(), _STEPS + 1)
    ramps = np.clip((angle[:, None] - ends[:-1]) / (ends[1] - ends[0]), 0.0, 1.0)
    ramps -= ramps.mean(axis=0)
    left = min(nnls(ramps, side * torque)[1] for side in (1.0, -1.0))
    return 1.0 - left**2 / total


def goes_with_encoder(evidence: ReplayEvidence, noise_rad: float) -> bool:
    """Whether the rod error repeats with the rotor's angle, and no better with the screw's.

    noise_rad: of the rod error.
    """
    error = evidence.rod_error_rad - np.nanmean(evidence.rod_error_rad)
    angle = evidence.rotor_angle_rad
    one = np.ones_like(angle)

    def waves(turn: FloatArray, count: int) -> list[FloatArray]:
        return [wave(k * turn) for k in range(1, count + 1) for wave in (np.sin, np.cos)]

    screw = angle / evidence.drive.transmission.gear_ratio
    encoder = _explained(error, [one, *waves(angle, _ENCODER_HARMONICS)])
    kinematic = _explained(error, [one, angle, *waves(screw, _SCREW_HARMONICS)])
    turned = float(np.nanmax(angle) - np.nanmin(angle)) > 2.0 * math.pi
    # Noise goes with nothing.
    most = 1.0 - min(1.0, noise_rad**2 / float(np.nanvar(error)))
    return turned and encoder > _RIDES * most and 1.0 - kinematic > _NO_BETTER * (1.0 - encoder)
