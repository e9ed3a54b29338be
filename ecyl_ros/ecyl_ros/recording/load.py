"""`load_recording`: what the commands read a recording with, whatever it is."""

from __future__ import annotations

import dataclasses
from pathlib import Path

from ..errors import InputError
from .cdr import CdrError
from .csvfile import STAMP, read_csv
from .layout import MessageLayout, MessageType
from .map import SignalMap
from .mapped import contract_map, read_mapped
from .reader import StampError, read_recording
from .signals import SIGNALS, Recording
from .source import TableSource, open_source
from .stream import BagStream
from .stretch import pick_stretch

HINT = "a map says which field is which signal (--map M.yaml; ecyl inspect proposes one)"


def load_recording(path: str | Path, signal_map: SignalMap | None = None) -> Recording:
    """Read a recording by a map, or without one where its names are this project's.

    Topics of this project are joined by equal stamps; where these repeat, go back or differ, they
    are put in order and resampled as for any other recording, and the notes say so.

    Raises:
        InputError: unusable, or of other names and without a map.
    """
    if signal_map is not None:
        return read_mapped(path, signal_map)
    source = open_source(path)
    if isinstance(source, TableSource):
        table = source.tables.get("")
        if table is not None and STAMP in table.names and set(SIGNALS) & set(table.names):
            return read_csv(path)
        raise InputError(f"{path}: is no recording of this project: {HINT}")
    try:
        return read_recording(path)
    except StampError as error:
        why = str(error).removeprefix(f"{path}: ")
        recording = read_mapped(path, present(path, contract_map()))
        note = f"{path}: {why}: put in order"
        return dataclasses.replace(recording, notes=(note, *recording.notes))
    except InputError as error:
        if "no messages on any of" in str(error):
            raise InputError(f"{error}; {HINT}") from None
        raise


# Larger recordings are looked through first. At 1 kHz our topics take 10 MB a minute at most.
WHOLE_BYTES = 64 * 2**20


def load_stretch(path: str | Path, signal_map: SignalMap | None, longest_s: float) -> Recording:
    """What a diagnosis judges: the recording, or of a large bag the part that tells most.

    The first note says which part that is.

    Raises:
        InputError: as `load_recording`.
    """
    if _size(Path(path)) <= WHOLE_BYTES:
        return load_recording(path, signal_map)
    own = signal_map
    if own is None and not isinstance(open_source(path), TableSource):
        own = present(path, contract_map())
    chosen = None if own is None else pick_stretch(path, own, longest_s)
    if chosen is None or own is None:
        return load_recording(path, signal_map)
    recording = read_mapped(path, own, start_ns=chosen.start_ns, stop_ns=chosen.stop_ns)
    return dataclasses.replace(recording, notes=(f"{path}: {chosen.note}", *recording.notes))


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
