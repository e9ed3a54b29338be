"""What a law may depend on, along the measured motion of an output (rigid drives, followers)."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ...arrays import BoolArray, FloatArray
from ...drive.law import LEAST_PERIODS, PERIODS
from ...drive.memory import since_reversal
from ..rigid.balance import Balance
from ..rigid.motion import Motion
from ..rigid.rest import reversing
from ..rigid.terms import Catalogue
from .visited import reversals

_CELLS, _VISITED, _FILLED = 10, 3, 0.5  # of a plane: each way, samples of a visit, share visited
# What is not a place on a rigid drive's motion. Heat would be the effort that is to be explained,
# low-passed: it predicts that whatever the cause.
_NOT_TOLD = ("current", "torque", "voltage", "time", "heat")
_ASKED_FOR = 0.5  # share of the speed's variance that its reference has to make


@dataclass(frozen=True)
class Decimated:
    """Compared samples need no further filter; a window of three points is none."""

    step: float
    points: int = 3


@dataclass(frozen=True, eq=False)
class Filtered:
    """The motion at all samples, float64[m], and what makes compared ones of efforts along it."""

    position: FloatArray
    speed: FloatArray
    through: Callable[[FloatArray], FloatArray]


@dataclass(frozen=True, eq=False)
class MeasuredMotion:
    """The compared samples of a measured motion; see `visited.Visited`.

    Attributes:
        known: bool[n], where what is missing can be known: past reversals, in motion.
        filtered: where it comes from, if it was filtered.
        answers: whether the speed changes because the loop answers what is missing: its reference
            rests. The effort is then the loop's own law of the speed.
        place: what the position is called: within a turn where the output goes round.
    """

    time_s: FloatArray
    position: FloatArray
    speed: FloatArray
    known: BoolArray
    place: str
    stretch_s: float
    smooth: Decimated
    filtered: Filtered | None = None
    answers: bool = False

    @classmethod
    def of(cls, balance: Balance, catalogue: Catalogue) -> MeasuredMotion:
        """Of a rigid drive's balance."""
        motion: Motion = balance.motion
        rows = motion.rows
        slid = balance.usable & ~reversing(motion, catalogue.along)[rows]
        return cls(
            balance.time_s,
            motion.position[rows],
            motion.velocity[rows],
            slid,
            place_of(motion, catalogue.machine.linear),
            balance.stretch_s,
            Decimated(motion.step / motion.rate_hz),
            Filtered(motion.position, motion.velocity, motion.filtered),
            answers(motion, rows[slid]),
        )

    @property
    def fine(self) -> MeasuredMotion:
        """See `Visited`; of nothing but the variables."""
        if self.filtered is None:
            return self
        position, speed = self.filtered.position, self.filtered.speed
        known = np.ones(position.size, dtype=bool)
        return replace(self, position=position, speed=speed, known=known, filtered=None)

    def passed(self, table: FloatArray) -> FloatArray:
        """See `Visited`."""
        return table if self.filtered is None else self.filtered.through(table)

    def periods(self, name: str, on_load: bool) -> float:
        """See `Visited`."""
        if name in ("position", "rotor_angle", "screw_angle") and name != self.place:
            return 0.0
        if name in _NOT_TOLD or (name == "speed" and self.answers):
            return 0.0
        if name == "travel":
            return reversals(self.speed[self.known])
        if name not in PERIODS:
            return math.inf
        return float(np.ptp(self.position[self.known])) / PERIODS[name]

    def fills(self, one: str, other: str, on_load: bool) -> bool:
        """See `Visited`.

        A motion that repeats one path is a thin line in the plane of two variables, and any effort
        along it a law of both.
        """
        if "direction" in (one, other):
            return True
        places = []
        for name in (one, other):
            values = self.variable(name, False)[self.known]
            if name in PERIODS:
                values = np.mod(values, PERIODS[name])
            low, high = np.quantile(values, [0.005, 0.995])
            share = (values - low) / max(float(high - low), 1e-300)
            places.append(np.clip((share * _CELLS).astype(np.int64), 0, _CELLS - 1))
        visits = np.bincount(places[0] * _CELLS + places[1], minlength=_CELLS**2)
        return float(np.mean(visits >= _VISITED)) >= _FILLED

    def variable(self, name: str, on_load: bool, time_constant_s: float = 0.0) -> FloatArray:
        """See `Visited`."""
        if name in ("position", "rotor_angle"):
            return self.position
        if name == "speed":
            return self.speed
        if name == "direction":
            return np.sign(self.speed)
        if name == "travel":
            return since_reversal(self.position, self.speed)
        raise KeyError(name)


def answers(motion: Motion, rows: np.ndarray) -> bool:
    """Whether most of the speed's changes on rows, int64[m], were not asked for; no where it is
    not known what was."""
    asked = motion.reference_velocity
    if not np.isfinite(asked).any():
        asked = np.gradient(motion.reference_position, 1.0 / motion.rate_hz)
    asked = asked[rows]
    told = np.isfinite(asked)
    if not told.any():
        return False
    moved = np.var(motion.velocity[rows][told])
    return bool(np.var(asked[told]) < _ASKED_FOR * moved)


def place_of(motion: Motion, linear: bool) -> str:
    """What the position of an output is called: an angle where it goes round far enough."""
    turns = 0.0 if linear else float(np.ptp(motion.position[motion.usable])) / math.tau
    return "rotor_angle" if turns > LEAST_PERIODS else "position"
