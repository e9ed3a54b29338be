"""Columns of numbers out of batches of messages: chosen fields, or all there are."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray, StampArray
from .cdr import MAX_LAYOUTS, CdrError
from .layout import MessageLayout, MessageType, Run, stamp_ns
from .stream import Batch

MOST_FIELDS = 256  # of a topic, where all are asked for


@dataclass(frozen=True)
class Columns:
    """Samples of one topic (or table), some at a time.

    Attributes:
        topic: its name; empty for a table without topics.
        type: message type, or what kind of table it is.
        log_time_ns: int64[n], when each was recorded; None in tables.
        header_ns: int64[n], the messages' own stamps; None without any.
        values: path -> float64[n], NaN where a message has no such field; int64[n] for whole
            numbers in tables that a float64 would round.
    """

    topic: str
    type: str
    log_time_ns: StampArray | None
    header_ns: StampArray | None
    values: dict[str, FloatArray]

    def __len__(self) -> int:
        for column in (self.log_time_ns, self.header_ns, *self.values.values()):
            if column is not None:
                return int(column.size)
        return 0


# What to take of messages of one structure: (name of the column, where its primitive stands).
Chooser = Callable[[MessageLayout], Sequence[tuple[str, Run]]]


def everything(layout: MessageLayout) -> Sequence[tuple[str, Run]]:
    """A chooser of all numbers, up to `MOST_FIELDS`."""
    return layout.listed(MOST_FIELDS)


class TopicDecoder:
    """Decodes the batches of one topic.

    Messages of one structure (equal lengths of everything, equal names) are decoded at once. The
    first of each is walked; the others are compared with it.

    Args:
        batch: the topic's first.
        choose: which columns to take.

    Attributes:
        names: path of each list of names met -> the names, of the first message with any.

    Raises:
        CdrError: an encoding other than CDR, or no usable definition.
    """

    def __init__(self, batch: Batch, choose: Chooser) -> None:
        if batch.topic.encoding != "cdr":
            raise CdrError(f"message encoding is {batch.topic.encoding[:40]!r}, expected 'cdr'")
        self._type = MessageType(batch.topic)
        self._choose = choose
        self._layouts: list[tuple[MessageLayout, Sequence[tuple[str, Run]]]] = []
        self._messages = 0
        self.names: dict[str, tuple[str, ...]] = {}

    def columns(self, batch: Batch) -> Columns:
        """All of a batch. Raises CdrError for messages that are not of the type."""
        from .kernels import alike

        count = batch.start.size
        header = np.full(count, -1, dtype=np.int64)
        stamped = False
        values: dict[str, FloatArray] = {}
        left = np.arange(count)
        number = 0
        while left.size:
            if number == len(self._layouts):
                self._learn(batch, int(left[0]))
            layout, chosen = self._layouts[number]
            same = np.empty(left.size, dtype=np.bool_)
            start, length = batch.start[left], batch.length[left]
            alike(batch.data, start, length, layout.template, layout.fixed, same)
            number += 1
            if not same.any():
                continue
            rows = left[same]
            self._take(batch, layout, chosen, rows, header, values)
            stamped = stamped or layout.stamp is not None
            left = left[~same]
        self._messages += count
        return Columns(
            batch.topic.name,
            batch.topic.type,
            batch.log_time_ns,
            header if stamped else None,
            values,
        )

    def _learn(self, batch: Batch, row: int) -> None:
        where = f"message {self._messages + row}"
        if len(self._layouts) >= MAX_LAYOUTS:
            raise CdrError(f"{where}: more than {MAX_LAYOUTS} structures in one topic")
        try:
            layout = self._type.layout(batch.message(row))
        except CdrError as error:
            raise CdrError(f"{where}: {error}") from None
        for path, names in layout.names.items():
            if names:
                self.names.setdefault(path, names)
        self._layouts.append((layout, self._choose(layout)))

    def _take(
        self,
        batch: Batch,
        layout: MessageLayout,
        chosen: Sequence[tuple[str, Run]],
        rows: NDArray[np.intp],
        header: StampArray,
        values: dict[str, FloatArray],
    ) -> None:
        from .kernels import gather

        stamp = [] if layout.stamp is None else [layout.stamp]
        offsets = np.array([*stamp, *(run.offset for _, run in chosen)], dtype=np.int64)
        sizes = np.array([*(8 for _ in stamp), *(run.size for _, run in chosen)], dtype=np.int64)
        if not offsets.size:
            return
        raw = np.zeros((offsets.size, rows.size, 8), dtype=np.uint8)
        gather(batch.data, batch.start[rows], offsets, sizes, False, raw)
        if stamp:
            header[rows] = stamp_ns(raw[0], layout.big_endian)
        order = ">" if layout.big_endian else "<"
        for (name, run), table in zip(chosen, raw[len(stamp) :], strict=True):
            column = np.ascontiguousarray(table[:, : run.size]).view(f"{order}{run.letters}")[:, 0]
            if name not in values:
                if rows.size == header.size:
                    values[name] = column.astype(np.float64)
                    continue
                values[name] = np.full(header.size, np.nan)
            values[name][rows] = column
