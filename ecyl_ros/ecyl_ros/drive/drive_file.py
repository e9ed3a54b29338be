"""Drive files: ROS 2 parameter files in, checked key by key, and out again.

The same file serves nodes (`--params-file`) and offline commands (`--drive`). Nodes hand the flat
parameters they were given to `drive_from_flat`; commands call `load_drive`.
"""

from __future__ import annotations

import dataclasses
import difflib
import math
import os
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from ..effects.catalogue import CATALOGUE
from ..errors import InputError
from ..finite import is_finite
from .coupling import MAY_MISS, rigid_coupling
from .law import KEY as LEARNED
from .law import KEYS as LAW_KEYS
from .law import law_from_flat, law_to_flat
from .packed import MAX_SEGMENTS
from .parameters import GROUPS, LOOPS, DriveParameters, check_relations, leaf_fields
from .tolerances import CONSTANTS, stated_tolerances

# Parameters of the nodes themselves (see nodes/), which a drive file may hold beside the drive's.
NODE_KEYS = (
    "use_sim_time",
    "start_type_description_service",
    "realtime",
    "duration",
    "partner_timeout",
    "processors",
    "recorder",
    "summary_file",
    "reference",
    "lookahead",
    "window",
    "out",
    "overwrite",
    "qos_overrides",
)


def config_folder() -> Path:
    """Folder of the profiles that come with the package, installed or in the source tree."""
    package = Path(__file__).resolve().parents[1]
    source = package.parent
    places = [source / "config"] if (source / "package.xml").is_file() else []
    places += [parent / "share/ecyl_ros/config" for parent in package.parents]
    prefixes = os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
    places += [
        Path(prefix, "share/ecyl_ros/config") for prefix in (*prefixes, sys.prefix) if prefix
    ]
    for place in places:
        if place.is_dir():
            return place
    raise InputError("ecyl_ros: its config folder is missing; expected share/ecyl_ros/config")


def profiles() -> list[str]:
    """Names of the profiles that come with the package."""
    return sorted(path.stem for path in config_folder().glob("*.yaml"))


def resolve_drive(name: str | os.PathLike[str]) -> Path:
    """Path of a drive file given as a path or as a profile's name (`paper`, `bench`, ...)."""
    path = Path(name)
    if path.is_file():
        return path
    if str(name) in profiles():
        return config_folder() / f"{name}.yaml"
    raise InputError(
        f"{name}: no such drive file; expected a ROS 2 parameter file or one of "
        f"{', '.join(profiles())}"
    )


def _flatten(tree: Mapping[Any, Any], prefix: str = "") -> dict[str, Any]:
    flat: dict[str, Any] = {}
    for key, value in tree.items():
        if isinstance(value, Mapping):
            flat |= _flatten(value, f"{prefix}{key}.")
        else:
            flat[f"{prefix}{key}"] = value
    return flat


def read_parameter_file(path: Path) -> dict[str, Any]:
    """Flat dotted parameters of a ROS 2 parameter file; later node patterns override earlier."""
    try:
        text = path.read_text(encoding="utf-8")
        aliases = any(isinstance(event, yaml.AliasEvent) for event in yaml.parse(text))
        tree = None if aliases else yaml.safe_load(text)
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}; expected a readable drive file") from None
    except (yaml.YAMLError, UnicodeDecodeError, RecursionError, ValueError) as error:
        mark = getattr(error, "problem_mark", None)
        place = f" at line {mark.line + 1}" if mark else ""
        raise InputError(f"{path}: not YAML{place}; expected a ROS 2 parameter file") from None
    if aliases:  # nested ones grow without bounds once written out
        raise InputError(f"{path}: a YAML alias (*name); expected every value written out")
    flat: dict[str, Any] = {}
    found = False
    for node, content in tree.items() if isinstance(tree, Mapping) else ():
        if isinstance(content, Mapping) and isinstance(content.get("ros__parameters"), Mapping):
            found = True
            flat |= _flatten(content["ros__parameters"])
        elif isinstance(content, Mapping) and any(
            isinstance(inner, Mapping) and "ros__parameters" in inner for inner in content.values()
        ):
            raise InputError(
                f"{path}: parameters below namespace {node}; expected them below '/**'"
            )
    if not found:
        raise InputError(f"{path}: no 'ros__parameters'; expected '/**: ros__parameters: ...'")
    return flat


