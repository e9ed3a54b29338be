"""What a running drive sends, topic by topic: stamped samples in order, run by run.

Topics come on their own, each in order. A stamp that goes back means that the drive began a new
run; what other topics still send of the old one is left out until they too are in the new one.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...arrays import FloatArray, StampArray

NANOSECONDS = 1_000_000_000
LATE_NS = 100_000_000  # a stamp that is this little behind is a late message, not a new run
_SAME_RUN_NS = NANOSECONDS  # topics of one run are never further apart
_RECENT = 50  # steps that tell a stream's period
_MOST = 200_000  # samples kept of a topic that nothing can be compared with
_MISSING_STEPS = 1.5


class Stream:
    """Samples of one topic that wait to be compared.

    Attributes:
        signals: names of the columns, as `Recording` calls them.
        stamp_ns: int64[n], increasing. values: float64[n, signals].
        newest_ns: the newest stamp of this run, None before the first. heard_s: wall time then.
        missing, late: samples that the stamps say were left out; messages out of order or twice.
    """

    def __init__(self, signals: Sequence[str]) -> None:
        self.signals = tuple(signals)
        self.run = 0
        self.heard_s = -np.inf
        self.missing = 0
        self.late = 0
        self.received = 0
        self._steps: StampArray = np.empty(0, dtype=np.int64)
        self.clear()

    def clear(self) -> None:
        """Forget the samples of a run."""
        self.stamp_ns: StampArray = np.empty(0, dtype=np.int64)
        self.values: FloatArray = np.empty((0, len(self.signals)))
        self.newest_ns: int | None = None

    @property
    def period_ns(self) -> float:
        """Median time between recent samples; NaN before the second."""
        return float(np.median(self._steps)) if self._steps.size else float("nan")

    def append(self, stamp_ns: StampArray, values: FloatArray) -> None:
        """Add samples whose stamps go on from the newest one."""
        steps = np.diff(stamp_ns, prepend=[] if self.newest_ns is None else [self.newest_ns])
        self._steps = np.concatenate([self._steps, steps])[-_RECENT:]
        if steps.size:
            left_out = steps > _MISSING_STEPS * self.period_ns
            self.missing += int(np.sum(np.round(steps[left_out] / self.period_ns) - 1.0))
        self.stamp_ns = np.concatenate([self.stamp_ns, stamp_ns])[-_MOST:]
        self.values = np.concatenate([self.values, values])[-_MOST:]
        self.newest_ns = int(stamp_ns[-1])

    def drop(self, count: int) -> None:
        """Forget the oldest `count` samples."""
        self.stamp_ns, self.values = self.stamp_ns[count:], self.values[count:]

    def at(self, stamp_ns: int) -> FloatArray:
        """float64[signals], the sample nearest to an instant; NaN if none is within a period."""
        if self.stamp_ns.size:
            row = int(np.argmin(np.abs(self.stamp_ns - stamp_ns)))
            away = abs(int(self.stamp_ns[row]) - stamp_ns)
            if away == 0 or away <= self.period_ns:
                nearest: FloatArray = self.values[row]
                return nearest
        return np.full(len(self.signals), np.nan)


class Streams:
    """The topics of one drive, by key.

    Attributes:
        run: counts the runs met. reason: why the latest began, "" for the first.
    """

    def __init__(self, signals: dict[str, Sequence[str]]) -> None:
        self.by_key = {key: Stream(names) for key, names in signals.items()}
        self.run = 0
        self.reason = ""

    def put(self, key: str, stamp_ns: StampArray, values: FloatArray, now_s: float) -> None:
        """Take samples of one topic in the order they came.

        stamp_ns: int64[n]. values: float64[n, signals]. now_s: on any steady clock.
        """
        stream = self.by_key[key]
        stream.heard_s = now_s
        stream.received += len(stamp_ns)
        start = 0
        newest = stream.newest_ns
        stamps = stamp_ns.tolist()
        keep: list[int] = []
        for row, stamp in enumerate(stamps):
            if newest is not None and stamp <= newest:
                if newest - stamp <= LATE_NS:
                    stream.late += 1
                    continue
                self._append(stream, stamp_ns[keep], values[keep])
                self._went_back(stream, newest - stamp)
                keep, start = [], row
            keep.append(row)
            newest = stamp
        if keep and keep[0] >= start:
            self._append(stream, stamp_ns[keep], values[keep])

    def _append(self, stream: Stream, stamp_ns: StampArray, values: FloatArray) -> None:
        if not stamp_ns.size:
            return
        if stream.run < self.run:
            # Of the old run, or the first that is heard of this topic in the new one.
            newest = [s.newest_ns for s in self.by_key.values() if s.run == self.run]
            known = [one for one in newest if one is not None]
            of_now = np.zeros(stamp_ns.size, dtype=bool)
            for one in known:
                of_now |= np.abs(stamp_ns - one) < _SAME_RUN_NS
            if not of_now.any():
                # Its stamps are noted, so that going back is seen.
                stream.newest_ns = int(stamp_ns[-1])
                return
            stream.run = self.run
            stream.clear()
            stamp_ns, values = stamp_ns[of_now], values[of_now]
        stream.append(stamp_ns, values)

    def _went_back(self, stream: Stream, by_ns: int) -> None:
        if stream.run == self.run:
            self.run += 1
            self.reason = f"stamps went back by {by_ns / NANOSECONDS:.3g} s"
            for other in self.by_key.values():
                newest = other.newest_ns
                other.clear()
                other.newest_ns = newest
        stream.run = self.run
        stream.clear()

    def of_run(self) -> dict[str, Stream]:
        """The topics of which this run has samples or had."""
        return {
            key: stream
            for key, stream in self.by_key.items()
            if stream.run == self.run and stream.newest_ns is not None
        }
