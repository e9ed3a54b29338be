"""A sure cause is named although something small beside it cannot be told apart."""

from __future__ import annotations

import numpy as np
import pytest
from sheets import exact

from ecyl_ros.gap import cylinder as module
from ecyl_ros.gap.compete.competition import Competition
from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.gap.fit.fit import Fit
from ecyl_ros.gap.study.cylinder.cases import Case, record_case

LIMIT, INERTIA, GAIN = "voltage_limit", "load_inertia_error", "inverter_gain"


def fit(judged: float, *names: str) -> Fit:
    """Of some effects that leave `judged`; their values do not matter here."""
    return Fit({name: {} for name in names}, np.zeros(0), np.zeros((1, 1)), judged, judged, judged)


def competition(*rivals: Fit) -> Competition:
    """Won by a limit and an inertia."""
    without = {LIMIT: fit(9.0, INERTIA), INERTIA: fit(1.2, LIMIT)}
    winner = fit(0.85, LIMIT, INERTIA)
    return Competition(fit(9.0), fit(9.0), (), winner, rivals, without)


@pytest.fixture
def taken_out(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The effects that are taken out of the winner."""
    found: list[str] = []

    def without_effects(given: Competition, fitter: object, effects: list[str]) -> Competition:
        found.extend(effects)
        return given

    monkeypatch.setattr(module, "without_effects", without_effects)
    return found


def test_what_cannot_be_told_apart_goes_and_is_noted(taken_out) -> None:
    """A supply's gain in the inertia's place leaves as little: the limit alone is kept."""
    given = competition(fit(0.852, LIMIT, GAIN), fit(3.0, INERTIA, GAIN))
    _, (note,) = module._without_unsure(given, None)
    assert taken_out == [INERTIA]
    assert "wrong load inertia" in note.lower() and "each equally well" in note


@pytest.mark.parametrize(
    "rivals",
    [
        (fit(1.5, LIMIT, GAIN), fit(3.0, INERTIA, GAIN)),
        (fit(0.852, LIMIT, GAIN), fit(0.851, INERTIA, GAIN)),
    ],
    ids=["all are sure", "none is"],
)
def test_causes_that_are_sure_or_unsure_alike_stay(rivals, taken_out) -> None:
    """Only beside a sure cause does an unsure one go; its confidence says the rest."""
    assert module._without_unsure(competition(*rivals), None)[1] == []
    assert taken_out == []


def test_a_limit_of_another_make_of_machine_is_named_alone() -> None:
    """Surely, and with the true voltage in its interval."""
    drive = exact("bench")
    true = {LIMIT: {"voltage_v": 2.586485128454045}}
    found = diagnose(record_case(Case(0, 866944933, "single", true), drive).slice(0.0, 4.0), drive)
    assert [one.effect for one in found.causes] == [LIMIT]
    assert found.causes[0].confidence > 0.9
    (value,) = found.causes[0].parameters
    assert value.low < true[LIMIT]["voltage_v"] < value.high
