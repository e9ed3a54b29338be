"""Parameters that only shape an effect are fitted, too, where its size alone does not do."""

from __future__ import annotations

import math

import pytest
from other_make import DRIVE, replayed

from ecyl_ros.gap.fit.descent import polish, search
from ecyl_ros.gap.fit.fit import Fitter
from ecyl_ros.gap.split import held_out
from ecyl_ros.gap.study.cylinder.cases import Stage

SEED = 6  # of a machine whose dead time turns its sign over 25 mA


def test_a_dead_time_with_corners_is_found_from_one_without() -> None:
    """Voltage, transition and straight line of another make of machine, from a round start."""
    true = {"inverter_dead_time": {"voltage_v": 1.3}}
    replay = replayed(true, seed=SEED)
    fitter = Fitter(replay, held_out(replay.time_s))
    start = {"voltage_v": 1.0, "transition_a": 0.05, "straightness": 0.1}
    begin = fitter.evaluate({"inverter_dead_time": start})
    found = search(fitter, begin, fitter.nominal)
    assert found.fitted > 2.0 * fitter.perfect**2  # the size alone does not do
    for _ in range(2):
        found = polish(fitter, found, 8)
    values = found.values["inverter_dead_time"]
    assert found.fitted < 1.5 * fitter.perfect**2
    assert values["voltage_v"] == pytest.approx(1.3, rel=3e-3)
    assert values["straightness"] > 0.8
    # All is lost at the corner, 76 % at the transition.
    corner = values["transition_a"] / math.tanh(1.0)
    true_corner = Stage.of(SEED, DRIVE).machine.dead_time_transition_a
    assert corner == pytest.approx(true_corner, rel=0.05)
