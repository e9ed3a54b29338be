"""Brings messages that arrive in any interleaving of topics into a recording's canonical order."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Sequence

from .topics import TOPICS

NAMES = tuple(topic.name for topic in TOPICS)


class SampleSequencer:
    """Collects the messages of each sample and releases samples whole, in stamp order.

    So that a file does not depend on which of several publishers was heard first: a graph's
    recording then compares equal, byte for byte, with one written from arrays.

    Within one topic messages come in order (that much a reliable subscription gives). Hence a
    sample is settled as soon as every topic has reached its stamp: whatever it still lacks then
    will not come any more. A topic that stays silent altogether would hold everything back, so
    beyond `max_pending` samples (ten seconds at 1 kHz) the oldest are released as they are.

    Args:
        sink: called as `sink(topic, cdr, stamp_ns)`, for instance `RecordingWriter.write`.
        topics: names of the topics expected, in canonical order.
        max_pending: samples kept waiting at most.

    Attributes:
        incomplete: samples released without all their topics.
        late: messages that came after their sample had been released, or a later one. They are
            passed on at once, out of order, unless their own topic has gone on: within a topic
            stamps increase, which is what readers rely on. A drive that restarts in lockstep,
            from stamp 0, is for another recording.
        duplicates: second messages of one topic with the same stamp; the first is kept. A
            controller that was killed and started again answers the last measurement once more.
    """

    def __init__(
        self,
        sink: Callable[[str, bytes, int], None],
        *,
        topics: Sequence[str] = NAMES,
        max_pending: int = 10_000,
    ) -> None:
        if not topics or len(set(topics)) != len(topics):
            raise ValueError("topics must be one or more different names")
        if max_pending < 1:
            raise ValueError("max_pending must be at least 1")
        self._sink = sink
        self._topics = tuple(topics)
        self._max_pending = max_pending
        self._samples: dict[int, dict[str, bytes]] = {}
        self._stamps: list[int] = []  # heap of the keys of _samples
        self._reached: dict[str, int | None] = dict.fromkeys(topics)
        self._released: int | None = None
        self._written: dict[str, int | None] = dict.fromkeys(topics)
        self.incomplete = 0
        self.late = 0
        self.duplicates = 0

    def put(self, topic: str, cdr: bytes, stamp_ns: int) -> None:
        """Take one message in; KeyError for a topic that was not announced."""
        reached = self._reached[topic]
        if self._released is not None and stamp_ns <= self._released:
            last = self._written[topic]
            if stamp_ns == last:
                self.duplicates += 1
                return
            self.late += 1
            if last is None or stamp_ns > last:
                self._pass_on(topic, cdr, stamp_ns)
            return
        if reached is None or stamp_ns > reached:
            self._reached[topic] = stamp_ns
        sample = self._samples.get(stamp_ns)
        if sample is None:
            sample = self._samples[stamp_ns] = {}
            heapq.heappush(self._stamps, stamp_ns)
        elif topic in sample:
            self.duplicates += 1
            return
        sample[topic] = cdr
        while self._stamps and self._settled(self._stamps[0]):
            self._release()
        while len(self._stamps) > self._max_pending:
            self._release()

    def finish(self) -> None:
        """Release all that waits, in order, complete or not."""
        while self._stamps:
            self._release()

    @property
    def released_ns(self) -> int:
        """Stamp of the newest sample released, -1 before the first."""
        return -1 if self._released is None else self._released

    @property
    def pending(self) -> int:
        """Samples waiting."""
        return len(self._stamps)

    def _settled(self, stamp_ns: int) -> bool:
        return all(
            reached is not None and reached >= stamp_ns for reached in self._reached.values()
        )

    def _release(self) -> None:
        stamp_ns = heapq.heappop(self._stamps)
        sample = self._samples.pop(stamp_ns)
        self._released = stamp_ns
        if len(sample) < len(self._topics):
            self.incomplete += 1
        for topic in self._topics:
            if topic in sample:
                self._pass_on(topic, sample[topic], stamp_ns)

    def _pass_on(self, topic: str, cdr: bytes, stamp_ns: int) -> None:
        self._written[topic] = stamp_ns
        self._sink(topic, cdr, stamp_ns)
