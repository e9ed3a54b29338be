"""When a gap is there: shares of its energy under conditions of motion, and its lines."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.signal import find_peaks

from ...arrays import BoolArray, FloatArray
from ..diagnosis import ConditionShare

_REVERSAL_S = 0.06  # before and after the speed changes sign
_CROWDED = 10  # parts of a stroke or time within one of which a gap counts as gathered
_LINES = 3


def near_reversal(speed: FloatArray, step_s: float, times: int = 1) -> BoolArray:
    """bool[n], within `times` times 0.06 s of where the speed changes sign."""
    crossing = np.zeros(len(speed), dtype=bool)
    crossing[1:] = np.signbit(speed[1:]) != np.signbit(speed[:-1])
    return widened(crossing, step_s, times)


def widened(where: BoolArray, step_s: float, times: int = 1) -> BoolArray:
    """bool[n], within `times` times 0.06 s of `where`."""
    width = times * max(1, round(_REVERSAL_S / step_s))
    # Not mode="same", whose result is as long as the longer of the two: a live window may be short.
    near: BoolArray = np.convolve(where, np.ones(2 * width + 1))[width : width + len(where)] > 0.0
    return near


def shares(
    energy: FloatArray, masks: Mapping[str, BoolArray], over: Mapping[str, FloatArray]
) -> tuple[ConditionShare, ...]:
    """Shares of the energy, float64[n], under each condition, largest surplus first.

    masks: where each holds, bool[n]. over: what the energy may be gathered over, float64[n].
    """
    total = float(energy.sum())
    found = [
        ConditionShare(name, float(energy[mask].sum()) / total, float(mask.mean()))
        for name, mask in masks.items()
    ]
    found += [_gathered(name, values, energy) for name, values in over.items()]
    found.sort(key=lambda one: one.time_share - one.share)
    return tuple(found)


def _gathered(name: str, over: FloatArray, energy: FloatArray) -> ConditionShare:
    """How much of the energy falls into the tenth of `over`'s range that holds most of it."""
    low, high = float(np.nanmin(over)), float(np.nanmax(over))
    if not high > low:
        return ConditionShare(name, 1.0, 1.0)
    bins = np.clip(((over - low) / (high - low) * _CROWDED).astype(np.int64), 0, _CROWDED - 1)
    gathered = np.bincount(bins, weights=energy, minlength=_CROWDED) / energy.sum()
    best = int(np.argmax(gathered))
    return ConditionShare(name, float(gathered[best]), float(np.mean(bins == best)))


def strongest_lines(frequency: FloatArray, density: FloatArray, least: float) -> tuple[float, ...]:
    """Hz of the highest peaks of a spectrum that stand above `least`, highest first."""
    peaks, _ = find_peaks(np.concatenate([[0.0], density]), height=least)
    peaks = peaks - 1
    peaks = peaks[frequency[peaks] > 0.0]
    order = peaks[np.argsort(-density[peaks])][:_LINES]
    return tuple(float(frequency[row]) for row in order)
