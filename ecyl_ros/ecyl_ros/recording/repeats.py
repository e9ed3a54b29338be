"""Rows that a logger has repeated: all signals stand still together, and should not have.

A drive at rest with coarse signals stands still, too. So there has to be evidence, in one signal at
least: its noise rests with it; or, of a measured position, which cannot leap, that it does at the
end, by far more than it moves on either side, to where it then stays.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np
from numpy.typing import NDArray

from .names import PLACED, words
from .signals import FloatArray
from .whiteness import white_noise

_SHORTEST = 5  # rows of a stretch
_RARER = 5.0  # times the usual run of equal rows
_BY_CHANCE = 1e-6  # runs that long, expected of rows that are equal as often as these
_FEWEST = 50  # runs that say how long is usual
_BESIDE = 50  # rows on either side, that noise is taken from
_NEAR, _STAYS = 25, 5  # rows on either side that a pace is taken from, that it stays for
_LEAP = 4.0  # times the largest step on either side
_STEPS = 3.0  # of the smallest kind, that noise has to be above


def repeated_rows(
    signals: Mapping[str, FloatArray], held: Collection[str] = ()
) -> NDArray[np.bool_]:
    """bool[n], True where a logger repeats a row; of signals float64[n] by name.

    held: signals that may hold a value and leap (commands), and hence are no evidence.
    """
    size = next(iter(signals.values())).size if signals else 0
    names = [name for name, values in signals.items() if _changes(values)]
    changing = [signals[name] for name in names]
    found = np.zeros(size, dtype=bool)
    if len(changing) < 2:
        return found
    still = np.ones(max(size - 1, 0), dtype=bool)
    for values in changing:
        same = (values[1:] == values[:-1]) | (np.isnan(values[1:]) & np.isnan(values[:-1]))
        still &= same
    known = np.any([np.isfinite(values) for values in changing], axis=0)
    still &= known[1:]
    starts = np.concatenate([[0], np.flatnonzero(~still) + 1])
    lengths = np.diff(np.append(starts, size))
    if starts.size < _FEWEST:
        return found
    usual = float(np.quantile(lengths, 0.95, method="lower"))
    long = lengths >= max(_SHORTEST, _RARER * usual)
    equal = float((lengths[~long] - 1).sum()) / max(float(lengths[~long].sum()), 1.0)
    long &= starts.size * equal ** (lengths - 1.0) < _BY_CHANCE
    runs = [(int(a), int(a + n)) for a, n in zip(starts[long], lengths[long], strict=True)]
    for begin, end in runs:
        found[begin:end] = True
    # What stands still says nothing of how its neighbours move.
    live = {
        name: (values, np.where(found, np.nan, values))
        for name, values in zip(names, changing, strict=True)
        if name not in held
    }
    placed = [pair for name, pair in live.items() if words(name) & PLACED]
    for begin, end in runs:
        evident = any(_noise_rests(*pair, begin, end) for pair in live.values())
        if not evident and not any(_leaps(*pair, begin, end) for pair in placed):
            found[begin:end] = False
    return found


def _changes(values: FloatArray) -> bool:
    known = values[np.isfinite(values)]
    return known.size > 1 and bool(np.any(known != known[0]))


def _noise_rests(values: FloatArray, live: FloatArray, begin: int, end: int) -> bool:
    """Whether a signal bears noise on either side; live: the same, NaN where rows stand still."""
    sides = [part[np.isfinite(part)] for part in (live[:begin][-_BESIDE:], live[end:][:_BESIDE])]
    judged = [side for side in sides if side.size >= _NEAR]
    steps = np.abs(np.diff(values))
    finest = float(np.min(steps[steps > 0.0], initial=np.inf))
    return bool(judged) and all(white_noise(side) >= _STEPS * finest for side in judged)


def _leaps(values: FloatArray, live: FloatArray, begin: int, end: int) -> bool:
    if begin < _STAYS or end + _STAYS > values.size:
        return False
    leap = float(values[end] - values[end - 1])
    there = float(np.median(values[end : end + _STAYS])) - float(values[end - 1])
    near = [np.abs(np.diff(live[:begin][-_NEAR:])), np.abs(np.diff(live[end:][:_NEAR]))]
    largest = max((float(np.nanmax(one)) for one in near if np.isfinite(one).any()), default=0.0)
    return abs(leap - there) < 0.5 * abs(leap) and abs(leap) > _LEAP * largest > 0.0
