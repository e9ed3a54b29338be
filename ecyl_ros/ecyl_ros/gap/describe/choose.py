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
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from ...arrays import FloatArray
from ...drive.law import PERIODS
from .balance import Balance
from .chance import LEVEL, probability
from .guess import Guess, Trial
from .motion import HEAT_S
from .regress import Regression
from .trials import pairs, singles, waves
from .visited import Visited

_ONE_SIDED_95 = 1.645
_EXPLAINS = 0.5  # share of what the sheet alone leaves above the noise that a law has to predict
_NEAR = 2  # sets of each sort that are tried in closed loop
_LOOKED_AT = 5  # pairs of variables that are looked at closely
_HEAT_STEP = math.log(HEAT_S[1] / HEAT_S[0])  # from one time constant of heat to the next
_HEAT_FOUND = 0.02  # of a time constant: so near it is found
_ANSWERS = {"current", "torque"}  # what the loop answers with


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
        above_noise = self.alone.error - 1.0
        if above_noise <= 0.0 or guess.found.error - 1.0 > (1.0 - _EXPLAINS) * above_noise:
            return False  # or nothing is missing
        return self.by_chance(guess) <= LEVEL

    @property
    def sets(self) -> int:
        """How many sets of variables were looked at."""
        return len({(one.kind, one.of) for one in (self.best, *self.rivals)})

    def by_chance(self, guess: Guess, sets: int = 1) -> float:
        """The probability of as good a prediction by a law without connection to what is missing.

        sets: how many sets of variables were looked at.
        """
        missing, left = (one.left[np.newaxis] for one in (self.alone, guess.found))
        return probability(missing, left, guess.found.block, 1.0, sets)


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
            guesses.append(heated(kind, first.tried, first.found.error, balance))
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
