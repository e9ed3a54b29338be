"""Compiled loops over millions of messages: framing, comparison, columns, running figures."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..drive.compiled import kernel

OP_MESSAGE = 5

# Rows of the running figures of a column.
COUNT, MINIMUM, MAXIMUM, TOTAL, SQUARES, LAST, TRAVEL, TURNS, HEADING, EQUAL, FIRST = range(11)
FIGURES = 11


@kernel
def _word(data: Any, at: int, size: int) -> Any:
    value = np.uint64(0)
    for i in range(size):
        value |= np.uint64(data[at + i]) << np.uint64(8 * i)
    return value


@kernel
def walk(data: Any, channels: Any, times: Any, starts: Any, lengths: Any, others: Any) -> Any:
    """Frame a chunk's records.

    Fills channel, log time, first byte and length of each message's data, and the places of all
    other records. Returns how many of each, and where the last whole record ends. A message
    record shorter than its own header has length -1.
    """
    messages = 0
    rest = 0
    at: Any = 0
    end = data.size
    while at + 9 <= end:
        length = np.int64(_word(data, at + 1, 8))
        start = at + 9
        if length < 0 or length > end - start:
            break
        if data[at] == OP_MESSAGE:
            if length < 22:
                lengths[messages] = -1
            else:
                channels[messages] = np.int64(_word(data, start, 2))
                times[messages] = np.int64(_word(data, start + 6, 8))
                starts[messages] = start + 22
                lengths[messages] = length - 22
            messages += 1
        else:
            others[rest] = at
            rest += 1
        at = start + length
    return messages, rest, at


@kernel
def alike(data: Any, starts: Any, lengths: Any, template: Any, ranges: Any, out: Any) -> None:
    """Whether each message has the template's length, and its bytes in the ranges [from, to)."""
    for i in range(starts.size):
        same = lengths[i] == template.size
        if same:
            base = starts[i]
            for r in range(ranges.shape[0]):
                for k in range(ranges[r, 0], ranges[r, 1]):
                    if data[base + k] != template[k]:
                        same = False
                        break
                if not same:
                    break
        out[i] = same


@kernel
def gather(data: Any, starts: Any, offsets: Any, sizes: Any, swap: bool, out: Any) -> None:
    """Copy values of up to 8 bytes at `offsets` of each message, out: uint8[values, n, 8].

    swap: reverse the bytes, so that the values are little-endian.
    """
    for i in range(starts.size):
        base = starts[i]
        for c in range(offsets.size):
            at = base + offsets[c]
            size = sizes[c]
            if size == 8 and not swap:  # a length that is known becomes one move
                for k in range(8):
                    out[c, i, k] = data[at + k]
            else:
                for k in range(size):
                    out[c, i, k] = data[at + (size - 1 - k if swap else k)]


@kernel
def run_figures(values: Any, figures: Any) -> None:
    """Carry on the running figures of one column, float64[FIGURES], over more values.

    TOTAL and SQUARES are of the differences to the FIRST. TRAVEL is the sum of all steps' sizes,
    TURNS how often they change sign, EQUAL how many values equal the one before; HEADING is the
    last step's sign. Values that are not finite are left out.
    """
    count = figures[COUNT]
    low, high = figures[MINIMUM], figures[MAXIMUM]
    total, squares = figures[TOTAL], figures[SQUARES]
    last, travel = figures[LAST], figures[TRAVEL]
    turns, heading, equal = figures[TURNS], figures[HEADING], figures[EQUAL]
    first = figures[FIRST]
    for value in values:
        if not np.isfinite(value):
            continue
        if count == 0:
            low = high = first = value
        else:
            step = value - last
            travel += abs(step)
            if step == 0.0:
                equal += 1
            else:
                way = 1.0 if step > 0.0 else -1.0
                if way * heading < 0.0:
                    turns += 1
                heading = way
        low = min(low, value)
        high = max(high, value)
        total += value - first
        squares += (value - first) * (value - first)
        last = value
        count += 1
    figures[COUNT] = count
    figures[MINIMUM], figures[MAXIMUM] = low, high
    figures[TOTAL], figures[SQUARES] = total, squares
    figures[LAST], figures[TRAVEL] = last, travel
    figures[TURNS], figures[HEADING], figures[EQUAL] = turns, heading, equal
    figures[FIRST] = first


def framed(
    data: bytes,
) -> tuple[
    NDArray[np.int64],
    NDArray[np.int64],
    NDArray[np.int64],
    NDArray[np.int64],
    NDArray[np.int64],
    int,
]:
    """Channels, log times, starts and lengths of a chunk's messages, places of others, the end."""
    table = np.frombuffer(data, dtype=np.uint8)
    # A record takes 9 bytes at least; memory that nothing is written to costs nothing.
    columns = np.empty((4, table.size // 9 + 1), np.int64)
    others = np.empty(table.size // 9 + 1, np.int64)
    count, rest, end = walk(table, columns[0], columns[1], columns[2], columns[3], others)
    channels, times, starts, lengths = columns[:, :count]
    return channels, times, starts, lengths, others[:rest], int(end)
