"""A rest-to-rest move with limits of its own, as `motion.yaml` holds it."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

from ruckig import Trajectory

from ...errors import InputError
from ..parameters import LimitParameters
from .moves import plan_move

_SLACK = 1.0 + 1e-6


@dataclass(frozen=True)
class Leg:
    """One move to `to_m`, m, within speed m/s, acceleration m/s^2 and jerk m/s^3, then `rest_s`."""

    to_m: float
    speed: float
    acceleration: float
    jerk: float
    rest_s: float = 0.0

    def begun_at(self, place_m: float) -> Move:
        """The move from a place."""
        move = plan_move(place_m, self.to_m, self.speed, self.acceleration, self.jerk)
        return Move(move, self.to_m, self.rest_s)

    def check(self, limits: LimitParameters, place_m: float, where: str) -> None:
        """Refuse a move that asks a drive for more than its limits; InputError names the field."""
        if not limits.stroke_min <= self.to_m <= limits.stroke_max:
            raise InputError(
                f"{where}: to_m = {self.to_m:g}, expected within limits.stroke_min = "
                f"{limits.stroke_min:g} to limits.stroke_max = {limits.stroke_max:g} m of this "
                "drive"
            )
        for name in ("speed", "acceleration", "jerk"):
            value, most = getattr(self, name), getattr(limits, name)
            if value > most * _SLACK:
                raise InputError(
                    f"{where}: {name} = {value:g}, expected at most limits.{name} = {most:g} "
                    "of this drive: the motion was planned for another"
                )


@dataclass(frozen=True, eq=False)
class Move:
    """A leg from where it begins. end_m: where it ends; rest_s: for how long it then stays."""

    trajectory: Trajectory
    end_m: float
    rest_s: float

    @property
    def length_s(self) -> float:
        """Without the rest."""
        return float(self.trajectory.duration)

    def at(self, time_s: float) -> tuple[float, float, float]:
        """Position m, velocity m/s, acceleration m/s^2 at a time from its beginning to its end."""
        position, velocity, acceleration = self.trajectory.at_time(time_s)
        return float(position[0]), float(velocity[0]), float(acceleration[0])

    def knots(self) -> list[float]:
        """Times at which jerk changes, s: between them position is a cubic of time."""
        switches = itertools.accumulate(self.trajectory.profiles[0][0].t)
        return [0.0, *switches, self.length_s]
