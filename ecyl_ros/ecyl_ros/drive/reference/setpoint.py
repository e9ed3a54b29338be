"""`setpoint`: follows live position setpoints, and trajectories, within the drive's limits.

Each accepted setpoint is a new goal for an online trajectory generator (Ruckig), so that a step
becomes a motion the drive can follow. Setpoints that are not finite, lie beyond the stroke, or ask
for more speed than the drive's limit are refused and counted, never followed. A trajectory is
followed as it is, or refused as a whole.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from ruckig import ControlInterface, InputParameter, OutputParameter, Ruckig
from ruckig import Trajectory as Braking

from ..parameters import LimitParameters
from .trajectory import Point, State, Trajectory, made


class SetpointFollower:
    """Turns setpoints and trajectories into a reference; call `sample` once per period, in order.

    Attributes:
        accepted, refused: setpoints so far. trajectories_accepted, trajectories_refused: likewise.
    """

    def __init__(self, limits: LimitParameters, period_s: float, start_m: float = 0.0) -> None:
        """limits: of the drive. period_s: between two samples, s. start_m: where the rod rests."""
        self.refused = 0
        self.accepted = 0
        self.trajectories_refused = 0
        self.trajectories_accepted = 0
        self._period_s = period_s
        self._trajectory: Trajectory | None = None  # what is followed instead of a setpoint
        self._generator = Ruckig(1, period_s)
        self._input = InputParameter(1)
        self._output = OutputParameter(1)
        self._input.current_position = self._input.target_position = [start_m]
        self.change_limits(limits)
        self._last_time_s = 0.0

    def change_limits(self, limits: LimitParameters) -> None:
        """Follow within other limits from the next sample on."""
        self.limits = limits
        self._input.max_velocity = [limits.speed]
        self._input.max_acceleration = [limits.acceleration]
        self._input.max_jerk = [limits.jerk]

    @property
    def state(self) -> State:
        """Position m, velocity m/s and acceleration m/s^2 at the last sample."""
        now = self._input
        return now.current_position[0], now.current_velocity[0], now.current_acceleration[0]

    def go_back(self, state: State) -> None:
        """Go on from an earlier sample's state, as if those after it had not been asked for."""
        for name, value in zip(("position", "velocity", "acceleration"), state, strict=True):
            setattr(self._input, f"current_{name}", [value])

    def offer(self, position_m: float, time_s: float) -> str | None:
        """Take a setpoint that arrived at `time_s`; returns why it is refused, or None.

        The speed a setpoint asks for is its distance from the last accepted one over the time
        since that one (since the start for the first), one sample at least.
        """
        reason = self._objection(position_m, time_s)
        if reason is None:
            self.accepted += 1
            self._trajectory = None
            self._input.target_position = [position_m]
            self._last_time_s = time_s
        else:
            self.refused += 1
        return reason

    def offer_trajectory(
        self, points: Sequence[Point], state: State, now_s: float, begin_s: float
    ) -> str | None:
        """Take a trajectory that leaves `state` at `now_s`; returns why it is refused, or None.

        points: their times count from `begin_s`; none: come to rest, now, within the limits. What
        was followed before it ends here. Every sample has to keep stroke, speed and acceleration.
        """
        if not points:
            self._trajectory = None
            self._input.target_position = [self._rest_place(state)]
            reason = None
        else:
            try:
                trajectory = made(points, state, now_s, begin_s)
            except ValueError as error:
                reason = str(error)
            else:
                reason = trajectory.objection(self.limits, self._period_s)
        if reason is not None:
            self.trajectories_refused += 1
            return reason
        self.trajectories_accepted += 1
        self._last_time_s = now_s
        if points:
            self._trajectory = trajectory
            self._input.target_position = [points[-1].position]
        return None

    def _rest_place(self, state: State) -> float:
        """Where the rod comes to rest soonest from `state`, m."""
        wanted = InputParameter(1)
        wanted.control_interface = ControlInterface.Velocity
        for name, value in zip(("position", "velocity", "acceleration"), state, strict=True):
            setattr(wanted, f"current_{name}", [value])
        wanted.target_velocity = wanted.target_acceleration = [0.0]
        wanted.max_velocity, wanted.max_acceleration = (
            [self.limits.speed],
            [self.limits.acceleration],
        )
        wanted.max_jerk = [self.limits.jerk]
        braking = Braking(1)
        Ruckig(1).calculate(wanted, braking)
        place = float(braking.at_time(braking.duration)[0][0])
        return min(max(place, self.limits.stroke_min), self.limits.stroke_max)

    def _objection(self, position_m: float, time_s: float) -> str | None:
        limits = self.limits
        if not math.isfinite(position_m):
            return f"setpoint {position_m} is not finite, expected a rod position in m"
        if not limits.stroke_min <= position_m <= limits.stroke_max:
            return (
                f"setpoint {position_m:g} m is beyond the stroke, expected "
                f"{limits.stroke_min:g} to {limits.stroke_max:g} m"
            )
        distance = abs(position_m - self._input.target_position[0])
        # Two may arrive between two samples, as in lockstep while the plant waits.
        elapsed = max(time_s - self._last_time_s, self._period_s)
        if distance > limits.speed * elapsed * (1.0 + 1e-9):
            return (
                f"setpoint {position_m:g} m asks for {distance:g} m in {elapsed:g} s, "
                f"expected at most {limits.speed:g} m/s"
            )
        return None

    def sample(self, time_s: float) -> tuple[float, float]:
        """Position m and velocity m/s of the next period, at `time_s`."""
        if self._trajectory is not None:
            self.go_back(self._trajectory.at(time_s))
            return self._input.current_position[0], self._input.current_velocity[0]
        if time_s <= 0.0:
            return self._input.current_position[0], 0.0
        self._generator.update(self._input, self._output)
        self._output.pass_to_input(self._input)
        return self._output.new_position[0], self._output.new_velocity[0]
