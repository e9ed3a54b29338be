"""The JSON of a diagnosis, read back: what of it a plan goes by, checked field by field."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..drive.parameters import DriveParameters
from ..drive.tolerances import constants_of
from ..effects.catalogue import CATALOGUE
from ..errors import InputError
from ..finite import is_finite
from ..gap.replay.replay import SIGNALS

_SCHEMA = "ecyl.diagnosis/1"
_OPTIONAL = "?"  # ends the key of a field that may be missing or null
_ANY = "*"  # the key of whatever has a name of its own
_SHAPE: dict[str, Any] = {
    "verdict": str,
    "reason?": str,
    "location": {"signals": [{"name": str}]},
    "causes": [{"effect": str, "parameters": {_ANY: {"value": float}}, "alternatives?": [str]}],
    "candidates?": [{"effects": [str]}],
    "alike?": [{"effects": (str, str)}],
    "limits?": [{"effect": str, "smallest_seen?": float}],
    "sheet?": [{"parameter": str, "nominal": float}],
}
_WORDS = {
    str: "text",
    float: "a finite number",
    list: "a list",
    tuple: "a list of two",
    dict: "a mapping",
}


def read_diagnosis(path: Path, drive: DriveParameters, drive_name: str) -> dict[str, Any]:
    """The JSON of a diagnosis of this drive; InputError for any other file."""
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise InputError(f"--from {path}: {error}; expected the JSON of ecyl diagnose") from None
    if not isinstance(data, dict) or data.get("schema") != _SCHEMA:
        raise InputError(f"--from {path}: expected {_SCHEMA}, of ecyl diagnose --json")
    _check(data, _SHAPE, f"--from {path}:", "")
    _check_drive(data, drive, path, drive_name)
    _check_values(data, path)
    return data


def _check(data: Any, shape: Any, head: str, field: str) -> None:
    """Refuse what has another shape; field: where in the file."""
    kind = shape if isinstance(shape, type) else type(shape)
    if not _fits(data, shape, kind):
        said = "missing" if data is None else f"{data!r}"[:60]
        raise InputError(
            f"{head} {field} = {said}, expected {_WORDS[kind]}, as ecyl diagnose --json writes it"
        )
    if kind in (list, tuple):
        for number, one in enumerate(data):
            _check(one, shape[0], head, f"{field}[{number}]")
    elif kind is dict:
        for key, inner in shape.items():
            name = key.removesuffix(_OPTIONAL)
            for own in data if key == _ANY else (name,):
                if data.get(own) is not None or key == name:
                    _check(data.get(own), inner, head, f"{field}.{own}" if field else own)


def _fits(data: Any, shape: Any, kind: type) -> bool:
    if kind is float:
        return is_finite(data)
    if kind is tuple:
        return isinstance(data, list) and len(data) == len(shape)
    return isinstance(data, kind)


def _check_drive(
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
    for one in data.get("sheet") or ():
        held = nominal.get(one["parameter"])
        if held is None or not math.isclose(held, one["nominal"], rel_tol=1e-6):
            raise InputError(
                f"--from {path}: {one['parameter']} = {one['nominal']:g}, {drive_name} has "
                f"{'none' if held is None else f'{held:g}'}; expected a diagnosis of this drive"
            )


def _check_values(data: Mapping[str, Any], path: Path) -> None:
    """An effect of the catalogue has to have its own parameters, all of them."""
    for cause in data["causes"]:
        effect = CATALOGUE.get(cause["effect"])
        if effect is None:
            continue
        try:
            effect.complete({name: one["value"] for name, one in cause["parameters"].items()})
        except KeyError as error:
            known = ", ".join(one.name for one in effect.parameters)
            raise InputError(
                f"--from {path}: causes: parameter {error} of {effect.name} is missing or not its "
                f"own; expected {known}"
            ) from None
