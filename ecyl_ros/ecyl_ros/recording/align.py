"""Samples of several topics on one grid: sorted, on one clock, resampled where that is needed."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from ..arrays import BoolArray, FloatArray, StampArray
from ..errors import InputError
from ..number_of import number_of
from .clocks import ClockFit, ClockMeter, longest_run, steadied
from .held import fresh_rows
from .signals import Recording

BRIDGED = 5.0  # steps; a shorter pause is filled in, a longer one stays a gap
EVEN = 0.02  # of a step, by which steps may differ and still count as even
SAME_CLOCK_S = 0.02  # transport delays reach this; clocks that differ by less are taken for one
DRIFTED_S = 0.002  # over the recording: a drift of less is none
_APART_NS = 30_000_000_000  # a longer pause makes two recordings; the longer one is used
_LARGEST = 1e100  # of a value; slopes of larger ones leave the range of a float64
# Commands and currents jump; a spline would ring there.
_LINEAR = ("current_", "voltage_", "rotor_torque", "rod_force")


@dataclass
class Stream:
    """One topic's samples.

    Attributes:
        name: what notes call it.
        stamps_ns: int64[n] by the clock in use, in file order.
        log_ns: int64[n], the recorder's times; None in a table.
        by: `header`, `bag` or `table`: whose the stamps are.
        signals: float64[n] in SI by `Recording` field.
    """

    name: str
    stamps_ns: StampArray
    log_ns: StampArray | None
    by: str
    signals: dict[str, FloatArray]
    notes: list[str] = field(default_factory=list)

    @property
    def step_ns(self) -> float:
        """Median step; NaN with fewer than two samples."""
        return float(np.median(np.diff(self.stamps_ns))) if self.stamps_ns.size > 1 else math.nan

    def keep(self, rows: NDArray[np.intp] | BoolArray | slice) -> None:
        """Only these rows."""
        self.stamps_ns = self.stamps_ns[rows]
        self.log_ns = None if self.log_ns is None else self.log_ns[rows]
        self.signals = {name: values[rows] for name, values in self.signals.items()}

    def tidy(self) -> None:
        """Put the stamps in order, each once, on one setting of the clock; note what that took."""
        part, jumps = longest_run(self.stamps_ns, self.log_ns)
        if jumps:
            lost = self.stamps_ns.size - (part.stop - part.start)
            self.notes.append(
                f"{self.name}: its clock was set {jumps} times: the longest run is used, "
                f"{lost} samples are left out"
            )
            self.keep(part)
        backward = int((self.stamps_ns < np.maximum.accumulate(self.stamps_ns)).sum())
        if backward:
            self.notes.append(f"{self.name}: {backward} samples out of order: sorted")
            self.keep(np.argsort(self.stamps_ns, kind="stable"))
        again = np.flatnonzero(np.diff(self.stamps_ns) == 0) + 1
        if again.size:
            alike = np.ones(again.size, dtype=bool)
            for values in self.signals.values():
                same = values[again] == values[again - 1]
                alike &= same | ~np.isfinite(values[again])
            other = int((~alike).sum())
            what = f", {other} of them with other values" if other else ""
            self.notes.append(
                f"{self.name}: {again.size} stamps repeated{what}: the first of each is kept"
            )
            keep = np.ones(self.stamps_ns.size, dtype=bool)
            keep[again] = False
            self.keep(keep)

    def freshen(self) -> None:
        """Leave out rows that repeat a position which is refreshed more slowly than the others."""
        fresh = fresh_rows(self.signals)
        if fresh is not None:
            apart_s = float(np.median(np.diff(self.stamps_ns[fresh]))) * 1e-9
            self.notes.append(
                f"{self.name}: the position is new only every {1e3 * apart_s:.3g} ms: the rows "
                "between, which repeat it, are left out (log it as often as the others)"
            )
            self.keep(fresh)


def aligned(streams: list[Stream], *, source: str, gap_s: float | None = None) -> Recording:
    """One recording of all streams.

    Stamps are sorted and each kept once. Topics whose clocks differ are put on that of the fastest
    measured topic, by a line through the least differences to the recorder's clock. Arrival times
    that stray from an even beat are put back to it. The grid is that of the fastest measured
    topic: its own samples where they are even but for those lost, else an even grid of its mean
    step. Signals of other stamps come by cubic spline (positions, speeds) or linear interpolation
    (currents, voltages, efforts) and are NaN in pauses longer than five of their own steps, or
    gap_s. In such pauses of the fastest topic there are no samples at all.

    Args:
        streams: one or more, each with a sample at least.
        source: what messages call the recording.
        gap_s: see above; five steps by default.

    Raises:
        InputError: topics that have no time in common.
    """
    notes: list[str] = []
    for one in streams:
        one.tidy()
        one.freshen()
    base = _base(streams)
    _one_clock(streams, base)
    for one in streams:
        if one.by == "bag":
            _steady(one)
    grid = _grid(base, gap_s)
    grid = _in_reach(grid, streams, base, source)
    signals: dict[str, Any] = {}
    for one in streams:
        signals.update(_on_grid(one, grid, gap_s))
    for one in streams:
        notes += one.notes
    return Recording(stamp_ns=grid, **signals, notes=tuple(f"{source}: {note}" for note in notes))


def _base(streams: list[Stream]) -> Stream:
    """The fastest topic that holds something measured; of equally fast ones the first."""
    measured = [
        one
        for one in streams
        if any(not name.startswith("reference_") for name in one.signals) and one.step_ns > 0
    ]
    # In whole us: of topics that are equally fast but for jitter the first is taken.
    return min(
        measured or streams,
        key=lambda one: round(one.step_ns / 1e3) if one.step_ns > 0.0 else math.inf,
    )


def _fit(one: Stream) -> ClockFit | None:
    if one.by != "header" or one.log_ns is None:
        return None
    meter = ClockMeter()
    meter.take(one.stamps_ns, one.log_ns)
    return meter.fit()


def _one_clock(streams: list[Stream], base: Stream) -> None:
    """Put all stamps on the base topic's clock where they plainly run on another."""
    if all(np.array_equal(one.stamps_ns, base.stamps_ns) for one in streams):
        return
    fit = _fit(base)
    for one in streams:
        if one is base or one.by == "table":
            continue
        own = _fit(one)
        if own is None and fit is None:
            continue
        ends = one.stamps_ns[[0, -1]]
        shift = _shift(ends, own, fit)
        drift_s = float(shift[1] - shift[0])
        drift = drift_s / max((ends[1] - ends[0]) / 1e9, 1e-9)
        error = math.hypot(own.drift_error if own else 0.0, fit.drift_error if fit else 0.0)
        drifts = abs(drift_s) > DRIFTED_S and abs(drift) > 4.0 * error
        if float(np.abs(shift).max()) <= SAME_CLOCK_S and not drifts:
            continue
        moved = _shift(one.stamps_ns, own, fit)
        if not drifts:
            moved = np.full(one.stamps_ns.size, float(np.median(moved)))
        how = f" and loses {drift * 1e6:.1f} ppm" if drifts and drift > 0.0 else ""
        how = f" and gains {-drift * 1e6:.1f} ppm" if drifts and drift < 0.0 else how
        way = "behind" if moved[0] > 0.0 else "ahead of"
        one.notes.append(
            f"{one.name}: its clock is {abs(float(moved[0])):.6g} s {way} that of {base.name}{how}"
            ": corrected, except for differences of transport delays"
        )
        one.stamps_ns = one.stamps_ns + np.round(moved * 1e9).astype(np.int64)


