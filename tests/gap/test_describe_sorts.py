"""A law of two variables may change fast along one of them and slowly along the other."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ecyl_ros.gap.describe.axis import SORTS, Axis, columns, roughness
from ecyl_ros.gap.describe.balance import Balance
from ecyl_ros.gap.describe.guess import Trial
from ecyl_ros.gap.describe.missing import TORQUE, Missing
from ecyl_ros.gap.describe.regress import regress

PAIR = ("position", "speed")
TIME_S = np.arange(0.0, 12.0, 0.01)


def _along(**variables: np.ndarray) -> Any:
    """A motion whose variables are known."""
    motion = SimpleNamespace(
        time_s=TIME_S,
        speed=variables["speed"],
        stretch_s=0.5,
        smooth=SimpleNamespace(points=2, step=0.01),
        passed=lambda table: table,
        variable=lambda name, on_load, heat_s: variables[name],
    )
    motion.fine = motion
    return motion


@pytest.mark.parametrize("narrow", [0, 1])
def test_a_damper_at_one_place_is_told_where_it_begins_and_ends(narrow: int) -> None:
    """Proportional to one variable over a tenth of the other: more places along the other, a law
    that is nearer to the truth and predicts better than with as many along both."""
    rng = np.random.default_rng(9)
    drawn = rng.uniform(-1.0, 1.0, (2, TIME_S.size))
    wide = drawn[1 - narrow]
    truth = 40.0 * wide * np.exp(-(((drawn[narrow] - 0.2) / 0.1) ** 2))
    every = np.ones(TIME_S.size, dtype=bool)
    rows, none = np.arange(TIME_S.size), np.zeros((0, TIME_S.size))
    left = truth + rng.standard_normal(TIME_S.size)
    missing = Missing(TORQUE, "N m", left, 1.0, every, rows, none, (), np.zeros(0))
    balance = Balance([(missing, 1.0)], _along(**dict(zip(PAIR, drawn, strict=True))), every)
    found = balance.guess("torque", Trial(PAIR), balance.level)
    sizes = [axis.at.size for axis in found.axes]
    assert sizes[narrow] > 2 * sizes[1 - narrow]
    even = tuple(
        Axis.over(name, values, 1, sort)
        for name, values, sort in zip(PAIR, drawn, SORTS[0], strict=True)
    )
    table = columns(even, list(drawn), TIME_S.size)
    alike = regress(balance.data, table, roughness(even), balance.level)
    assert found.found.error < 0.6 * alike.error
    off, off_alike = (
        np.sqrt(np.mean((one.values @ rows - truth) ** 2))
        for one, rows in ((found.found, balance.table(found)), (alike, table))
    )
    assert off < 0.7 * off_alike
