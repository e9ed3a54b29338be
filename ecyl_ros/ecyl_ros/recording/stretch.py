"""Which parts of a long recording tell most: chosen in one pass, in memory for the chunk."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..errors import InputError
from .map import SignalMap
from .mapped import wanted_of
from .signals import Recording
from .source import TableSource, open_source

BIN_S = 0.1  # noise averages out within, moves of a drive do not
_MOST_BINS = 40_000_000  # 46 days
_STEP_S = 1.0  # between the starts that are tried
_LIVELY = 0.25  # of the best part's score; what has less is rest
# Signals that show what a drive was put through, the ones to be preferred first.
_MOTION = ("reference_position_m", "reference_position_rad", "rod_position_m", "rotor_position_rad")
_SPEED = ("rotor_velocity_rad_per_s", "rod_velocity_m_per_s", "reference_velocity_m_per_s")
_EFFORT = ("rotor_torque_nm", "current_q_a", "rod_force_n", "voltage_q_v")


@dataclass(frozen=True)
class Stretch:
    """Part of a recording.

    Attributes:
        start_ns, stop_ns: by the recorder's clock; of a recording in memory by its stamps.
        begin_s, end_s: the same from the beginning of the recording.
    """

    start_ns: int
    stop_ns: int
    begin_s: float
    end_s: float


@dataclass(frozen=True)
class Stretches:
    """Parts of a recording that tell most.

    Attributes:
        whole_s: how long the recording is.
        by: what they were chosen by, in words.
        chosen: the best first; they do not overlap.
    """

    whole_s: float
    by: str
    chosen: tuple[Stretch, ...]

    @property
    def note(self) -> str:
        """A line that says which part is judged, of how much, and by what it was chosen."""
        best = self.chosen[0]
        return (
            f"{self.whole_s:.0f} s long: judged from {best.begin_s:.1f} s to {best.end_s:.1f} s, "
            f"chosen by {self.by}"
        )


class _Bins:
    """Sums of one signal over bins of time."""

    def __init__(self) -> None:
        self.count = np.zeros(0)
        self.total = np.zeros(0)
        self.squares = np.zeros(0)

    def take(self, index: NDArray[np.int64], values: FloatArray) -> None:
        """Values and the bins they fall into."""
        good = np.isfinite(values)
        index, values = index[good], values[good]
        if not index.size:
            return
        size = int(index.max()) + 1
        if size > self.count.size:
            grown = max(size, 2 * self.count.size)
            for name in ("count", "total", "squares"):
                own = getattr(self, name)
                setattr(self, name, np.pad(own, (0, grown - own.size)))
        low = int(index.min())
        for name, weights in (("count", None), ("total", values), ("squares", values * values)):
            added = np.bincount(index - low, weights=weights)
            getattr(self, name)[low : low + added.size] += added


def pick_stretches(
    path: str | Path,
    signal_map: SignalMap,
    longest_s: float,
    most: int = 1,
    progress: Callable[[float], None] | None = None,
    within_ns: tuple[int, int] | None = None,
) -> Stretches | None:
    """The parts of `longest_s` in which the drive was put through most: the best, and more.

    Each part is judged by the travel and the reversals of the position (the reference's where it
    is mapped), by how much of its range and of all speeds it covers, and by how the effort varies,
    each relative to the best part's, all less the share of samples missing. Means over 0.1 s are
    used, so that noise does not count. Beyond the best of all, the best of each of `most` equal
    parts of the recording is taken, so that what changes with time is met; not where it is rest.

    Args:
        path, signal_map: the recording, and which field is which signal.
        longest_s: length of a stretch.
        most: how many at the most.
        progress: called now and then with the share of the file gone through.
        within_ns: recorder's times between which to look; the stretches count from the first.

    Returns:
        None where the recording is no longer than `longest_s`, or a table (which is read whole).

    Raises:
        InputError: as `mapped.read_mapped`, or none of the mapped signals moves.
    """
    source = open_source(path)
    if isinstance(source, TableSource):
        return None
    bins: dict[str, _Bins] = {}
    origin, stop = (None, 2**62) if within_ns is None else within_ns
    last = 0
    wanted = wanted_of(source, signal_map)
    for part in source.columns(wanted, start_ns=origin, stop_ns=stop):
        log = part.log_time_ns
        if log is None or not log.size:
            continue
        if origin is None:
            origin = int(log[0])
        index = (log - origin) // round(BIN_S * 1e9)
        # A message of before the first, or of years later, is no part of the run.
        usable = (index >= 0) & (index < _MOST_BINS) & (log < stop)
        last = max(last, int(index[usable].max(initial=0)))
        for target, values in part.values.items():
            bins.setdefault(target, _Bins()).take(index[usable], values[usable])
        if progress is not None:
            progress(source.share)
    if origin is None:
        raise InputError(f"{path}: no message on any topic of {signal_map.source}")
    return _chosen(bins, last + 1, origin, longest_s, most)


def recording_stretches(
    recording: Recording, longest_s: float, most: int = 1, first_s: float = 0.0
) -> Stretches | None:
    """As `pick_stretches`, of a recording in memory; times are its stamps.

    first_s: when it begins, where it is part of a longer one.
    """
    index = (recording.stamp_ns - recording.stamp_ns[:1]) // round(BIN_S * 1e9)
    if not index.size or index[-1] >= _MOST_BINS:
        return None
    bins: dict[str, _Bins] = {}
    for name in {*_MOTION, *_SPEED, *_EFFORT}:
        if recording.has(name):
            bins[name] = _Bins()
            bins[name].take(index, recording.signal(name))
    count, origin = int(index[-1]) + 1, int(recording.stamp_ns[0])
    return _chosen(bins, count, origin, longest_s, most, first_s)


def _chosen(
    bins: dict[str, _Bins],
    count: int,
    origin_ns: int,
    longest_s: float,
    most: int,
    first_s: float = 0.0,
) -> Stretches | None:
    width = round(longest_s / BIN_S)
    if count <= width:
        return None
    step = max(1, round(_STEP_S / BIN_S))
    starts = np.arange(0, count - width + step, step)
    starts = np.minimum(starts, count - width)
    score, by = _scores(bins, starts, width, count)
    best = int(np.argmax(score))
    taken = [best]
    free = np.abs(starts - starts[best]) >= width
    free &= score >= _LIVELY * float(score[best])
    sections = max(1, min(most, count // width))
    bounds = np.linspace(0.0, float(starts[-1]) + 1.0, sections + 1)
    for low, high in itertools.pairwise(bounds):
        within = np.flatnonzero(free & (starts >= low) & (starts < high))
        if within.size and len(taken) < most:
            found = int(within[np.argmax(score[within])])
            taken.append(found)
            free &= np.abs(starts - starts[found]) >= width
    taken.sort(key=lambda one: -float(score[one]))
    tick = round(BIN_S * 1e9)
    length_ns = round(longest_s * 1e9)
    chosen = []
    for one in taken:
        begin = int(starts[one])
        start_ns = origin_ns + begin * tick
        begin_s = first_s + begin * BIN_S
        chosen.append(Stretch(start_ns, start_ns + length_ns, begin_s, begin_s + longest_s))
    return Stretches(count * BIN_S, by, tuple(chosen))


def _scores(
    bins: dict[str, _Bins], starts: NDArray[np.int64], width: int, count: int
) -> tuple[FloatArray, str]:
    ends = starts + width

    def within(values: FloatArray) -> FloatArray:
        summed = np.concatenate([[0.0], np.cumsum(values)])
        parts: FloatArray = summed[ends] - summed[starts]
        return parts

    score = np.zeros(starts.size)
    named: list[str] = []
    motion = next((name for name in _MOTION if name in bins), None)
    if motion is not None:
        mean = _means(bins[motion], count)
        step = np.diff(mean, prepend=mean[0])
        span = float(np.ptp(mean)) or 1.0
        # A rest is no reversal: steps of less than a thousandth of the range do not count.
        way = np.where(np.abs(step) > 1e-3 * span, np.sign(step), 0.0)
        moving = way[way != 0.0]
        turned = np.zeros(count)
        turned[np.flatnonzero(way)[1:]] = np.diff(moving) != 0.0
        score += _relative(within(np.abs(step)))
        score += _relative(within(turned))
        covered = [float(np.ptp(mean[a:b])) for a, b in zip(starts, ends, strict=True)]
        score += _relative(np.array(covered))
        named += ["travel", "reversals", "range"]
    for names, what in ((_SPEED, "speed"), (_EFFORT, "effort")):
        found = next((name for name in names if name in bins), None)
        if found is None:
            continue
        own = bins[found]
        total, squares, held = own.total[:count], own.squares[:count], own.count[:count]
        filled = [np.pad(one, (0, count - one.size)) for one in (total, squares, held)]
        many = np.maximum(within(filled[2]), 1.0)
        variance = within(filled[1]) / many - (within(filled[0]) / many) ** 2
        score += _relative(np.sqrt(np.maximum(variance, 0.0)))
        named.append(what)
    for own in bins.values():
        held = np.pad(own.count[:count], (0, count - own.count[:count].size))
        usual = float(np.median(held[held > 0])) if (held > 0).any() else 1.0
        lacking = within((held < 0.5 * usual).astype(np.float64)) / width
        score -= 4.0 * lacking / len(bins)
    return score, ", ".join(named) or "nothing"


def _means(own: _Bins, count: int) -> FloatArray:
    held = np.pad(own.count[:count], (0, max(0, count - own.count.size)))
    total = np.pad(own.total[:count], (0, max(0, count - own.total.size)))
    known = np.flatnonzero(held)
    return np.interp(np.arange(count), known, total[known] / held[known])


def _relative(values: FloatArray) -> FloatArray:
    most = float(values.max(initial=0.0))
    return values / most if most > 0.0 else np.zeros(values.size)
