"""Two torques that cancel each other are found in the balance of torque."""

from __future__ import annotations

import pytest
from sheets import exact

from ecyl_ros.gap.compete.chained import chained
from ecyl_ros.gap.fit.fit import Fitter
from ecyl_ros.gap.fit.robust import misfit
from ecyl_ros.gap.replay.replay import Replay
from ecyl_ros.gap.split import held_out
from ecyl_ros.gap.study.cylinder.cases import Case, record_case

TRUE = {"constant_load": {"force_n": -250.4}, "spring_load": {"stiffness_n_per_m": 24235.0}}


def test_a_load_and_a_spring_that_cancel_each_other_are_begun_together() -> None:
    """Alone the load would be -24 N; the first set has both within 2 %, and is near the floor."""
    drive = exact("bench")
    replay = Replay(record_case(Case(0, 629204307, "pair", TRUE), drive), drive, "recording")
    fitter = Fitter(replay, held_out(replay.time_s))
    names = ("load_coulomb_friction", *TRUE, "load_viscous_friction", "cogging_torque")
    best, *others = chained(fitter, fitter.nominal, names)
    assert set(best.names) == set(TRUE)
    assert best.values["constant_load"]["force_n"] == pytest.approx(-250.4, rel=0.02)
    assert best.values["spring_load"]["stiffness_n_per_m"] == pytest.approx(24235.0, rel=0.02)
    assert misfit(best.fitted) < 2.0 * fitter.perfect < 0.5 * misfit(fitter.nominal.fitted)
    assert not any("cogging_torque" in one.names for one in others)  # a wave has a phase to find
