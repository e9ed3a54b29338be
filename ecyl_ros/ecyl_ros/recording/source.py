"""One way into recordings of every kind: bags, CSV files, folders of these, MAT files."""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from ..errors import InputError
from .cdr import CdrError
from .columns import Columns, TopicDecoder, everything
from .csvtable import CsvTable
from .layout import MessageLayout, Run
from .mattable import MatTable
from .mcap_file import MAGIC
from .packed import kind
from .stream import BagStream

BAG_SUFFIXES = (".mcap", ".db3")
CSV_SUFFIXES = (".csv", ".txt", ".tsv", ".dat")
MAT_SUFFIX = ".mat"


@dataclass(frozen=True)
class Wanted:
    """A column asked for: what it shall be called, the field's path, and a joint's name or none."""

    key: str
    field: str
    joint: str = ""


class BagSource:
    """A bag's topics.

    Attributes:
        path, kind: the bag.
        notes: of what was cut off or could not be read; complete after reading.
        types: topic -> message type, of all topics met.
        names: topic -> list of joint names met, by path.
        unread: topic -> why its messages could not be decoded.
        share: of the bag gone through while it is read, 0 to 1.
    """

    kind = "bag"

    def __init__(self, path: Path) -> None:
        self.path = path
        self.notes: tuple[str, ...] = ()
        self.types: dict[str, str] = {}
        self.names: dict[str, dict[str, tuple[str, ...]]] = {}
        self.unread: dict[str, str] = {}
        self.share = 0.0

    def columns(
        self,
        wanted: Mapping[str, Sequence[Wanted]] | None = None,
        *,
        start_ns: int | None = None,
        stop_ns: int | None = None,
    ) -> Iterator[Columns]:
        """Samples of each topic in file order, some thousand at a time.

        Args:
            wanted: topic -> columns; all numbers of all topics by default.
            start_ns, stop_ns: chunks with no log time within [start, stop) are skipped.

        Raises:
            InputError: unusable as `read_bag` says; of topics asked for by name, also messages
                that do not parse, and a column that no message of its topic has.
        """
        stream = BagStream(
            self.path,
            topics=None if wanted is None else set(wanted),
            start_ns=start_ns,
            stop_ns=stop_ns,
        )
        decoders: dict[str, TopicDecoder] = {}
        choosers: dict[str, _Chooser] = {}
        for batch in stream:
            self.share = stream.share
            name = batch.topic.name
            if name in self.unread:
                continue
            try:
                if name not in decoders:
                    choose = everything
                    if wanted is not None:
                        choose = choosers[name] = _Chooser(wanted[name])
                    decoders[name] = TopicDecoder(batch, choose)
                    self.names[name] = decoders[name].names
                found = decoders[name].columns(batch)
            except CdrError as error:
                if wanted is not None:
                    raise InputError(f"{self.path}: {name}: {error}") from None
                self.unread[name] = str(error)
                continue
            yield found
        self.notes = stream.bag.notes
        self.types = {name: topic.type for name, topic in stream.bag.topics.items()}
        for name in wanted or ():
            if name not in self.types:
                self._no_topic(name)
            if name in choosers:
                for one in wanted[name] if wanted else ():
                    if one.key not in choosers[name].found:
                        reason = choosers[name].reasons.get(one.key, "no message")
                        raise InputError(f"{self.path}: {name}: {reason}")

    def _no_topic(self, name: str) -> None:
        near = difflib.get_close_matches(name, self.types, n=1)
        hint = f"did you mean {near[0]}?" if near else f"there are {_listed(self.types)}"
        cut = "; the file was cut off" if self.notes else ""
        raise InputError(f"{self.path}: no topic {name[:80]}; {hint}{cut}")


class _Chooser:
    """Finds the columns asked for in each structure of a topic's messages."""

    def __init__(self, wanted: Sequence[Wanted]) -> None:
        self._wanted = wanted
        self.found: set[str] = set()
        self.reasons: dict[str, str] = {}

    def __call__(self, layout: MessageLayout) -> list[tuple[str, Run]]:
        chosen = []
        for one in self._wanted:
            try:
                chosen.append((one.key, layout.find(one.field, one.joint)))
                self.found.add(one.key)
            except CdrError as error:
                self.reasons[one.key] = str(error)
        return chosen


class TableSource:
    """A CSV or MAT file, or a folder of CSV files, each of which is a topic of its name."""

    def __init__(self, path: Path, tables: Sequence[CsvTable | MatTable], kind: str) -> None:
        self.path = path
        self.kind = kind
        self.tables = {table.topic: table for table in tables}
        self.types = {table.topic: kind for table in tables}
        self.names: dict[str, dict[str, tuple[str, ...]]] = {}
        self.unread: dict[str, str] = {}
        self.notes: tuple[str, ...] = ()

    def columns(
        self,
        wanted: Mapping[str, Sequence[Wanted]] | None = None,
        *,
        start_ns: int | None = None,
        stop_ns: int | None = None,
    ) -> Iterator[Columns]:
        """As `BagSource.columns`; tables are read whole whatever the times."""
        chosen = self.tables if wanted is None else wanted
        for name in chosen:
            if name not in self.tables:
                known = _listed(self.tables)
                raise InputError(f"{self.path}: no topic {name[:80]}; there are {known or 'none'}")
            table = self.tables[name]
            if wanted is None:
                yield from table.columns()
                continue
            fields = list(dict.fromkeys(one.field for one in wanted[name]))
            for part in table.columns(fields):
                values = {
                    one.key: part.values[one.field]
                    for one in wanted[name]
                    if one.field in part.values
                }
                yield Columns(part.topic, part.type, None, None, values)
        self.notes = tuple(note for table in self.tables.values() for note in table.notes)


Source = BagSource | TableSource


def open_source(path: str | Path) -> Source:
    """The way into a recording, by what the file is.

    Raises:
        InputError: nothing there, or nothing that can be read.
    """
    place = Path(path)
    if place.is_dir():
        bags = [one for one in place.iterdir() if kind(one) in BAG_SUFFIXES]
        bags += place.glob("metadata.yaml")
        tables = sorted(place.glob("*.csv"))
        if not bags and tables:
            return TableSource(place, [CsvTable(one, one.stem) for one in tables], "CSV")
        return BagSource(place)
    suffix = place.suffix.lower()
    if suffix in CSV_SUFFIXES:
        return TableSource(place, [CsvTable(place)], "CSV")
    if suffix == MAT_SUFFIX:
        return TableSource(place, [MatTable(place)], "MAT")
    if place.is_file() and kind(place) not in BAG_SUFFIXES:
        with place.open("rb") as file:
            if not file.read(len(MAGIC)).startswith(MAGIC):
                raise InputError(
                    f"{path}: of no known kind; expected .mcap, .db3, .csv, .txt, .tsv, .dat, "
                    ".mat, or a folder"
                )
    return BagSource(place)


def _listed(names: Mapping[str, object]) -> str:
    shown = [name[:60] for name in sorted(names)]
    return ", ".join(shown[:12]) + (f" and {len(shown) - 12} more" if len(shown) > 12 else "")
