"""Recordings from files and back."""

from __future__ import annotations

import math
import os
from pathlib import Path

from ..errors import InputError
from ..recording.csvfile import write_csv
from ..recording.load import load_recording
from ..recording.map import SignalMap
from ..recording.map_file import load_map
from ..recording.propose import Proposal, propose
from ..recording.signals import Recording
from ..recording.span import Span
from ..recording.survey import survey
from ..recording.writer import write_recording

PathName = str | os.PathLike[str]


def read(
    path: PathName,
    signal_map: SignalMap | PathName | None = None,
    *,
    begin_s: float | None = None,
    end_s: float | None = None,
) -> Recording:
    """Read a recording: MCAP, sqlite3, CSV or MAT file, or a rosbag2 folder.

    Args:
        path: the file or folder.
        signal_map: which field of a foreign recording is which signal: a map file, or what
            `propose_map` found. Without one the names must be this project's.
        begin_s, end_s: the part to be read, in s from the first stamp; all by default.

    Returns:
        All signals on one grid of stamps, in SI units, NaN where nothing was measured; `notes`
        say what was missing, cut off or put in order.

    Raises:
        InputError: unusable, of other names and without a map, or without samples in the part.
    """
    return load_recording(Path(path), as_map(signal_map), as_span(begin_s, end_s))


def propose_map(path: PathName) -> Proposal:
    """What the names and units in a foreign recording suggest, as `ecyl inspect` does.

    Returns:
        `map` for `read` (None where nothing could be recognised; `print(map)` shows it as a file
        would hold it), and `remarks` on what to check.

    Raises:
        InputError: the recording cannot be read.
    """
    return propose(survey(Path(path)))


def write(recording: Recording, path: PathName, *, overwrite: bool = False) -> None:
    """Write a recording: MCAP `NAME.mcap`, a rosbag2 folder `NAME`, or CSV `NAME.csv`.

    Raises:
        InputError: `path` exists and is not to be overwritten, cannot be written, or the recording
            holds nothing.
    """
    target = Path(path)
    if target.suffix != ".csv":
        write_recording(recording, target, overwrite=overwrite)
        return
    if target.exists() and not overwrite:
        raise InputError(f"{target}: exists; expected a new name, or overwrite=True")
    write_csv(recording, target)


def as_map(signal_map: SignalMap | PathName | None) -> SignalMap | None:
    """The map itself, read where a file is named."""
    if signal_map is None or isinstance(signal_map, SignalMap):
        return signal_map
    return load_map(Path(signal_map))


def as_span(begin_s: float | None, end_s: float | None) -> Span | None:
    """The part between two times; None where neither is given."""
    if begin_s is None and end_s is None:
        return None
    return Span(0.0 if begin_s is None else begin_s, math.inf if end_s is None else end_s)
