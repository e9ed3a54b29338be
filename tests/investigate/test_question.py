"""What a diagnosis leaves open, and what the loop does about it."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ecyl_ros.drive.drive_file import load_drive, resolve_drive
from ecyl_ros.drive.reference.planned import Planned
from ecyl_ros.effects.catalogue import CATALOGUE
from ecyl_ros.errors import InputError
from ecyl_ros.investigate import loop
from ecyl_ros.investigate.bounds import Bounds, Sample, bounds_for
from ecyl_ros.investigate.loop import Investigation, Settings
from ecyl_ros.investigate.played import Played
from ecyl_ros.investigate.question import question
from ecyl_ros.investigate.survey import survey
from ecyl_ros.plan.healthy import Healthy

DRIVE = load_drive("servo_1khz")
PAIR = ("load_coulomb_friction", "rotor_coulomb_friction")
HEALTHY = Healthy(0.01, 10.0, 50.0)


def _diagnosis(verdict: str, **more: Any) -> dict[str, Any]:
    made: dict[str, Any] = {
        "verdict": verdict,
        "causes": [],
        "location": {"signals": [{"name": "current_q"}]},
        "limits": [],
    }
    return made | more


def _cause(*alternatives: str) -> dict[str, Any]:
    return {
        "effect": PAIR[1],
        "parameters": {"coulomb_nm": {"value": 0.02}},
        "alternatives": list(alternatives),
    }


def test_a_cause_without_rivals_and_a_machine_that_hides_nothing_are_decided() -> None:
    """Nothing is open: no motion could add to it."""
    seen = [{"effect": name, "smallest_seen": 1.0} for name in CATALOGUE]
    assert question(_diagnosis("explained", causes=[_cause()])) is None
    assert question(_diagnosis("within_sheet", limits=seen)) is None
    assert question(_diagnosis("described")) is None


def test_what_is_open_is_asked_for() -> None:
    """Alternatives by pairs; what would not have shown, and what could not be judged, by itself."""
    asked = question(_diagnosis("explained", causes=[_cause(PAIR[0])]))
    assert asked is not None and asked.pairs == (PAIR,) and asked.known[PAIR[1]]
    hidden = [{"effect": PAIR[0], "smallest_seen": None}]
    asked = question(_diagnosis("no_gap", limits=hidden))
    assert asked is not None and asked.alone == (PAIR[0],)
    asked = question(_diagnosis("not_judgeable", reason="the rod rests"))
    assert asked is not None and set(asked.alone) == set(CATALOGUE) and asked.why == "the rod rests"


def _investigated(
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    answers: list[Any],
    motions: int = 4,
    ended: str | None = None,
    missed: Sequence[int | Exception] = (),
) -> tuple[Any, list[float], list[Any]]:
    """The story of diagnoses that come in turn; lengths of motions; what was planned for.

    missed: ticks that the drive misses in each motion, or what comes instead of it; then none.
    """
    lengths: list[float] = []
    planned: list[Any] = []

    def play(motion: Planned, bounds: Bounds, out: Path) -> Played:
        lengths.append(motion.duration_s)
        late = missed[len(lengths) - 1] if len(lengths) <= len(missed) else 0
        if isinstance(late, Exception):
            raise late
        out.write_text(f"played as number {len(lengths)}")
        return Played(out, 1000, 1e-3, 1.0, ended, True, late)

    def judged(recordings: Any, drive_file: Path, tell: Any) -> Any:
        data = answers[len(recordings) - 1]
        if isinstance(data, Exception):
            raise data
        return SimpleNamespace(
            to_dict=lambda: data,
            sentence=data["verdict"],
            verdict=data["verdict"],
            causes=(),
            write_json=lambda path: None,
            write_report=lambda path: None,
        )

    def make_plan(drive: Any, duration_s: float, pairs: Any, alone: Any, *_: Any, **__: Any) -> Any:
        planned.append((pairs, alone))
        motion, _ = survey(DRIVE, duration_s)
        return SimpleNamespace(motion=motion, pairs=(), alone=(), needed=0.1, predictions=())

    monkeypatch.setattr(loop, "judged", judged)
    monkeypatch.setattr(loop, "make_plan", make_plan)
    work = Investigation(
        DRIVE,
        resolve_drive("servo_1khz"),
        "a machine",
        folder / "found",
        Settings(motions=motions, duration_s=2.0),
        play,
        lambda line: None,
        lambda title: lambda share: None,
    )
    return work.run(), lengths, planned


OPEN = _diagnosis("explained", causes=[_cause(PAIR[0])])


def test_the_loop_plans_for_what_is_open_until_it_is_decided(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Survey, a motion for the pair, and one twice as long where that has not told."""
    answers = [OPEN, OPEN, _diagnosis("explained", causes=[_cause()])]
    story, lengths, planned = _investigated(tmp_path, monkeypatch, answers)
    assert (story.outcome, lengths) == ("decided", [2.0, 2.0, 4.0])
    assert planned == [((PAIR,), ())] * 2
    assert (tmp_path / "found" / "index.html").read_text().count("<h2>Motion") == 3


