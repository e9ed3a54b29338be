"""Rows of a recording that its logger has repeated: left out."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from ...recording.repeats import repeated_rows
from ...recording.runs import runs_of
from ...recording.screening import HELD
from ...recording.signals import FOREIGN_SIGNALS, SIGNALS, Recording


def without_repeats(recording: Recording) -> tuple[Recording, list[tuple[float, float]]]:
    """The recording with NaN where its logger was frozen, and from when to when, s."""
    signals = {
        name: recording.signal(name) for name in (*SIGNALS, *FOREIGN_SIGNALS) if recording.has(name)
    }
    rows = repeated_rows(signals, HELD)
    if not rows.any():
        return recording, []
    changed: dict[str, Any] = {
        name: np.where(rows, np.nan, values) for name, values in signals.items() if name != "mode"
    }
    spans = [(float(recording.time_s[a]), float(recording.time_s[b - 1])) for a, b in runs_of(rows)]
    return dataclasses.replace(recording, **changed), spans
