"""References from text: `sine:amplitude=2e-5,frequency=1`, `moves:...`, `setpoint`, or a file.

A file is a recording, whose reference is played, or a planned motion (`.yaml`).

The same text serves the command line and the reference node's parameter. Numbers are SI; lists are
separated by semicolons.
"""

from __future__ import annotations

import dataclasses
import difflib
import math
from pathlib import Path
from typing import Any

from ...errors import InputError
from ..parameters import DriveParameters, LimitParameters
from .base import Reference
from .chirp import Chirp
from .moves import Moves
from .multisine import Multisine
from .planned import SUFFIXES, read_planned
from .setpoint import SetpointFollower
from .sine import Sine

KINDS: dict[str, type] = {"sine": Sine, "chirp": Chirp, "moves": Moves, "multisine": Multisine}

# Arguments that must be above zero for the motion to mean anything.
_POSITIVE = (
    "amplitude",
    "frequency",
    "start",
    "end",
    "sweep",
    "base",
    "speed",
    "acceleration",
    "jerk",
)
_BRIEF = 60  # characters
PEAK_SAMPLES = 20000  # how finely a reference is walked to check it against stroke and speed


def usage() -> str:
    """One line per kind with its arguments, for help texts."""
    lines = []
    for name, kind in KINDS.items():
        words = [
            f"{item.name}=" if item.default is dataclasses.MISSING else f"[{item.name}=]"
            for item in dataclasses.fields(kind)
        ]
        lines.append(f"{name}:{','.join(words)}")
    return "\n".join([*lines, "setpoint", "PATH of a recording, or of a motion (.yaml)"])


def _brief(text: str) -> str:
    """A text as messages repeat it: what was expected must not get lost behind it."""
    return text if len(text) <= _BRIEF else f"{text[: _BRIEF - 4]} ..."


def _value(text: str, item: dataclasses.Field, spec: str) -> Any:
    kind = str(item.type)
    try:
        if kind == "bool":
            return {"true": True, "false": False}[text.lower()]
        if kind.startswith("tuple"):
            values = tuple(float(word) for word in text.split(";") if word.strip())
        else:
            values = (float(text),)
    except (ValueError, KeyError):
        values = ()
    if not values or not all(math.isfinite(value) for value in values):
        wanted = "true or false" if kind == "bool" else "a finite number"
        wanted = "numbers like 0.01;0.02;0" if kind.startswith("tuple") else wanted
        raise InputError(f"reference {spec}: {item.name} = {_brief(text)!r}, expected {wanted}")
    if item.name in _POSITIVE and values[0] <= 0.0:
        raise InputError(f"reference {spec}: {item.name} = {text}, expected more than 0")
    if item.name == "dwell" and values[0] < 0.0:
        raise InputError(f"reference {spec}: dwell = {text}, expected 0 s or more")
    return values if kind.startswith("tuple") else values[0]


def _parse(kind_name: str, text: str, limits: LimitParameters, spec: str) -> Reference:
    kind = KINDS[kind_name]
    known = {item.name: item for item in dataclasses.fields(kind)}
    arguments: dict[str, Any] = {}
    for word in filter(None, (word.strip() for word in text.split(","))):
        name, equals, value = word.partition("=")
        if name not in known or not equals:
            near = difflib.get_close_matches(name, known, n=1)
            hint = f"did you mean {near[0]}?" if near else f"expected {', '.join(known)}"
            raise InputError(f"reference {spec}: unknown argument {word!r}; {hint}")
        arguments[name] = _value(value, known[name], spec)
    if kind is Moves:  # a move that names no limits uses the drive's
        for name in ("speed", "acceleration", "jerk"):
            arguments.setdefault(name, getattr(limits, name))
    for name, item in known.items():
        if item.default is dataclasses.MISSING and name not in arguments:
            several = "0.01;0.02;0" if str(item.type).startswith("tuple") else "..."
            raise InputError(
                f"reference {spec}: {name} is missing; expected {kind_name}:{name}={several}"
            )
    made = kind(**arguments)
    try:
        made.sample(0.0)
    except InputError as error:
        raise InputError(f"reference {spec}: {error}") from None
    return made


def check_within_limits(
    reference: Reference, limits: LimitParameters, duration_s: float, spec: str
) -> None:
    """Refuse a reference that leaves the stroke or exceeds the speed within `duration_s`."""
    step = duration_s / PEAK_SAMPLES
    for index in range(PEAK_SAMPLES + 1):
        position, velocity = reference.sample(index * step)
        if not limits.stroke_min <= position <= limits.stroke_max:
            raise InputError(
                f"reference {spec}: asks for {position:g} m at {index * step:.3g} s, "
                f"expected within limits.stroke_min = {limits.stroke_min:g} to "
                f"limits.stroke_max = {limits.stroke_max:g} m"
            )
        if abs(velocity) > limits.speed * (1.0 + 1e-9):
            raise InputError(
                f"reference {spec}: asks for {abs(velocity):g} m/s at "
                f"{index * step:.3g} s, expected at most limits.speed = {limits.speed:g} m/s"
            )


def make_reference(spec: str, drive: DriveParameters, duration_s: float) -> Reference:
    """Make the reference that `spec` asks for and check it against the drive's limits.

    Raises InputError naming the argument at fault, or the file if `spec` is a recording.
    """
    kind_name, _, text = spec.partition(":")
    named = _brief(spec)
    if kind_name == "setpoint" and not text:
        return SetpointFollower(drive.limits, 1.0 / drive.sample_rate)
    reference: Reference
    if kind_name in KINDS:
        reference = _parse(kind_name, text, drive.limits, named)
        if isinstance(reference, Multisine) and reference.end < max(
            reference.start, reference.base
        ):
            raise InputError(f"reference {spec}: no line of base lies between start and end")
    elif spec.endswith(SUFFIXES) and Path(spec).exists():
        planned = read_planned(spec)
        planned.check(drive.limits, spec)
        reference = planned
    elif Path(spec).exists():
        from ...recording.reader import read_recording
        from .recorded import Recorded

        reference = Recorded.from_recording(read_recording(Path(spec)), spec)
    else:
        raise InputError(
            f"reference {spec}: neither a recording, a motion file, nor one of "
            f"{', '.join([*KINDS, 'setpoint'])}; expected e.g. sine:amplitude=2e-5,frequency=1"
        )
    check_within_limits(reference, drive.limits, duration_s, named)
    return reference
