"""Two causes that hide each other are found between what each of them comes to alone."""

from __future__ import annotations

import pytest
from sheets import exact

from ecyl_ros.gap.compete.joint import joined
from ecyl_ros.gap.fit.fit import Fit, Fitter
from ecyl_ros.gap.replay.replay import Replay
from ecyl_ros.gap.split import held_out
from ecyl_ros.gap.study.cylinder.cases import Case, record_case

ROTOR, LOAD = "rotor_coulomb_friction", "load_coulomb_friction"


@pytest.fixture(scope="module")
def fitter() -> Fitter:
    """Of a drive with friction on both sides of its play."""
    drive = exact("bench")
    true = {ROTOR: {"coulomb_nm": 0.0699}, LOAD: {"coulomb_nm": 0.2238}}
    replay = Replay(record_case(Case(0, 1456662079, "pair", true), drive), drive, "recording")
    return Fitter(replay, held_out(replay.time_s))


@pytest.fixture(scope="module")
def singles(fitter: Fitter) -> list[Fit]:
    """Effects fitted alone: each friction stands in for both, at nearly their sum."""
    found = [
        {LOAD: {"coulomb_nm": 0.293}},
        {ROTOR: {"coulomb_nm": 0.294}},
        {"stiffness_error": {"stiffness_nm_per_rad": 5000.0}},
        {"friction_drift": {"coulomb_nm": 0.294, "rate_per_s": 0.001}},
    ]
    return [fitter.evaluate(values) for values in found]


def test_frictions_that_hide_each_other_are_found_in_shares_of_their_sizes(fitter, singles) -> None:
    """What is left falls below half of either alone, within a tenth of the true torques."""
    best = joined(fitter, singles)[0]
    assert set(best.names) == {ROTOR, LOAD}
    assert best.fitted < 0.5 * min(one.fitted for one in singles)
    assert best.values[LOAD]["coulomb_nm"] == pytest.approx(0.2238, rel=0.1)
    assert best.values[ROTOR]["coulomb_nm"] == pytest.approx(0.0699, rel=0.1)


def test_a_general_case_is_not_joined_beside_its_special_one(fitter, singles) -> None:
    """Friction that drifts holds friction that does not: three effects make three pairs."""
    names = [set(one.names) for one in joined(fitter, singles)]
    assert len(names) == 3
    assert not any("friction_drift" in one for one in names)
