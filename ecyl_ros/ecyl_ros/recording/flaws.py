"""Stretches of a recording that say nothing: frozen, repeated, cut off, at the end of their range.

A drive at rest, a coarse encoder, a command that holds and a limit that is reached all leave a
signal the same for long, and are no flaw. So a long run of equal values counts as frozen only with
evidence that it should have changed, one of:

- noise: up to the run and from its end on the signal carries noise of several times its finest
  step, and within the run no sample differs. The noise of a sensor does not rest with the drive.
- leap: at the end of the run the signal leaps by far more than in any other sample, to where it
  then stays: what moves cannot get there at once, so it moved unseen.
- speed: the same body's own speed, less its offset, carries it far over its step in the run.
- motion: while a position runs on at its usual pace, a speed or an effort rests for many times its
  longest run of equal values in such motion. Positions are not judged by this: they can stick.

Where all signals of a topic stand still together and one of them has such evidence, the logger has
repeated its last sample, and nothing in it holds; such runs may be much shorter, see `repeats`.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..arrays import BoolArray, FloatArray, StampArray
from .carried import carried_way
from .names import PLACED, QUANTITY, words
from .repeats import repeated_rows, worked_out
from .runs import runs_of
from .whiteness import white_noise

FROZEN, REPEATED, CUT_END, SATURATED = "frozen", "repeated", "cut_end", "saturated"
_SHORTEST = 20  # samples of a frozen stretch
_RARER = 10.0  # times the usual run of equal values
_BY_CHANCE = 1e-6  # runs that long, expected of the signal's own statistics
_FEWEST_RUNS = 50
_VALUES = 12  # different ones; a signal of fewer is a state, not a measurement
_BESIDE = 50  # samples on either side of a run that noise is taken from
_NOISE_STEPS = 3.0  # a signal's finest steps
_NEAR = 25  # samples on either side, that a pace is taken from
_PAUSE = 2.5  # steps of time
_LEAP = 5.0  # times the largest other step
_LEAPING = ("effort", "current", "voltage")  # what a command may make leap
_CARRIED = 0.02  # of the range, that the speed has to carry a frozen position
_RESTS = 5  # samples at the end of an integer range
_SUDDEN = 0.15  # of the usual step, with which a signal runs into the end of its range
_RANGES = (12, 13, 14, 16, 24, 32)  # bits of integers whose ends are known


@dataclass(frozen=True)
class Flaw:
    """Rows of one topic whose values are not to be used.

    Attributes:
        kind: `frozen`, `repeated` (all signals at once), `cut_end` or `saturated`.
        fields: whose values.
        begin, end: rows, the end one beyond the last.
        begin_ns, end_ns: stamps of the first and the last of them.
        value: that a saturated field rests at; NaN for other kinds.
        times: how many stretches; of a saturated field begin and end are the first's and last's.
        samples: rows in all.
    """

    kind: str
    fields: tuple[str, ...]
    begin: int
    end: int
    begin_ns: int
    end_ns: int
    samples: int
    value: float = math.nan
    times: int = 1

    def rows(self, values: FloatArray) -> BoolArray | slice:
        """Which of the rows of a field are meant."""
        if self.kind == SATURATED:
            return np.asarray(values == self.value)
        return slice(self.begin, self.end)

    def text(self, origin_ns: int | None, names: Mapping[str, str] | None = None) -> str:
        """One line: what it is, and from when to when, in s from the origin, or in rows."""
        when = f"from row {self.begin + 1} to row {self.end}"
        if origin_ns is not None:
            begin, end = ((at - origin_ns) / 1e9 for at in (self.begin_ns, self.end_ns))
            when = f"from {begin:.3f} s to {end:.3f} s"
        named = names or {}
        shown = [named.get(one, one) for one in self.fields]
        who = ", ".join(shown[:6]) + (f" and {len(shown) - 6} more" if len(shown) > 6 else "")
        if self.kind == REPEATED:
            return f"all signals repeat one sample {self.samples} times, {when}"
        if self.kind == CUT_END:
            return f"{who}: the end is cut off: {self.samples} rows of zeros, {when}"
        if self.kind == SATURATED:
            return (
                f"{who}: rests at {self.value:.16g}, the end of its integer range, in "
                f"{self.samples} samples, {when}"
            )
        return f"{who}: frozen, the very same value for {self.samples} samples, {when}"


@dataclass(frozen=True)
class _Runs:
    """Runs of equal values of one field.

    Attributes:
        values: float64[n].
        starts, lengths: int64[r].
        usual: length that all but a hundredth of the runs stay below.
        finest: smallest step between two samples.
        largest: largest step between two samples, but for those that end a long run.
        long: the runs that are far longer than usual.
    """

    values: FloatArray
    starts: NDArray[np.intp]
    lengths: NDArray[np.intp]
    usual: float
    finest: float
    largest: float
    long: NDArray[np.intp]

    @property
    def lively(self) -> bool:
        """Whether there is anything to tell a frozen stretch by."""
        return self.starts.size > _FEWEST_RUNS and np.isfinite(self.finest)


def find_flaws(
    stamps_ns: StampArray,
    columns: Mapping[str, FloatArray],
    *,
    held: Collection[str] = (),
    speeds: Mapping[str, str] | None = None,
    last: bool = True,
) -> list[Flaw]:
    """What of one topic's samples is not to be used.

    Args:
        stamps_ns: int64[n].
        columns: field -> float64[n], in file order.
        held: fields that may hold a value for long (commands, states); they count as frozen only
            where everything does.
        speeds: position -> speed of the same body, both in SI.
        last: whether these are the topic's last samples.
    """
    if stamps_ns.size < 2 * _SHORTEST:
        return []
    cut = _cut_end(columns) if last else 0
    end = stamps_ns.size - cut
    out: list[Flaw] = []
    if cut:
        out.append(_flaw(CUT_END, tuple(columns), end, end + cut, stamps_ns))
    runs = {name: _runs(values[:end]) for name, values in columns.items()}
    judged = {name: own for name, own in runs.items() if own.lively}
    seen: dict[tuple[int, int], set[str]] = {}
    # What holds or bears noise shows no motion.
    paces = [columns[name] for name in judged if name not in held and _smooth(columns[name][:end])]
    dependent = worked_out(columns)
    for name, own in judged.items():
        if name in held or name in dependent:
            continue
        speed = columns.get((speeds or {}).get(name, ""))
        for run in own.long.tolist():
            others = [] if words(name) & PLACED else paces
            if _evident(own, run, speed, stamps_ns, leaps=not _is_effort(name)) or _rests_in_motion(
                own, run, [other for other in others if other is not columns[name]]
            ):
                begin = int(own.starts[run])
                seen.setdefault((begin, begin + int(own.lengths[run])), set()).add(name)
    changing = [name for name, own in runs.items() if own.starts.size > 1]
    for (begin, stop), names in _joined(seen):
        still = {name for name in changing if _still(columns[name], begin, stop)}
        together = {name for name in still if name in judged and _same_run(runs[name], begin, stop)}
        if len(changing) > 1 and still == set(changing):
            out.append(_flaw(REPEATED, tuple(columns), begin, stop, stamps_ns))
        else:
            fields = tuple(name for name in columns if name in names | (together - set(held)))
            out.append(_flaw(FROZEN, fields, begin, stop, stamps_ns))
    repeated = repeated_rows({name: values[:end] for name, values in columns.items()}, held)
    for flaw in out:
        if flaw.kind == REPEATED:
            repeated[flaw.begin : flaw.end] = False
    more = [
        _flaw(REPEATED, tuple(columns), begin, stop, stamps_ns)
        for begin, stop in runs_of(repeated).tolist()
    ]
    out = [*(flaw for flaw in out if not any(_within(flaw, other) for other in more)), *more]
    out += [
        one
        for name in columns
        if (one := _saturated(name, columns[name][:end], stamps_ns)) is not None
    ]
    return sorted(out, key=lambda one: (one.begin, one.kind))


def _within(one: Flaw, other: Flaw) -> bool:
    return other.begin <= one.begin and one.end <= other.end


def _flaw(kind: str, fields: tuple[str, ...], begin: int, end: int, stamps: StampArray) -> Flaw:
    return Flaw(kind, fields, begin, end, int(stamps[begin]), int(stamps[end - 1]), end - begin)


def _runs(values: FloatArray) -> _Runs:
    # NaN differs from itself, so that samples missing end a run.
    starts = np.concatenate([[0], np.flatnonzero(values[1:] != values[:-1]) + 1])
    lengths = np.diff(np.append(starts, values.size))
    known = np.isfinite(values[starts])
    starts, lengths = starts[known], lengths[known]
    nothing = np.zeros(0, dtype=np.intp)
    if starts.size <= _FEWEST_RUNS or not _varied(values[starts]):
        return _Runs(values, starts, lengths, math.inf, math.nan, math.inf, nothing)
    usual = float(np.quantile(lengths, 0.99, method="lower"))
    long = np.flatnonzero(lengths >= max(_SHORTEST, _RARER * usual))
    ordinary = np.ones(starts.size, dtype=bool)
    ordinary[long] = False
    equal = float((lengths[ordinary] - 1).sum()) / max(float(lengths[ordinary].sum()), 1.0)
    if equal > 0.0 and long.size:
        chance = starts.size * equal ** (lengths[long] - 1.0)
        long = long[chance < _BY_CHANCE]
    level = values[starts]
    steps = np.abs(np.diff(level))
    after = np.zeros(steps.size, dtype=bool)
    after[long[long < steps.size]] = True
    usual_steps = steps[~after]
    positive = steps[steps > 0.0]
    return _Runs(
        values,
        starts,
        lengths,
        usual,
        float(positive.min()) if positive.size else math.nan,
        float(usual_steps.max(initial=0.0)),
        long,
    )


def _varied(values: FloatArray) -> bool:
    """Whether there are more different values than states have."""
    few = values[: 1024 * _VALUES]
    return np.unique(few).size >= _VALUES or np.unique(values).size >= _VALUES


def _is_effort(name: str) -> bool:
    """Whether a field may leap of itself: an effort does with its command."""
    return any(QUANTITY.get(word, "").startswith(_LEAPING) for word in words(name))


def _evident(
    own: _Runs, run: int, speed: FloatArray | None, stamps: StampArray, *, leaps: bool
) -> bool:
    begin = int(own.starts[run])
    end = begin + int(own.lengths[run])
    return (
        _noise_rests(own, begin, end)
        or (leaps and _leaps(own, begin, end, stamps))
        or (speed is not None and _carried(own, begin, end, speed, stamps))
    )


def _at_rail(own: _Runs, begin: int) -> bool:
    """A limit that is reached, or a current that is switched off, bears no noise either."""
    value = float(own.values[begin])
    known = own.values[np.isfinite(own.values)]
    return value == 0.0 or value in (float(known.min()), float(known.max()))


def _noise_rests(own: _Runs, begin: int, end: int) -> bool:
    if _at_rail(own, begin):
        return False
    sides = [own.values[max(0, begin - _BESIDE) : begin], own.values[end : end + _BESIDE]]
    judged = [side for side in sides if side.size >= _SHORTEST]
    return bool(judged) and all(white_noise(side) >= _NOISE_STEPS * own.finest for side in judged)


def _leaps(own: _Runs, begin: int, end: int, stamps: StampArray) -> bool:
    values = own.values
    if end + _RESTS >= values.size or begin < _RESTS:
        return False
    # Behind samples that were lost it may be anywhere.
    if stamps[end] - stamps[end - 1] > _PAUSE * float(np.median(np.diff(stamps[begin:end]))):
        return False
    leap = float(values[end] - values[end - 1])
    after = values[end : end + _RESTS]
    there = float(np.median(after)) - float(values[end - 1])
    # A lone outlier comes back; what moved unseen stays where it is, and had the time for it.
    stays = math.isfinite(there) and abs(leap - there) < 0.5 * abs(leap)
    return stays and _LEAP * own.largest < abs(leap) <= (end - begin) * own.largest


def _smooth(values: FloatArray) -> bool:
    """Whether a signal's single steps add up to the way it makes: a position, no noise."""
    known = values[np.isfinite(values)]
    way = float(np.abs(known[2 * _NEAR :] - known[: -2 * _NEAR]).sum())
    return bool(way > 0.5 * 2 * _NEAR * np.abs(np.diff(known)).sum() > 0.0)


