"""A disturbance at the one frequency that the drive itself moves at.

Whatever depends on a motion of one sine, a spring, an inertia, a friction, swings as that does; and
no disturbance of its own frequency falls on it but by a coincidence.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import minimize_scalar

from ...arrays import FloatArray
from ...effects.starts import rates_over_time, strongest
from ..compete.competition import Competition
from ..fit.fit import Fitter
from ..replay.replay import Replay
from .constancy import without_effects

_EFFECT = "periodic_disturbance"
_NEARLY_ALL = 0.9  # of the power of the speed asked for


def without_own_frequency(
    competition: Competition, fitter: Fitter
) -> tuple[Competition, list[str]]:
    """The competition without a disturbance at the frequency of the motion, and a line of why."""
    given = competition.winner.values.get(_EFFECT)
    if given is None:
        return competition, []
    hertz = given["frequency_hz"]
    for part in fitter.replay.parts:
        own = swing_hz(part)
        if own is None or abs(hertz - own) * float(np.ptp(part.time_s)) > 1.0:
            return competition, []
    note = (
        f"a periodic disturbance at {hertz:.3g} Hz comes near, but the drive itself moves at that "
        "frequency, and what depends on its motion swings alike; a motion of other frequencies "
        "would tell"
    )
    return without_effects(competition, fitter, [_EFFECT]), [note]


def swing_hz(replay: Replay) -> float | None:
    """The frequency of the one sine that nearly all of the motion asked for is, Hz; None of any
    other motion."""
    time = replay.time_s - replay.time_s[0]
    speed = np.gradient(replay.reference_m, time)
    power = float(np.sum((speed - speed.mean()) ** 2))
    if not power > 0.0:
        return None
    rates = rates_over_time(time)
    near = strongest(speed, time, rates, 1, np.ones_like(time))
    if not near:
        return None
    step = float(rates[1] - rates[0])

    def left(rate: float) -> float:
        return _beside(rate, time, speed)

    found = minimize_scalar(left, bounds=(near[0][0] - step, near[0][0] + step))
    return float(found.x) / math.tau if found.fun <= (1.0 - _NEARLY_ALL) * power else None


def _beside(rate: float, time_s: FloatArray, values: FloatArray) -> float:
    """Power of values beside a sine and a mean."""
    turn = rate * time_s
    columns = np.stack([np.sin(turn), np.cos(turn), np.ones_like(turn)], axis=1)
    rest = values - columns @ np.linalg.lstsq(columns, values, rcond=None)[0]
    return float(rest @ rest)
