"""On what the missing quantity depends: the smallest set of variables that predicts it.

Every set of up to two variables competes, at every port that a balance speaks of, on stretches that
it was not fitted to. A larger set has to predict better by more than chance moves the difference
between stretches; among sets that cannot be told apart the one of fewer parameters stands. Where
the loop can be replayed it has the last word, on all that come `near`.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize_scalar

from ...drive.law import PERIODS, Law, order_of
from ..fit.robust import LOSS_SCALE, robust_weights
from ..replay.replay import BoolArray, FloatArray
from ..sheet import EVIDENCE_PER_S
from .axis import Axis, columns, roughness
from .missing import ROD, TORQUE, VOLTAGE, Missing
from .motion import HEAT_S, Motion
from .regress import SMOOTH, Regression, Rows, regress
from .trials import COARSE, FINEST, Trial, pairs, singles, waves
from .visited import Visited

_ONE_SIDED_95 = 1.645
_EXPLAINS = 0.5  # share of what the sheet alone leaves of a balance that a law has to predict
_VISITED = 3  # samples about a place from which it counts as visited
_NEAR = 2  # sets of each sort that are tried in closed loop
_LOOKED_AT = 5  # pairs of variables that are looked at closely
_HEAT_STEP = math.log(HEAT_S[1] / HEAT_S[0])  # from one time constant of heat to the next
_HEAT_FOUND = 0.02  # of a time constant: so near it is found
_ANSWERS = {"current", "torque"}  # what the loop answers with


@dataclass(frozen=True, eq=False)
class Guess:
    """A law at a kind of port, regressed.

    Attributes:
        kind: `torque` or `friction` (on rotor or load), or a port. of: the variables.
        axes: of the table. time_constant_s: of heat.
        found: the regression. on_load: whether the variables are the load's.
    """

    kind: str
    of: tuple[str, ...]
    axes: tuple[Axis, ...]
    time_constant_s: float
    found: Regression
    on_load: bool = False

    @property
    def order(self) -> int:
        """How often it repeats itself in a turn; 1 where it has no angle."""
        return max(
            (order_of(name, axis.period) for name, axis in zip(self.of, self.axes, strict=True)),
            default=1,
        )

    @property
    def looked_at(self) -> int:
        """Orders that it was chosen from."""
        return FINEST - COARSE if self.order > 1 else 0

    def with_values(self, values: FloatArray) -> Guess:
        """The same with other values."""
        return replace(self, found=replace(self.found, values=values))

    def law(self, port: str, values: FloatArray | None = None) -> Law:
        """As it is played at a port."""
        given = self.found.values if values is None else values
        return Law(
            port,
            self.of,
            tuple(tuple(float(one) for one in axis.at) for axis in self.axes),
            tuple(float(one) for one in given),
            tuple(axis.period for axis in self.axes),
            self.time_constant_s if "heat" in self.of else 0.0,
        )


@dataclass(frozen=True, eq=False)
class Choice:
    """What came of the sets at one kind of balance.

    best: the set that stands. rivals: the others, best first. alone: what the sheet alone predicts.
    """

    best: Guess
    rivals: tuple[Guess, ...]
    alone: Regression

    @property
    def explains(self) -> bool:
        """Whether the set predicts enough of what the sheet alone leaves."""
        return self._explains(self.best)

    def beside(self, guess: Guess) -> list[Guess]:
        """The sets of other variables than a guess, the one that stands first."""
        return [one for one in (self.best, *self.rivals) if one.of != guess.of]

    @property
    def near(self) -> list[Guess]:
        """Those that predict enough and come nearest, of each number of variables.

        Along a recording what the loop answers with, current and torque, predicts what it answers
        to: sets with these and sets without go side by side, for the loop to tell.
        """
        found: list[Guess] = []
        ranked = sorted((self.best, *self.rivals), key=lambda one: one.found.error)
        for size, answers in itertools.product(range(3), (False, True)):
            first: dict[tuple[str, tuple[str, ...]], Guess] = {}
            for one in ranked:
                alike = len(one.of) == size and bool(set(one.of) & _ANSWERS) is answers
                if alike and self._explains(one):
                    first.setdefault((one.kind, one.of), one)
            found += list(first.values())[:_NEAR]
        return found

    def _explains(self, guess: Guess) -> bool:
        return guess.found.error <= (1.0 - _EXPLAINS) * self.alone.error


def heated(kind: str, trial: Trial, level: float, balance: Balance) -> Guess:
    """A law of heat with the time constant, around that of a trial, that predicts best.

    level: mean square error to begin with.
    """

    def at(logarithm: float) -> Trial:
        return trial._replace(heat_s=math.exp(logarithm))

    def error(logarithm: float) -> float:
        return balance.guess(kind, at(logarithm), level, glimpse=True).found.error

    middle = math.log(trial.heat_s)
    ends = (middle - _HEAT_STEP, middle + _HEAT_STEP)
    found = minimize_scalar(error, bounds=ends, method="bounded", options={"xatol": _HEAT_FOUND})
    return balance.guess(kind, at(float(found.x)), level)


def stretches(motion: Visited, rows: np.ndarray) -> np.ndarray:
    """The stretch each row lies in, numbered from 0 without holes: int64[m]."""
    index = np.floor(motion.time_s[rows] / motion.stretch_s).astype(np.int64)
    numbered: np.ndarray = np.unique(index, return_inverse=True)[1]
    return numbered


def _tried(guess: Guess) -> Trial:
    return Trial(guess.of, guess.on_load, guess.time_constant_s, guess.order)


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
        for (one, _), rows in zip(parts, self.rows, strict=True):
            targets.append(one.values[rows] / one.noise)
            sheet = np.zeros((len(pulled), len(rows)))
            for index, row in enumerate(one.pulled):
                sheet[pulled.index(row)] = one.columns[index, rows] / one.noise
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
        )
        self.level = max(float(np.mean(self.data.target**2)), 1.0)

    def guess(self, kind: str, trial: Trial, level: float, *, glimpse: bool = False) -> Guess:
        """A law of some variables, regressed.

        level: mean square error to begin with. glimpse: the law is not put through the filter that
            what it has to predict went through, and few degrees of smoothness are tried.
        """
        motion = self.motion
        values = [motion.variable(one, trial.on_load, trial.heat_s) for one in trial.of]
        paired = len(trial.of) > 1 and "direction" not in trial.of  # which has two places
        axes = tuple(
            Axis.over(name, one[self.visited], paired=paired, order=trial.order)
            for name, one in zip(trial.of, values, strict=True)
        )
        law = self._columns(kind, axes, trial, filtered=not glimpse)
        rough = roughness(axes)
        if glimpse:
            found = regress(self.data, law, rough, level, choices=SMOOTH[1::3], rounds=1)
        else:
            found = regress(self.data, law, rough, level)
        return Guess(kind, trial.of, axes, trial.heat_s, found, trial.on_load)

    def design(self, guess: Guess) -> FloatArray:
        """What a law's values add to the rows, float64[k, m]."""
        return self._columns(guess.kind, guess.axes, _tried(guess), filtered=True)

    def passed(self, guess: Guess) -> FloatArray:
        """What each of a law's values drives with along the motion, through the filter that what is
        missing went through: float64[k, n]."""
        return self._passed(guess.kind, guess.axes, _tried(guess))

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
        scale = max(LOSS_SCALE * 1.4826 * float(np.median(np.abs(left))), LOSS_SCALE)
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


