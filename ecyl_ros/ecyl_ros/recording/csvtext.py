"""The text of a CSV file: its delimiter, its quotes, and blocks of whole lines."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from ..errors import InputError

BLOCK_BYTES = 8 * 2**20
LONGEST_LINE = 2**20
_DELIMITERS = ",;\t|"
_STEADY = ";\t|,"  # a comma may be the decimal sign between the others


def find_delimiter(lines: list[str]) -> str:
    """The sign that all lines hold equally many of, else the one that the first holds most of."""
    bare = [outside_quotes(line) for line in lines]
    whole = bare[:-1] or bare  # the last may be cut off
    for sign in _STEADY:
        counts = {line.rstrip(sign + " ").count(sign) for line in whole}
        if len(counts) == 1 and counts != {0}:
            return sign
    counts_in = {sign: bare[0].count(sign) for sign in _DELIMITERS}
    most = max(counts_in, key=lambda sign: counts_in[sign])
    if counts_in[most]:
        return most
    return " " if len(lines[0].split()) > 1 else ","


def last_decimals(line: str, delimiter: str, decimal: str) -> int:
    """Decimals of the last number of a line; -1 where it has no point."""
    cell = (line.split() if delimiter == " " else line.split(delimiter))[-1:] or [""]
    whole, point, decimals = cell[0].strip().partition(decimal)
    return len(decimals) if point and (whole + decimals).strip("+-").isdigit() else -1


def outside_quotes(line: str) -> str:
    return re.sub(r'"[^"]*"', "", line) if '"' in line else line


def blocks(file: BinaryIO, path: Path) -> Iterator[tuple[bytes, bool]]:
    """Whole lines of about `BLOCK_BYTES`, and whether they are the last."""
    rest = b""
    coming = file.read(BLOCK_BYTES)
    while coming:
        block, coming = rest + coming, file.read(BLOCK_BYTES)
        end = block.rfind(b"\n") + 1
        if len(block) - end > LONGEST_LINE:
            raise InputError(f"{path}: a line has more than {LONGEST_LINE} bytes: no CSV text")
        if not coming:
            yield block, True
            return
        rest = block[end:]
        if end:
            yield block[:end], False
