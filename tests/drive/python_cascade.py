"""The cascade once more in plain Python, written from its description: the tests' own truth.

Numbers in, numbers out: it knows nothing of drive files, packed records or compiled code.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field


@dataclass
class PythonCascade:
    """One controller; gains in parallel form, angles at the rotor, time constants in s."""

    tick_s: float
    rod_per_rotor: float
    inductance: float
    pole_pairs: int
    position: tuple[float, float, float]  # kp, ki, kd
    speed: tuple[float, float] | None  # None: the position loop asks for the current
    current: tuple[float, float]
    feedback_rod: bool = False
    velocity_feedforward: float = 0.0
    acceleration_feedforward: float = 0.0
    setpoint_filter: float = 0.0
    current_command_filter: float = 0.0
    speed_filter: float = 0.0
    differences: bool = False
    speed_limit: float = math.inf
    current_limit: float = math.inf
    voltage_limit: float = math.inf
    sums: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    past: dict[str, float] = field(default_factory=lambda: {"current": 0.0})

    def _low_pass(self, name: str, value: float, time_constant_s: float) -> float:
        if time_constant_s == 0.0:
            return value
        kept = math.exp(-self.tick_s / time_constant_s)
        last = self.past.get(name, value)
        self.past[name] = kept * last + (1.0 - kept) * value
        return self.past[name]

    def _loop(self, index: int, error: float, gains: tuple, extra: float, limit: float) -> float:
        wanted = gains[0] * error + gains[1] * self.sums[index] + extra
        if abs(wanted) > limit:
            return math.copysign(limit, wanted)
        self.sums[index] += error * self.tick_s
        return wanted

    def tick(self, reference, velocity, angle, speed, rod, current) -> tuple[float, float]:
        """(u_d, u_q) in V from reference m, m/s and measured rad, rad/s, m, A."""
        per = 1.0 / self.rod_per_rotor
        if self.differences:
            last = self.past.get("angle", angle)
            self.past["angle"] = angle
            speed = (angle - last) / self.tick_s
        u_d = -self.pole_pairs * speed * self.inductance * current
        seen = self._low_pass("speed", speed, self.speed_filter)
        if self.setpoint_filter:
            self.past.setdefault("rate", 0.0)
            reference = self._low_pass("reference", reference, self.setpoint_filter)
            velocity = self._low_pass("rate", velocity, self.setpoint_filter)
        acceleration = (velocity - self.past.get("velocity", velocity)) / self.tick_s
        self.past["velocity"] = velocity
        error = reference * per - (rod * per if self.feedback_rod else angle)
        forward = self.velocity_feedforward * velocity * per
        push = self.acceleration_feedforward * acceleration * per
        damping = self.position[2] * (velocity * per - seen)
        if self.speed is None:
            wanted = self._loop(0, error, self.position, push + damping, self.current_limit)
        else:
            rate = self._loop(0, error, self.position, forward + damping, self.speed_limit)
            wanted = self._loop(1, rate - seen, self.speed, push, self.current_limit)
        wanted = self._low_pass("current", wanted, self.current_command_filter)
        u_q = self._loop(2, wanted - current, self.current, 0.0, self.voltage_limit)
        return min(max(u_d, -self.voltage_limit), self.voltage_limit), u_q


def commands_of(cascade: PythonCascade, samples) -> list[tuple[float, float]]:
    """(u_d, u_q) that a controller gives along the engine's samples, one for every tick."""
    from ecyl_ros.drive.engine import MEASUREMENT, REFERENCE, REFERENCE_VELOCITY

    rows = samples.tolist()
    at = MEASUREMENT
    return [
        cascade.tick(
            row[REFERENCE], row[REFERENCE_VELOCITY], row[at], row[at + 1], row[at + 2], row[at + 5]
        )
        for row in rows
    ]


def plain_numbers(drive) -> dict:
    """A drive's controller as arguments of `PythonCascade`, the features of plain cascades only."""
    control = drive.controller
    series = control.form == "series"

    def parallel(gains) -> tuple[float, float]:
        return gains.kp, gains.kp * gains.ki if series else gains.ki

    return {
        "tick_s": 1.0 / control.rate,
        "rod_per_rotor": drive.transmission.rod_per_rotor,
        "inductance": drive.motor.inductance,
        "pole_pairs": drive.motor.pole_pairs,
        "position": (*parallel(control.position), 0.0),
        "speed": parallel(control.speed),
        "current": parallel(control.current),
        "feedback_rod": control.feedback == "rod",
        "velocity_feedforward": control.velocity_feedforward,
        "speed_limit": control.speed_limit,
        "current_limit": control.current_limit,
        "voltage_limit": control.voltage_limit,
    }
