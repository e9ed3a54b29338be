"""The nearest named effect as a curve beside a law: what it would give where the law was read."""

from __future__ import annotations

import copy

import numpy as np

from ...arrays import FloatArray
from ...drive.law import Law
from ..fit.fit import Fit, Fitter
from .guess import Guess
from .missing import missing
from .motion import Motion
from .points import at_port

_BINS = 48
_FEWEST = 3  # samples of a bin, of which the median is drawn


def curve(law: Law, points: FloatArray) -> FloatArray | None:
    """Medians over a law's variable, float64[2, k]; None for a law of two or none.

    points: float64[variables + 1, m], the law's variables and what an effect gives there, of the
    law's unit and sign.
    """
    if len(law.of) != 1:
        return None
    x, y = points
    (places,), (period,) = law.at, law.periods
    last = places[-1] if not period else places[0] + period
    if period:
        x = places[0] + np.mod(x - places[0], period)
    edges = np.linspace(places[0], last, _BINS + 1)
    at = np.digitize(x, edges) - 1
    found = [
        (0.5 * (edges[k] + edges[k + 1]), float(np.median(y[at == k])))
        for k in range(_BINS)
        if np.count_nonzero(at == k) >= _FEWEST
    ]
    return np.array(found).T if len(found) > 1 else None


def played_curve(
    fitter: Fitter, named: Fit, law: Law, guess: Guess, balance: str, gain: float
) -> FloatArray | None:
    """The same of an effect that was fitted in closed loop: what its own recording would lack.

    balance: that the law was read from. gain: what one unit at the port adds to it.
    """
    if len(law.of) != 1:
        return None
    replay = copy.copy(fitter.replay)
    replay.recorded = replay.simulate(named.values, fitter.sheet.constants(named.pulls))
    motion = Motion.of(replay, replay.full(named.values))
    part = missing(motion, fitter.sheet)[balance]
    return curve(law, at_port(part, gain, named.pulls, law.port, guess, motion)[1])