def _shift(stamps: StampArray, own: ClockFit | None, base: ClockFit | None) -> FloatArray:
    """What to add to stamps, in s, to have them on the base topic's clock.

    own, base: None for stamps that are the recorder's already.
    """
    moved = np.zeros(stamps.size) if own is None else own.offset_at(stamps)
    if base is not None:
        log = stamps + np.round(moved * 1e9).astype(np.int64)
        # The base's stamp s has log time s + offset(s): solved for s by one correction, which
        # leaves drift squared times the time from the origin.
        guess = log - round(base.offset_s * 1e9)
        moved = moved - base.offset_at(guess)
    return moved


def _steady(one: Stream) -> None:
    step = one.step_ns
    if not step > 0.0:
        return
    steps = np.diff(one.stamps_ns) / step
    if bool((np.abs(steps - np.round(steps)) < EVEN).all()):
        return
    found = steadied(one.stamps_ns, BRIDGED)
    if found is None:
        return
    one.stamps_ns, moved_s = found
    one.notes.append(
        f"{one.name}: arrives unevenly ({moved_s * 1e3:.3g} ms rms): taken as sampled evenly at "
        f"{1e9 / one.step_ns:.6g} Hz"
    )


def _grid(base: Stream, gap_s: float | None) -> StampArray:
    stamps, step = base.stamps_ns, base.step_ns
    if not step > 0.0:
        return stamps
    apart = np.flatnonzero(np.diff(stamps) > _APART_NS) + 1
    if apart.size:
        edges = np.concatenate([[0], apart, [stamps.size]])
        longest = int(np.argmax(np.diff(edges)))
        base.notes.append(
            f"{base.name}: {apart.size} pauses of more than {_APART_NS // 10**9} s: the part with "
            f"most samples is used, {stamps.size - int(np.diff(edges)[longest])} are left out"
        )
        base.keep(slice(int(edges[longest]), int(edges[longest + 1])))
        stamps = base.stamps_ns
    ratio = np.diff(stamps) / step
    whole = np.maximum(np.round(ratio), 1.0)
    if bool((np.abs(ratio - whole) < EVEN * whole).all()):
        lost = int((whole - 1.0).sum())
        if lost:
            base.notes.append(
                f"{base.name}: {lost} samples lost, in {int((ratio > 1.5).sum())} places"
            )
        return stamps
    limit = _limit(step, gap_s)
    steps = np.diff(stamps)
    inside = steps <= limit
    mean = float(steps[inside].mean()) if inside.any() else step
    edges = np.concatenate([[0], np.flatnonzero(~inside) + 1, [stamps.size]])
    parts = []
    for begin, end in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
        first = math.ceil((stamps[begin] - stamps[0]) / mean - 1e-6)
        last = math.floor((stamps[end - 1] - stamps[0]) / mean + 1e-6)
        parts.append(np.arange(first, last + 1))
    index = np.unique(np.concatenate(parts))
    low, high = np.percentile(steps[inside], [1, 99]) / 1e6 if inside.any() else (0.0, 0.0)
    base.notes.append(
        f"{base.name}: stamps are uneven (steps of {low:.4g} to {high:.4g} ms): resampled at "
        f"{1e9 / mean:.6g} Hz"
    )
    long = int((~inside).sum())
    if long:
        worst = float(steps.max()) / 1e9
        gaps = f"{number_of(long, 'gap')} of up to {worst:.4g} s"
        base.notes.append(f"{base.name}: {gaps} left as recorded")
    grid: StampArray = stamps[0] + np.round(index * mean).astype(np.int64)
    return grid


