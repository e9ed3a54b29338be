"""The median curve: hysteresis taken out of a loop (section 3.3).

The paper filters readings of one angle by the median of their torque, and averages rising and
falling edges. Here the angles are cut into bins of equally many readings; each bin gives, edge by
edge, the median torque at the median angle, and the mean of the two edges. Edges are averaged at
equal angle, not at equal torque: friction acts along the torque axis, so it cancels there
whatever the shape of the curve, while an average at equal torque rounds every corner off by the
friction on either side. Bins share no reading, so their errors are independent.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ...arrays import FloatArray
from ...errors import InputError
from ...typical import typical_rms
from .edges import Edges
from .loop import Loop

PER_BIN = 20  # readings, both edges together; fewer where the loop has few
MIN_POINTS = 20
WANTED_POINTS = 60
SMOOTHED = 9  # bins, for the loop's width
OPEN = 0.9  # of its usual width from which a loop counts as open
MARGIN = 3.0  # angles to OPEN left out
USUAL = 0.9  # quantile of the widths on a flank that counts as usual
TRUSTED = 3.0  # scatters of the width that friction must exceed to spoil anything
FINEST = 1e-6  # of the torque's range: a narrower loop has no width
NARROW = 0.5  # of the loop's torques: a curve over less is told of


@dataclass(frozen=True)
class MedianCurve:
    """Points of the median curve, in the order of angle.

    Attributes:
        angle_rad, torque_nm: float64[m].
        half_width_nm: float64[m], half of rising less falling torque: friction, bin by bin.
        friction_nm: its median.
        notes: one line each on what may spoil the curve.
    """

    angle_rad: FloatArray = field(repr=False)
    torque_nm: FloatArray = field(repr=False)
    half_width_nm: FloatArray = field(repr=False)
    friction_nm: float
    notes: tuple[str, ...] = ()


def median_curve(loop: Loop, edges: Edges, *, per_bin: int | None = None) -> MedianCurve:
    """The median curve of a loop.

    Its ends are left out: after a turn, friction takes some angle to turn round, and the mean of
    the edges is off by what is missing. That is seen in the loop's width, which opens from nothing
    to friction over the same angle; three times the angle to 90 % of it is left out, after which
    0.1 % is missing.

    Args:
        loop, edges: readings and where they rise and fall.
        per_bin: readings per point; 20 unless given, fewer where that leaves too few points.

    Raises:
        InputError: too few readings for 20 points, or a setting that is not possible.
    """
    if per_bin is not None and per_bin < 4:
        raise InputError(f"bench: {per_bin} readings per point, expected 4 or more")
    sides = [
        (
            np.concatenate([loop.angle_rad[one] for one in slices]),
            np.concatenate([loop.torque_nm[one] for one in slices]),
        )
        for slices in (edges.rising, edges.falling)
    ]
    low = max(float(angle.min()) for angle, _ in sides)
    high = min(float(angle.max()) for angle, _ in sides)
    pooled = np.sort(np.concatenate([a[(a >= low) & (a <= high)] for a, _ in sides]))
    each = per_bin or max(4, min(PER_BIN, pooled.size // WANTED_POINTS))
    count = pooled.size // each
    if count < MIN_POINTS:
        raise InputError(
            f"{loop.source}: {pooled.size} readings on both edges, expected "
            f"{MIN_POINTS * each} or more"
        )
    borders = pooled[np.linspace(0, pooled.size - 1, count + 1).astype(int)]
    (rise_angle, rise), (fall_angle, fall) = (
        _medians(angle, torque, borders) for angle, torque in sides
    )
    angle, torque = 0.5 * (rise_angle + fall_angle), 0.5 * (rise + fall)
    half = 0.5 * (rise - fall)
    known = np.isfinite(torque)
    angle, torque, half = angle[known], torque[known], half[known]
    first, last = _open(angle, torque, half) if known.sum() >= MIN_POINTS else (0, 0)
    if last - first < MIN_POINTS:
        raise InputError(
            f"{loop.source}: {last - first} points where both edges were read and the loop is "
            f"open, expected {MIN_POINTS} or more; load further, or more slowly"
        )
    angle, torque, half = angle[first:last], torque[first:last], half[first:last]
    friction = float(np.median(half))
    return MedianCurve(angle, torque, half, friction, _notes(loop, torque, friction))


def _open(angle: FloatArray, torque: FloatArray, half: FloatArray) -> tuple[int, int]:
    """First and last bin (exclusive) between which the loop is open."""
    from scipy.ndimage import median_filter

    width = np.abs(median_filter(half, size=SMOOTHED, mode="nearest"))
    scatter = typical_rms(half - np.median(half))
    middle = width.size // 2
    cuts = []
    for part in (width[:middle], width[middle:][::-1]):  # from the end inwards
        usual = float(np.quantile(part, USUAL))
        if usual <= max(TRUSTED * scatter / np.sqrt(SMOOTHED), FINEST * float(np.ptp(torque))):
            cuts.append(0)
            continue
        cuts.append(int(np.flatnonzero(part >= OPEN * usual)[0]))
    low = angle[0] + MARGIN * (angle[cuts[0]] - angle[0])
    high = angle[-1] - MARGIN * (angle[-1] - angle[angle.size - 1 - cuts[1]])
    inside = np.flatnonzero((angle >= low) & (angle <= high))
    return (int(inside[0]), int(inside[-1]) + 1) if inside.size else (0, 0)


def _medians(
    angle: FloatArray, torque: FloatArray, borders: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Median angle and torque in each bin; NaN where a bin has no reading."""
    from scipy.stats import binned_statistic

    found = binned_statistic(angle, [angle, torque], statistic="median", bins=_distinct(borders))
    return found.statistic[0], found.statistic[1]


def _distinct(borders: FloatArray) -> FloatArray:
    # A shaft that stands still under a held torque repeats its angle; a bin needs some width.
    return np.unique(borders)


def _notes(loop: Loop, torque: FloatArray, friction: float) -> tuple[str, ...]:
    notes = []
    if friction < 0.0:
        notes.append(
            f"{loop.source}: rising torque is below falling torque by {-2.0 * friction:.3g} N m: "
            "the loop runs backwards in time"
        )
    if np.ptp(torque) < NARROW * np.ptp(loop.torque_nm):
        notes.append(
            f"{loop.source}: nothing is known beyond {torque.min():.3g} to {torque.max():.3g} N m: "
            "over the rest friction turns round; load further to see more of the flanks"
        )
    return tuple(notes)
