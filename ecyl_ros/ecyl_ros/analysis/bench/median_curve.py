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

from ...errors import InputError
from ...recording.signals import FloatArray
from .edges import Edges
from .loop import Loop

PER_BIN = 20  # readings, both edges together
MIN_POINTS = 20
TIPS = 0.15  # of the torque left out at either end, where friction is still turning round
CLOSED = 0.7  # a loop narrower than this share of its usual width is still opening


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


def median_curve(
    loop: Loop, edges: Edges, *, per_bin: int = PER_BIN, tips: float = TIPS
) -> MedianCurve:
    """The median curve of a loop.

    Args:
        loop, edges: readings and where they rise and fall.
        per_bin: readings per point.
        tips: share of the largest torque left out at either end.

    Raises:
        InputError: too few readings for 20 points, or a setting that is not possible.
    """
    if per_bin < 4 or not 0.0 <= tips < 0.9:
        raise InputError(
            f"bench: {per_bin} readings per point and {tips:g} left out at the tips, expected 4 "
            "or more and 0 to 0.9"
        )
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
    count = pooled.size // per_bin
    if count < MIN_POINTS:
        raise InputError(
            f"{loop.source}: {pooled.size} readings on both edges, expected "
            f"{MIN_POINTS * per_bin} or more"
        )
    borders = pooled[np.linspace(0, pooled.size - 1, count + 1).astype(int)]
    (rise_angle, rise), (fall_angle, fall) = (
        _medians(angle, torque, borders) for angle, torque in sides
    )
    angle, torque = 0.5 * (rise_angle + fall_angle), 0.5 * (rise + fall)
    half = 0.5 * (rise - fall)
    largest = min(float(np.abs(loop.torque_nm[one]).max()) for one in edges.rising + edges.falling)
    kept = np.isfinite(torque) & (np.abs(torque) <= (1.0 - tips) * largest)
    if kept.sum() < MIN_POINTS:
        raise InputError(
            f"{loop.source}: {int(kept.sum())} points where both edges were read, expected "
            f"{MIN_POINTS} or more"
        )
    angle, torque, half = angle[kept], torque[kept], half[kept]
    friction = float(np.median(half))
    return MedianCurve(angle, torque, half, friction, _notes(loop, half, friction, tips))


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


def _notes(loop: Loop, half: FloatArray, friction: float, tips: float) -> tuple[str, ...]:
    notes = []
    if friction < 0.0:
        notes.append(
            f"{loop.source}: rising torque is below falling torque by {-2.0 * friction:.3g} N m: "
            "the loop runs backwards; are torque and angle of one sign?"
        )
    ends = max(3, half.size // 50)
    for name, part in (("lower", half[:ends]), ("upper", half[-ends:])):
        if friction > 0.0 and float(np.median(part)) < CLOSED * friction:
            notes.append(
                f"{loop.source}: the loop is still narrow at its {name} end: friction turns round "
                f"over more than the {tips:.0%} left out"
            )
    return tuple(notes)
