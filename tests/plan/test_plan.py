"""Planned experiments: what the motion separates, and what is refused."""

from __future__ import annotations

import dataclasses
import itertools
import json
from pathlib import Path

import numpy as np
import pytest
import yaml

from ecyl_ros.cli.main import main
from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.drive.reference.leg import Leg
from ecyl_ros.drive.reference.planned import Planned
from ecyl_ros.drive.reference.swing import Swing
from ecyl_ros.errors import InputError
from ecyl_ros.gap.replay.replay import SIGNALS
from ecyl_ros.plan import make, search
from ecyl_ros.plan.blocks import Block, library
from ecyl_ros.plan.diagnosis_file import read_diagnosis
from ecyl_ros.plan.hypotheses import open_or_alike
from ecyl_ros.plan.make import make_plan
from ecyl_ros.plan.others import moves, usual
from ecyl_ros.plan.predict import Experiment, predicted, separations
from ecyl_ros.plan.trajectory import as_yaml
from ecyl_ros.plan.waves import Wave, waves

PAIR = ("rotor_coulomb_friction", "load_coulomb_friction")


def test_a_planned_motion_separates_what_a_sine_does_not() -> None:
    """Friction on either side: at least twice the separation of sine and moves along straight
    lines, by fits half as much again; within limits."""
    drive = dataclasses.replace(load_drive("bench"), tolerances={"all": "exact"})
    signals = tuple(one.name for one in SIGNALS)
    plan = make_plan(drive, 2.0, [PAIR], [], {}, signals, [], budget_s=0.0)
    apart = {one.motion: one.apart[0] for one in plan.predictions}
    experiment = Experiment(drive, 2.0, signals)
    straight = {
        one.motion: min(separations(predicted(experiment, one.reference, 2.0), plan.pairs)[0])
        for one in plan.predictions
    }
    assert straight["planned"] > 2.0 * max(straight["sine"], straight["moves"])
    assert apart["planned"] > 1.5 * max(apart["sine"], apart["moves"])
    assert apart["planned"] > plan.needed
    plan.motion.check(drive.limits, "plan")
    assert plan.motion.moving_s <= 2.0 + 1e-6


def test_a_plan_is_never_worth_less_than_plain_moves(monkeypatch: pytest.MonkeyPatch) -> None:
    """A search that was cut short ends with a feeble motion: moves are played in its stead."""
    drive = dataclasses.replace(load_drive("bench"), tolerances={"all": "exact"})
    feeble = Planned((Leg(1e-5, 1e-4, 1e-2, 1.0),), 2.0)
    monkeypatch.setattr(make, "planned", lambda *given: (feeble, False))
    signals = tuple(one.name for one in SIGNALS)
    plan = make.make_plan(drive, 2.0, [PAIR], [], {}, signals, [], budget_s=0.0)
    apart = {one.motion: one.apart[0] for one in plan.predictions}
    assert plan.motion == moves(drive.limits, 2.0)
    assert apart["planned"] == apart["moves"]


def test_blocks_begin_and_end_where_the_motion_starts() -> None:
    """So that they can follow each other in any order; none leaves the stroke."""
    drive = load_drive("bench")
    one_sided = dataclasses.replace(drive.limits, stroke_min=0.0)
    for limits in (drive.limits, one_sided):
        for block in library(dataclasses.replace(drive, limits=limits), 0.5):
            legs = block.legs(limits, 0.5)
            assert legs[-1].to_m == 0.0
            assert all(limits.stroke_min <= leg.to_m <= limits.stroke_max for leg in legs)


def test_waves_keep_the_limits_about_the_start() -> None:
    """As large as the limits allow; none where the start lies at an end of the stroke."""
    limits = load_drive("bench").limits
    one_sided = dataclasses.replace(limits, stroke_min=0.0)
    made = [*waves(1.0), *waves(8.0), Wave(1.0, 1.3, 1.9)]  # the last between two lines of 1 Hz
    assert len(made) >= 7
    for wave, length_s in itertools.product(made, (1.0, 8.0)):
        (swing,) = wave.legs(limits, length_s)
        assert swing.refused() is None and swing.length_s == length_s
        swing.check(limits, 0.0, "wave")
        larger = dataclasses.replace(swing, amplitude_m=1.01 * swing.amplitude_m)
        with pytest.raises(InputError, match="expected at most limits"):
            larger.check(limits, 0.0, "wave")
        assert wave.legs(one_sided, length_s) == ()


def test_motions_that_stand_beside_a_plan_keep_the_same_limits() -> None:
    """Speed, acceleration and jerk by differences, as large as they may be."""
    limits = load_drive("bench").limits
    times = np.arange(0.0, 6.0, 1e-3)
    for name, motion in usual(limits, 6.0).items():
        place = np.array([motion.sample(one)[0] for one in times])
        tops = [float(np.abs(np.diff(place, order)).max()) / 1e-3**order for order in (1, 2, 3)]
        asked = (limits.speed, limits.acceleration, limits.jerk)
        shares = [top / most for top, most in zip(tops, asked, strict=True)]
        assert 0.85 < max(shares) < 1.01, name
        assert limits.stroke_min <= place.min() <= place.max() <= limits.stroke_max


