"""What a recording's flaws cost: rows left out, and a note on each."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..arrays import FloatArray
from .flaws import Flaw, find_flaws
from .signals import FOREIGN_SIGNALS, SIGNALS, Recording
from .signs import wrong_signs

SPEEDS = {
    "rotor_position_rad": "rotor_velocity_rad_per_s",
    "rod_position_m": "rod_velocity_m_per_s",
    "load_position_rad": "load_velocity_rad_per_s",
}
# Commands and states hold; what is put in from outside does, too.
HELD = {
    *(
        name
        for name in (*SIGNALS, *FOREIGN_SIGNALS)
        if name.startswith(("reference_", "injected_"))
    ),
    "mode",
}


def left_out(signals: dict[str, FloatArray], flaws: list[Flaw]) -> None:
    """Put NaN in the rows that flaws take; in place."""
    for flaw in flaws:
        for name in flaw.fields:
            if name in signals:
                values = np.array(signals[name], dtype=np.float64)
                values[flaw.rows(values)] = np.nan
                signals[name] = values


def flaw_notes(
    flaws: list[Flaw], origin_ns: int, names: Mapping[str, str] | None = None
) -> list[str]:
    """A line on each stretch left out."""
    return [f"{one.text(origin_ns, names)}: left out" for one in flaws]


def screened(recording: Recording, source: str) -> Recording:
    """A recording of this project's own topics without its frozen, repeated or cut off stretches.

    `Recording.notes` says which seconds of which signals were left out.
    """
    signals = {
        name: recording.signal(name) for name in (*SIGNALS, *FOREIGN_SIGNALS) if recording.has(name)
    }
    flaws = find_flaws(recording.stamp_ns, signals, held=HELD, speeds=SPEEDS)
    if not flaws:
        return recording
    changed: dict[str, Any] = dict(signals)
    left_out(changed, flaws)
    notes = [f"{source}: {note}" for note in flaw_notes(flaws, int(recording.stamp_ns[0]))]
    return dataclasses.replace(recording, **changed, notes=(*notes, *recording.notes))


def with_sign_notes(
    recording: Recording, source: str, names: Mapping[str, str] | None = None
) -> Recording:
    """The recording with a note, before all others, on each signal of the wrong sign.

    names: signal -> what the map calls it, where a map could turn its sign.
    """
    found = wrong_signs(recording)
    if not found:
        return recording
    hint = {
        one.signal: "; " + one.remedy(f" for signals.{names[one.signal]}", -1)
        for one in found
        if names and one.signal in names
    }
    notes = [f"{source}: {one.text}{hint.get(one.signal, '')}" for one in found]
    return dataclasses.replace(recording, notes=(*notes, *recording.notes))
