"""Fits from coarse to fine, where a load that rattles makes a gap of many narrow valleys."""

from __future__ import annotations

import dataclasses

import pytest

from ecyl_ros.gap.fit.fit import Fitter
from ecyl_ros.gap.fit.stages import COARSE, FINE, MEDIUM
from ecyl_ros.gap.replay.replay import Replay
from ecyl_ros.gap.split import held_out_of
from ecyl_ros.gap.study.case import Case
from ecyl_ros.gap.study.cylinder.cases import complete_case, record_case, stated
from ecyl_ros.gap.study.random_drives import draw_setup

SEED, SHEET = 168175380, 0.02
COGGING = {"amplitude_nm": 1.156, "periods_per_rev": 8.0}
INERTIA = 0.006526


@pytest.fixture(scope="module")
def fitter() -> Fitter:
    """Of a drawn drive off its sheet whose rotor is a fifth too light, with cogging beside it."""
    setup = draw_setup(SEED)
    true = {"cogging_torque": COGGING, "rotor_inertia_error": {"inertia_kg_m2": INERTIA}}
    case = complete_case(
        Case(index=0, seed=SEED, kind="pair", effects=true, drives="random", sheet=SHEET), setup
    )
    constants = {**case.constants, "motor.rotor_inertia": INERTIA}
    case = dataclasses.replace(case, effects=true, constants=constants)
    replay = Replay(record_case(case, setup), stated(setup.drive, SHEET), "case")
    return Fitter(replay, held_out_of(replay.time_s, replay.gap({}), replay.usable))


@pytest.mark.parametrize("inertia", [0.95 * INERTIA, 1.065 * INERTIA])
def test_a_fit_from_afar_ends_at_the_noise(fitter: Fitter, inertia: float) -> None:
    """From 5 % too light or 6.5 % too heavy, the constants as the sheet has them."""
    values = {
        "cogging_torque": {**COGGING, "periods_per_rev": 8.002, "phase_rad": 1.377},
        "rotor_inertia_error": {"inertia_kg_m2": inertia},
    }
    fit = fitter.evaluate(values)
    assert fit.fitted > 6.0 * fitter.perfect**2
    for stage in (COARSE, MEDIUM, FINE):
        fit = fitter.fit(fit, steps=8, stage=stage)
    assert fit.fitted < 1.2 * fitter.perfect**2
    assert fit.values["rotor_inertia_error"]["inertia_kg_m2"] == pytest.approx(INERTIA, rel=0.03)
