"""What of a recording can be used: outliers, dead signals, a foreign drive file, too long a run."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from scipy.ndimage import median_filter

from ...arrays import FloatArray
from ...drive.parameters import DriveParameters
from ...errors import InputError
from ...recording.signals import Recording

LEAST_SAMPLES = 200
LONGEST_S = 40.0  # a longer recording is judged on its liveliest stretch of this length
_OUTLIER_SHARE = 2.0  # times the range of the rest: impacts of the flanks are spikes, too
_OUTLIERS_AT_MOST = 0.01  # share of samples; more of them are no outliers
_FOREIGN = 2.0  # times the nominal travel of the rod per rotor angle, either way

SCREENED = (
    "rotor_position_rad",
    "rotor_velocity_rad_per_s",
    "current_q_a",
    "voltage_q_v",
    "rod_position_m",
)


def screen(
    recording: Recording, drive: DriveParameters, source: str
) -> tuple[Recording, list[str]]:
    """The recording with unusable values taken out (NaN), and a line on each thing taken out.

    Raises InputError where the drive file plainly belongs to another machine, or there is no
    reference to replay, no signal to compare with, or too little of either.
    """
    _check(recording, source)
    recording, notes = _liveliest(recording)
    changed: dict[str, Any] = {}
    moving = _spread(recording.reference_position_m) > 0.0
    if not moving:
        notes.append("the reference never moves: only what shows at rest can be judged")
    for name in SCREENED:
        values = np.array(recording.signal(name))
        if not np.isfinite(values).any():
            continue
        if moving and _spread(values) == 0.0:
            notes.append(f"{name} is constant, as if not connected: not judged")
            changed[name] = np.full(values.shape, np.nan)
            continue
        lone = _outliers(values)
        if lone.any():
            notes.append(f"{name}: {int(lone.sum())} lone outliers left out")
            values[lone] = np.nan
            changed[name] = values
    if changed:
        recording = dataclasses.replace(recording, **changed)
    _check_ratio(recording, drive, source)
    return recording, notes


def _check(recording: Recording, source: str) -> None:
    if len(recording) < LEAST_SAMPLES:
        raise InputError(
            f"{source}: {len(recording)} samples, expected at least {LEAST_SAMPLES} to diagnose"
        )
    known = np.isfinite(recording.reference_position_m)
    if known.sum() < 0.5 * len(recording):
        raise InputError(
            f"{source}: /ecyl/reference holds {int(known.sum())} of {len(recording)} "
            "positions, expected at least half of them to replay the loop"
        )
    if not any(recording.has(name) for name in SCREENED):
        raise InputError(
            f"{source}: no rotor, rod, current or voltage signal, expected at least one"
        )


def _spread(values: FloatArray) -> float:
    known = values[np.isfinite(values)]
    return float(known.max() - known.min()) if known.size else 0.0


def _liveliest(recording: Recording) -> tuple[Recording, list[str]]:
    """The stretch of up to `LONGEST_S` with most travel and reversals, for long recordings."""
    if recording.duration_s <= LONGEST_S:
        return recording, []
    time = recording.time_s
    reference = recording.reference_position_m
    known = np.isfinite(reference)
    if known.sum() < 3:
        return recording, []
    step = np.diff(np.interp(time, time[known], reference[known]))
    moved = np.concatenate([[0.0], np.cumsum(np.abs(step))])
    turned = np.concatenate([[0.0, 0.0], np.cumsum(np.signbit(step[1:]) != np.signbit(step[:-1]))])
    starts = np.arange(0.0, time[-1] - LONGEST_S + 1e-9, 0.25 * LONGEST_S)
    ends = np.searchsorted(time, starts + LONGEST_S) - 1
    begins = np.searchsorted(time, starts)
    travel = moved[ends] - moved[begins]
    turns = turned[ends] - turned[begins]
    score = travel / max(float(travel.max()), 1e-300) + turns / max(float(turns.max()), 1.0)
    best = float(starts[int(np.argmax(score))])
    note = f"{time[-1]:.0f} s long: judged from {best:.1f} s to {best + LONGEST_S:.1f} s"
    return recording.slice(best, best + LONGEST_S), [note]


def _outliers(values: FloatArray) -> np.ndarray:
    """Lone samples far from both neighbours: bool[n]."""
    filled = np.where(np.isfinite(values), values, np.nanmedian(values))
    low, high = np.nanpercentile(values, [0.5, 99.5])
    away = np.abs(filled - median_filter(filled, 5, mode="nearest"))
    lone = away > _OUTLIER_SHARE * max(float(high - low), 1e-300)
    lone &= np.isfinite(values)
    if not 0.0 < lone.mean() <= _OUTLIERS_AT_MOST:
        lone[:] = False
    return np.asarray(lone)


def _check_ratio(recording: Recording, drive: DriveParameters, source: str) -> None:
    """Refuse a drive file whose rod moves by another order than the recorded one."""
    angle, rod = recording.rotor_position_rad, recording.rod_position_m
    nominal = drive.transmission.rod_per_rotor
    for name, driver, driven, expected in (
        ("rod per rotor angle", angle, rod, nominal),
        ("rotor angle per reference", recording.reference_position_m, angle, 1.0 / nominal),
    ):
        known = np.isfinite(driver) & np.isfinite(driven)
        if known.sum() < 100:
            continue
        x = driver[known] - driver[known].mean()
        y = driven[known] - driven[known].mean()
        power = float(x @ x)
        clearance = drive.transmission.backlash * (nominal if driven is rod else 1.0)
        if power <= 0.0 or np.ptp(driven[known]) < 10.0 * clearance:
            continue
        slope = float(x @ y) / power
        linear = slope * float(x @ y) / max(float(y @ y), 1e-300)
        if linear < 0.9:
            continue
        ratio = slope / expected
        if not 1.0 / _FOREIGN < ratio < _FOREIGN:
            unit = "m/rad" if driven is rod else "rad/m"
            raise InputError(
                f"{source}: {name} is {slope:.4g} {unit}, the drive file's lead and gear ratio "
                f"give {expected:.4g}: it belongs to another machine"
            )
