"""`motion.yaml`: a planned motion, rest-to-rest moves of which each has limits of its own::

    motion:
      schema: ecyl.motion/1
      duration_s: 10.0
      legs:
        - {to_m: 0.004, speed: 0.2, acceleration: 4.0, jerk: 180.0, rest_s: 0.1}

Each leg begins where the last one ended, the first at 0; after the last the rod stays where it is.
"""

from __future__ import annotations

import itertools
from bisect import bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from ruckig import Trajectory

from ...errors import InputError
from ...finite import is_finite
from ..parameters import LimitParameters
from .moves import plan_move
from .trajectory import Point

SCHEMA = "ecyl.motion/1"
SUFFIXES = (".yaml", ".yml")
_SLACK = 1.0 + 1e-6
_SHORTEST_S = 1e-5  # between two switches: shorter ones change nothing that could be seen


@dataclass(frozen=True)
class Leg:
    """One move to `to_m`, m, within speed m/s, acceleration m/s^2 and jerk m/s^3, then `rest_s`."""

    to_m: float
    speed: float
    acceleration: float
    jerk: float
    rest_s: float = 0.0


@dataclass(frozen=True)
class Planned:
    """Legs one after the other; the rod starts at 0 at rest.

    duration_s: of the motion as it was planned, the rest at its end included.
    """

    legs: tuple[Leg, ...]
    duration_s: float

    @cached_property
    def _moves(self) -> tuple[list[float], list[Trajectory]]:
        starts, moves, clock, place = [], [], 0.0, 0.0
        for leg in self.legs:
            move = plan_move(place, leg.to_m, leg.speed, leg.acceleration, leg.jerk)
            starts.append(clock)
            moves.append(move)
            clock += move.duration + leg.rest_s
            place = leg.to_m
        return [*starts, clock], moves

    @property
    def moving_s(self) -> float:
        """When the last leg has come to its end, with its rest, s."""
        return self._moves[0][-1]

    def sample(self, time_s: float) -> tuple[float, float]:
        """Position m and velocity m/s at `time_s`."""
        starts, moves = self._moves
        if not moves:
            return 0.0, 0.0
        index = min(max(0, bisect_right(starts, time_s) - 1), len(moves) - 1)
        move = moves[index]
        position, velocity, _ = move.at_time(min(max(time_s - starts[index], 0.0), move.duration))
        return float(position[0]), float(velocity[0])

    def accelerations(self, times_s: Sequence[float]) -> np.ndarray:
        """Acceleration m/s^2 at each time, float64[n]."""
        starts, moves = self._moves
        made = np.zeros(len(times_s))
        for row, time in enumerate(times_s):
            index = min(max(0, bisect_right(starts, time) - 1), len(moves) - 1)
            inside = time - starts[index]
            if moves and 0.0 <= inside <= moves[index].duration:
                made[row] = moves[index].at_time(inside)[2][0]
        return made

    def switches(self) -> list[float]:
        """Times at which jerk changes, s, from 0 on: between them position is a cubic of time."""
        starts, moves = self._moves
        found = [0.0]
        for start, move in zip(starts, moves, strict=False):
            steps = itertools.accumulate(move.profiles[0][0].t)
            for time in (start, *(start + step for step in steps), start + move.duration):
                if time > found[-1] + _SHORTEST_S:
                    found.append(time)
        return found

    def points(self) -> list[Point]:
        """What splines through points turn into this motion, to `duration_s` at rest."""
        times = [*(time for time in self.switches() if time < self.duration_s), self.duration_s]
        seconds = [round(time * 1e9) * 1e-9 for time in times]
        faster = self.accelerations(seconds).tolist()
        return [
            Point(time, *self.sample(time), acceleration)
            for time, acceleration in zip(seconds, faster, strict=True)
        ]

    def check(self, limits: LimitParameters, source: str) -> None:
        """Refuse a motion that asks a drive for more than its limits; InputError names the leg."""
        for number, leg in enumerate(self.legs, start=1):
            where = f"{source}: legs, number {number}"
            if not limits.stroke_min <= leg.to_m <= limits.stroke_max:
                raise InputError(
                    f"{where}: to_m = {leg.to_m:g}, expected within limits.stroke_min = "
                    f"{limits.stroke_min:g} to limits.stroke_max = {limits.stroke_max:g} m of this "
                    "drive"
                )
            for name in ("speed", "acceleration", "jerk"):
                value, most = getattr(leg, name), getattr(limits, name)
                if value > most * _SLACK:
                    raise InputError(
                        f"{where}: {name} = {value:g}, expected at most limits.{name} = {most:g} "
                        "of this drive: the motion was planned for another"
                    )

    def as_file(self, about: Mapping[str, Any] | None = None) -> str:
        """The motion as YAML; about: what else is said of it."""
        legs = [{key: round(value, 9) for key, value in asdict(leg).items()} for leg in self.legs]
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


def _leg(data: Any, where: str) -> Leg:
    if not isinstance(data, dict):
        raise InputError(f"{where}: expected to_m, speed, acceleration, jerk and rest_s")
    known = [one.name for one in fields(Leg)]
    unknown = sorted(set(map(str, data)) - set(known))
    if unknown:
        raise InputError(f"{where}: unknown key {unknown[0]}; expected {', '.join(known)}")
    values = {"rest_s": 0.0, **data}
    for name in known:
        value: Any = values.get(name)
        if not is_finite(value):
            raise InputError(f"{where}: {name} = {value!r}, expected a finite number")
        if name == "rest_s" and value < 0.0:
            raise InputError(f"{where}: rest_s = {value:g}, expected 0 s or more")
        if name in ("speed", "acceleration", "jerk") and value <= 0.0:
            raise InputError(f"{where}: {name} = {value:g}, expected more than 0")
    return Leg(**{name: float(values[name]) for name in known})
