"""CSV of any make, some megabytes at a time: delimiter, decimal sign, header, lists found out."""

from __future__ import annotations

import csv
import io
import re
from collections import Counter
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import Any

from ..arrays import FloatArray
from ..errors import InputError
from ..number_of import number_of
from .columns import Columns
from .csvnumbers import numbers
from .csvtext import LONGEST_LINE, blocks, find_delimiter, last_decimals, outside_quotes
from .instants import DATE
from .names import name_of
from .units import dimension_of

_MOST_COLUMNS = 4096
_LYING = 50  # columns to a row: a table that has its signals in rows
_ALIKE = 20  # last lines that are compared
_COMMA_NUMBER = re.compile(r"[+-]?\d*,\d+([eE][+-]?\d+)?$")
_POINT_NUMBER = re.compile(r"[+-]?\d*\.\d+([eE][+-]?\d+)?$")
_COMMENTS = ("#", "%", "//")
_LOOKED_AT = 200  # lines, for the delimiter and the decimal sign
_ENOUGH = 6  # lines that show which of them are rows
_SHARE = "%"  # of a rated value
_END = ";"
_UNIT_LABELS = ("unit", "units")
_MISSING = ["", "nan", "NaN", "NAN", "NA", "N/A", "null", "None", "-", "--"]


def _is_unit(cell: str) -> bool:
    word = cell.strip("[]() ")
    return dimension_of(word) is not None or word.lower() in _UNIT_LABELS or word == _SHARE


