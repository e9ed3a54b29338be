"""`motion.yaml`: a planned motion, moves and swings one after the other::

    motion:
      schema: ecyl.motion/1
      duration_s: 10.0
      legs:
        - {to_m: 0.004, speed: 0.2, acceleration: 4.0, jerk: 180.0, rest_s: 0.1}
        - {amplitude_m: 1.0e-05, start_hz: 0.5, end_hz: 8.0, base_hz: 0.25, length_s: 4.0,
           fade_s: 0.5}

Each begins at rest where the last one ended, the first at 0; after the last the rod stays where it
is.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import MISSING, asdict, dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from ...errors import InputError
from ...finite import is_finite
from ..parameters import LimitParameters
from .leg import Leg, Move
from .swing import Swing, Swung
from .trajectory import Point

SCHEMA = "ecyl.motion/1"
SUFFIXES = (".yaml", ".yml")
_SHORTEST_S = 1e-5  # between two switches: shorter ones change nothing that could be seen


@dataclass(frozen=True)
class Planned:
    """Legs one after the other; the rod starts at 0 at rest.

    duration_s: of the motion as it was planned, the rest at its end included.
    """

    legs: tuple[Leg | Swing, ...]
    duration_s: float

    @cached_property
    def _parts(self) -> tuple[list[float], list[Move | Swung]]:
        """When each begins, and the last with its rest is over; and themselves."""
        starts, parts, clock, place = [], [], 0.0, 0.0
        for leg in self.legs:
            part = leg.begun_at(place)
            starts.append(clock)
            parts.append(part)
            clock += part.length_s + part.rest_s
            place = part.end_m
        return [*starts, clock], parts

    @property
    def moving_s(self) -> float:
        """When the last leg has come to its end, with its rest, s."""
        return self._parts[0][-1]

    def _at(self, time_s: float) -> tuple[float, float, float]:
        starts, parts = self._parts
        if not parts:
            return 0.0, 0.0, 0.0
        index = min(max(0, bisect_right(starts, time_s) - 1), len(parts) - 1)
        part, inside = parts[index], time_s - starts[index]
        position, velocity, acceleration = part.at(min(max(inside, 0.0), part.length_s))
        moving = 0.0 <= inside <= part.length_s
        return position, velocity, acceleration if moving else 0.0

    def sample(self, time_s: float) -> tuple[float, float]:
        """Position m and velocity m/s at `time_s`."""
        return self._at(time_s)[:2]

    def accelerations(self, times_s: Sequence[float]) -> np.ndarray:
        """Acceleration m/s^2 at each time, float64[n]."""
        return np.array([self._at(time)[2] for time in times_s])

    def switches(self) -> list[float]:
        """Times between which a quintic is the motion, s, from 0 on."""
        starts, parts = self._parts
        found = [0.0]
        for start, part in zip(starts, parts, strict=False):
            for time in (start + knot for knot in part.knots()):
                if time > found[-1] + _SHORTEST_S:
                    found.append(time)
        return found

    def points(self) -> list[Point]:
        """What splines through points turn into this motion, to `duration_s` at rest."""
        times = [*(time for time in self.switches() if time < self.duration_s), self.duration_s]
        seconds = [round(time * 1e9) * 1e-9 for time in times]
        return [Point(time, *self._at(time)) for time in seconds]

    def check(self, limits: LimitParameters, source: str) -> None:
        """Refuse a motion that asks a drive for more than its limits; InputError names the leg."""
        place = 0.0
        for number, (leg, part) in enumerate(zip(self.legs, self._parts[1], strict=True), start=1):
            leg.check(limits, place, f"{source}: legs, number {number}")
            place = part.end_m

    def as_file(self, about: Mapping[str, Any] | None = None) -> str:
        """The motion as YAML; about: what else is said of it."""
        legs = [
            {key: float(f"{value:.9g}") for key, value in asdict(leg).items()} for leg in self.legs
        ]
        head = {"schema": SCHEMA, **(about or {}), "duration_s": self.duration_s}
        text = yaml.safe_dump({"motion": head}, sort_keys=False, default_flow_style=False)
        rows = "".join(
            "  - " + yaml.safe_dump(leg, sort_keys=False, default_flow_style=True, width=200)
            for leg in legs
        )
        return f"{text}  legs:\n{rows}"


def read_planned(path: str | Path) -> Planned:
    """Read a motion file; InputError names the file, the field and what was expected."""
    try:
        data = yaml.safe_load(Path(path).read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        why = " ".join(str(error).split())
        raise InputError(f"{path}: cannot be read as YAML: {why}") from None
    motion = data.get("motion") if isinstance(data, dict) else None
    if not isinstance(motion, dict) or motion.get("schema") != SCHEMA:
        raise InputError(f"{path}: expected a motion with motion.schema: {SCHEMA}")
    legs = motion.get("legs")
    if not isinstance(legs, list) or not legs:
        raise InputError(f"{path}: motion.legs is missing or empty, expected a list of moves")
    made = tuple(_leg(one, f"{path}: legs, number {row}") for row, one in enumerate(legs, start=1))
    planned = Planned(made, 0.0)
    try:
        moving_s = planned.moving_s
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    length = motion.get("duration_s", moving_s)
    if not is_finite(length) or length <= 0.0:
        raise InputError(f"{path}: duration_s = {length!r}, expected more than 0 s")
    return Planned(made, float(length))


def _leg(data: Any, where: str) -> Leg | Swing:
    if not isinstance(data, dict):
        raise InputError(
            f"{where}: expected a move (to_m, speed, acceleration, jerk, rest_s) or a multisine "
            "(amplitude_m, start_hz, ...)"
        )
    kind: type[Leg | Swing] = Swing if "amplitude_m" in data else Leg
    known = [one.name for one in fields(kind)]
    unknown = sorted(set(map(str, data)) - set(known))
    if unknown:
        raise InputError(f"{where}: unknown key {unknown[0]}; expected {', '.join(known)}")
    values = {one.name: one.default for one in fields(kind) if one.default is not MISSING} | data
    for name in known:
        value: Any = values.get(name)
        if not is_finite(value):
            raise InputError(f"{where}: {name} = {value!r}, expected a finite number")
        if name == "rest_s" and value < 0.0:
            raise InputError(f"{where}: rest_s = {value:g}, expected 0 s or more")
        if name not in ("rest_s", "to_m") and value <= 0.0:
            raise InputError(f"{where}: {name} = {value:g}, expected more than 0")
    leg = kind(**{name: float(values[name]) for name in known})
    refused = leg.refused() if isinstance(leg, Swing) else None
    if refused is not None:
        raise InputError(f"{where}: {refused}")
    return leg