def test_a_multisine_is_planned_where_it_tells_most(monkeypatch: pytest.MonkeyPatch) -> None:
    """All moves but feeble ones taken away, the plan swings, within the limits and the time."""
    drive = dataclasses.replace(load_drive("bench"), tolerances={"all": "exact"})
    slow = [Block(1e-5, 1e-4, 1e-2, 0.0)]
    monkeypatch.setattr(search, "library", lambda *given: slow)
    signals = tuple(one.name for one in SIGNALS)
    plan = make_plan(drive, 2.0, [PAIR], [], {}, signals, [], beside=(), budget_s=20.0)
    assert any(isinstance(leg, Swing) for leg in plan.motion.legs)
    plan.motion.check(drive.limits, "plan")
    assert 1.5 < plan.motion.moving_s <= 2.0 + 1e-6
    assert plan.motion.sample(2.0) == pytest.approx((0.0, 0.0), abs=1e-12)


def test_limits_that_leave_no_motion_are_refused() -> None:
    """A stroke without the start, and a drive too slow for the time."""
    drive = load_drive("bench")
    away = dataclasses.replace(drive.limits, stroke_min=0.1)
    with pytest.raises(InputError, match="motions start at 0 m"):
        library(dataclasses.replace(drive, limits=away), 0.5)


def test_the_trajectory_is_the_motion() -> None:
    """Points of the message against the motion itself; time goes on."""
    motion = Planned((Leg(0.01, 0.1, 2.0, 100.0), Leg(0.0, 0.1, 2.0, 100.0)), 1.0)
    data = yaml.safe_load(as_yaml(motion, "slide"))
    assert data["joint_names"] == ["slide"]
    times = [
        one["time_from_start"]["sec"] + 1e-9 * one["time_from_start"]["nanosec"]
        for one in data["points"]
    ]
    assert np.all(np.diff(times) > 0.0) and times[-1] == pytest.approx(1.0)
    for time, point in zip(times, data["points"], strict=True):
        wanted = motion.sample(time)
        assert (point["positions"][0], point["velocities"][0]) == pytest.approx(wanted, abs=2e-9)


def _diagnosis(**more: object) -> dict[str, object]:
    made: dict[str, object] = {
        "schema": "ecyl.diagnosis/1",
        "verdict": "explained",
        "location": {"signals": [{"name": "current_q"}]},
        "causes": [],
    }
    return {**made, **more}


def test_what_a_diagnosis_leaves_open_is_planned_for(tmp_path: Path) -> None:
    """A cause with an alternative is a pair, in the size that was found."""
    path = tmp_path / "diagnosis.json"
    cause = {
        "effect": PAIR[0],
        "parameters": {"coulomb_nm": {"value": 0.02}},
        "alternatives": [PAIR[1]],
    }
    path.write_text(json.dumps(_diagnosis(causes=[cause])))
    found = open_or_alike(read_diagnosis(path, load_drive("bench"), "bench"))
    assert found.pairs == (tuple(sorted(PAIR)),)
    assert found.values == {PAIR[0]: {"coulomb_nm": 0.02}}
    assert found.signals == ("current_q",)


def test_a_diagnosis_of_another_drive_is_refused(tmp_path: Path) -> None:
    """Its sheet holds constants that this drive file has not."""
    path = tmp_path / "diagnosis.json"
    sheet = [{"parameter": "motor.resistance", "nominal": 1.5}]
    path.write_text(json.dumps(_diagnosis(sheet=sheet)))
    with pytest.raises(InputError, match="expected a diagnosis of this drive"):
        read_diagnosis(path, load_drive("bench"), "bench")


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"location": []}, r"location = \[\], expected a mapping"),
        ({"causes": [{"effect": 3}]}, r"causes\[0\].effect = 3, expected text"),
        ({"sheet": [{"parameter": "motor.resistance"}]}, r"sheet\[0\].nominal = missing"),
        ({"alike": [{"effects": ["a"]}]}, r"alike\[0\].effects = \['a'\], expected a list of two"),
        (
            {"causes": [{"effect": PAIR[0], "parameters": {"coulomb": {"value": 1}}}]},
            r"parameter 'coulomb' of \w+ is missing or not its own; expected coulomb_nm",
        ),
    ],
)
def test_a_diagnosis_of_another_shape_is_refused(tmp_path: Path, more: dict, said: str) -> None:
    """One line names the file, the field and what was expected."""
    path = tmp_path / "diagnosis.json"
    path.write_text(json.dumps(_diagnosis(**more)))
    with pytest.raises(InputError, match=said) as caught:
        read_diagnosis(path, load_drive("bench"), "bench")
    assert str(path) in str(caught.value)


def test_a_diagnosis_of_another_kind_of_drive_is_refused(tmp_path: Path) -> None:
    """A follower's or a rigid drive's JSON names signals that no cylinder has."""
    path = tmp_path / "diagnosis.json"
    signals = [{"name": "position", "unit": "m"}]
    path.write_text(json.dumps(_diagnosis(location={"signals": signals})))
    with pytest.raises(InputError, match="holds position; expected a diagnosis of a cylinder"):
        read_diagnosis(path, load_drive("bench"), "bench")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--between", "rotor_friction,backlash_error"], "no effect called rotor_friction"),
        (["--between", "backlash_error"], "expected two effects or more"),
        (["--between", ",".join(PAIR), "--speed", "9"], "--speed = 9: expected within"),
        (["--all", "--stroke-min", "-9"], "--stroke-min = -9: expected within"),
        (["--from", "missing.json"], "expected the JSON of ecyl diagnose"),
    ],
)
def test_bad_requests_are_one_clear_line(
    tmp_path: Path, words: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Exit 2, nothing written."""
    out = tmp_path / "motion.yaml"
    line = ["plan", "--drive", "bench", "--duration", "3", "--out", str(out), *words]
    assert main(line) == 2
    assert said in capsys.readouterr().err
    assert not out.exists()