def _moving(values: FloatArray) -> BoolArray:
    """Where a smooth signal goes at half its usual pace or faster."""
    out = np.zeros(values.size, dtype=bool)
    if values.size <= 4 * _NEAR:
        return out
    way = np.abs(values[2 * _NEAR :] - values[: -2 * _NEAR])
    going = way[way > 0.0]
    if going.size:
        out[_NEAR:-_NEAR] = way >= 0.5 * float(np.median(going))
    return out


def _rests_in_motion(own: _Runs, run: int, others: list[FloatArray]) -> bool:
    begin = int(own.starts[run])
    length = int(own.lengths[run])
    values = own.values
    # A position can stick while its drive goes on.
    if _at_rail(own, begin) or _smooth(values):
        return False
    ordinary = np.ones(own.starts.size, dtype=bool)
    ordinary[own.long] = False
    for other in others:
        moving = _moving(other[: values.size])
        if float(moving[begin : begin + length].mean()) < 0.9:
            continue
        longest = own.lengths[ordinary & moving[own.starts]].max(initial=1)
        if length >= _RARER * float(longest):
            return True
    return False


def _carried(own: _Runs, begin: int, end: int, speed: FloatArray, stamps: StampArray) -> bool:
    way = carried_way(own.values, begin, end, speed, stamps)
    values = own.values[np.isfinite(own.values)]
    return way > max(20.0 * own.finest, _CARRIED * float(np.ptp(values)), _LEAP * own.largest)


