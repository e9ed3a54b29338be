"""A replay that runs away from its recording has no figures: how far says nothing of the drive.

A position from effort alone grows with the square of time. Once it is further off than all the way
that was recorded, RMS and floor are those of the time between two restarts.
"""

from __future__ import annotations

import dataclasses
import math
from typing import NamedTuple

import numpy as np

from ...arrays import BoolArray, FloatArray
from .replay import Replay

_MOTION = ("position", "speed")


class Runaways(NamedTuple):
    """Which replays ran away: with the nominal model, and with what was found."""

    before: bool
    after: bool


def without_runaways(played: Replay, runaways: Runaways) -> Replay:
    """The replay, NaN for what a run that ran away says, and a note."""
    before, after = runaways
    if not (before or after):
        return played
    nan = math.nan
    signals = tuple(
        dataclasses.replace(
            one,
            gap=nan if before else one.gap,
            after=nan if after else one.after,
            floor=nan if after else one.floor,
        )
        for one in played.signals
    )
    who = "with the nominal model" if before else "with the causes found"
    who = f"{who} and with the causes found" if before and after else who
    note = (
        f"{who} the replay runs away: its error exceeds the whole recorded motion; check the sign "
        "and gain of the effort, and what else drives the output"
    )
    return dataclasses.replace(
        played,
        signals=signals,
        before=np.full_like(played.before, nan) if before else played.before,
        after=np.full_like(played.after, nan) if after else played.after,
        notes=(*played.notes, note),
    )


def ran_away(played: Replay, judged: BoolArray) -> Runaways:
    """Which replays ran away; judged: bool[m], rows that figures are of."""
    rows = [at for at, one in enumerate(played.signals) if one.name in _MOTION]
    rows = rows if played.recorded.size else []
    return Runaways(*(_away(played, run, rows, judged) for run in (played.before, played.after)))


def _away(played: Replay, run: FloatArray, rows: list[int], judged: BoolArray) -> bool:
    """Whether a run is further off, by its RMS, than the recording moves."""
    for row in rows:
        recorded, left = played.recorded[row][judged], (played.recorded - run)[row][judged]
        known = np.isfinite(left)
        if known.any() and np.sqrt(np.mean(left[known] ** 2)) > np.ptp(recorded[known]):
            return True
    return False
