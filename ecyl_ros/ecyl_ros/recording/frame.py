"""Signals by name to and from pandas frames; `Recording` does the rest."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..errors import InputError

if TYPE_CHECKING:
    from pandas import DataFrame

STAMP, TIME = "stamp_ns", "time_s"


def to_frame(
    stamp_ns: NDArray[np.int64],
    time_s: FloatArray,
    signals: Mapping[str, FloatArray],
    resolution: Mapping[str, float],
    notes: Sequence[str],
) -> DataFrame:
    """Stamps and signals as columns, the index time in s; `attrs` hold `resolution` and `notes`."""
    import pandas as pd

    columns: dict[str, Any] = {STAMP: stamp_ns.copy()}
    columns |= {name: values.copy() for name, values in signals.items()}
    frame = pd.DataFrame(columns, index=pd.Index(time_s, name=TIME))
    frame.attrs = {"resolution": dict(resolution), "notes": list(notes)}
    return frame


def from_frame(frame: DataFrame, known: Collection[str]) -> dict[str, Any]:
    """What `Recording` takes, by name: `stamp_ns`, signals, `resolution` and `notes`.

    Args:
        frame: columns by the names `known`, SI units; others are left aside. The instants are the
            column `stamp_ns`, or the column `time_s`, or the index: dates, time spans, or seconds.

    Raises:
        InputError: no column with a signal's name, one that holds no numbers, or instants that
            are missing or do not increase.
    """
    names = [str(name) for name in frame.columns if name in known]
    if not names:
        raise InputError("frame: no column with a signal's name, such as rod_position_m")
    found: dict[str, Any] = {}
    for name in names:
        try:
            found[name] = frame[name].to_numpy(dtype=np.float64, na_value=np.nan)
        except (TypeError, ValueError):
            raise InputError(f"frame: column {name} holds no numbers") from None
    stamps = _stamps(frame)
    if np.any(stamps[1:] <= stamps[:-1]):
        raise InputError("frame: the instants do not increase; expected one row an instant")
    about = {
        "resolution": frame.attrs.get("resolution", {}),
        "notes": tuple(frame.attrs.get("notes", ())),
    }
    return {STAMP: stamps, **found, **about}


def _stamps(frame: DataFrame) -> NDArray[np.int64]:
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
