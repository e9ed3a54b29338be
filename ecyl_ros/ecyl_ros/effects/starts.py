"""Where fits begin: multiples of the nominal value, regressions and lines of periodic effects."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from .effect import Evidence, FloatArray, Start


def multiples(
    parameter: str, nominal: Callable[[Evidence], float], factors: Sequence[float]
) -> Callable[[Evidence], Sequence[Start]]:
    """Starts at `factors` times what the nominal model has."""

    def starts(evidence: Evidence) -> Sequence[Start]:
        return [{parameter: nominal(evidence) * factor} for factor in factors]

    return starts


def regress(signal: FloatArray, *columns: FloatArray) -> FloatArray:
    """Least-squares coefficients of `signal` on `columns` over the rows that are finite in all.

    Zeros where there are too few rows to say.
    """
    rows = np.isfinite(signal)
    for column in columns:
        rows &= np.isfinite(column)
    if rows.sum() < 10 * len(columns):
        return np.zeros(len(columns))
    matrix = np.column_stack([column[rows] for column in columns])
    return np.asarray(np.linalg.lstsq(matrix, signal[rows], rcond=None)[0], dtype=np.float64)


def direction(evidence: Evidence) -> FloatArray:
    """Sign of the rotor's speed, NaN where it is too slow to say."""
    speed = evidence.rotor_speed_rad_s
    slow = np.abs(speed) < 0.02 * float(np.nanmax(np.abs(speed), initial=0.0))
    return np.where(slow, np.nan, np.sign(speed))


def strongest(
    signal: FloatArray, angle: FloatArray, candidates: FloatArray, count: int, gain: FloatArray
) -> list[tuple[float, float, float]]:
    """The `count` best lines gain x A sin(candidate x angle + phase) in `signal`.

    Returns (candidate, A, phase rad) with the best first: local maxima of the variance that a
    line at the candidate explains beside a constant and a slope.
    """
    rows = np.isfinite(signal) & np.isfinite(angle) & np.isfinite(gain)
    if rows.sum() < 50:
        return []
    y, x, g = signal[rows], angle[rows], gain[rows]
    stride = max(1, len(y) // 4000)
    y, x, g = y[::stride], x[::stride], g[::stride]
    trend = np.column_stack([np.ones_like(x), x])
    base, *_ = np.linalg.qr(trend)
    y = y - base @ (base.T @ y)
    found = np.zeros((len(candidates), 3))
    for row, candidate in enumerate(candidates):
        pair = np.column_stack([g * np.sin(candidate * x), g * np.cos(candidate * x)])
        pair -= base @ (base.T @ pair)
        gram = pair.T @ pair + 1e-12 * np.eye(2) * max(1e-30, float((pair**2).sum()))
        sine, cosine = np.linalg.solve(gram, pair.T @ y)
        fit = pair @ np.array([sine, cosine])
        # A line that is hardly more than a slope over the angles seen gets an absurd amplitude.
        sound = math.hypot(sine, cosine) * float(np.sqrt(np.mean(g**2))) < 5.0 * float(np.std(y))
        found[row] = (float(fit @ y) if sound else 0.0, math.hypot(sine, cosine), 0.0)
        found[row, 2] = math.atan2(cosine, sine)
    score = found[:, 0]
    peaks = [
        row
        for row in range(len(score))
        if score[row] > 0.0 and score[row] == score[max(0, row - 2) : row + 3].max()
    ]
    peaks.sort(key=lambda row: -score[row])
    return [
        (float(candidates[row]), float(found[row, 1]), float(found[row, 2]))
        for row in peaks[:count]
    ]


def angular_orders(angle: FloatArray, highest: float) -> FloatArray:
    """Orders (periods per revolution of `angle`) worth trying, as finely as its travel resolves."""
    travel = float(np.nanmax(angle) - np.nanmin(angle)) if np.isfinite(angle).any() else 0.0
    step = min(0.5, max(0.05, 0.25 * 2.0 * math.pi / max(travel, 1e-9)))
    return np.arange(1.0, highest + step, step)
