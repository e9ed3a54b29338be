"""Where fits begin: multiples of the nominal value, regressions and lines of periodic effects."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from ..arrays import FloatArray
from .effect import Evidence, Start
from .lines import explained
from .passed import Passed

_DIGITS = 1e-9  # relative: values this near are equal
_STAYS = 5  # samples that follow an equal one, from which a command is cut off
_BY_CHANCE = 0.02  # of them, of those near the largest, where a log is fine
_FINER = 25  # steps between a candidate and its neighbour when a line is placed
_HIGHEST_HZ = 150.0  # of lines over time
_HIGHEST_ORDER, _LINES, _WHOLE = 96.0, 4, 2  # over a rotor turn: orders, lines of any and of whole


def multiples(
    parameter: str, nominal: Callable[[Evidence], float], factors: Sequence[float]
) -> Callable[[Evidence], Sequence[Start]]:
    """Starts at `factors` times what the nominal model has."""

    def starts(evidence: Evidence) -> Sequence[Start]:
        return [{parameter: nominal(evidence) * factor} for factor in factors]

    return starts


def delays(parameter: str) -> Callable[[Evidence], Sequence[Start]]:
    """Starts in control ticks, the first so small that it still acts in proportion.

    Whole ticks among them: between two, the current is sampled where it stands for the mean of a
    tick less well, and a fit would have to climb to get from one to the next.
    """
    return multiples(
        parameter,
        lambda evidence: 1.0 / evidence.drive.controller.rate,
        (0.2, 1.5, 1.0, 2.0, 3.5, 6.0),
    )


def limits(parameter: str, values: FloatArray) -> list[Start]:
    """Starts of a limit that acts: it shows itself as the largest of `values`, float64[n]."""
    largest = float(np.nanmax(np.abs(values), initial=0.0))
    return [{parameter: largest * factor} for factor in (1.0, 0.97, 0.9) if largest > 0.0]


def plateau(values: FloatArray) -> float | None:
    """Where a command is cut off: its largest value, if it stays there to the last digit.

    values: float64[n]; a command has no noise. None where it does not, or where a coarse log lets
    any command stay.
    """
    sizes = np.abs(values[np.isfinite(values)])
    top = float(np.max(sizes, initial=0.0))
    if top == 0.0:
        return None
    at = sizes >= top * (1.0 - _DIGITS)
    stays = at[1:] & at[:-1]
    near = ~at & (sizes > 0.5 * top)
    coarse = near[1:] & near[:-1] & (np.diff(sizes) == 0.0)
    few = int(np.count_nonzero(coarse)) <= _BY_CHANCE * max(int(np.count_nonzero(near)), 1)
    return top if np.count_nonzero(stays) >= _STAYS and few else None


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
    signal: FloatArray,
    angle: FloatArray,
    candidates: FloatArray,
    count: int,
    gain: FloatArray,
    at: Sequence[float] = (),
    passed: Passed | None = None,
    whole: int = 0,
) -> list[tuple[float, float, float]]:
    """The `count` best lines gain x A sin(candidate x angle + phase) in `signal`.

    Returns (candidate, A, phase rad) with the best first: local maxima of the variance that a
    line at the candidate explains beside a constant and a slope; between them, where they are
    others, those that explain most among candidates that are `whole` numbers, so many; then those
    `at` given candidates, which over a short way are no maxima beside a slope.
    """
    rows = np.isfinite(signal) & np.isfinite(angle) & np.isfinite(gain)
    if passed is not None:
        rows &= np.isfinite(passed.speed)
    if rows.sum() < 50:
        return []
    y, x, g = signal[rows], angle[rows], gain[rows]
    stride = max(1, len(y) // 4000)
    y, x, g = y[::stride], x[::stride], g[::stride]
    seen = passed and passed.at(rows).at(slice(None, None, stride))
    base, *_ = np.linalg.qr(np.column_stack([np.ones_like(x), x]))
    y = y - base @ (base.T @ y)
    found = explained(y, x, g, base, candidates, seen)
    score = found[:, 0]
    peaks = [
        row
        for row in range(len(score))
        if score[row] > 0.0 and score[row] == score[max(0, row - 2) : row + 3].max()
    ]
    peaks.sort(key=lambda row: -score[row])
    step = float(np.median(np.diff(candidates)))
    lines = []
    for row in peaks[:count]:
        # The candidates are as far apart as the record resolves; its noise lets more be told.
        near = candidates[row] + step * np.linspace(-1.0, 1.0, 2 * _FINER + 1)
        around = explained(y, x, g, base, near, seen)
        best = int(np.argmax(around[:, 0]))
        lines.append((float(near[best]), float(around[best, 1]), float(around[best, 2])))
    if whole:
        orders = np.arange(math.ceil(candidates[0]), candidates[-1])
        told = np.column_stack([orders, explained(y, x, g, base, orders, seen)])
        _put_between(lines, told[np.argsort(-told[:, 1], kind="stable")[:whole]], step / _FINER)
    for one, (_, size, shift) in zip(
        at, explained(y, x, g, base, np.array(at, dtype=float), seen).tolist(), strict=True
    ):
        if all(abs(one - line) > step for line, _, _ in lines):
            lines.append((one, size, shift))
    return lines


def rates_over_time(time_s: FloatArray) -> FloatArray:
    """Rates, rad/s, that a recording tells apart, for lines over time: float64[k]."""
    length = float(time_s[-1] - time_s[0])
    top = 0.4 * len(time_s) / max(length, 1e-9)
    return np.arange(1.0 / length, min(top, _HIGHEST_HZ), 0.4 / length) * 2.0 * math.pi


def _put_between(
    lines: list[tuple[float, float, float]], others: FloatArray, fineness: float
) -> None:
    """Put a line behind each of the first `lines`, where it explains anything and is another.

    others: float64[k, 4], candidate, variance explained, size and phase, best first. fineness: what
    is nearer to a line than that is the same.
    """
    for rank, (one, variance, size, shift) in enumerate(others.tolist()):
        if variance > 0.0 and all(abs(one - line) > fineness for line, _, _ in lines):
            lines.insert(2 * rank + 1, (one, size, shift))


def over_rotor_turn(evidence: Evidence, gain: FloatArray) -> list[tuple[float, float, float]]:
    """(order, A, phase rad) of the strongest lines gain x A sin(order x rotor angle + phase) in the
    unexplained torque.

    Poles and slots make whole orders: the best of these are tried, too, where noise has moved the
    strongest line off its own.
    """
    angle = evidence.rotor_angle_rad
    return strongest(
        evidence.torque_nm,
        angle,
        angular_orders(angle, _HIGHEST_ORDER),
        _LINES,
        gain,
        passed=evidence.torque_over_angle,
        whole=_WHOLE,
    )


def angular_orders(angle: FloatArray, highest: float) -> FloatArray:
    """Orders (periods per revolution of `angle`) worth trying, as finely as its travel resolves."""
    travel = float(np.nanmax(angle) - np.nanmin(angle)) if np.isfinite(angle).any() else 0.0
    step = min(0.5, max(0.05, 0.5 * np.pi / max(travel, 1e-9)))
    return np.arange(1.0, highest + step, step)
