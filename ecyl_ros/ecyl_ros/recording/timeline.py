"""When each message of a bag is due on playback: rate, offset, clock and loops, without ROS."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass

from ..errors import InputError
from .bag_contents import Bag, in_time_order

NANOSECONDS = 1_000_000_000


@dataclass(frozen=True)
class Event:
    """One thing to publish.

    Attributes:
        due_ns: ns after playback began.
        bag_ns: the bag's own time of it.
        topic: name in the bag; None for the clock.
        data: serialised message; empty for the clock.
    """

    due_ns: int
    bag_ns: int
    topic: str | None
    data: bytes = b""


class Timeline:
    """A bag's messages against the time of playback.

    All due times are counted from the beginning, so that no error adds up.

    Args:
        bag: the messages, kept as they are.
        topics: names to play; all by default.
        rate: speed of playback, more than 0.
        start_offset_s: part of the bag left out at its start, bag time.
        clock_hz: clock ticks per second of playback (not of bag time, as in `ros2 bag play`); 0
            for none.
        loop: start again at the end, for ever. One mean message interval lies between the rounds.

    Attributes:
        start_ns, end_ns: bag time of the part played.
        message_count: messages of one round.

    Raises:
        InputError: a topic that the bag does not hold, nothing left to play, or an option out of
            its range; the message names it.
    """

    def __init__(
        self,
        bag: Bag,
        *,
        topics: Collection[str] | None = None,
        rate: float = 1.0,
        start_offset_s: float = 0.0,
        clock_hz: float = 0.0,
        loop: bool = False,
    ) -> None:
        if not 0.0 < rate < float("inf"):
            raise InputError(f"--rate is {rate:g}, expected more than 0")
        if not 0.0 <= start_offset_s < float("inf"):
            raise InputError(f"--start-offset is {start_offset_s:g} s, expected 0 or more")
        if not 0.0 <= clock_hz < float("inf"):
            raise InputError(f"--clock is {clock_hz:g} Hz, expected more than 0")
        unknown = sorted(set(topics or ()) - set(bag.topics))
        if unknown:
            held = ", ".join(sorted(bag.topics)) or "none"
            raise InputError(f"{bag.path}: holds no topic {unknown[0]}; its topics: {held}")
        messages = [m for m in in_time_order(bag) if topics is None or m[1] in topics]
        if not messages:
            raise InputError(f"{bag.path}: holds no message to play")
        self.start_ns = messages[0][0] + round(start_offset_s * NANOSECONDS)
        self.end_ns = messages[-1][0]
        self._messages = [m for m in messages if m[0] >= self.start_ns]
        if not self._messages:
            raise InputError(
                f"{bag.path}: --start-offset is {start_offset_s:g} s, the bag ends at "
                f"{(self.end_ns - messages[0][0]) / NANOSECONDS:g} s"
            )
        self.message_count = len(self._messages)
        self._rate = rate
        self._clock_hz = clock_hz
        self._loop = loop

    @property
    def duration_ns(self) -> int:
        """Time that one round takes on playback."""
        return self._due(self.end_ns)

    def _due(self, bag_ns: int) -> int:
        return round((bag_ns - self.start_ns) / self._rate)

    def __iter__(self) -> Iterator[Event]:
        """Events in the order in which they are due; without end where looping."""
        # A bag of one instant would loop without a pause.
        gap = max(self.duration_ns // max(self.message_count - 1, 1), 1_000_000)
        begin = 0
        while True:
            for event in self._round():
                yield Event(begin + event.due_ns, event.bag_ns, event.topic, event.data)
            if not self._loop:
                return
            begin += self.duration_ns + gap

    def _round(self) -> Iterator[Event]:
        tick = 0
        for bag_ns, topic, data in self._messages:
            due = self._due(bag_ns)
            while self._clock_hz and (at := round(tick * NANOSECONDS / self._clock_hz)) <= due:
                yield Event(at, self.start_ns + round(at * self._rate), None)
                tick += 1
            yield Event(due, bag_ns, topic, data)