def _number(value: Any, meta: Mapping[str, Any], key: str, source: str, whole: bool) -> float | int:
    unit, low, high = meta["unit"], meta["low"], meta["high"]
    kind = "a whole number" if whole else "a number"
    wanted = f"expected {kind} {'above' if meta['open_low'] else 'from'} {low:g} to {high:g} {unit}"
    if isinstance(value, str):  # YAML 1.1 reads 1e3 (no dot) as text; ROS reads a number
        try:
            value = float(value)
        except ValueError:
            raise InputError(f"{source}: {key} = {value!r}, {wanted}") from None
    if not is_finite(value) and value not in (math.inf, -math.inf):
        raise InputError(f"{source}: {key} = {value!r}, {wanted}")
    if whole and value != int(value if math.isfinite(value) else 0):
        raise InputError(f"{source}: {key} = {value!r}, {wanted}")
    if not low <= value <= high or (meta["open_low"] and value == low):
        raise InputError(f"{source}: {key} = {value:g} {unit}, {wanted} (SI units throughout)")
    return int(value) if whole else float(value)


def _leaf(value: Any, item: dataclasses.Field, key: str, source: str) -> Any:
    meta = item.metadata
    if "choices" in meta:
        if value not in meta["choices"]:
            raise InputError(
                f"{source}: {key} = {value!r}, expected {' or '.join(meta['choices'])}"
            )
        return value
    if str(item.type).startswith("tuple"):
        values = [] if value is None else value
        if isinstance(values, str | bytes) or not hasattr(values, "__iter__"):
            values = [values]
        values = list(values)
        if len(values) > MAX_SEGMENTS or (not values and item.default is dataclasses.MISSING):
            raise InputError(
                f"{source}: {key} has {len(values)} values, expected 1 to {MAX_SEGMENTS} in "
                f"{meta['unit']}"
            )
        return tuple(_number(one, meta, key, source, False) for one in values)
    return _number(value, meta, key, source, str(item.type) == "int")


def drive_from_flat(flat: Mapping[str, Any], source: str) -> DriveParameters:
    """Build and check a drive from flat dotted parameters; `source` names them in errors.

    Raises InputError for an unknown key (with the nearest known one), a missing key, a value that
    is no number or beyond what is possible in its unit, and values that do not fit together.
    """
    leaves = leaf_fields()
    values: dict[str, Any] = {}
    effects: dict[str, dict[str, float]] = {}
    for key, value in flat.items():
        if key in leaves:
            values[key] = _leaf(value, leaves[key], key, source)
        elif key == LEARNED or key.startswith(f"{LEARNED}."):
            continue  # read as one, below
        elif key.startswith("effects."):
            _put_effect(effects, key, value, source)
        elif key.split(".")[0] not in ("tolerances", *NODE_KEYS):
            near = difflib.get_close_matches(key, leaves, n=1)
            hint = f"; did you mean {near[0]}?" if near else "; see the drive file reference"
            raise InputError(f"{source}: unknown key {key}{hint}")
    left_out = _coupling_left_out(values)
    values |= left_out
    for key, item in leaves.items():
        missing = item.default is dataclasses.MISSING and key not in (*values, *MAY_MISS)
        if missing:
            unit = item.metadata["unit"]
            raise InputError(
                f"{source}: {key} is missing; expected {item.metadata['meaning']}, {unit}"
            )
    groups = {}
    for name, kind in GROUPS.items():
        arguments: dict[str, Any] = {}
        for item in dataclasses.fields(kind):
            key = f"{name}.{item.name}"
            if item.metadata:
                if key in values:
                    arguments[item.name] = values[key]
            else:
                loop = LOOPS[item.name]
                gains = {
                    g.name: values[f"{key}.{g.name}"]
                    for g in dataclasses.fields(loop)
                    if f"{key}.{g.name}" in values
                }
                arguments[item.name] = loop(**gains)
        groups[name] = kind(**arguments)
    top = {key: value for key, value in values.items() if "." not in key}
    units = {key: leaves[key].metadata["unit"] for key in CONSTANTS}
    tolerances = stated_tolerances(flat, units, source)
    drive = DriveParameters(
        **groups,
        **top,
        effects=_complete(effects, source),
        learned=law_from_flat(flat, source),
        tolerances=tolerances,
        left_out=tuple(left_out),
    )
    check_relations(drive, source)
    return drive


