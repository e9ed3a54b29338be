"""Recordings to and from pandas."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InputError
from .signals import FOREIGN_SIGNALS, SIGNALS, Recording, StampArray

if TYPE_CHECKING:
    from pandas import DataFrame

STAMP, TIME = "stamp_ns", "time_s"


def to_frame(recording: Recording) -> DataFrame:
    """The measured signals as columns, the index time in s since the first stamp.

    The column `stamp_ns` keeps the stamps whole; `attrs` hold `resolution` and `notes`.
    """
    import pandas as pd

    names = [name for name in (*SIGNALS, *FOREIGN_SIGNALS) if recording.has(name)]
    columns: dict[str, Any] = {STAMP: recording.stamp_ns.copy()}
    columns |= {name: recording.signal(name).copy() for name in names}
    frame = pd.DataFrame(columns, index=pd.Index(recording.time_s, name=TIME))
    frame.attrs = {"resolution": dict(recording.resolution), "notes": list(recording.notes)}
    return frame


def from_frame(frame: DataFrame) -> Recording:
    """The recording that a frame holds.

    Args:
        frame: columns by the names in `SIGNALS`, SI units; others are left aside. The instants
            are the column `stamp_ns`, or the column `time_s`, or the index: dates, time spans,
            or seconds.

    Raises:
        InputError: no column with a signal's name, one that holds no numbers, or instants that
            are missing or do not increase.
    """
    known = {*SIGNALS, *FOREIGN_SIGNALS}
    names = [str(name) for name in frame.columns if name in known]
    if not names:
        raise InputError("frame: no column with a signal's name, such as rod_position_m")
    signals: dict[str, Any] = {}
    for name in names:
        try:
            signals[name] = frame[name].to_numpy(dtype=np.float64, na_value=np.nan)
        except (TypeError, ValueError):
            raise InputError(f"frame: column {name} holds no numbers") from None
    stamps = _stamps(frame)
    if np.any(stamps[1:] <= stamps[:-1]):
        raise InputError("frame: the instants do not increase; expected one row an instant")
    about = {
        "resolution": frame.attrs.get("resolution", {}),
        "notes": tuple(frame.attrs.get("notes", ())),
    }
    return Recording(stamp_ns=stamps, **signals, **about)


def _stamps(frame: DataFrame) -> StampArray:
    import pandas as pd

    if STAMP in frame.columns:
        return frame[STAMP].to_numpy(dtype=np.int64)
    index = pd.Index(frame[TIME]) if TIME in frame.columns else frame.index
    if isinstance(index, pd.DatetimeIndex | pd.TimedeltaIndex):
        if index.hasnans:
            raise InputError("frame: instants are missing; expected one a row")
        return index.as_unit("ns").to_numpy().astype(np.int64)
    try:
        seconds = index.to_numpy(dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError("frame: the index is no time; expected s, dates, or stamp_ns") from None
    if not np.isfinite(seconds).all():
        raise InputError("frame: instants are missing; expected one a row")
    return np.round(seconds * 1e9).astype(np.int64)
