"""What a missing thing may depend on, along the recorded motion."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.signal import savgol_filter

from ...arrays import BoolArray, FloatArray
from ...drive.engine import LOAD
from ...drive.law import PERIODS
from ...drive.memory import since_reversal, warmed
from ..replay.evidence import Smoother
from ..replay.replay import SIGNALS, Replay
from ..split import STRETCH_S
from .visited import reversals

HEAT_S = (0.5, 0.8, 1.25, 2.0, 3.2, 5.0)  # time constants of heat that are tried, s
_PRESLIDING_RAD = 5e-4  # way from a reversal on which dry friction is not yet what it will be
_QUIET = 6.0  # times the noise of the speed: slower is rest


@dataclass(frozen=True, eq=False)
class Motion:
    """The recorded motion of one side, filled in from a replay where it was not recorded.

    Attributes:
        time_s, angle, speed, acceleration, current, voltage: float64[n], at the rotor, SI; speed
            and acceleration smoothed.
        raw_speed, raw_current: as recorded.
        load_angle, load_speed: float64[n], of the load, at the rotor.
        contact: bool[n], the flanks touch, and have for a filter's window.
        side: float64[n], of the flank that touches, 1 or -1.
        smooth: the filter that all of it went through.
    """

    replay: Replay
    smooth: Smoother
    angle: FloatArray
    speed: FloatArray
    acceleration: FloatArray
    current: FloatArray
    voltage: FloatArray
    raw_speed: FloatArray
    raw_current: FloatArray
    load_angle: FloatArray
    load_speed: FloatArray
    contact: BoolArray
    side: FloatArray

    @classmethod
    def of(cls, replay: Replay, columns: FloatArray) -> Motion:
        """From a recording beside a replay of it (its columns, `Replay.full`)."""
        smooth = Smoother(replay.time_s)
        simulated = {one.name: columns[one.column] for one in SIGNALS}
        recorded = dict(zip((one.name for one in replay.signals), replay.recorded, strict=True))

        def signal(name: str) -> FloatArray:
            values = recorded.get(name)
            if values is None:
                return simulated[name]
            return np.where(np.isfinite(values), values, simulated[name])

        angle, current = signal("rotor_position"), signal("current_q")
        speed = signal("rotor_velocity")
        if "rotor_velocity" not in recorded and "rotor_position" in recorded:
            speed = smooth(angle, 1)
        ratio = replay.drive.transmission.rod_per_rotor
        half = 0.5 * replay.drive.transmission.backlash
        known = "rod_position" in recorded and "rotor_position" in recorded
        load = signal("rod_position") / ratio if known else columns[LOAD]
        twist = angle - load if known else simulated["rotor_position"] - columns[LOAD]
        noise = float(replay.floor[list(recorded).index("rod_position")]) / ratio if known else 0.0
        # A clearance within its tolerance, and the scale's noise, leave this much open.
        touching = np.abs(twist) > 0.97 * half - 3.0 * noise
        side = np.where(twist > 0.0, 1.0, -1.0)
        window = np.ones(smooth.points)
        apart = np.convolve(~touching, window, mode="same") > 0.5
        turned = np.abs(np.convolve(side, window, mode="same")) < len(window) - 0.5
        contact = ~(apart | turned) if half > 0.0 else np.ones(len(angle), dtype=bool)
        return cls(
            replay,
            smooth,
            angle,
            smooth(speed),
            smooth(speed, 1),
            smooth(current),
            signal("voltage_q"),
            speed,
            current,
            load,
            smooth(load, 1) if known else columns[LOAD + 1],
            contact,
            side,
        )

    @property
    def fine(self) -> Motion:
        """See `Visited`."""
        return self

    def passed(self, table: FloatArray) -> FloatArray:
        """See `Visited`."""
        found: FloatArray = savgol_filter(table, self.smooth.points, 2, axis=1)
        return found

    @property
    def stretch_s(self) -> float:
        """Of stretches that are predicted from the others."""
        return STRETCH_S

    @property
    def time_s(self) -> FloatArray:
        """From the recording's first sample."""
        return self.replay.time_s

    @cached_property
    def moving(self) -> BoolArray:
        """Where dry friction would be fully against the motion: bool[n]."""
        names = [one.name for one in self.replay.signals]
        noise = 0.0
        if "rotor_velocity" in names:
            noise = float(self.replay.floor[names.index("rotor_velocity")])
        fast = np.abs(self.speed) > _QUIET * noise / math.sqrt(self.smooth.points)
        slid: BoolArray = fast & (np.abs(self.travel(False)) > _PRESLIDING_RAD)
        return slid

    def travel(self, on_load: bool) -> FloatArray:
        """Way since the speed last changed sign, rad, signed: float64[n]."""
        angle = self.load_angle if on_load else self.angle
        speed = self.load_speed if on_load else self.speed
        spans = self.replay.spans
        return np.concatenate([since_reversal(angle[one], speed[one]) for one in spans])

    def heat(self, time_constant_s: float) -> FloatArray:
        """Current squared behind a first-order low-pass that begins at 0, A^2: float64[n]."""
        times = self.smooth.step / time_constant_s
        return np.concatenate([warmed(self.current[one], times) for one in self.replay.spans])

    @property
    def own_time_s(self) -> FloatArray:
        """From the first sample of each of several recordings."""
        time = self.time_s
        return np.concatenate([time[one] - time[one.start] for one in self.replay.spans])

    def torque(self, on_load: bool) -> FloatArray:
        """Torque that the transmission carries, from the side where nothing is missing, N m."""
        drive = self.replay.drive
        if on_load:
            motor = drive.motor
            driven = motor.torque_constant * self.current - motor.rotor_inertia * self.acceleration
            return driven - motor.viscous_friction * self.speed
        return drive.load.inertia * self.acceleration + drive.load.viscous_friction * self.speed

    def variable(self, name: str, on_load: bool, time_constant_s: float = 0.0) -> FloatArray:
        """One of `drive.law.VARIABLES` along the motion of rotor or load: float64[n]."""
        transmission = self.replay.drive.transmission
        angle = self.load_angle if on_load else self.angle
        found: dict[str, Callable[[], FloatArray]] = {
            "position": lambda: angle * transmission.rod_per_rotor,
            "rotor_angle": lambda: angle,
            "screw_angle": lambda: angle / transmission.gear_ratio,
            "speed": lambda: self.load_speed if on_load else self.speed,
            "direction": lambda: np.sign(self.load_speed if on_load else self.speed),
            "current": lambda: self.current,
            "torque": lambda: self.torque(on_load),
            "voltage": lambda: self.voltage,
            "time": lambda: self.own_time_s,
            "heat": lambda: self.heat(time_constant_s),
            "travel": lambda: self.travel(on_load),
        }
        return found[name]()

    def fills(self, one: str, other: str, on_load: bool) -> bool:
        """See `Visited`: every pair is looked at, for a law of two has to hold in closed loop."""
        return True

    def periods(self, name: str, on_load: bool) -> float:
        """See `Visited`."""
        if name == "travel":
            speed = self.load_speed if on_load else self.speed
            return reversals(speed[self.moving & self.replay.usable])
        if name not in PERIODS:
            return math.inf
        values = self.variable(name, on_load)[self.replay.usable]
        return float(np.ptp(values)) / PERIODS[name]
