"""Flaws and wraps of all of a topic's fields, some megabytes at a time."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray, StampArray
from .flaws import SATURATED, Flaw, find_flaws
from .headers import ending, told
from .names import TIMED, holds, unnamed, words
from .units import plain
from .wrap import WrapFound, find_wrap

PIECE_BYTES = 32 * 2**20  # held at a time; statistics are of a piece each
_MOST = 50  # stretches kept


class HealthMeter:
    """Takes one topic's samples part by part and keeps what is wrong with them.

    Args:
        topic: its name.
        units: column -> unit, of the file's line of units.

    Attributes:
        whole: field -> whether all its values are whole numbers.
    """

    def __init__(self, topic: str, units: Mapping[str, str]) -> None:
        self._holds = holds(topic)
        self._units = units
        self._stamps: list[StampArray] = []
        self._parts: list[dict[str, FloatArray]] = []
        self._bytes = self._rows = self._seen = 0
        self._flaws: list[Flaw] = []
        self._wraps: dict[str, WrapFound] = {}
        self.whole: dict[str, bool] = {}

    def take(self, stamps_ns: StampArray, values: Mapping[str, NDArray[np.generic]]) -> None:
        """The next samples; stamps as many as values."""
        own = {name: np.asarray(one, dtype=np.float64) for name, one in values.items()}
        self._stamps.append(stamps_ns)
        self._parts.append(own)
        self._rows += stamps_ns.size
        self._bytes += 8 * stamps_ns.size * (len(own) + 1)
        if self._bytes >= PIECE_BYTES:
            self._judge(last=False)

    def found(self) -> tuple[tuple[Flaw, ...], dict[str, WrapFound]]:
        """All flaws, in order of time, and the fields that start again."""
        self._judge(last=True)
        return tuple(_merged(self._flaws)), self._wraps

    def _judge(self, *, last: bool) -> None:
        if not self._rows:
            return
        stamps = np.concatenate(self._stamps)
        names = list(dict.fromkeys(name for part in self._parts for name in part))
        columns: dict[str, FloatArray] = {}
        for name in names:
            if words(name) & TIMED:
                continue
            values = np.concatenate(
                [
                    part.get(name, np.full(own.size, np.nan))
                    for part, own in zip(self._parts, self._stamps, strict=True)
                ]
            )
            known = values[np.isfinite(values)]
            whole = bool((known == np.round(known)).all())
            self.whole[name] = self.whole.get(name, True) and whole
            found = find_wrap(values, plain(told(name, self._units.get(name, ""))) or ending(name))
            if found is not None:
                before = self._wraps.get(name)
                if before is not None:
                    found = dataclasses.replace(
                        found,
                        wrap=before.wrap,
                        times=found.times + before.times,
                        low=min(found.low, before.low),
                        high=max(found.high, before.high),
                    )
                self._wraps[name] = found
            columns[name] = values
        held = {
            name
            for name in columns
            if self._holds or holds(name) or unnamed(name) or name in self._wraps
        }
        flaws = find_flaws(stamps, columns, held=held, last=last)
        for flaw in flaws:
            self._flaws.append(
                dataclasses.replace(flaw, begin=flaw.begin + self._seen, end=flaw.end + self._seen)
            )
        self._flaws = _merged(self._flaws)[:_MOST]
        self._seen += stamps.size
        self._stamps, self._parts = [], []
        self._bytes = self._rows = 0


def _merged(flaws: list[Flaw]) -> list[Flaw]:
    """Stretches that a piece's end cut in two joined, and a field's rests at its end added up."""
    out: list[Flaw] = []
    for flaw in flaws:
        for place, before in enumerate(out):
            same = before.kind == flaw.kind and before.fields == flaw.fields
            saturated = flaw.kind == SATURATED and before.value == flaw.value
            if same and before.begin < flaw.begin and (saturated or before.end == flaw.begin):
                out[place] = dataclasses.replace(
                    before,
                    end=flaw.end,
                    end_ns=flaw.end_ns,
                    samples=before.samples + flaw.samples,
                    times=before.times + (flaw.times if saturated else 0),
                )
                break
        else:
            out.append(flaw)
    return out
