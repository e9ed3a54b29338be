"""Which part of a long recording tells most: chosen in one pass, in memory for the chunk."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from .map import SignalMap
from .mapped import wanted_of
from .source import TableSource, open_source

BIN_S = 0.1  # noise averages out within, moves of a drive do not
_MOST_BINS = 40_000_000  # 46 days
_STEP_S = 1.0  # between the starts that are tried
# Signals that show what a drive was put through, the ones to be preferred first.
_MOTION = ("reference_position_m", "reference_position_rad", "rod_position_m", "rotor_position_rad")
_SPEED = ("rotor_velocity_rad_per_s", "rod_velocity_m_per_s", "reference_velocity_m_per_s")
_EFFORT = ("rotor_torque_nm", "current_q_a", "rod_force_n", "voltage_q_v")


@dataclass(frozen=True)
class Stretch:
    """Part of a recording.

    Attributes:
        start_ns, stop_ns: by the recorder's clock.
        note: a line that says which part, of how much, and by what it was chosen.
    """

    start_ns: int
    stop_ns: int
    note: str


class _Bins:
    """Sums of one signal over bins of time."""

    def __init__(self) -> None:
        self.count = np.zeros(0)
        self.total = np.zeros(0)
        self.squares = np.zeros(0)

    def take(self, index: NDArray[np.int64], values: NDArray[np.float64]) -> None:
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


def pick_stretch(path: str | Path, signal_map: SignalMap, longest_s: float) -> Stretch | None:
    """The part of up to `longest_s` in which the drive was put through most.

    Each part is judged by the travel and the reversals of the position (the reference's where it
    is mapped), by how much of its range and of all speeds it covers, and by how the effort varies,
    each relative to the best part's, all less the share of samples missing. Means over 0.1 s are
    used, so that noise does not count.

    Returns:
        None where the recording is no longer than `longest_s`, or a table (which is read whole).

    Raises:
        InputError: as `mapped.read_mapped`, or none of the mapped signals moves.
    """
    source = open_source(path)
    if isinstance(source, TableSource):
        return None
    bins: dict[str, _Bins] = {}
    origin: int | None = None
    last = 0
    for part in source.columns(wanted_of(source, signal_map)):
        log = part.log_time_ns
        if log is None or not log.size:
            continue
        if origin is None:
            origin = int(log[0])
        index = (log - origin) // round(BIN_S * 1e9)
        # A message of before the first, or of years later, is no part of the run.
        usable = (index >= 0) & (index < _MOST_BINS)
        last = max(last, int(index[usable].max(initial=0)))
        for target, values in part.values.items():
            bins.setdefault(target, _Bins()).take(index[usable], values[usable])
    if origin is None:
        raise InputError(f"{path}: no message on any topic of {signal_map.source}")
    count = last + 1
    width = round(longest_s / BIN_S)
    if count <= width:
        return None
    step = max(1, round(_STEP_S / BIN_S))
    starts = np.arange(0, count - width + step, step)
    starts = np.minimum(starts, count - width)
    score, by = _scores(bins, starts, width, count)
    best = int(starts[int(np.argmax(score))])
    begin_s, whole_s = best * BIN_S, count * BIN_S
    note = (
        f"{whole_s:.0f} s long: judged from {begin_s:.1f} s to {begin_s + longest_s:.1f} s, chosen "
        f"by {by}"
    )
    start_ns = origin + best * round(BIN_S * 1e9)
    return Stretch(start_ns, start_ns + round(longest_s * 1e9), note)


def _scores(
    bins: dict[str, _Bins], starts: NDArray[np.int64], width: int, count: int
) -> tuple[NDArray[np.float64], str]:
    ends = starts + width

    def within(values: NDArray[np.float64]) -> NDArray[np.float64]:
        summed = np.concatenate([[0.0], np.cumsum(values)])
        parts: NDArray[np.float64] = summed[ends] - summed[starts]
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


def _means(own: _Bins, count: int) -> NDArray[np.float64]:
    held = np.pad(own.count[:count], (0, max(0, count - own.count.size)))
    total = np.pad(own.total[:count], (0, max(0, count - own.total.size)))
    known = np.flatnonzero(held)
    return np.interp(np.arange(count), known, total[known] / held[known])


def _relative(values: NDArray[np.float64]) -> NDArray[np.float64]:
    most = float(values.max(initial=0.0))
    return values / most if most > 0.0 else np.zeros(values.size)
