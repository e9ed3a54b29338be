"""What is still open: effects that act in its stead, in a size each, two by two."""

from __future__ import annotations

import dataclasses
import itertools
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..drive.parameters import DriveParameters
from ..drive.tolerances import constants_of
from ..effects.catalogue import CATALOGUE
from ..errors import InputError
from ..gap.limits.probes import Probe, Scale, probes
from ..gap.replay.replay import SIGNALS

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


def read_open(path: Path, drive: DriveParameters, drive_name: str) -> Open:
    """What the diagnosis in a JSON file has left open; InputError where it is of another drive."""
    return open_or_alike(read_diagnosis(path, drive, drive_name))


def open_or_alike(data: Mapping[str, Any]) -> Open:
    """What a diagnosis, as JSON, left open; else the pairs that its recording hardly separates."""
    found = open_in(data)
    if found.pairs:
        return found
    pairs = _catalogued(tuple(one["effects"]) for one in data.get("alike", []))
    why = "the recording could not have separated them"
    return dataclasses.replace(found, pairs=pairs, why=why)


def read_diagnosis(path: Path, drive: DriveParameters, drive_name: str) -> dict[str, Any]:
    """The JSON of a diagnosis of this drive; InputError for any other file."""
    data = _read(path)
    _same_drive(data, drive, path, drive_name)
    return data


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
        for other in cause.get("alternatives", [])
    ]
    why = "a named cause has alternatives"
    if not pairs and data["verdict"] in ("unexplained", "not_judgeable", "partly_explained"):
        singles: list[str] = []
        for one in data.get("candidates", []):
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


def _read(path: Path) -> dict[str, Any]:
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise InputError(f"--from {path}: {error}; expected the JSON of ecyl diagnose") from None
    needed = ("verdict", "causes", "location")
    if not isinstance(data, dict) or data.get("schema") != "ecyl.diagnosis/1":
        raise InputError(f"--from {path}: expected ecyl.diagnosis/1, of ecyl diagnose --json")
    for key in needed:
        if key not in data:
            raise InputError(f"--from {path}: no {key!r}, expected the JSON of ecyl diagnose")
    return data


def _same_drive(
    data: Mapping[str, Any], drive: DriveParameters, path: Path, drive_name: str
) -> None:
    known = {one.name for one in SIGNALS}
    strange = [one["name"] for one in data["location"]["signals"] if one["name"] not in known]
    if strange:
        raise InputError(
            f"--from {path}: location.signals holds {', '.join(strange)}; expected a diagnosis of "
            f"a cylinder, like {drive_name}: of {', '.join(sorted(known))}"
        )
    nominal = constants_of(drive)
    for one in data.get("sheet", []):
        held = nominal.get(one["parameter"])
        if held is None or not math.isclose(held, one["nominal"], rel_tol=1e-6):
            raise InputError(
                f"--from {path}: {one['parameter']} = {one['nominal']:g}, {drive_name} has "
                f"{'none' if held is None else f'{held:g}'}; expected a diagnosis of this drive"
            )


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
