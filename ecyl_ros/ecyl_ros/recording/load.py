"""`load_recording`: what the commands read a recording with, whatever it is."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from ..errors import InputError
from .cdr import CdrError
from .csvfile import STAMP, read_csv
from .layout import MessageLayout, MessageType
from .map import SignalMap
from .mapped import contract_map, read_mapped, wanted_of
from .reader import StampError, read_recording
from .screening import screened, with_sign_notes
from .signals import SIGNALS, Recording
from .source import TableSource, open_source
from .span import Span
from .stream import BagStream
from .stretch import Stretch, Stretches, pick_stretches, recording_stretches

HINT = "a map says which field is which signal (--map M.yaml; ecyl inspect proposes one)"


def load_recording(
    path: str | Path, signal_map: SignalMap | None = None, span: Span | None = None
) -> Recording:
    """Read a recording by a map, or without one where its names are this project's.

    Topics of this project are joined by equal stamps; where these repeat, go back or differ, they
    are put in order and resampled as for any other recording, and the notes say so.

    Args:
        path: as `source.open_source` takes it.
        signal_map: of a recording of other names.
        span: the part to be read; all by default.

    Raises:
        InputError: unusable, of other names and without a map, or without samples in the span.
    """
    recording = _whole(path, signal_map)
    return recording if span is None else span.part(recording, str(path))


def _whole(path: str | Path, signal_map: SignalMap | None) -> Recording:
    if signal_map is not None:
        return read_mapped(path, signal_map)
    source = open_source(path)
    if isinstance(source, TableSource):
        table = source.tables.get("")
        if table is not None and STAMP in table.names and set(SIGNALS) & set(table.names):
            return _own(read_csv(path), path)
        raise InputError(f"{path}: is no recording of this project: {HINT}")
    try:
        return _own(read_recording(path), path)
    except StampError as error:
        why = str(error).removeprefix(f"{path}: ")
        recording = read_mapped(path, present(path, contract_map()))
        note = f"{path}: {why}: sorted and resampled"
        return dataclasses.replace(recording, notes=(note, *recording.notes))
    except InputError as error:
        if "no messages on any of" in str(error):
            raise InputError(f"{error}; {HINT}") from None
        raise


def _own(recording: Recording, path: str | Path) -> Recording:
    """A recording of our own topics, screened as those that come by a map are."""
    return with_sign_notes(screened(recording, str(path)), str(path))


# Larger recordings are looked through first. At 1 kHz our topics take 10 MB a minute at most.
WHOLE_BYTES = 64 * 2**20


@dataclass(frozen=True)
class LongRecording:
    """A recording longer than what is judged of it at once.

    Attributes:
        path: the file.
        stretches: the parts that tell most.
        read: one of them as a recording.
    """

    path: Path
    stretches: Stretches
    read: Callable[[Stretch], Recording]


def load_long(
    path: str | Path,
    signal_map: SignalMap | None,
    longest_s: float,
    most: int,
    progress: Callable[[float], None] | None = None,
    span: Span | None = None,
) -> Recording | LongRecording:
    """The recording, or where it is longer than `longest_s` the `most` stretches that tell most.

    A large bag is looked through once and then read a stretch at a time; a table, or a bag of up
    to `WHOLE_BYTES`, is read once.

    Args:
        path, signal_map, longest_s, most, progress: as `stretch.pick_stretches` takes them.
        span: the part to be read; all by default.

    Raises:
        InputError: as `load_recording`.
    """
    place = Path(path)
    own = _streamed_map(place, signal_map)
    if own is not None:
        picked = _picked(place, own, longest_s, most, progress, span)
        if isinstance(picked, Recording):
            return picked
        if picked is not None:
            return LongRecording(place, picked, functools.partial(_read_stretch, place, own))
    recording = load_recording(place, signal_map, span)
    return long_or_whole(recording, place, longest_s, most, span.begin_s if span else 0.0)


def long_or_whole(
    recording: Recording,
    path: str | Path,
    longest_s: float,
    most: int,
    begin_s: float = 0.0,
) -> Recording | LongRecording:
    """A recording in memory, or where it is longer than `longest_s` its `most` stretches.

    path: what messages call it. begin_s: where it begins in that file.
    """
    if recording.duration_s <= longest_s:
        return recording
    found = recording_stretches(recording, longest_s, most, begin_s)
    return recording if found is None else LongRecording(Path(path), found, _Slices(recording))


def load_stretch(
    path: str | Path,
    signal_map: SignalMap | None,
    longest_s: float,
    progress: Callable[[float], None] | None = None,
    span: Span | None = None,
) -> Recording:
    """The recording, or of a large bag the part of `longest_s` that tells most.

    The first note says which part that is.

    Args:
        path, signal_map, longest_s, progress: as `stretch.pick_stretches` takes them.
        span: the part to be read; all by default.

    Raises:
        InputError: as `load_recording`.
    """
    place = Path(path)
    own = _streamed_map(place, signal_map)
    found = None if own is None else _picked(place, own, longest_s, 1, progress, span)
    if isinstance(found, Recording):
        return found
    if own is None or found is None:
        return load_recording(place, signal_map, span)
    recording = _read_stretch(place, own, found.chosen[0])
    return dataclasses.replace(recording, notes=(f"{path}: {found.note}", *recording.notes))


def _streamed_map(path: Path, signal_map: SignalMap | None) -> SignalMap | None:
    """The map of a bag too large to be read whole; None for others and for tables."""
    if _size(path) <= WHOLE_BYTES or isinstance(open_source(path), TableSource):
        return None
    return signal_map or present(path, contract_map())


def _picked(
    path: Path,
    own: SignalMap,
    longest_s: float,
    most: int,
    progress: Callable[[float], None] | None,
    span: Span | None,
) -> Stretches | Recording | None:
    """The stretches of a large bag, or the part asked for where that is no longer than one."""
    if span is None:
        return pick_stretches(path, own, longest_s, most, progress)
    source = open_source(path)
    first = next(
        (
            int(part.log_time_ns[0])
            for part in source.columns(wanted_of(source, own))
            if part.log_time_ns is not None and part.log_time_ns.size
        ),
        None,
    )
    if first is None:
        raise span.empty(str(path), 0.0)
    begin_ns = first + round(span.begin_s * 1e9)
    end_ns = first + round(min(span.end_s, 9e9) * 1e9)
    if span.end_s - span.begin_s > longest_s:
        found = pick_stretches(path, own, longest_s, most, progress, (begin_ns, end_ns))
        if found is not None:
            return dataclasses.replace(
                found,
                chosen=tuple(
                    dataclasses.replace(
                        one,
                        begin_s=one.begin_s + span.begin_s,
                        end_s=one.end_s + span.begin_s,
                    )
                    for one in found.chosen
                ),
            )
    try:
        part = read_mapped(path, own, start_ns=begin_ns, stop_ns=end_ns)
    except InputError as error:
        if "within the time asked for" in str(error):
            raise InputError(f"{path}: no samples {span.text}") from None
        raise
    return dataclasses.replace(part, notes=(f"{path}: {span.note}", *part.notes))


def _read_stretch(path: Path, signal_map: SignalMap, stretch: Stretch) -> Recording:
    return read_mapped(path, signal_map, start_ns=stretch.start_ns, stop_ns=stretch.stop_ns)


@dataclass(frozen=True)
class _Slices:
    """Stretches of a recording in memory."""

    recording: Recording

    def __call__(self, stretch: Stretch) -> Recording:
        first = int(self.recording.stamp_ns[0])
        begin, end = ((at - first) / 1e9 for at in (stretch.start_ns, stretch.stop_ns))
        return self.recording.slice(begin, end)


def _size(path: Path) -> int:
    try:
        files = path.iterdir() if path.is_dir() else [path]
        return sum(file.stat().st_size for file in files if file.is_file())
    except OSError:  # what opens it says why
        return 0


def present(path: str | Path, signal_map: SignalMap) -> SignalMap:
    """The part of the project's own map that a bag has topics and joints for."""
    wanted = {one.topic for one in signal_map.signals}
    layouts: dict[str, MessageLayout] = {}
    for batch in BagStream(path, topics=wanted):
        if batch.topic.name not in layouts:
            try:
                layouts[batch.topic.name] = MessageType(batch.topic).layout(batch.message(0))
            except CdrError as error:
                raise InputError(f"{path}: {batch.topic.name}: {error}") from None
        if len(layouts) == len(wanted):
            break
    kept = []
    for one in signal_map.signals:
        layout = layouts.get(one.topic)
        if layout is None:
            continue
        try:
            layout.find(one.field, one.joint)
        except CdrError:  # no such joint, or no array of this kind
            continue
        kept.append(one)
    if not kept:
        raise InputError(f"{path}: holds none of this project's topics: {HINT}")
    return dataclasses.replace(signal_map, signals=tuple(kept))
