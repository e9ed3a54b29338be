"""The axis of a table: where its places lie along what was visited, and how smooth it is.

A law is linear in its table's values: along a motion each value is a column of a regression. Values
are held together by a penalty on their second differences (P-splines, Eilers and Marx), whose
weight the data choose, so that the number of places says nothing of how fast a law may change.
A law of two variables may change faster along one than along the other: see `SORTS`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...arrays import FloatArray
from ...drive.compiled import allocating
from ...drive.law import PERIODS
from ...effects.learned import places, segments

# Places of the axis of a law of one variable.
_PLACES = {"position": 48, "rotor_angle": 48, "screw_angle": 48, "heat": 12}
_OTHER_PLACES = 24
_WAVE_PLACES = 12  # of one that repeats itself several times a turn


class Sort(NamedTuple):
    """How finely an axis is told.

    places: of it; periodic: of one that goes round; 0 for as many as alone. weight: of its
    roughness against that of the other axis.
    """

    places: int
    periodic: int
    weight: float

    @property
    def all_places(self) -> Sort:
        """The same with as many places as alone."""
        return Sort(0, 0, self.weight)


ALONE = Sort(0, 0, 1.0)
_EVENLY, _FAST, _SLOWLY = Sort(10, 12, 1.0), Sort(24, 24, 1.0 / 30.0), Sort(6, 8, 1.0)
# Of a law's first variable and of its second; those that predict best are taken. The weights differ
# by one and a half steps of the smoothness that is tried; by three they predict no better.
SORTS = ((_EVENLY, _EVENLY), (_FAST, _SLOWLY), (_SLOWLY, _FAST))


@dataclass(frozen=True, eq=False)
class Axis:
    """variable: its name. at: float64[k], the places. period: 0 for none. weight: see `Sort`."""

    variable: str
    at: FloatArray
    period: float
    weight: float = 1.0

    @classmethod
    def over(cls, variable: str, visited: FloatArray, order: int = 1, sort: Sort = ALONE) -> Axis:
        """Even places over all that was visited: a law is often largest where few samples lie.

        order: how often a law of an angle repeats itself in a turn.
        """
        if variable == "direction":
            return cls(variable, np.array([-1.0, 1.0]), 0.0, sort.weight)
        alone = _PLACES.get(variable, _OTHER_PLACES)
        period = PERIODS.get(variable, 0.0) / order
        if period > 0.0:
            count = _WAVE_PLACES if order > 1 else sort.periodic or alone
            return cls(variable, np.arange(count) * period / count, period, sort.weight)
        low, high = float(visited.min()), float(visited.max())
        if not high > low:
            low, high = low - 0.5, low + 0.5
        at = np.linspace(low, high, sort.places or alone)
        return cls(variable, at, 0.0, sort.weight)

    def columns(self, values: FloatArray) -> FloatArray:
        """What each place's value counts for along a variable: float64[k, n]."""
        made = segments(self.at, self.period)
        return _columns(made, self.period, np.ascontiguousarray(values, dtype=np.float64))

    def roughness(self) -> FloatArray:
        """The penalty's matrix, float64[k, k]: second differences, of two places the first."""
        count = len(self.at)
        if count == 2:
            return self.weight * np.array([[1.0, -1.0], [-1.0, 1.0]])
        eye = np.eye(count)
        if self.period > 0.0:
            second = np.roll(eye, 1, axis=0) - 2.0 * eye + np.roll(eye, -1, axis=0)
        else:
            second = np.diff(eye, 2, axis=0)
        # Of the same weight however many places there are.
        found: FloatArray = second.T @ second * self.weight * (count / 10.0) ** 3
        return found


@allocating
def _columns(segments, period, values):
    count = segments.shape[0]
    found = np.zeros((count, values.shape[0]))
    for index in range(values.shape[0]):
        row = places(segments, count, period, values[index])
        found[row[0], index] += row[4]
        found[row[1], index] += row[5]
        found[row[2], index] += row[6]
        found[row[3], index] += row[7]
    return found


def columns(axes: tuple[Axis, ...], values: list[FloatArray], count: int) -> FloatArray:
    """What each value of a table counts for along the motion: float64[k, n]."""
    found = np.ones((1, count))
    for axis, one in zip(axes, values, strict=True):
        along = axis.columns(one)
        found = (found[:, None, :] * along[None, :, :]).reshape(-1, count)
    return found


def roughness(axes: tuple[Axis, ...]) -> FloatArray:
    """The penalty's matrix of a table, float64[k, k]."""
    if not axes:
        return np.zeros((1, 1))
    if len(axes) == 1:
        return axes[0].roughness()
    first, second = (one.roughness() for one in axes)
    a, b = len(first), len(second)
    found: FloatArray = np.kron(first, np.eye(b)) / b + np.kron(np.eye(a), second) / a
    return found