def test_the_loop_ends_with_its_budget_and_with_a_drive_that_was_stopped(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Still open, with the reason; what was ended is not diagnosed."""
    story, lengths, _ = _investigated(tmp_path / "a", monkeypatch, [OPEN] * 3, motions=2)
    assert (story.outcome, len(lengths)) == ("open", 2) and "budget of motions, 2" in story.said
    story, _, _ = _investigated(tmp_path / "b", monkeypatch, [], ended="current of 60 A")
    assert story.outcome == "ended" and "current of 60 A" in story.said
    assert story.steps[0].diagnosis is None


def test_a_motion_in_which_many_ticks_were_missed_is_played_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Once more, twice at the most, or not where the drive will not; every recording is kept."""
    every = DRIVE.telemetry_every
    many, few = 6 * every, 4 * every  # of 1000 samples
    refused = InputError("the drive is gone")
    for name, missed, wanted in (
        ("again", [many, few], ["", "_late_1"]),
        ("twice", [many, many, many], ["", "_late_1", "_late_2"]),
        ("refused", [many, refused], [""]),
    ):
        answers = [_diagnosis("explained", causes=[_cause()])]
        story, lengths, _ = _investigated(tmp_path / name, monkeypatch, answers, missed=missed)
        assert story.outcome == "decided" and len(lengths) == len(missed)
        kept = sorted((tmp_path / name / "found").glob("*.mcap"))
        assert [one.stem for one in kept] == [f"motion_1{end}" for end in wanted]
        assert kept[0].read_text() == f"played as number {len(wanted)}"


def test_a_planned_motion_too_near_the_limits_is_not_played(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The healthy drive would take more than four fifths of its current: the loop ends, and why."""
    close = Healthy(1e-3, 0.9 * DRIVE.controller.current_limit, 10.0)
    monkeypatch.setattr(loop, "Healthy", SimpleNamespace(on=lambda *_: close))
    story, lengths, _ = _investigated(tmp_path, monkeypatch, [OPEN])
    assert (story.outcome, len(lengths)) == ("open", 1)
    assert "four fifths of controller.current_limit" in story.said


def test_recordings_that_do_not_go_together_end_the_loop_with_what_was_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The story so far is kept, with the reason; of the first recording alone it is refused."""
    refused = InputError("a.mcap and b.mcap: expected recordings of one machine")
    story, lengths, _ = _investigated(tmp_path / "a", monkeypatch, [OPEN, refused])
    assert story.outcome == "open" and "recordings of one machine" in story.said
    assert len(lengths) == 2 and (tmp_path / "a" / "found" / "index.html").exists()
    with pytest.raises(InputError, match="one machine"):
        _investigated(tmp_path / "b", monkeypatch, [refused])


def test_every_bound_is_held_against_each_sample() -> None:
    """Stroke and speed of the reference, tracking error, current; a rod that is not measured."""
    bounds = bounds_for(DRIVE, HEALTHY, None, None)
    healthy = Sample(0.0, 0.01, 0.1, 0.011, 5.0)
    assert bounds.objection(healthy) is None
    for change, said in (
        ({"reference": 0.26}, "stroke"),
        ({"velocity": -0.6}, "m/s"),
        ({"rod": 0.05}, "tracking error of 40 mm, beyond 30 mm"),
        ({"rod": np.nan}, "tracking error"),
        ({"current": -58.0}, "current of 58 A, beyond 57 A"),
    ):
        assert said in (bounds.objection(dataclasses.replace(healthy, **change)) or ""), change


def test_bounds_that_the_healthy_drive_would_not_keep_are_refused() -> None:
    """Before anything moves: the flag, its value and what the model comes to."""
    for error, current, said in ((5e-3, None, "--max-error = 0.005"), (None, 9.0, "--max-current")):
        with pytest.raises(InputError, match=said):
            bounds_for(DRIVE, HEALTHY, error, current)


def test_the_first_motion_keeps_the_limits_and_is_refused_where_there_are_none() -> None:
    """Within stroke, speed, acceleration; a drive too weak for any motion gets one clear line."""
    motion, healthy = survey(DRIVE, 4.0)
    motion.check(DRIVE.limits, "survey")
    assert motion.moving_s <= 4.0 and motion.sample(4.0)[0] == pytest.approx(0.0, abs=1e-9)
    assert healthy.excess(DRIVE) is None
    weak = dataclasses.replace(DRIVE.controller, current_limit=1e-3)
    with pytest.raises(InputError, match="no motion leaves the healthy drive room"):
        survey(dataclasses.replace(DRIVE, controller=weak), 2.0)