def _joined(
    seen: Mapping[tuple[int, int], set[str]],
) -> Iterable[tuple[tuple[int, int], set[str]]]:
    """Runs of several fields that are one stretch: their ends differ by a sample at most."""
    left = dict(sorted(seen.items()))
    while left:
        (begin, end), names = next(iter(left.items()))
        same = [key for key in left if abs(key[0] - begin) <= 1 and abs(key[1] - end) <= 1]
        names = set().union(*(left.pop(key) for key in same))
        yield (max(key[0] for key in same), min(key[1] for key in same)), names


def _still(values: FloatArray, begin: int, end: int) -> bool:
    part = values[begin:end]
    return bool((part == part[0]).all() | np.isnan(part).all())


def _same_run(own: _Runs, begin: int, end: int) -> bool:
    place = int(np.searchsorted(own.starts, begin, side="right")) - 1
    if place < 0:
        return False
    first = int(own.starts[place])
    return abs(first - begin) <= 1 and abs(first + int(own.lengths[place]) - end) <= 1


def _cut_end(columns: Mapping[str, FloatArray]) -> int:
    """How many rows at the end are nothing but zeros that the signals cannot have got to."""
    changing = {
        name: values
        for name, values in columns.items()
        if np.isfinite(values).any() and np.nanmin(values) < np.nanmax(values)
    }
    if len(changing) < 2:
        return 0
    zero = np.all([values == 0.0 for values in changing.values()], axis=0)
    filled = np.flatnonzero(~zero)
    if not filled.size or filled[-1] + 1 == zero.size:
        return 0
    end = int(filled[-1]) + 1
    leaps, fell = 0, 0
    for values in changing.values():
        before = values[max(0, end - 1)]
        steps = np.abs(np.diff(values[:end]))
        largest = float(np.nanmax(steps, initial=0.0))
        fell += bool(np.isfinite(before) and before != 0.0)
        leaps += bool(np.isfinite(before) and abs(before) > _LEAP * largest > 0.0)
    before_all_zero = bool(zero[:end].any())
    if leaps or (fell >= 3 and fell == len(changing) and not before_all_zero):
        return int(zero.size - end)
    return 0