def _coupling_left_out(values: Mapping[str, Any]) -> dict[str, Any]:
    """What takes the place of a coupling's values that are left out, where it can be told."""
    needed = ("motor.rotor_inertia", "load.inertia", "controller.rate")
    if any(key not in values for key in needed):
        return {}
    rotor, load, rate = (float(values[key]) for key in needed)
    return dict(rigid_coupling(values, rotor, load, rate))


def _put_effect(effects: dict[str, dict[str, float]], key: str, value: Any, source: str) -> None:
    """Check one key effects.NAME.PARAMETER and put its value into `effects`."""
    name, _, parameter = key.removeprefix("effects.").partition(".")
    if name not in CATALOGUE:
        near = difflib.get_close_matches(name, CATALOGUE, n=1)
        hint = f"did you mean {near[0]}?" if near else f"expected one of {', '.join(CATALOGUE)}"
        raise InputError(f"{source}: unknown effect {key}; {hint}")
    quantities = {one.name: one for one in CATALOGUE[name].parameters}
    if parameter not in quantities:
        raise InputError(f"{source}: unknown key {key}; {name} has {', '.join(quantities)}")
    one = quantities[parameter]
    meta = {"unit": one.unit, "low": one.low, "high": one.high, "open_low": False}
    effects.setdefault(name, {})[parameter] = float(_number(value, meta, key, source, False))


def _complete(effects: dict[str, dict[str, float]], source: str) -> dict[str, dict[str, float]]:
    """The effects with defaults filled in; InputError where a parameter without one is missing."""
    full = {}
    for name, values in effects.items():
        try:
            full[name] = CATALOGUE[name].complete(values)
        except KeyError as missing:
            key = f"effects.{name}.{missing.args[0]}"
            raise InputError(f"{source}: {key} is missing; the effect needs it") from None
    return full


def key_meaning(key: str) -> str:
    """What a dotted key of a drive file means, with its unit."""
    if key.startswith(f"{LEARNED}."):
        return f"learned law: {LAW_KEYS[key.removeprefix(f'{LEARNED}.')]}"
    if key.startswith("effects."):
        name, _, parameter = key.removeprefix("effects.").partition(".")
        effect = CATALOGUE[name]
        (one,) = (one for one in effect.parameters if one.name == parameter)
        return f"{effect.title}: {one.meaning}, {one.unit}"
    if key.startswith("tolerances."):
        return f"half width that holds 95 % of healthy machines, of {key.partition('.')[2]}"
    meta = leaf_fields()[key].metadata
    unit = meta.get("unit", "")
    return f"{meta['meaning']}, {unit}" if unit else str(meta["meaning"])


def load_drive(name: str | os.PathLike[str]) -> DriveParameters:
    """Read and check a drive file, given as a path or a profile's name."""
    path = resolve_drive(name)
    return drive_from_flat(read_parameter_file(path), str(path))


def with_rate(drive: DriveParameters, rate: float | None, source: str) -> DriveParameters:
    """The drive at another control rate, Hz, if one is given; InputError as `drive_from_flat`."""
    if rate is None:
        return drive
    return drive_from_flat(drive_to_flat(drive) | {"controller.rate": rate}, source)


def drive_to_flat(drive: DriveParameters) -> dict[str, Any]:
    """Flat dotted parameters of `drive`, every key, in file order; tuples become lists.

    Those of a coupling that its file leaves out are left out here, too. Effects that the drive has
    come after them, then tolerances that were stated.
    """
    flat: dict[str, Any] = {}
    for key in leaf_fields():
        if key in drive.left_out:
            continue
        value: Any = drive
        for part in key.split("."):
            value = getattr(value, part)
        flat[key] = list(value) if isinstance(value, tuple) else value
    for name, values in drive.effects.items():
        flat |= {f"effects.{name}.{parameter}": value for parameter, value in values.items()}
    if drive.learned is not None:
        flat |= law_to_flat(drive.learned)
    # As text: a parameter of a node has one type.
    flat |= {f"tolerances.{key}": str(value) for key, value in drive.tolerances.items()}
    return flat