def choose(kinds: Sequence[str], balances: Mapping[str, Balance], motion: Visited) -> Choice | None:
    """Of the kinds that one balance speaks of, the set that stands; None where nothing is known."""
    kinds = [kind for kind in kinds if kind in balances]
    if not kinds:
        return None
    balance = balances[kinds[0]]
    trials = [(kind, trial) for kind in kinds for trial in singles(kind, motion)]
    guesses = [balance.guess(*trial, balance.level) for trial in trials]
    balance.weighed_by(min(guesses, key=lambda one: one.found.error))
    alone = balance.alone()
    trials += [(kind, trial) for kind in kinds for trial in waves(kind, balance, alone, motion)]
    guesses = [balance.guess(*trial, balance.level) for trial in trials]
    level = min(one.found.error for one in guesses)
    for kind in kinds:
        hot = [one for one in guesses if one.kind == kind and one.of == ("heat",)]
        if hot:
            first = min(hot, key=lambda one: one.found.error)
            guesses.append(heated(kind, _tried(first), first.found.error, balance))
    for error, kind, trial in _promising(kinds, guesses, level, balance):
        if "heat" in trial.of:
            guesses.append(heated(kind, trial, error, balance))
        else:
            guesses.append(balance.guess(kind, trial, level))
    guesses.sort(key=lambda one: one.found.error)
    best = standing(guesses)
    return Choice(best, tuple(one for one in guesses if one is not best), alone)


def _promising(
    kinds: Sequence[str], alone: Sequence[Guess], level: float, balance: Balance
) -> list[tuple[float, str, Trial]]:
    """The pairs of variables that predict best at a glimpse, with their errors; best first."""
    glimpsed = [
        (balance.guess(kind, trial, level, glimpse=True).found.error, kind, trial)
        for kind in kinds
        for trial in pairs(kind, alone, balance.motion)
    ]
    found: dict[tuple[str, tuple[str, ...]], tuple[float, str, Trial]] = {}
    for error, kind, trial in sorted(glimpsed, key=lambda one: one[0]):
        found.setdefault((kind, trial.of), (error, kind, trial))
    return list(found.values())[:_LOOKED_AT]


def standing(guesses: Sequence[Guess]) -> Guess:
    """Of guesses on the same rows the simplest that the best does not beat by more than chance."""
    best = min(guesses, key=lambda one: one.found.error)
    used = best.found.count > 0
    counts = best.found.count[used]

    def by_stretch(one: Guess) -> FloatArray:
        # No stretch counts for more than the others because much happened in it.
        return np.log((one.found.errors[used] + counts) / counts) + one.found.price

    close = []
    for one in guesses:
        gap = by_stretch(one) - by_stretch(best)
        doubt = float(np.std(gap) / np.sqrt(len(gap)))
        if one is best or float(np.mean(gap)) <= _ONE_SIDED_95 * doubt:
            close.append(one)
    # A law that repeats itself says more than one that only runs alike where it was seen.
    return min(
        close,
        key=lambda one: (len(one.of), -sum(name in PERIODS for name in one.of), one.found.freedom),
    )
