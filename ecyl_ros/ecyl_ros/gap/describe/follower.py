"""How a follower departs from its reference beyond lag and dead band, as a law along its motion.

Of a servo loop whose controller is unknown position and reference tell a static law at best: what
the error depends on once the loop has answered. A loop's own answer is linear in the motion's
derivatives: the lag (as a delay or a first-order loop, whichever is closer) stands for the speed,
and the acceleration is free beside the law, as nobody states it. Friction, and what an integrator
makes of it, are odd in the direction and come at every reversal anew: along one repeated path they
are a law of any variable. Laws are therefore looked for only where each position was passed at
several speeds, and of neither direction nor the travel since a reversal.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from scipy.signal import savgol_filter

from ...arrays import BoolArray, FloatArray
from ...drive.rigid.law import counted_in
from ..diagnosis import Diagnosis
from ..judge.verdict import shrink_of
from ..rigid.motion import Motion
from . import words
from .balance import Balance
from .choose import choose
from .description import Course, Description
from .measured_motion import Decimated, MeasuredMotion, place_of
from .missing import Missing
from .regressed import FREE, LEAST_STRETCHES, described, held

_PORT = "following_error"
_MOST_ROWS = 5000
_SETTLED = 3.0  # lags after which a first-order loop has answered to 5 %


@dataclass(frozen=True, eq=False)
class Followed:
    """What is known of a follower once lag, dead band and offset are; float64[n] on its grid.

    Attributes:
        late: the reference behind the lag. predicted: position by lag, dead band and offset, fitted
            to `fitted`. dead_band: -1 to 1, on which side of the dead band `late` is. lag_s: found.
        offset_half, lag_half_s, width_half: half their 95 % intervals.
        fitted, judged: bool[n]. stretch_s: length of a stretch. floor: of the position's noise.
    """

    motion: Motion
    linear: bool
    late: FloatArray
    predicted: FloatArray
    dead_band: FloatArray
    lag_s: float
    offset_half: float
    lag_half_s: float
    width_half: float
    fitted: BoolArray
    judged: BoolArray
    stretch_s: float
    floor: float


def with_follower_description(diagnosis: Diagnosis, followed: Followed) -> Diagnosis:
    """The diagnosis of a gap; where a law holds on unseen data, `described`."""
    motion, end = followed.motion, diagnosis.signals[0].unit
    rows = np.arange(0, motion.time_s.size, max(1, motion.time_s.size // _MOST_ROWS))
    seen = _seen(followed, rows)
    if not (seen.known.any() and seen.fills(seen.place, "speed", False)):
        return diagnosis
    missing = _missing(followed, seen, rows, end)
    fitted, judged = followed.fitted[rows], followed.judged[rows] & seen.known
    stretch = np.floor(seen.time_s / seen.stretch_s)
    if len(np.unique(stretch[seen.known & fitted])) < LEAST_STRETCHES or not judged.any():
        return diagnosis
    looked = Balance([(missing, 1.0)], seen, fitted)
    choice = choose((_PORT,), {_PORT: looked}, seen)
    if choice is None or not choice.best.of:
        return diagnosis
    holds = held(looked, choice, missing, judged, followed.floor)
    if holds is None or not holds.whole:
        return diagnosis
    law, loop = holds.law, holds.sheet
    played = counted_in(choice.best.law(_PORT), end, followed.linear)
    values = missing.values - loop
    found = described(
        looked,
        choice,
        played,
        f"beyond lag and dead band, {words.place(played)} {words.depends(played)}",
        Course(seen.time_s, values, 1.96 * followed.floor, seen.known, law, end),
        values[missing.rows],
        missing.rows,
    )
    return _closed(diagnosis, followed, found, np.interp(motion.time_s, seen.time_s, law + loop))


def _closed(
    diagnosis: Diagnosis, followed: Followed, found: Description, added: FloatArray
) -> Diagnosis:
    """The diagnosis with what lag, dead band and the law leave on held-out data."""
    position = followed.predicted + added
    left = (followed.motion.raw_position - position)[followed.judged]
    (gap,) = diagnosis.signals
    after = float(np.sqrt(np.mean(left**2)))
    shrink = shrink_of(gap.gap, after, max(gap.gap - gap.floor, 1e-12))
    return dataclasses.replace(
        diagnosis,
        verdict="described",
        law=dataclasses.replace(found, shrink=shrink),
        signals=(dataclasses.replace(gap, after=after),),
        after=diagnosis.before * after / gap.gap,
        shrink=shrink,
        series=dataclasses.replace(diagnosis.series, after=position[None]),
        misfit_after=after / gap.floor,
    )


def _seen(followed: Followed, rows: np.ndarray) -> MeasuredMotion:
    """The motion at some rows; known past the answer to a reversal, and not at rest."""
    motion = followed.motion
    speed = motion.velocity
    top = float(np.nanmax(np.abs(speed)))
    moving = np.abs(speed) > max(3.0 * motion.speed_noise, 1e-3 * top)
    sign = np.sign(np.where(moving, speed, 0.0))
    changed = np.flatnonzero(np.concatenate([[True], sign[1:] != sign[:-1]]))
    since = np.arange(sign.size) - np.repeat(changed, np.diff(np.append(changed, sign.size)))
    settled = since > _SETTLED * followed.lag_s * motion.rate_hz
    known = motion.usable & moving & settled
    step = (rows[1] - rows[0]) / motion.rate_hz
    return MeasuredMotion(
        motion.time_s[rows],
        motion.position[rows],
        speed[rows],
        known[rows],
        place_of(motion, followed.linear),
        followed.stretch_s,
        Decimated(step),
    )


def _missing(followed: Followed, seen: MeasuredMotion, rows: np.ndarray, end: str) -> Missing:
    """What lag, dead band and offset leave; these beside it within their intervals, and the
    acceleration, of which nothing is known."""
    motion = followed.motion
    values = (motion.raw_position - followed.predicted)[rows]
    points = max(5, 2 * round(0.5 * followed.lag_s * motion.rate_hz) + 1)
    points = min(points, motion.time_s.size - 1 + motion.time_s.size % 2)
    second = savgol_filter(followed.late, points, 3, deriv=2)[rows]
    size = float(np.std(values)) / (float(np.std(second)) or 1.0)
    columns = np.array(
        [
            np.full(rows.size, followed.offset_half),
            -followed.lag_half_s * motion.velocity[rows],
            -0.5 * followed.width_half * followed.dead_band[rows],
            FREE * size * second,
        ]
    )
    known = np.flatnonzero(seen.known)
    pulled = tuple(range(len(columns)))
    same = np.zeros(len(pulled))  # what is measured is the position, whatever the follower
    return Missing(_PORT, end, values, followed.floor, seen.known, known, columns, pulled, same)