class CsvTable:
    """A CSV file as columns of numbers.

    The delimiter (comma, semicolon, tab, bar or blanks) is the one that all lines hold equally many
    of, else the one that the first line holds most of; with a semicolon, tab or bar a comma may be
    the decimal sign. Lines that begin with #, % or // are skipped; where the file has no other
    header, the last of them with as many words as there are columns is taken for it. Without a
    header the columns are called column_1, column_2, ... A line of units below the header is kept
    apart. Lines above the header that are no comments are left out, and a note says so. A delimiter
    at the end of each line is taken for no column. A cell such as "[0.1, 0.2]" holds several
    columns, `name[0]`, `name[1]`. Dates by ISO 8601 become ns since 1970.

    Args:
        path: the file.
        topic: what its columns are filed under.

    Attributes:
        names: of the columns, in order.
        units: column -> unit, where the file has a line of them.
        dated: columns that hold dates; complete after reading.
        notes: one line each on what was left out; complete after reading.

    Raises:
        InputError: no such file, or no text with a line of columns.
    """

    def __init__(self, path: str | Path, topic: str = "") -> None:
        self.path = Path(path)
        self.topic = topic
        self.notes: tuple[str, ...] = ()
        self.dated: set[str] = set()
        try:
            with self.path.open("rb") as file:
                head = file.read(4 * LONGEST_LINE)
        except OSError as error:
            raise InputError(f"{path}: cannot be read: {error.strerror}") from None
        if not head.strip():
            raise InputError(f"{path}: is empty, expected a header line and rows of numbers")
        if head[:2] in (b"\xff\xfe", b"\xfe\xff"):
            raise InputError(f"{path}: is UTF-16 text, expected UTF-8 (save it as such)")
        if b"\0" in head:
            raise InputError(f"{path}: is no CSV text: it holds bytes of zero")
        self._encoding, self._end = "utf-8", b""
        try:
            head.decode("utf-8")
        except UnicodeDecodeError as error:
            if error.start < len(head) - 4:  # not just a letter cut in two by the limit
                self._encoding = "latin-1"
        self._find_header(head)

    def _find_header(self, head: bytes) -> None:
        at = 3 if head.startswith(b"\xef\xbb\xbf") else 0
        line_number = 0
        comments: list[str] = []
        lines: list[tuple[int, int, str]] = []  # where each begins, its number, and its text
        while at < len(head) and len(lines) < _LOOKED_AT:
            end = head.find(b"\n", at)
            end = len(head) if end < 0 else end + 1
            if end - at > LONGEST_LINE:
                raise InputError(
                    f"{self.path}: line {line_number + 1} has more than {LONGEST_LINE} bytes: "
                    "no CSV text"
                )
            text = head[at:end].decode(self._encoding, "replace").strip("\r\n ")
            if text.strip() and not text.lstrip().startswith(_COMMENTS):
                lines.append((at, line_number, text))
            elif text.strip() and not lines:
                comments.append(text.strip())
            line_number += 1
            at = end
        if not lines:
            raise InputError(f"{self.path}: holds nothing but comments, expected rows of numbers")
        texts = [text for _, _, text in lines]
        self.delimiter = find_delimiter(texts)
        rows = texts[len(texts) // 2 :]
        # As MATLAB writes a matrix: commas, and a semicolon at the end of each row.
        if self.delimiter != _END and all(row.endswith(_END) for row in rows[:-1] or rows):
            self._end = _END.encode()
            texts = [text.removesuffix(_END) for text in texts]
        before = self._before_the_table(texts)
        if before:
            self.notes += (
                f"{self.path}: {number_of(before, 'line')} before the table left "
                f"out ({texts[0][:40]})",
            )
            lines, texts = lines[before:], texts[before:]
        row = self._cells(texts[0])
        numbered = [cell for text in texts for cell in self._cells(text)]
        self._decimal = "."
        if self.delimiter != "," and any(map(_COMMA_NUMBER.match, numbered)):
            self._decimal = "." if any(map(_POINT_NUMBER.match, numbered)) else ","
        # A delimiter that ends each line ends a cell, and begins none.
        follows = self._cells(texts[-1]) if len(texts) > 1 else row
        if len(row) > 1 and not row[-1] and (len(follows) < len(row) or not follows[-1]):
            row = row[:-1]
        self.units: dict[str, str] = {}
        begins = 0
        if all(self._is_value(cell) for cell in row):
            self.names = self._told(comments, len(row))
        else:
            self.names = row
            begins = 1
            if len(lines) > 1:
                second = self._cells(texts[1])[: len(row)]
                if (
                    len(second) == len(row)
                    and len(lines) > 2
                    and not any(self._is_value(cell) for cell in second if cell)
                    and any(self._is_value(cell) for cell in self._cells(texts[2]))
                    and all(len(cell) <= 16 for cell in second)
                ):
                    self._take_units(second)
                    begins = 2
        if not self.names:
            self.names = [name_of(i + 1) for i in range(len(row))]
        if at >= len(head) < 4 * LONGEST_LINE and len(self.names) > _LYING * len(lines):
            raise InputError(
                f"{self.path}: {len(lines)} rows of {len(self.names)} columns, expected a signal "
                "in each column: transpose the table"
            )
        if len(self.names) > _MOST_COLUMNS:
            raise InputError(
                f"{self.path}: {len(self.names)} columns, expected {_MOST_COLUMNS} at most"
            )
        self.names = [name or name_of(i + 1) for i, name in enumerate(self.names)]
        self._tell_apart()
        self._start = lines[begins][0] if begins < len(lines) else len(head)
        self._first_line = lines[begins][1] + 1 if begins < len(lines) else line_number + 1

    def _tell_apart(self) -> None:
        """Number columns of one name, as pandas does: torque, torque.1, torque.2."""
        seen: Counter[str] = Counter()
        names: list[str] = []
        for name in self.names:
            told = f"{name}.{seen[name]}" if seen[name] else name
            seen[name] += 1
            if told in names or (told != name and told in self.names):
                raise InputError(f"{self.path}: two columns are called {told[:60]}")
            names.append(told)
        twice = [name for name, count in seen.items() if count > 1]
        if twice:
            self.notes += (
                f"{self.path}: {seen[twice[0]]} columns are called {twice[0][:40]}: the second is "
                f"read as {twice[0][:40]}.1, and so on",
            )
        self.names = names

    def _before_the_table(self, texts: list[str]) -> int:
        """How many lines that are no comments stand before the header.

        The header is the line above the rows, as wide as they are; with a line of units it is the
        one above that. May settle on the delimiter that the rows have.
        """
        rows = texts[len(texts) // 2 :][: -1 or None]
        if len(texts) < _ENOUGH:
            return 0
        if len({len(self._cells(row)) for row in rows}) > 1 or len(self._cells(rows[0])) < 2:
            self.delimiter = find_delimiter(rows)
        width = len(self._cells(rows[0]))
        first = len(texts) - 1  # of the rows
        while first > 0 and self._is_row(texts[first - 1], width):
            first -= 1
        if first == 0 or first == len(texts) - 1:
            return 0
        header = first - 1
        cells = self._cells(texts[header])
        units = [_is_unit(cell) for cell in cells if cell]
        if header > 0 and len(self._cells(texts[header - 1])) == width and all(units):
            header -= 1
        told = len(self._cells(texts[header])) == width
        # Metadata hold words where rows hold numbers.
        rows_hold = self._values_in(texts[first])
        known = any(self._values_in(text) == rows_hold for text in texts[:header])
        return header if told and not known else 0

    def _values_in(self, text: str) -> list[bool]:
        """Which cells of a line hold a value."""
        return [self._is_value(cell) for cell in self._cells(text)]

    def _is_row(self, text: str, width: int) -> bool:
        cells = self._cells(text)
        return len(cells) == width and any(map(self._is_value, filter(None, cells)))

    def _told(self, comments: list[str], columns: int) -> list[str]:
        """Names out of the comments before the first row; empty where none fits."""
        for place in reversed(range(len(comments))):
            names = self._comment_cells(comments[place], columns)
            if not names:
                continue
            above = self._comment_cells(comments[place - 1], columns) if place else []
            units = [dimension_of(one.strip("[]() ")) for one in names]
            if (
                above
                and any(units)
                and all(one or not name for one, name in zip(units, names, strict=True))
            ):
                self.names = above
                self._take_units(names)
                return above
            self.names = names
            below = comments[place + 1 : place + 2]
            cells = self._split(below[0], columns) if below else []
            if any(_is_unit(cell) for cell in cells):
                self._take_units(cells)
            return names
        return []

    def _comment_cells(self, comment: str, columns: int) -> list[str]:
        """Of a line that has as many, not all of them values."""
        cells = self._split(comment, columns)
        return [] if all(self._is_value(cell) for cell in cells) else cells

    def _split(self, comment: str, columns: int) -> list[str]:
        """Of a line that has as many."""
        text = comment.lstrip("#%/ ")
        for cells in (self._cells(text), text.split(), text.split(",")):
            if len(cells) == columns + 1 and not cells[-1]:
                cells = cells[:-1]
            if len(cells) == columns and any(cells):
                return [cell.strip() for cell in cells]
        return []

    def _take_units(self, cells: list[str]) -> None:
        nameless = (name or name_of(i + 1) for i, name in enumerate(self.names))
        told = zip(nameless, (cell.strip("[]() ") for cell in cells), strict=True)
        labels = ("", "#", *_UNIT_LABELS)
        self.units = {name: unit for name, unit in told if unit.lower() not in labels}

    def _cells(self, line: str) -> list[str]:
        if self.delimiter == " ":
            return line.split()
        if "\r" in line.rstrip("\r"):
            raise InputError(
                f"{self.path}: a carriage return within a line, expected lines that end in a line "
                "feed (save it so)"
            )
        try:
            rows = list(csv.reader([line], delimiter=self.delimiter, skipinitialspace=True))
        except csv.Error as error:
            raise InputError(f"{self.path}: is no CSV text: {error}") from None
        return [cell.strip() for cell in rows[0]] if rows else []

    def _is_value(self, cell: str) -> bool:
        if cell in _MISSING or cell.startswith("[") or DATE.match(cell):
            return True
        try:
            float(cell.replace(",", ".") if self.delimiter != "," else cell)
        except ValueError:
            return False
        return True

    def columns(self, wanted: Collection[str] | None = None) -> Iterator[Columns]:
        """Rows in order, some thousand at a time.

        Args:
            wanted: names of columns, or of entries of a column of lists (`positions[2]`). All
                that hold numbers by default.

        Raises:
            InputError: a row of another length, or a cell of a wanted column that is no number.
        """
        places = self._places(wanted)
        line = self._first_line
        with self.path.open("rb") as file:
            file.seek(self._start)
            for block, last in blocks(file, self.path):
                yield self._block(block, places, wanted is not None, line, last)
                line += block.count(b"\n")

    def _places(self, wanted: Collection[str] | None) -> dict[int, list[str]]:
        """Column number -> the names asked of it."""
        if wanted is None:
            return {i: [] for i in range(len(self.names))}
        places: dict[int, list[str]] = {}
        for name in wanted:
            base = name
            if base not in self.names:
                base = re.sub(r"\[\d+\]$", "", name)
            if base not in self.names:
                known = ", ".join(self.names[:12])
                raise InputError(f"{self.path}: no column {name[:60]}; found {known}")
            places.setdefault(self.names.index(base), []).append(name)
        return places

    def _block(
        self, block: bytes, places: dict[int, list[str]], strict: bool, line: int, last: bool
    ) -> Columns:
        import pandas

        block = self._whole_rows(block, line, last)
        values: dict[str, FloatArray] = {}
        if not block.strip():
            return Columns(self.topic, "CSV", None, None, values)
        options: dict[str, Any] = (
            {"sep": r"\s+"}
            if self.delimiter == " "
            else {"sep": self.delimiter, "skipinitialspace": True}
        )
        try:
            table = pandas.read_csv(
                io.BytesIO(block),
                header=None,
                names=range(len(self.names)),
                usecols=sorted(places),
                index_col=False,
                decimal=self._decimal,
                na_values=_MISSING,
                keep_default_na=False,
                encoding=self._encoding,
                encoding_errors="replace",
                low_memory=False,
                **options,
            )
        except (pandas.errors.ParserError, ValueError, OverflowError) as error:
            reason = " ".join(str(error).split())[:120]
            raise InputError(f"{self.path}: from line {line}: is no CSV text: {reason}") from None
        for place, asked in places.items():
            name = self.names[place]
            found = numbers(table[place], name, asked, strict, line, self.path)
            values |= found.values
            if found.dated:
                self.dated.add(name)
        return Columns(self.topic, "CSV", None, None, values)

    def _whole_rows(self, block: bytes, line: int, last: bool) -> bytes:
        """The block without comments, once all its rows have as many cells as there are columns."""
        if self._end:
            block = re.sub(rb";[ \t]*(?=\r?\n|\Z)", b"", block)
        if last:
            block = self._uncut(block)
        sign = self.delimiter.encode()
        expected = len(self.names)
        commented = any(
            block.startswith(mark) or b"\n" + mark in block
            for mark in (one.encode() for one in _COMMENTS)
        )
        # Cheap first: as many delimiters as so many lines should have.
        quick = self.delimiter != " " and b'"' not in block
        if quick and not commented and b"\n\n" not in block and b"\n\r\n" not in block:
            lines = block.count(b"\n") + (bool(block) and not block.endswith(b"\n"))
            if block.count(sign) == lines * (expected - 1):
                return block
        if self.delimiter == " " and not commented and not last:
            return block
        rows = block.splitlines(keepends=True)
        kept = []
        for i, row in enumerate(rows):
            text = row.decode(self._encoding, "replace").strip("\r\n")
            if text.lstrip().startswith(_COMMENTS):
                kept.append(b"\n")  # lines keep their numbers
                continue
            blanks = self.delimiter == " "
            outside = outside_quotes(text)
            cells = len(text.split()) if blanks else outside.count(self.delimiter) + 1
            if cells == expected + 1 and outside.rstrip(" ").endswith(self.delimiter):
                end = row.rstrip(b"\r\n ")
                kept.append(end[: -len(sign)] + b"\n")
                continue
            if cells == expected or not text.strip():
                kept.append(row)
                continue
            if last and i == len(rows) - 1 and not row.endswith(b"\n") and cells < expected:
                self.notes += (f"{self.path}: the last line is cut off and left out",)
                break
            if blanks:
                kept.append(row)
                continue
            raise InputError(f"{self.path}: line {line + i}: {cells} cells, expected {expected}")
        return b"".join(kept)

    def _uncut(self, block: bytes) -> bytes:
        """The file's end without a last row whose last number breaks off.

        That shows where the last line does not end and has fewer decimals than every line before.
        """
        rows = block.splitlines()[-_ALIKE:]
        if block.endswith((b"\n", b"\r")) or len(rows) < _ALIKE:
            return block
        ends = [
            last_decimals(row.decode(self._encoding, "replace"), self.delimiter, self._decimal)
            for row in rows
        ]
        if len(set(ends[:-1])) > 1 or ends[0] < 1 or ends[-1] >= ends[0]:
            return block
        self.notes += (f"{self.path}: the last line breaks off within a number and is left out",)
        return block[: -len(rows[-1])]
