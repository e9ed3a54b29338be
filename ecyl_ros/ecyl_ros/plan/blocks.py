"""Blocks of motion within a drive's limits, of which a plan is put together.

A block goes out and back about the place where the motion starts, as often as it fits its time:
tiny and slow about the clearance, wide and fast, sharp and gentle. Every block begins and ends
there at rest, so that blocks can follow each other in any order.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable
from dataclasses import dataclass

from ..drive.parameters import DriveParameters, LimitParameters
from ..drive.reference.leg import Leg
from ..drive.reference.moves import plan_move
from ..drive.reference.planned import Planned
from ..errors import InputError

_REACHES = (1.0, 0.3, 0.1, 0.03, 0.01, 0.003)  # of the widest block that fits
_SPEEDS = (1.0, 0.25, 0.05)
_ACCELERATIONS = (1.0, 0.2)
_RESTS_S = (0.0, 0.1)
_MOST_CYCLES = 40
_SAME = 0.1  # blocks that differ by less in every figure are one


@dataclass(frozen=True)
class Block:
    """A way to move: reach m either side, speed m/s, acceleration m/s^2, rest s at each turn."""

    reach: float
    speed: float
    acceleration: float
    rest_s: float

    def legs(self, limits: LimitParameters, length_s: float) -> tuple[Leg, ...]:
        """Out, back and to the start again, as often as it fits; once at the least."""
        high, low = min(self.reach, limits.stroke_max), max(-self.reach, limits.stroke_min)
        stops = [place for place in (high, low) if abs(place) > 1e-3 * self.reach]
        jerk = limits.jerk
        once = self._time(stops, jerk)
        cycles = min(max(1, math.floor(length_s / once)), _MOST_CYCLES)
        turns = stops * cycles
        made = [Leg(to, self.speed, self.acceleration, jerk, self.rest_s) for to in turns]
        home = Leg(0.0, self.speed, self.acceleration, jerk, self.rest_s)
        return (*made, home)

    @property
    def point(self) -> tuple[float, ...]:
        """What a search may vary: logarithms of reach, speed and acceleration."""
        return math.log(self.reach), math.log(self.speed), math.log(self.acceleration)

    def highest(self, limits: LimitParameters, reach: float) -> tuple[float, ...]:
        """The largest `point` within a drive's limits, and within a reach, m."""
        return math.log(reach), math.log(limits.speed), math.log(limits.acceleration)

    def moved_to(self, point: Iterable[float]) -> Block:
        """The block at another point."""
        reach, speed, acceleration = map(math.exp, point)
        return Block(reach, speed, acceleration, self.rest_s)

    def _time(self, stops: list[float], jerk: float) -> float:
        """Of one cycle, s."""
        places = [stops[-1], *stops]
        return sum(
            plan_move(start, goal, self.speed, self.acceleration, jerk).duration + self.rest_s
            for start, goal in itertools.pairwise(places)
            if start != goal
        ) or 2.0 * (
            plan_move(0.0, stops[0], self.speed, self.acceleration, jerk).duration + self.rest_s
        )

    def peak_speed(self, jerk: float) -> float:
        """That a move over the whole block reaches, m/s."""
        move = plan_move(-self.reach, self.reach, self.speed, self.acceleration, jerk)
        return max(
            abs(move.at_time(move.duration * share)[1][0]) for share in (0.3, 0.4, 0.5, 0.6, 0.7)
        )


def check_room(limits: LimitParameters) -> None:
    """Refuse limits that leave no motion about the start, rod position 0."""
    if not limits.stroke_min <= 0.0 <= limits.stroke_max:
        raise InputError(
            f"limits.stroke_min = {limits.stroke_min:g}, limits.stroke_max = "
            f"{limits.stroke_max:g}: motions start at 0 m, expected a stroke that holds it"
        )
    if not limits.stroke_max - limits.stroke_min > 0.0:
        raise InputError("limits.stroke_max = limits.stroke_min, expected room to move in")


def widest(limits: LimitParameters, length_s: float) -> float:
    """Reach of the widest block that can be run through once in `length_s`, m."""
    low, high = 0.0, max(limits.stroke_max, -limits.stroke_min)
    for _ in range(40):
        middle = 0.5 * (low + high)
        block = Block(middle, limits.speed, limits.acceleration, 0.0)
        long = Planned(block.legs(limits, 0.0), length_s).moving_s > length_s if middle else False
        low, high = (low, middle) if long else (middle, high)
    return low


def library(drive: DriveParameters, length_s: float) -> list[Block]:
    """The blocks to choose from; length_s: time that each may take."""
    limits = drive.limits
    check_room(limits)
    top = widest(limits, length_s)
    found: list[tuple[tuple[float, ...], Block]] = []
    for reach, speed, acceleration, rest in itertools.product(
        _REACHES, _SPEEDS, _ACCELERATIONS, _RESTS_S
    ):
        block = Block(reach * top, speed * limits.speed, acceleration * limits.acceleration, rest)
        legs = block.legs(limits, length_s)
        time = Planned(legs, length_s).moving_s
        if time > 1.05 * length_s:
            continue
        figures = (block.reach, block.peak_speed(limits.jerk), time / len(legs), 0.01 + rest)
        if not any(_alike(figures, other) for other, _ in found):
            found.append((figures, block))
    if not found:
        raise InputError(
            f"limits: no move out and back fits {length_s:.3g} s, an eighth of --duration; "
            "expected a longer motion, or more speed, acceleration or jerk"
        )
    return [block for _, block in found]


def _alike(one: tuple[float, ...], other: tuple[float, ...]) -> bool:
    return all(abs(math.log(a / b)) < _SAME for a, b in zip(one, other, strict=True))
