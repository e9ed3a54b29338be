"""Which parameters are varied, and how: `stiffness=0.7,1,1.3`, `contact_damping:=0,1e-4`."""

from __future__ import annotations

import difflib
import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...drive.drive_file import drive_from_flat, drive_to_flat
from ...drive.parameters import DriveParameters, leaf_fields
from ...effects.catalogue import CATALOGUE
from ...errors import InputError

LARGEST = 100_000  # runs


@dataclass(frozen=True)
class Axis:
    """One parameter and the values it takes.

    Attributes:
        key: dotted, as in the drive file.
        unit: its SI unit; empty for a choice.
        nominal: the drive's own value; None where the drive does not have it.
        given: the numbers (or words) as they were given.
        relative: whether `given` are multiples of `nominal`.
        values: float, list of float, or word, each as the drive file would have it.
    """

    key: str
    unit: str
    nominal: Any
    given: tuple[Any, ...]
    relative: bool
    values: tuple[Any, ...]


@dataclass(frozen=True)
class Point:
    """One drive of a sweep: what was given per axis, and its flat parameters."""

    given: tuple[Any, ...]
    values: tuple[Any, ...]
    flat: Mapping[str, Any]


def parse_axis(text: str, drive: DriveParameters) -> Axis:
    """An axis from text.

    NAME=F1,F2,... are multiples of the drive's value, NAME:=V1,V2,... values themselves in SI; each
    item a number or START:STOP:COUNT, evenly spaced. NAME is a key of the drive file or its end, as
    far as it is unique (`stiffness`, `speed.kp`). A list is multiplied as a whole; as a value it
    is written 6498;9878.

    Raises:
        InputError: a name that is unknown or not unique, an item that is no number, a multiple of
            a value that is zero, infinite or a word.
    """
    flag = f"--vary {text}"
    name, equals, items = text.partition("=")
    absolute = name.endswith(":")
    name = name.removesuffix(":").strip()
    if not equals or not name:
        raise InputError(f"{flag}: expected NAME=F1,F2,... (multiples) or NAME:=V1,V2,... (values)")
    flat = drive_to_flat(drive)
    key = _key(name, flat, flag)
    nominal = flat.get(key)
    unit, choices = _unit(key)
    words = [word.strip() for word in items.split(",") if word.strip()]
    if not words:
        raise InputError(f"{flag}: no values, expected numbers separated by commas")
    if absolute:
        given = tuple(
            word if choices else one for word in words for one in _items(word, flag, choices)
        )
        return Axis(key, unit, nominal, given, False, given)
    if choices:
        raise InputError(f"{flag}: {key} is a choice; expected {name}:={','.join(choices)}")
    parts: list[Any] = nominal if isinstance(nominal, list) else [nominal]
    if nominal is None or not parts or not all(0.0 < abs(one) < math.inf for one in parts):
        raise InputError(
            f"{flag}: {key} is {nominal} in the drive, which has no multiples; expected values, "
            f"{name}:=V1,V2,..."
        )
    factors = tuple(one for word in words for one in _items(word, flag, ()))
    for factor in factors:
        if isinstance(factor, list):
            raise InputError(f"{flag}: a list is no multiple, expected numbers")
    values = tuple(
        [factor * one for one in nominal] if isinstance(nominal, list) else factor * nominal
        for factor in factors
    )
    return Axis(key, unit, nominal, factors, True, values)


def points(drive: DriveParameters, axes: Sequence[Axis], source: str) -> list[Point]:
    """Every combination of the axes' values, the last axis fastest, each a drive that is possible.

    Raises:
        InputError: one parameter on two axes, too many points, or values a drive cannot have.
    """
    keys = [axis.key for axis in axes]
    if len(set(keys)) < len(keys):
        raise InputError(f"--vary: {keys[0]} is varied twice, expected two different parameters")
    count = math.prod(len(axis.values) for axis in axes)
    if count > LARGEST:
        raise InputError(f"--vary: {count} runs, expected at most {LARGEST}")
    nominal = drive_to_flat(drive)
    found = []
    for places in itertools.product(*(range(len(axis.values)) for axis in axes)):
        values = tuple(axis.values[place] for axis, place in zip(axes, places, strict=True))
        given = tuple(axis.given[place] for axis, place in zip(axes, places, strict=True))
        flat = nominal | dict(zip(keys, values, strict=True))
        drive_from_flat(flat, f"--vary, {source}")
        found.append(Point(given, values, flat))
    return found


def _key(name: str, flat: Mapping[str, Any], flag: str) -> str:
    known = dict.fromkeys((*leaf_fields(), *flat))
    if name in known or name.startswith("effects."):
        return name
    ends = [key for key in known if key.endswith(f".{name}")]
    if len(ends) == 1:
        return ends[0]
    if ends:
        raise InputError(f"{flag}: {name} is not unique, expected one of {', '.join(ends)}")
    short = {key.rpartition(".")[2]: key for key in known}
    near = difflib.get_close_matches(name, [*known, *short], n=1)
    hint = f"; did you mean {near[0]}?" if near else "; expected a key of the drive file"
    raise InputError(f"{flag}: unknown parameter {name}{hint}")


def _unit(key: str) -> tuple[str, tuple[str, ...]]:
    if key.startswith("effects."):
        effect, _, parameter = key.removeprefix("effects.").partition(".")
        for one in CATALOGUE[effect].parameters if effect in CATALOGUE else ():
            if one.name == parameter:
                return one.unit, ()
        return "", ()  # drive_from_flat says what is wrong with the name
    meta = leaf_fields()[key].metadata
    return meta.get("unit", ""), tuple(meta.get("choices", ()))


def _items(word: str, flag: str, choices: tuple[str, ...]) -> list[Any]:
    if choices:
        return [word]
    if word.count(":") == 2:
        start, stop, count = word.split(":")
        number = _number(count, flag)
        if number != int(number) or not 2 <= number <= LARGEST:
            raise InputError(
                f"{flag}: {word!r}, expected START:STOP:COUNT with a count of 2 or more"
            )
        grid = np.linspace(_number(start, flag), _number(stop, flag), int(number))
        return [float(f"{one:.12g}") for one in grid]
    if ";" in word:
        return [[_number(one, flag) for one in word.split(";") if one.strip()]]
    return [_number(word, flag)]


def _number(text: str, flag: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(f"{flag}: {text!r}, expected a finite number")
    return value
