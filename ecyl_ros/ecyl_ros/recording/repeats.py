"""Rows that a logger has repeated: all signals stand still together, and should not have.

A drive at rest with coarse signals stands still, too. So there has to be evidence, in one signal at
least: its noise rests with it; or, of a measured position, which cannot leap, that it does at the
end, by far more than it moves on either side, to where it then stays. What is worked out of other
columns, as the effort of a controller from a position, rests whenever they do and is none.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping

import numpy as np

from ..arrays import BoolArray, FloatArray
from .names import PLACED, words
from .whiteness import white_noise

_SHORTEST = 5  # rows of a stretch
_RARER = 5.0  # times the usual run of equal rows
_BY_CHANCE = 1e-6  # runs that long, expected of rows that are equal as often as these
_FEWEST = 50  # runs that say how long is usual
_BESIDE = 50  # rows on either side, that noise is taken from
_NEAR, _STAYS = 25, 5  # rows on either side that a pace is taken from, that it stays for
_LEAP = 4.0  # times the largest step on either side
_STEPS = 3.0  # of the smallest kind, that noise has to be above
_OF_ITSELF = 0.5  # of its steps beside others that stand still; noise that is seen makes nearly all


def repeated_rows(signals: Mapping[str, FloatArray], held: Collection[str] = ()) -> BoolArray:
    """bool[n], True where a logger repeats a row; of signals float64[n] by name.

    held: signals that may hold a value and leap (commands), and hence are no evidence.
    """
    changing = {name: values for name, values in signals.items() if _changes(values)}
    runs = _standstills(changing)
    found = _rows(runs, signals)
    # What stands still says nothing of how its neighbours move.
    evidence = _of_themselves(changing, found) - set(held) if runs else set[str]()
    live = {name: (signals[name], np.where(found, np.nan, signals[name])) for name in evidence}
    placed = [pair for name, pair in live.items() if words(name) & PLACED]
    for begin, end in runs:
        evident = any(_noise_rests(*pair, begin, end) for pair in live.values())
        if not evident and not any(_leaps(*pair, begin, end) for pair in placed):
            found[begin:end] = False
    return found


def worked_out(signals: Mapping[str, FloatArray]) -> set[str]:
    """Names of the signals that change only where others do: what a controller works out of them.

    Positions are none of these.
    """
    changing = {name: values for name, values in signals.items() if _changes(values)}
    return set(changing) - _of_themselves(changing, _rows(_standstills(changing), signals))


def _rows(runs: Iterable[tuple[int, int]], signals: Mapping[str, FloatArray]) -> BoolArray:
    out = np.zeros(next(iter(signals.values())).size if signals else 0, dtype=bool)
    for begin, end in runs:
        out[begin:end] = True
    return out


def _same(signals: Iterable[FloatArray]) -> BoolArray:
    """Where each value is the one before, bool[signals, n - 1]."""
    return np.array(
        [
            (values[1:] == values[:-1]) | (np.isnan(values[1:]) & np.isnan(values[:-1]))
            for values in signals
        ]
    )


def _standstills(signals: Mapping[str, FloatArray]) -> list[tuple[int, int]]:
    """Rows, the end one beyond, in which all stand still for far longer than elsewhere."""
    if len(signals) < 2:
        return []
    known = np.any([np.isfinite(values) for values in signals.values()], axis=0)
    still = np.all(_same(signals.values()), axis=0) & known[1:]
    starts = np.concatenate([[0], np.flatnonzero(~still) + 1])
    lengths = np.diff(np.append(starts, known.size))
    if starts.size < _FEWEST:
        return []
    usual = float(np.quantile(lengths, 0.95, method="lower"))
    long = lengths >= max(_SHORTEST, _RARER * usual)
    equal = float((lengths[~long] - 1).sum()) / max(float(lengths[~long].sum()), 1.0)
    long &= starts.size * equal ** (lengths - 1.0) < _BY_CHANCE
    return [(int(a), int(a + n)) for a, n in zip(starts[long], lengths[long], strict=True)]


def _of_themselves(signals: Mapping[str, FloatArray], still: BoolArray) -> set[str]:
    """Names of the positions, and of what changes where all others stand still, or they never do.

    For two steps, for a controller that takes a difference looks back by one.

    still: bool[n], rows that may be repeated and tell nothing.
    """
    same = _same(signals.values())
    out = set()
    for at, name in enumerate(signals):
        others = np.all(np.delete(same, at, axis=0), axis=0)
        others[1:] &= others[:-1]
        others &= ~still[1:]
        changes = not others.any() or float(np.mean(same[at][others])) < _OF_ITSELF
        if changes or words(name) & PLACED:
            out.add(name)
    return out


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
