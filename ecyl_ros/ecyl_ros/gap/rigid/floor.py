"""How well a measured effort repeats: the floor of a drive whose noise nobody has stated.

What no function of position, speed and acceleration can explain is estimated from pairs of instants
in the same state of motion at different times (Gamma test: Stefansson, Koncar, Jones, "A note on
the Gamma test", Neural Computing & Applications 5, 1997): half the squared difference of their
efforts, extrapolated to a distance of zero between the states.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from ...arrays import BoolArray, FloatArray
from ...typical import typical_rms
from .balance import Balance
from .solution import Solution
from .white import least_density

_NEIGHBOURS = 12
_FIRST, _MOST = 4, 96  # nearest ones that are looked at, for each that is wanted and at most
_APART = 2  # stretches between two instants that count as different times, at the least
_NEAR = 0.3 * math.sqrt(3.0)  # of the state's spread: neighbours further away say nothing
_BRIEF = 64  # compared samples of a spectrum: short, so that there are some between two blows
_QUIET = 0.2  # share of the recording that is quieter than what counts as its noise
_WHITE = (0.1, 0.9)  # share of the band that its noise is judged by
_ALL_NEAR = 0.1  # of their mean, by which distances differ
_FEWEST = 100  # pairs that say something
_FREQUENCIES = 1024  # by which the filter's response is added up


class Pairs(NamedTuple):
    """Instants (rows of `rows`) and those in nearly the same state of motion at other times.

    rows: int64[m]. distance: float64[m, k], of the state's spread. neighbour: int64[m, k]. other:
    bool[m, k], at another time.
    """

    rows: NDArray[np.int64]
    distance: FloatArray
    neighbour: NDArray[np.int64]
    other: BoolArray


def pairs(
    balance: Balance, periodic: bool, without_hz: float | None = None, others: int = 1
) -> Pairs:
    """Neighbours in position, speed and acceleration within one recording, the nearest first.

    periodic: position modulo one turn. without_hz: of a line that is taken out of the motion.
    others: how many at other times are looked for, as far as they are among the nearest `_MOST`.
    """
    motion = balance.motion
    rows = np.flatnonzero(balance.usable)
    position, *state = (
        motion.in_band(one)[rows] for one in (motion.position, motion.velocity, motion.acceleration)
    )
    if without_hz is not None:
        time_s = balance.time_s[rows]
        position, *state = (less_line(one, time_s, without_hz) for one in (position, *state))
    state = [one / (float(np.std(one)) or 1.0) for one in state]
    if periodic:
        state += [np.cos(position) * math.sqrt(2.0), np.sin(position) * math.sqrt(2.0)]
    else:
        state.append(position / (float(np.std(position)) or 1.0))
    points = np.stack(state, axis=1)
    stretch, of = balance.stretch[rows], motion.recording[rows]
    shape = rows.size, min(_MOST, int(np.max(np.bincount(of), initial=0)))
    distance, index = np.full(shape, np.inf), np.zeros(shape, dtype=np.int64)
    other = np.zeros(shape, dtype=bool)
    # What another recording does not repeat may be wear, or another temperature: no noise.
    for number in np.unique(of).tolist():
        own = np.flatnonzero(of == number)
        tree, looked = cKDTree(points[own]), own
        count, most = _FIRST * others, min(_MOST, own.size)
        while looked.size:
            count = min(count, most)
            near, at = tree.query(points[looked], k=range(1, count + 1), distance_upper_bound=_NEAR)
            there = np.isfinite(near)
            distance[looked, :count] = near
            index[looked, :count] = found = own[np.where(there, at, 0)]
            # Neighbours in time are neighbours in state: only other times count.
            apart = np.abs(stretch[found] - stretch[looked, None]) >= _APART
            other[looked, :count] = there & apart
            if count == most:
                break
            # Where there may be more in reach, further ones are asked for.
            looked = looked[there[:, -1] & (np.count_nonzero(other[looked], axis=1) < others)]
            count *= 2
    return Pairs(rows, distance, index, other)


def less_line(values: FloatArray, time_s: FloatArray, frequency_hz: float) -> FloatArray:
    """float64[n] less the sine over time that comes closest."""
    phase = math.tau * frequency_hz * time_s
    wave = np.stack([np.cos(phase), np.sin(phase), np.ones_like(phase)], axis=1)
    fit = np.linalg.lstsq(wave, values, rcond=None)[0]
    left: FloatArray = values - wave[:, :2] @ fit[:2]
    return left


def coherence(found: Pairs, time_s: FloatArray, frequency_hz: float) -> float:
    """How well the phase of a line is told by the state of motion alone, 0 to 1.

    1 of a harmonic of a motion that comes again and again: any function of the motion has a line
    there. time_s: float64 of the balance's rows.
    """
    first = np.argmax(found.other, axis=1)
    rows = np.flatnonzero(found.other.any(axis=1))
    if rows.size < _FEWEST:
        return 0.0
    at = time_s[found.rows]
    apart = at[rows] - at[found.neighbour[rows, first[rows]]]
    return abs(float(np.mean(np.cos(math.tau * frequency_hz * apart))))


def repeatability(balance: Balance, broad: Solution, periodic: bool) -> float | None:
    """Standard deviation of the filtered effort that does not repeat; None where no state does.

    Args:
        balance: the recording.
        broad: a fit that takes the smooth dependence on the motion away, so that the distance of
            neighbours matters little.
        periodic: the position counts modulo one turn.
    """
    found = pairs(balance, periodic, others=_NEIGHBOURS)
    return _extrapolated(found, broad.residual[found.rows])


def white_part(balance: Balance, fit: Solution) -> float:
    """Standard deviation of what has no structure of what a fit leaves.

    White noise is as dense at every frequency of the band and at all times: the least density there
    bounds it, of the quieter parts of the recording. So does what changes from one sample to the
    next, for no structure takes from that; of short stretches it says more than a spectrum.
    """
    motion = balance.motion
    band = motion.bandwidth_hz
    density = least_density(
        fit.residual,
        balance.usable,
        motion.rate_hz / motion.step,
        _WHITE[0] * band,
        below_hz=_WHITE[1] * band,
        share=_QUIET,
        segment=_BRIEF,
    )
    return min(math.sqrt(density * band), _by_differences(balance, fit))


def _by_differences(balance: Balance, fit: Solution) -> float:
    """Standard deviation of white noise, through the filter of the comparison, that differs from
    one compared sample to the next as much as what a fit leaves."""
    motion = balance.motion
    of = motion.recording
    both = balance.usable[1:] & balance.usable[:-1] & (of[1:] == of[:-1])
    if not both.any():
        return math.inf
    power = 0.5 * float(np.mean(np.diff(fit.residual)[both] ** 2))
    hertz = np.linspace(0.0, 0.5 * motion.rate_hz, _FREQUENCIES)
    passed = motion.gain(hertz) ** 2
    turned = np.cos(math.tau * hertz * motion.step / motion.rate_hz)
    alike = float(np.sum(passed * turned) / np.sum(passed))
    return math.sqrt(power / (1.0 - alike))


def _extrapolated(found: Pairs, values: FloatArray) -> float | None:
    _, distance, index, near = found
    rank = np.cumsum(near, axis=1)
    squared, halves = [], []
    for number in range(1, _NEIGHBOURS + 1):
        at = near & (rank == number)
        rows = np.flatnonzero(at.any(axis=1))
        if rows.size < _FEWEST:
            break
        column = np.argmax(at[rows], axis=1)
        difference = values[rows] - values[index[rows, column]]
        squared.append(float(np.mean(distance[rows, column] ** 2)))
        # A median is not led astray by the few pairs at a reversal.
        halves.append(0.5 * typical_rms(difference) ** 2)
    if len(squared) < 4:
        return None
    if np.ptp(squared) <= _ALL_NEAR * np.mean(squared):  # one distance says nothing of others
        return math.sqrt(float(np.mean(halves)))
    slope, intercept = np.polyfit(squared, halves, 1)
    least = 0.25 * halves[0]
    value = intercept if slope > 0.0 else float(np.mean(halves))
    return math.sqrt(max(value, least))
