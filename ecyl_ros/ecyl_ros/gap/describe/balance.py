"""The rows of one or more balances, in which laws of one kind are regressed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ...arrays import BoolArray, FloatArray
from ...typical import typical_rms
from ..fit.robust import LOSS_SCALE, robust_weights
from ..sheet import EVIDENCE_PER_S
from .axis import ALONE, SORTS, Axis, Sort, columns, roughness
from .guess import Guess, Trial
from .missing import ROD, TORQUE, VOLTAGE, Missing
from .motion import Motion
from .regress import SMOOTH, Regression, Rows, regress
from .visited import Visited

_VISITED = 3  # samples about a place from which it counts as visited


def stretches(motion: Visited, rows: np.ndarray) -> np.ndarray:
    """The stretch each row lies in, numbered from 0 without holes: int64[m]."""
    index = np.floor(motion.time_s[rows] / motion.stretch_s).astype(np.int64)
    numbered: np.ndarray = np.unique(index, return_inverse=True)[1]
    return numbered


def driving(kind: str, motion: Visited) -> FloatArray:
    """By what a law's value is multiplied where it drives, float64[n]: friction is a level."""
    return -np.sign(motion.speed) if kind == "friction" else np.ones(len(motion.speed))


class Balance:
    """Rows of one or more balances, whitened, for the regression of laws of one kind."""

    def __init__(
        self, parts: Sequence[tuple[Missing, float]], motion: Visited, fitted: BoolArray
    ) -> None:
        """parts: balances, and what one unit of the law adds to each. fitted: bool[n]."""
        self.motion, self.parts = motion, parts
        self.rows = [one.rows[fitted[one.rows]] for one, _ in parts]
        pulled = sorted({row for one, _ in parts for row in one.pulled})
        targets, sheets = [], []
        growth = np.zeros(len(pulled))
        for (one, _), rows in zip(parts, self.rows, strict=True):
            targets.append(one.values[rows] / one.noise)
            sheet = np.zeros((len(pulled), len(rows)))
            for index, row in enumerate(one.pulled):
                sheet[pulled.index(row)] = one.columns[index, rows] / one.noise
                growth[pulled.index(row)] += one.growth[index] * len(rows)
            sheets.append(sheet)
        self.pulled = tuple(pulled)
        where = np.concatenate(self.rows)
        self.where = np.unique(where)
        # A law has to say something of all that the recording visits, held-out stretches as well.
        self.visited = np.any([one.known for one, _ in parts], axis=0)
        seconds = len(np.unique(where)) * motion.smooth.step * max(1, motion.smooth.points // 2)
        self.data = Rows(
            np.concatenate(targets),
            np.concatenate(sheets, axis=1),
            stretches(motion, where),
            np.ones(len(where)),
            max(EVIDENCE_PER_S * seconds, 1.0),
            growth / len(where),
        )
        self.level = max(float(np.mean(self.data.target**2)), 1.0)

    def guess(self, kind: str, trial: Trial, level: float, *, glimpse: bool = False) -> Guess:
        """A law of some variables, regressed.

        level: mean square error to begin with. glimpse: the law is not put through the filter that
            what it has to predict went through, few degrees of smoothness are tried, and of two
            variables no sorts of axes.
        """
        sorts = SORTS if len(trial.of) == 2 else ((ALONE,) * len(trial.of),)

        def glimpsed(axes: tuple[Axis, ...], law: FloatArray) -> Regression:
            return regress(self.data, law, roughness(axes), level, choices=SMOOTH[1::3], rounds=1)

        tried = [
            (axes, self._columns(kind, axes, trial, filtered=not glimpse))
            for axes in (self._axes(trial, one) for one in (sorts[:1] if glimpse else sorts))
        ]
        if len(tried) > 1:
            tried = [min(tried, key=lambda one: glimpsed(*one).error)]
        ((axes, law),) = tried
        found = glimpsed(axes, law) if glimpse else regress(self.data, law, roughness(axes), level)
        return Guess(kind, trial.of, axes, trial.heat_s, found, trial.on_load)

    def _axes(self, trial: Trial, sorts: Sequence[Sort]) -> tuple[Axis, ...]:
        """Of a law's variables, over what was visited."""
        if "direction" in trial.of:  # which has two places, and leaves the other all of its own
            sorts = [one.all_places for one in sorts]
        values = (self.motion.variable(one, trial.on_load, trial.heat_s) for one in trial.of)
        return tuple(
            Axis.over(name, one[self.visited], trial.order, sort)
            for name, one, sort in zip(trial.of, values, sorts, strict=True)
        )

    def design(self, guess: Guess) -> FloatArray:
        """What a law's values add to the rows, float64[k, m]."""
        return self._columns(guess.kind, guess.axes, guess.tried, filtered=True)

    def passed(self, guess: Guess) -> FloatArray:
        """What each of a law's values drives with along the motion, through the filter that what is
        missing went through: float64[k, n]."""
        return self._passed(guess.kind, guess.axes, guess.tried)

    def table(self, guess: Guess) -> FloatArray:
        """What each of a law's values counts for along the whole motion: float64[k, n]."""
        values = [
            self.motion.variable(one, guess.on_load, guess.time_constant_s) for one in guess.of
        ]
        return columns(guess.axes, values, len(self.motion.time_s))

    def visits(self, guess: Guess) -> FloatArray:
        """How often the rows came near each place of a law's table: float64[k]."""
        found: FloatArray = np.abs(self.table(guess)[:, self.where]).sum(axis=1)
        return found

    def seen(self, guess: Guess) -> BoolArray:
        """The places of a law's table that were visited: bool[k]."""
        if not guess.axes:
            return np.ones(1, dtype=bool)
        found: BoolArray = self.visits(guess) >= _VISITED
        return found

    def along(self, kind: str, values: FloatArray) -> tuple[FloatArray, FloatArray]:
        """A variable, float64[n], on all rows, and what a law of 1 adds to each: float64[m]."""
        sign = driving(kind, self.motion)
        gains = [
            gain * sign[rows] / one.noise
            for (one, gain), rows in zip(self.parts, self.rows, strict=True)
        ]
        return values[np.concatenate(self.rows)], np.concatenate(gains)

    def _passed(self, kind: str, axes: tuple[Axis, ...], trial: Trial) -> FloatArray:
        fine = self.motion.fine
        values = [fine.variable(one, trial.on_load, trial.heat_s) for one in trial.of]
        return self.motion.passed(columns(axes, values, len(fine.speed)) * driving(kind, fine))

    def _columns(
        self, kind: str, axes: tuple[Axis, ...], trial: Trial, *, filtered: bool
    ) -> FloatArray:
        motion, where = self.motion, self.where
        if filtered:
            table = self._passed(kind, axes, trial)[:, where]
        else:
            values = [motion.variable(one, trial.on_load, trial.heat_s) for one in trial.of]
            table = columns(axes, [one[where] for one in values], len(where))
            table = table * driving(kind, motion)[where]
        parts = [
            gain * table[:, np.searchsorted(where, rows)] / one.noise
            for (one, gain), rows in zip(self.parts, self.rows, strict=True)
        ]
        return np.concatenate(parts, axis=1)

    def weighed_by(self, guess: Guess) -> None:
        """From now on let rows that a law leaves far out, such as impacts, count less.

        How far the others are out is what its own scatter says (by its median).
        """
        law = self.design(guess)
        left = self.data.target - guess.found.values @ law - guess.found.pulls @ self.data.sheet
        scale = max(LOSS_SCALE * typical_rms(left), LOSS_SCALE)
        self.data = replace(self.data, weight=robust_weights(left, scale))

    def alone(self) -> Regression:
        """The sheet alone, without any law."""
        nothing = np.zeros((0, len(self.data.target)))
        return regress(self.data, nothing, np.zeros((0, 0)), self.level)


def balances_of(
    found: Mapping[str, Missing], motion: Motion, fitted: BoolArray
) -> dict[str, Balance]:
    """The balances that laws are looked for in, by kind of port; none without a fitted row."""
    drive = motion.replay.drive
    found = {name: one for name, one in found.items() if fitted[one.rows].any()}
    made: dict[str, Balance] = {}
    if TORQUE in found:
        torque = Balance([(found[TORQUE], 1.0)], motion, fitted)
        made["torque"] = made["friction"] = torque
    if VOLTAGE in found:
        made["inverter_voltage"] = Balance([(found[VOLTAGE], 1.0)], motion, fitted)
    if TORQUE in found and VOLTAGE in found:
        made["current_error"] = Balance(
            [
                (found[TORQUE], -drive.motor.torque_constant),
                (found[VOLTAGE], drive.motor.resistance),
            ],
            motion,
            fitted,
        )
    if ROD in found:
        made["rod_error"] = Balance([(found[ROD], 1.0)], motion, fitted)
    return {kind: one for kind, one in made.items() if len(np.unique(one.data.block)) >= 4}
