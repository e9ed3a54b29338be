"""The nearest named effect as a curve beside a law: what it would give where the law was read."""

from __future__ import annotations

import copy

import numpy as np

from ...drive.law import Law
from ..diagnosis import FloatArray
from ..fit.fit import Fit, Fitter
from .choose import Guess
from .missing import missing
from .motion import Motion

_BINS = 48
_FEWEST = 3  # samples of a bin, of which the median is drawn


def curve(law: Law, x: FloatArray, y: FloatArray) -> FloatArray | None:
    """Medians of `y` over a law's variable, float64[2, k]; None for a law of two or none.

    x, y: float64[m], the variable and what an effect gives there, of the law's unit and sign.
    """
    if len(law.of) != 1:
        return None
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

    balance: that the law was read from. gain: of what is missing there by what acts at the port.
    """
    replay = copy.copy(fitter.replay)
    replay.recorded = replay.simulate(named.values, fitter.sheet.constants(named.pulls))
    motion = Motion.of(replay, replay.full(named.values))
    part = missing(motion, fitter.sheet).get(balance)
    if part is None:
        return None
    lacks = (part.values - named.pulls[list(part.pulled)] @ part.columns) / gain
    if law.port == "rotor_angle_error":
        lacks = -lacks
    if guess.kind == "friction":
        lacks = -np.sign(motion.speed) * lacks
    rows = part.rows
    along = [motion.variable(one, guess.on_load, guess.time_constant_s)[rows] for one in guess.of]
    return curve(law, along[0], lacks[rows]) if along else None
