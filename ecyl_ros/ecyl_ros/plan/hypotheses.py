"""What is still open: effects that act in its stead, in a size each, two by two."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..drive.parameters import DriveParameters
from ..effects.catalogue import CATALOGUE
from ..errors import InputError
from ..gap.limits.probes import Probe, Scale, probes

TIMES = 3.0  # as large as the smallest that is seen with moves of the same limits and time
_CLOSEST = 3  # candidates of an unexplained gap
_MOST_PAIRS = 6


@dataclass(frozen=True)
class Hypothesis:
    """An effect with its parameters; turned: the same a quarter of a period later, of a wave."""

    effect: str
    values: Mapping[str, float]
    turned: Mapping[str, float] | None = None

    @property
    def key(self) -> str:
        """What tells it from others."""
        return f"{self.effect} {dict(self.values)}"

    @property
    def size(self) -> str:
        """Its first parameter, with unit."""
        first = CATALOGUE[self.effect].parameters[0]
        unit = "" if first.unit == "1" else f" {first.unit}"
        return f"{self.values[first.name]:.3g}{unit}"


@dataclass(frozen=True)
class Pair:
    """Two hypotheses that a motion is to tell apart."""

    first: Hypothesis
    second: Hypothesis

    @property
    def name(self) -> str:
        """Both effects."""
        return f"{self.first.effect} | {self.second.effect}"


@dataclass(frozen=True)
class Open:
    """What a diagnosis has left open.

    Attributes:
        pairs: names of effects. values: of those whose size it knows. signals: that were recorded.
        why: one line.
    """

    pairs: tuple[tuple[str, str], ...]
    values: Mapping[str, Mapping[str, float]]
    signals: tuple[str, ...]
    why: str


def open_or_alike(data: Mapping[str, Any]) -> Open:
    """What a diagnosis, as JSON, left open; else the pairs that its recording hardly separates."""
    found = open_in(data)
    if found.pairs:
        return found
    pairs = _catalogued(one["effects"] for one in data.get("alike") or ())
    why = "the recording could not have separated them"
    return dataclasses.replace(found, pairs=pairs, why=why)


def open_in(data: Mapping[str, Any]) -> Open:
    """What a diagnosis, as JSON, could not decide: alternatives of causes, closest candidates."""
    values = {
        cause["effect"]: {key: float(one["value"]) for key, one in cause["parameters"].items()}
        for cause in data["causes"]
        if cause["effect"] in CATALOGUE
    }
    signals = tuple(one["name"] for one in data["location"]["signals"])
    pairs = [
        (cause["effect"], other)
        for cause in data["causes"]
        for other in cause.get("alternatives") or ()
    ]
    why = "a named cause has alternatives"
    if not pairs and data["verdict"] in ("unexplained", "not_judgeable", "partly_explained"):
        singles: list[str] = []
        for one in data.get("candidates") or ():
            if len(one["effects"]) == 1 and one["effects"][0] not in singles:
                singles += one["effects"]
        pairs = list(itertools.combinations(singles[:_CLOSEST], 2))
        why = f"{data['verdict']}: the effects that come closest"
    return Open(_catalogued(pairs), values, signals, why)


def _catalogued(pairs: Iterable[Sequence[str]]) -> tuple[tuple[str, str], ...]:
    """Each pair once, the first few."""
    known = [pair for pair in dict.fromkeys(_sorted(pair) for pair in pairs) if _known(pair)]
    return tuple(known[:_MOST_PAIRS])


def _sorted(pair: Sequence[str]) -> tuple[str, str]:
    first, second = sorted(pair)
    return first, second


def _known(pair: tuple[str, str]) -> bool:
    return all(name in CATALOGUE for name in pair) and pair[0] != pair[1]


def probe_of(name: str, drive: DriveParameters, scale: Scale) -> Probe:
    """An effect in its first shape; InputError for one that has no size to vary."""
    found = probes(name, drive, scale)
    if not found:
        raise InputError(
            f"{name}: has no one size that a motion could be planned for; expected another effect"
        )
    return found[0]


def sized(probe: Probe, size: float) -> Hypothesis:
    """An effect in a size."""
    kept = min(size, probe.largest)
    return Hypothesis(
        probe.effect, probe.made(kept), probe.turned(kept) if probe.turned is not None else None
    )


def given(effect: str, values: Mapping[str, float]) -> Hypothesis:
    """An effect as a diagnosis has found it."""
    full = CATALOGUE[effect].complete(values)
    turned = None
    if "phase_rad" in full:
        turned = {**full, "phase_rad": full["phase_rad"] + 0.5 * math.pi}
    return Hypothesis(effect, full, turned)