def _limit(step_ns: float, gap_s: float | None) -> float:
    return gap_s * 1e9 if gap_s is not None else BRIDGED * step_ns


def _in_reach(grid: StampArray, streams: list[Stream], base: Stream, source: str) -> StampArray:
    """The grid without what lies before or after the reference: nothing can be compared there."""
    for one in streams:
        if one is base or not any(name.startswith("reference_") for name in one.signals):
            continue
        first, last = one.stamps_ns[0], one.stamps_ns[-1]
        inside = (grid >= first) & (grid <= last)
        if not inside.any():
            raise InputError(
                f"{source}: {one.name} and {base.name} have no time in common: they end "
                f"{_apart(grid, one.stamps_ns):.6g} s apart; their stamps may be of different "
                "clocks (stamp: bag in the map takes the recorder's)"
            )
        outside = int((~inside).sum())
        if outside > 0.01 * grid.size:
            one.notes.append(
                f"{one.name}: {outside} of {grid.size} samples lie before or after it and are left "
                "out"
            )
        grid = grid[inside]
    return grid


def _apart(grid: StampArray, stamps: StampArray) -> float:
    return float(max(grid[0] - stamps[-1], stamps[0] - grid[-1])) / 1e9


def _on_grid(one: Stream, grid: StampArray, gap_s: float | None) -> dict[str, FloatArray]:
    stamps = one.stamps_ns
    out: dict[str, FloatArray] = {}
    step = one.step_ns
    places = np.clip(np.searchsorted(stamps, grid), 0, stamps.size - 1)
    before = np.maximum(places - 1, 0)
    earlier = np.abs(grid - stamps[before]) < np.abs(stamps[places] - grid)
    near = np.where(earlier, before, places)
    close = np.abs(stamps[near] - grid) <= (1e-3 * step if step > 0.0 else 0.0)
    # Samples at the grid's own stamps are taken as they are; what lacks among them was lost.
    direct = bool(close.all()) or (step > 0.0 and _even_with(grid, stamps, close))
    filled = 0
    for name, values in one.signals.items():
        if direct:
            out[name] = np.where(close, values[near], np.nan)
            continue
        out[name] = _interpolated(name, values, stamps, grid, _limit(step, gap_s))
        filled = max(filled, int(np.isnan(out[name]).sum()))
    if direct and not close.all():
        one.notes.append(f"{one.name}: {int((~close).sum())} of {grid.size} samples missing")
    if not direct and filled:
        one.notes.append(
            f"{one.name}: {filled} of {grid.size} samples lie before it, behind it or in its gaps"
        )
    return out


def _even_with(grid: StampArray, stamps: StampArray, close: BoolArray) -> bool:
    """Whether nearly all stamps of a topic are the grid's own, so that it has their beat."""
    return int(close.sum()) >= 0.9 * min(grid.size, stamps.size) and stamps.size >= 0.5 * grid.size


def _interpolated(
    name: str, values: FloatArray, stamps: StampArray, grid: StampArray, limit: float
) -> FloatArray:
    known = np.abs(values) < _LARGEST  # what is not finite is not known
    out = np.full(grid.size, np.nan)
    if not known.any():
        return out
    origin = int(grid[0])
    times, own = stamps[known], values[known]
    edges = np.concatenate([[0], np.flatnonzero(np.diff(times) > limit) + 1, [times.size]])
    for begin, end in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
        low, high = np.searchsorted(grid, [times[begin], times[end - 1] + 1])
        if low == high:
            continue
        x = (times[begin:end] - origin) / 1e9
        at = (grid[low:high] - origin) / 1e9
        if name == "mode":  # a state holds until the next
            out[low:high] = own[begin:end][np.searchsorted(x, at, side="right") - 1]
        elif end - begin >= 4 and not name.startswith(_LINEAR):
            out[low:high] = CubicSpline(x, own[begin:end])(at)
        else:
            out[low:high] = np.interp(at, x, own[begin:end])
    return out
