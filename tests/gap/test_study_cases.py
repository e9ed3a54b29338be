"""Drawn cases: repeatable, balanced, visible; labels that stay sealed."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections import Counter

import numpy as np
import pytest

from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.effects.catalogue import CATALOGUE
from ecyl_ros.errors import InputError
from ecyl_ros.gap.study.case import Case
from ecyl_ros.gap.study.cylinder.cases import VISIBLE, complete_case, plan_cases, record_case
from ecyl_ros.gap.study.cylinder.inside import INSIDE
from ecyl_ros.gap.study.cylinder.machine import noise_floor, run_machine
from ecyl_ros.gap.study.cylinder.outside import OUTSIDE
from ecyl_ros.gap.study.cylinder.stage import Stage
from ecyl_ros.gap.study.drives import BenchDrives, Choice, draw_cases
from ecyl_ros.gap.study.seal import BrokenSeal, Sealed, seal

DRIVE = load_drive("bench")


def test_two_hundred_cases_hold_the_kinds_that_the_figures_ask_for() -> None:
    """About half singles, a fifth pairs, 40 without a gap, 10 to 15 % not in the catalogue."""
    kinds = Counter(case.kind for case in plan_cases(200, 1))
    assert sum(kinds.values()) == 200
    assert kinds["none"] >= 40
    assert 90 <= kinds["single"] <= 104
    assert kinds["pair"] == 40
    assert 20 <= kinds["outside"] + kinds["withheld"] <= 30


def test_every_effect_of_the_catalogue_is_drawn_about_equally_often() -> None:
    """Numbers of single cases per effect differ by one at most."""
    numbers = Counter(
        name for case in plan_cases(200, 2) if case.kind == "single" for name in case.effects
    )
    assert set(numbers) == set(INSIDE)
    assert max(numbers.values()) - min(numbers.values()) <= 1


def test_withheld_effects_are_in_the_drive_and_not_in_the_diagnosis() -> None:
    """A withheld case holds one catalogue effect that its diagnosis must not be given, nor any
    finer form of it; pairs hold two different ones, never two forms of the same friction."""
    cases = plan_cases(400, 3)
    for case in cases:
        if case.kind == "withheld":
            (hidden,) = case.effects
            finer = {name for name, one in CATALOGUE.items() if hidden in one.refines}
            assert set(case.withheld) == {hidden} | finer
            assert case.nameable == set()
        if case.kind == "pair":
            assert len(case.effects) == 2
            assert set(case.effects) != {"rotor_coulomb_friction", "stribeck_friction"}
        if case.kind == "outside":
            assert set(case.effects) <= set(OUTSIDE)
            assert case.nameable == set()
        if case.kind == "beyond":
            assert len(case.nameable) == 1


def test_leaving_an_effect_out_keeps_it_out_of_everything_that_could_be_named() -> None:
    """With `without`, the effect is withheld in every case and occurs in withheld ones only."""
    cases = plan_cases(300, 4, without=("cogging_torque",))
    for case in cases:
        assert "cogging_torque" in case.withheld
        assert ("cogging_torque" in case.effects) == (case.kind == "withheld")
    assert any(case.kind == "withheld" for case in cases)


def test_kinds_and_effects_limit_a_study() -> None:
    """Only what was asked for is drawn; a choice that leaves nothing is refused in one line."""
    cases = plan_cases(10, 5, kinds=("single", "outside"), effects=("lead_error", "x_local_jam"))
    assert {name for case in cases for name in case.effects} == {"lead_error", "x_local_jam"}
    with pytest.raises(InputError, match="no case is left"):
        plan_cases(10, 5, kinds=("single",), effects=("x_local_jam",))


def test_drawn_cases_repeat() -> None:
    """The same count and seed give the same labels and recordings; another seed does not."""
    choice = Choice(kinds=("single",), effects=("lead_error",))
    first, again, other = (draw_cases(BenchDrives(DRIVE), 1, seed, choice) for seed in (6, 6, 7))
    assert [case.label() for case in first] == [case.label() for case in again]
    assert first[0].label() != other[0].label()
    one, two = record_case(first[0], DRIVE), record_case(again[0], DRIVE)
    np.testing.assert_array_equal(one.stamp_ns, two.stamp_ns)
    np.testing.assert_array_equal(one.rod_position_m, two.rod_position_m)


def test_each_effect_of_a_pair_shows_when_the_other_is_in_place() -> None:
    """Taking either effect out of the machine changes some signal by the visible size."""
    names = ("inverter_dead_time", "spring_load")
    planned = Case(0, 21, "pair", {name: {} for name in names})
    case = complete_case(planned, DRIVE)
    stage, floor = Stage.of(case.seed, DRIVE), noise_floor(DRIVE)

    def run(effects):
        machine = stage.with_effects(effects, case.seed)
        return run_machine(machine, stage.nuisances, DRIVE, stage.reference).signals

    complete = run(case.effects)
    for name in names:
        alone = run({other: case.effects[other] for other in names if other != name})
        gaps = [np.sqrt(np.mean((complete[key] - alone[key]) ** 2)) / floor[key] for key in floor]
        assert max(gaps) >= VISIBLE


def test_references_stay_within_speed_and_begin_and_end_at_rest() -> None:
    """Over many draws: no jump in position or velocity, never faster than asked, from zero."""
    from ecyl_ros.gap.study.cylinder.excitation import draw_reference

    for seed in range(30):
        position, velocity = draw_reference(np.random.default_rng(seed), 12.0, 1e-4, 0.04)
        assert len(position) == len(velocity) == 120_000
        assert position[0] == velocity[0] == 0.0
        assert np.max(np.abs(velocity)) <= 0.04 * 1.0001
        assert abs(velocity[-1]) < 1e-3
        # Velocity is the slope of position, everywhere.
        slope = np.diff(position) / 1e-4
        middle = 0.5 * (velocity[1:] + velocity[:-1])
        np.testing.assert_allclose(slope, middle, atol=2e-5)


def test_the_seal_is_the_hash_of_the_labels_and_breaks_with_any_change() -> None:
    """SHA-256 of canonical JSON, checked with hashlib alone; a changed label is refused."""
    cases = [
        Case(0, 5, "single", {"lead_error": {"lead_m": 0.0201}}, (), {"lead_error": {"x": 5.0}}),
        Case(1, 6, "withheld", {"spring_load": {"stiffness_n_per_m": 4e4}}, ("spring_load",)),
    ]
    sealed = seal(cases)
    labels = [
        dataclasses.asdict(case) | {"withheld": list(case.withheld), "unseen": []} for case in cases
    ]
    text = json.dumps(labels, sort_keys=True, separators=(",", ":"))
    assert sealed.sha256 == hashlib.sha256(text.encode()).hexdigest()
    assert sealed.open() == cases
    with pytest.raises(BrokenSeal):
        Sealed(sealed.text.replace("0.0201", "0.0202"), sealed.sha256).open()


def test_a_drive_without_noise_is_refused_in_one_line() -> None:
    """Without a noise floor nothing is at it: the message says what the drive file lacks."""
    quiet = dataclasses.replace(DRIVE, sensors=type(DRIVE.sensors)())
    with pytest.raises(InputError, match="rotor_position_noise is 0"):
        Stage.of(1, quiet)
