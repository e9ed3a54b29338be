"""`moves`: point-to-point moves of limited speed, acceleration and jerk, with pauses between."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass
from functools import cached_property

from ruckig import InputParameter, Result, Ruckig, RuckigError, Trajectory

from ...errors import InputError


def plan_move(
    start: float, goal: float, speed: float, acceleration: float, jerk: float
) -> Trajectory:
    """Time-optimal rest-to-rest trajectory, a Ruckig `Trajectory` of one axis (m).

    Raises:
        InputError: Ruckig finds none, as where the goal is beyond what it can resolve.
    """
    wanted = InputParameter(1)
    wanted.current_position, wanted.target_position = [start], [goal]
    wanted.max_velocity, wanted.max_acceleration = [speed], [acceleration]
    wanted.max_jerk = [jerk]
    trajectory = Trajectory(1)
    try:
        result = Ruckig(1).calculate(wanted, trajectory)
    except RuckigError:
        result = Result.Error
    if result not in (Result.Working, Result.Finished):
        raise InputError(
            f"no move from {start:g} m to {goal:g} m within speed {speed:g} m/s, acceleration "
            f"{acceleration:g} m/s^2, jerk {jerk:g} m/s^3 can be computed ({result.name})"
        )
    return trajectory


@dataclass(frozen=True)
class Moves:
    """Rest-to-rest moves through `positions` (m), pausing `dwell` s at each; starts at 0.

    speed: m/s, acceleration: m/s^2, jerk: m/s^3. With `repeat` the sequence goes round for ever.
    """

    positions: tuple[float, ...]
    speed: float
    acceleration: float
    jerk: float
    dwell: float = 0.2
    repeat: bool = True

    @cached_property
    def _legs(self) -> tuple[list[float], list[Trajectory], float]:
        """Start times, trajectories and total length of one round and the way into it."""
        starts, legs, clock, place = [], [], 0.0, 0.0
        rounds = 2 if self.repeat else 1  # the second round starts from the last position
        for goal in self.positions * rounds:
            leg = plan_move(place, goal, self.speed, self.acceleration, self.jerk)
            starts.append(clock)
            legs.append(leg)
            clock += leg.duration + self.dwell
            place = goal
        return starts, legs, clock

    def sample(self, time_s: float) -> tuple[float, float]:
        """Position m and velocity m/s at `time_s`."""
        starts, legs, length = self._legs
        if self.repeat and time_s >= length:
            second = starts[len(self.positions)]
            time_s = second + (time_s - second) % (length - second)
        index = max(0, bisect_right(starts, time_s) - 1)
        leg = legs[index]
        position, velocity, _ = leg.at_time(min(time_s - starts[index], leg.duration))
        return position[0], velocity[0]