def _saturated(name: str, values: FloatArray, stamps: StampArray) -> Flaw | None:
    """A whole number that runs into the end of its range and stays there."""
    known = values[np.isfinite(values)]
    if known.size < 2 * _SHORTEST:
        return None
    low, high = float(known.min()), float(known.max())
    ends = {value for bits in _RANGES for value in (2.0**bits - 1.0, 2.0 ** (bits - 1) - 1.0)}
    floors = {-(2.0 ** (bits - 1)) for bits in _RANGES}
    rails = ([high] if high in ends else []) + ([low] if low in floors else [])
    if not rails or not bool((known == np.round(known)).all()) or not _varied(known):
        return None
    size = np.abs(np.diff(known))
    if float(size.max()) > 0.5 * (high - low):  # it goes from end to end: it starts again
        return None
    for rail in rails:
        at = values == rail
        begins, stops = runs_of(at).T
        resting = (stops - begins) >= _RESTS
        if not resting.any():
            continue
        # It comes to rest there from full motion, not by slowing down to it.
        sudden = any(
            _sudden(values, int(begin), int(stop))
            for begin, stop in zip(begins[resting], stops[resting], strict=True)
        )
        if not sudden:
            continue
        first, final = int(begins[resting][0]), int(stops[resting][-1])
        found = _flaw(SATURATED, (name,), first, final, stamps)
        return Flaw(
            found.kind,
            found.fields,
            first,
            final,
            found.begin_ns,
            found.end_ns,
            int(at.sum()),
            rail,
            int(resting.sum()),
        )
    return None


def _sudden(values: FloatArray, begin: int, stop: int) -> bool:
    """Whether the signal runs into a run of equal values, or out of it, at its ordinary speed."""
    steps = np.abs(np.diff(values))
    usual = float(np.nanmedian(steps[steps > 0.0])) if (steps > 0.0).any() else 0.0
    sides = []
    if begin >= 4:
        sides.append(abs(float(values[begin - 1] - values[begin - 4])) / 3.0)
    if stop + 4 <= values.size:
        sides.append(abs(float(values[stop + 3] - values[stop])) / 3.0)
    return bool(sides) and max(sides) >= _SUDDEN * usual > 0.0
