"""What a law may be looked for along: the motion of a drive, whatever is known of it."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from ...arrays import FloatArray


class Filter(Protocol):
    """What the rows of a balance went through.

    points: of its window. step: time from one sample to the next, s.
    """

    @property
    def points(self) -> int: ...

    @property
    def step(self) -> float: ...


class Visited(Protocol):
    """A motion: float64[n] over time.

    time_s: from the first sample. speed: smoothed. stretch_s: how long a stretch is that is
    predicted from the others. smooth: what the rows went through.
    """

    @property
    def time_s(self) -> FloatArray: ...

    @property
    def speed(self) -> FloatArray: ...

    @property
    def stretch_s(self) -> float: ...

    @property
    def smooth(self) -> Filter: ...

    @property
    def fine(self) -> Visited:
        """The motion at the instants that were filtered: itself, or before it was decimated."""

    def passed(self, table: FloatArray) -> FloatArray:
        """float64[k, m] along `fine` through the filter that the balances went through:
        float64[k, n]."""

    def variable(self, name: str, on_load: bool, time_constant_s: float = 0.0) -> FloatArray:
        """One of `drive.law.VARIABLES` along it, float64[n]."""

    def fills(self, one: str, other: str, on_load: bool) -> bool:
        """Whether each of two variables varied enough where the other stood for both to be told."""

    def periods(self, name: str, on_load: bool) -> float:
        """How often a variable began anew: a periodic one went round, a way since a reversal was
        reversed; infinite for others, 0 where there is none."""


def reversals(speed: FloatArray) -> float:
    """How often a speed while moving, float64[n], changes sign."""
    return float(np.count_nonzero(np.diff(np.sign(speed))))
