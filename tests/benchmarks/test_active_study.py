"""The active study: what counts as which answer, and the motions it begins with."""

from __future__ import annotations

import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.errors import InputError
from ecyl_ros.gap.study.case import Case
from ecyl_ros.gap.study.cylinder.stage import Setup

FOLDER = str(Path(__file__).parents[2] / "benchmarks")
FAULTY = Case(0, 1, "single", {"backlash_error": {"backlash_rad": 0.01}})
HEALTHY = Case(1, 1, "none")


@pytest.fixture
def study(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """The benchmark's module, which belongs to no package."""
    monkeypatch.syspath_prepend(FOLDER)
    import active_study

    monkeypatch.delitem(sys.modules, "active_study")
    return active_study


def _said(verdict: str, *named: str, alternatives: tuple[str, ...] = ()) -> dict[str, object]:
    causes = [
        {"effect": one, "confidence": 0.9, "parameters": {}, "alternatives": list(alternatives)}
        for one in named
    ]
    return {
        "verdict": verdict,
        "causes": causes,
        "location": {"signals": [{"name": "current_q"}]},
        "limits": [],
    }


def test_an_answer_is_right_only_if_it_names_the_fault_and_leaves_nothing_open(
    study: ModuleType,
) -> None:
    """A fault named with an alternative is undecided, beside another name it is wrong."""
    fault = "backlash_error"
    for said, wanted in (
        (_said("explained", fault), "right"),
        (_said("explained", fault, alternatives=("lead_error",)), "undecided"),
        (_said("explained", fault, "lead_error"), "wrong"),
        (_said("unexplained"), "undecided"),
        (_said("within_sheet"), "missed"),
    ):
        assert study.answer(FAULTY, said, planned=True) == wanted


def test_a_healthy_machine_is_decided_once_a_motion_was_planned_for_what_is_hidden(
    study: ModuleType,
) -> None:
    """An effect that no size of would have shown asks for a motion, and for no second one."""
    said = _said("no_gap")
    said["limits"] = [{"effect": "backlash_error", "smallest_seen": None}]
    assert study.answer(HEALTHY, said, planned=False) == "undecided"
    assert study.answer(HEALTHY, said, planned=True) == "right"


def test_recordings_that_are_refused_decide_nothing(study: ModuleType) -> None:
    """Of two machines, say: the study goes on."""
    said = study.refused(InputError("first and planned: expected recordings of one machine"))
    assert study.answer(HEALTHY, said, planned=True) == "undecided"


def test_poor_motions_begin_at_rest_and_keep_the_limits(study: ModuleType) -> None:
    """Of the drive as the study's motions use it."""
    drive = study.limited(load_drive("bench"))
    for motion in study.POOR.values():
        position, velocity = study.ticked(motion, study.FIRST_S, Setup(drive))
        faster = np.diff(velocity) * drive.controller.rate
        assert position[0] == pytest.approx(0.0, abs=1e-9)
        assert velocity[0] == pytest.approx(0.0, abs=1e-9)
        assert np.max(np.abs(velocity)) <= drive.limits.speed
        assert np.max(np.abs(faster)) <= drive.limits.acceleration * (1.0 + 1e-6)
