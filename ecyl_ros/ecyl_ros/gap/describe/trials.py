"""What a law may depend on: the variables that are tried, alone and two together."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from ...drive.law import LEAST_PERIODS, PERIODS
from ...effects.lines import explained
from .balance import Balance
from .guess import COARSE, FINEST, Guess, Trial
from .motion import HEAT_S
from .regress import Regression
from .visited import Visited

_WAVES = 2  # finer ones that are tried

_PLACE = ("position", "rotor_angle", "screw_angle")
_ALIKE = (set(_PLACE), {"speed", "direction"}, {"current", "torque", "voltage"})

_FREE = {
    "torque": (*_PLACE, "speed", "current", "torque", "time", "heat", "travel"),
    "friction": (*_PLACE, "speed", "direction", "current", "torque", "time", "heat"),
    "inverter_voltage": (*_PLACE, "speed", "current", "time", "heat"),
    "current_error": (*_PLACE, "speed", "current", "time", "heat"),
    "rod_error": (*_PLACE, "speed", "direction", "time"),
    "following_error": (*_PLACE, "speed"),
}


def singles(kind: str, motion: Visited) -> list[Trial]:
    """No variable, and each one that makes sense at a kind of port."""
    found = [Trial(())]
    for one in _FREE[kind]:
        if motion.periods(one, False) < LEAST_PERIODS:
            continue
        if one == "torque":
            found += [Trial((one,), False), Trial((one,), True)]
        elif one == "heat":
            found += [Trial((one,), False, heat_s) for heat_s in HEAT_S]
        else:
            found.append(Trial((one,)))
    return found


def waves(kind: str, balance: Balance, alone: Regression, motion: Visited) -> list[Trial]:
    """Laws of an angle too fine for the table of a whole turn: those that explain most.

    alone: what the sheet alone predicts. An order that only sampling makes of another one predicts
    nothing where a stretch begins at another angle.
    """
    data, found = balance.data, []
    root = np.sqrt(data.weight)
    left = root * (data.target - alone.pulls @ data.sheet)
    base = np.linalg.qr((root * data.sheet).T)[0]
    orders = np.arange(COARSE + 1, FINEST + 1)
    for name in _FREE[kind]:
        if name not in PERIODS or motion.periods(name, False) < LEAST_PERIODS:
            continue
        angle, gain = balance.along(kind, motion.variable(name, False))
        variance = explained(left, angle, root * gain, base, orders.astype(float))[:, 0]
        found += [Trial((name,), order=int(orders[one])) for one in np.argsort(-variance)[:_WAVES]]
    return found


def pairs(kind: str, alone: Sequence[Guess], motion: Visited) -> list[Trial]:
    """Every two of the variables that were tried alone; heat at every time constant, for what it
    does alone says nothing of it beside another."""
    best: dict[str, Guess] = {}
    for one in alone:
        if one.kind == kind and len(one.of) == 1 and one.order == 1:
            name = one.of[0]
            if name not in best or one.found.error < best[name].found.error:
                best[name] = one
    return [
        Trial(tuple(sorted(pair)), any(best[one].on_load for one in pair), heat_s)
        for pair in itertools.combinations(best, 2)
        if not any(set(pair) <= alike for alike in _ALIKE) and motion.fills(*pair, False)
        for heat_s in (HEAT_S if "heat" in pair else (0.0,))
    ]
