"""Orders over the position and frequencies over time of what the balance leaves."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.fft import next_fast_len
from scipy.signal import find_peaks

from ...arrays import BoolArray, FloatArray
from ...effects.along import Along
from ...effects.carried_load import carried_by
from ...effects.local_jam import WIDEST
from ...effects.term import Left, Term
from .balance import Balance
from .floor import Pairs, coherence, less_line, pairs
from .lag import delay_of
from .solution import Solution
from .wave_sums import wave_sums

_MOST = 3  # peaks tried
# Of the time it moves no faster: there a wave has to be within the band, and in all but as much of
# the time below half the sampling rate.
_SLOWLY = 0.25
_SHARE = 0.01  # of the power that a peak holds
_FINE = 0.25  # of what two frequencies have to be apart to be told, between two tried
_POINTS = 8_000_000  # sines of one scan at the most
_SPACING = 0.3  # of what two orders have to be apart to be told, between two tried
_LEAST_PERIODS = 4.0  # within the travel or the time
_OWN_LINE = 0.03  # share of the motion's power that makes a frequency its own
_OF_MOTION = 0.5  # coherence with the state of motion: beyond, it has most of the line
_PLACES = 60  # along the travel that a window can begin and end at
_NARROW, _WIDE = 2, round(WIDEST * _PLACES)  # widths of a window, in places


def left_by(
    balance: Balance, along: Along, current: Solution, same: Callable[[], Pairs], enough: bool
) -> Left:
    """What a set leaves whose fit is `current`.

    same: gives instants in the same state of motion. enough: the set has as many orders over the
    position as are looked for.
    """
    residual = current.residual

    def orders(effort: FloatArray | None) -> list[float]:
        return [] if enough else _orders(balance, along, residual, effort)

    return Left(
        explained=current.explained(balance.nominal),
        carried=current.carried(carried_by(along.model).along(along)),
        orders=orders,
        lines=lambda: _frequencies(balance, along, current, same),
        window=lambda: _window(balance, along, residual),
        delay=lambda: delay_of(
            balance.motion, balance.effort, current.explained(balance.nominal), balance.fitted
        ),
        nearest=lambda term, over_time: _nearest(balance, along, term, over_time),
    )


def _nearest(balance: Balance, along: Along, term: Term, over_time: bool) -> float:
    """Order, or Hz, of the sine that comes closest to a periodic term; 0 without motion."""
    motion, turn = balance.motion, along.turn
    rows = motion.rows[balance.fitted]
    rate = float(np.median(np.abs(motion.velocity[rows]))) * turn.rate
    if not rate > 0.0:
        return 0.0
    at = motion.time_s[rows] if over_time else turn.angle[rows]
    best = term.rate * rate if over_time else math.tau * term.rate / rate
    wave, reach = np.exp(1j * term.phase[rows]), 0.3
    parts = _parts(balance, balance.fitted)  # a sine of time restarts in each recording

    def alike(rate: float) -> float:
        turn = np.exp(1j * rate * at)
        return sum(abs(np.vdot(wave[one], turn[one])) for one in parts)

    for _ in range(3):
        tried = best * (1.0 + np.linspace(-reach, reach, 61))
        powers = [alike(w) for w in tried] + [alike(-w) for w in tried]
        best, reach = float(tried[int(np.argmax(powers)) % tried.size]), reach / 15.0
    return best / math.tau if over_time else best


def _parts(balance: Balance, rows: BoolArray) -> list[slice]:
    """Where, among `rows`, bool[m], each recording lies."""
    of = balance.motion.recording[rows]
    ends = np.cumsum(np.bincount(of)).tolist()
    return [slice(a, b) for a, b in pairwise([0, *ends]) if b > a]


def _power(
    values: FloatArray, along: FloatArray, rates: FloatArray, weight: FloatArray
) -> FloatArray:
    """How much of `values` a sine of each rate removes by least squares (Lomb, 1976), float64[k].

    rates: evenly spaced. weight: what the sine is multiplied with (ones, or the effort).
    """
    if rates.size == 0:
        return np.zeros(0)
    along = along - along.mean()
    first, count = float(rates[0]), rates.size
    spacing = (float(rates[-1]) - first) / max(count - 1, 1)
    squares = weight**2
    both = float(squares.sum())
    product = wave_sums(values * weight, along, first, spacing, count)
    double = wave_sums(squares, along, 2.0 * first, 2.0 * spacing, count)
    cc, ss, cs = 0.5 * (both + double.real), 0.5 * (both - double.real), 0.5 * double.imag
    yc, ys = product.real, product.imag
    determinant = np.maximum(cc * ss - cs**2, 1e-9 * both**2 + 1e-300)
    made: FloatArray = (yc**2 * ss - 2.0 * yc * ys * cs + ys**2 * cc) / determinant
    total = float(np.sum(values**2))
    return made / max(total, 1e-300)


def _power_in(
    values: FloatArray,
    along: FloatArray,
    rates: FloatArray,
    weight: FloatArray,
    parts: Sequence[slice],
) -> FloatArray:
    """The same of sines that have a phase and size of their own in each part of the values."""
    if len(parts) == 1:
        return _power(values, along, rates, weight)
    made = np.zeros(rates.size)
    for one in parts:
        removed = _power(values[one], along[one], rates, weight[one])
        made += removed * float(np.sum(values[one] ** 2))
    return made / max(float(np.sum(values**2)), 1e-300)


def _peaks(
    values: FloatArray, along: FloatArray, rates: FloatArray, weight: FloatArray
) -> list[float]:
    return [float(rates[one]) for one in _tops(_power(values, along, rates, weight))]


def _tops(power: FloatArray) -> list[int]:
    """The highest peaks of shares of the power, best first."""
    top, _ = find_peaks(np.concatenate([[0.0], power, [0.0]]))
    top = top - 1
    return [int(one) for one in top[np.argsort(-power[top])][:_MOST] if power[one] > _SHARE]


def _orders(
    balance: Balance, along: Along, residual: FloatArray, effort: FloatArray | None = None
) -> list[float]:
    """Periods per radian of the turn (per m over a straight output without a lead), best first.

    effort: float64[n] that the sine is a share of; of an effort of its own unless given.

    Whole numbers of periods per turn where the output turns round: what repeats with the angle of
    a shaft does so after a turn.
    """
    motion = balance.motion
    angle, name, _, per_output = along.turn
    rows = np.flatnonzero(balance.fitted)
    position = angle[motion.rows][rows]
    travel = float(np.ptp(position))
    if not travel > 0.0:
        return []
    speeds = per_output * np.abs(motion.velocity[motion.rows][rows])
    slow, fast = np.maximum(np.quantile(speeds, (_SLOWLY, 1.0 - _SLOWLY)), 1e-12).tolist()
    highest = math.tau * motion.bandwidth_hz / slow
    # Beyond half the sampling rate a recording has it at another frequency.
    highest = min(highest, math.pi * motion.rate_hz / fast)
    # A wave as short as the noise of the position is in no phase.
    highest = min(highest, 1.0 / (per_output * motion.position_noise))
    lowest = _LEAST_PERIODS * math.tau / travel
    if not highest > 1.5 * lowest:
        return []
    weight = np.ones(rows.size) if effort is None else motion.filtered(effort)[rows]
    values = residual[rows] - np.mean(residual[rows])
    limit = max(64, _POINTS // rows.size)
    if name != "period_m" and travel > 2.0 * math.tau:
        rates = np.arange(max(1.0, math.ceil(lowest)), min(highest, 1000.0))
        return _peaks(values, position, rates[:limit], weight)
    spacing = _SPACING * math.tau / travel
    rates = np.arange(lowest, highest, max(spacing, (highest - lowest) / limit))
    return [
        _refined(values, position, rate, spacing, weight)
        for rate in _peaks(values, position, rates, weight)
    ]


def _frequencies(
    balance: Balance, along: Along, current: Solution, same: Callable[[], Pairs]
) -> list[float]:
    """Hz of the strongest lines over time within the band, best first.

    same: gives instants in the same state of motion; what they tell the phase of is the motion's
    own.
    """
    rows = np.flatnonzero(balance.fitted)
    time = balance.time_s[rows]
    parts = _parts(balance, balance.fitted)
    length = max((float(np.ptp(time[one])) for one in parts), default=0.0)
    if not length > 0.0:
        return []
    values = current.residual[rows] - np.mean(current.residual[rows])
    lowest, highest = _LEAST_PERIODS / length, 0.9 * balance.motion.bandwidth_hz
    weight = np.ones(rows.size)
    found = [
        _refined(values, time, math.tau * hertz, _FINE * math.tau / length, weight, parts)
        for hertz in _lines(balance, rows, values, lowest, highest)
    ]
    asked = balance.motion.filtered(current.explained(balance.nominal))[rows]
    kept = []
    for rate in found:
        hertz = rate / math.tau
        # A model errs by a share of what the motion asks: a line beyond all that it asks for there
        # is none of the motion's. It shakes the machine, and so shows in the motion itself.
        shakes = _line(values, time, hertz, parts) > _line(asked, time, hertz, parts)
        if _moves(balance, rows, time, rate, shakes):
            continue
        told = coherence(same(), balance.time_s, hertz)
        if told >= _OF_MOTION and shakes:
            turns = not along.machine.linear and along.turns
            told = coherence(pairs(balance, turns, hertz), balance.time_s, hertz)
        if told < _OF_MOTION:
            kept.append(hertz)
    return kept


def _lines(
    balance: Balance, rows: NDArray[np.int64], values: FloatArray, lowest: float, highest: float
) -> list[float]:
    """Hz of the strongest peaks between two frequencies; values: float64 at `rows`."""
    even, of = np.zeros(balance.time_s.size), balance.motion.recording
    even[rows] = values
    parts = [even[of == one] for one in range(len(balance.motion.parts))]
    size = next_fast_len(math.ceil(max(one.size for one in parts) / _FINE), real=True)
    power = np.sum([np.abs(np.fft.rfft(one, size)) ** 2 for one in parts], axis=0)
    power = power * 2.0 / rows.size
    hertz = np.fft.rfftfreq(size, float(np.median(np.diff(balance.time_s))))
    inside = (hertz >= lowest) & (hertz <= highest)
    power, hertz = power[inside] / max(float(np.sum(values**2)), 1e-300), hertz[inside]
    return [float(hertz[one]) for one in _tops(power)]


def _line(values: FloatArray, time: FloatArray, hertz: float, parts: Sequence[slice]) -> float:
    """Size of a line, in a phase of its own in each part."""
    lines = [values[one] - less_line(values[one], time[one], hertz) for one in parts]
    return float(np.std(np.concatenate(lines)))


def _moves(
    balance: Balance, rows: NDArray[np.int64], time: FloatArray, rate: float, shakes: bool
) -> bool:
    """Whether the motion itself has a line there: what depends on it then has one, too.

    shakes: the line may be what shakes the machine, in which acceleration shows it.
    """
    motion = balance.motion
    at = motion.rows[rows]
    weight, parts = np.ones(rows.size), _parts(balance, balance.fitted)
    judged = [motion.position[at], motion.velocity[at]]
    reference = motion.reference_position[at]
    if not shakes:
        judged.append(motion.acceleration[at])
    elif np.isfinite(reference).all():  # what was asked for is not shaken
        judged = [reference]
    for values in judged:
        power = _power_in(values - values.mean(), time, np.array([rate]), weight, parts)
        if float(power[0]) > _OWN_LINE:
            return True
    return False


def _refined(
    values: FloatArray,
    along: FloatArray,
    rate: float,
    spacing: float,
    weight: FloatArray,
    parts: Sequence[slice] = (slice(None),),
) -> float:
    """The rate near `rate` that removes most; in each part in a phase of its own."""
    for width in (1.0, 0.2, 0.04):
        around = rate + np.linspace(-width, width, 21) * spacing
        around = around[around > 0.0]
        rate = float(around[int(np.argmax(_power_in(values, along, around, weight, parts)))])
    return rate


def _window(balance: Balance, along: Along, residual: FloatArray) -> tuple[float, float]:
    """Middle and width of the part of the travel on which drag against the motion stands out most.

    Width 0 where none does.
    """
    motion = balance.motion
    rows = np.flatnonzero(balance.fitted)
    at = motion.rows[rows]
    position, sign = motion.position[at], along.sign[at]
    low, high = float(position.min()), float(position.max())
    if not high > low:
        return low, 0.0
    place = np.minimum(((position - low) / (high - low) * _PLACES).astype(np.int64), _PLACES - 1)
    count = np.bincount(place, minlength=_PLACES).astype(float)
    drag = np.bincount(place, weights=residual[rows] * sign, minlength=_PLACES)
    counts, drags = np.concatenate([[0.0], count.cumsum()]), np.concatenate([[0.0], drag.cumsum()])
    best, found = 0.0, (low, 0.0)
    for width in range(_NARROW, _WIDE + 1):
        inside = np.maximum(counts[width:] - counts[:-width], 1.0)
        gain = np.maximum(drags[width:] - drags[:-width], 0.0) ** 2 / inside
        first = int(np.argmax(gain))
        # A wider window has to be better by more than chance gives.
        if float(gain[first]) > 1.02 * best:
            best = float(gain[first])
            step = (high - low) / _PLACES
            found = (low + (first + 0.5 * width) * step, width * step)
    return found
