"""What a full cylinder's recording cannot decide between, and says so."""

from __future__ import annotations

import numpy as np
import pytest

from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.effects.catalogue import CATALOGUE
from ecyl_ros.gap.judge.verdict import named_cause, undecided
from ecyl_ros.gap.replay.evidence import gather
from ecyl_ros.gap.replay.replay import Replay
from ecyl_ros.plan.healthy import healthy_run
from ecyl_ros.plan.others import moves


def _cause(effect: str, sure: float, others: tuple[str, ...] = ()):
    return named_cause(effect, [], sure, others, 1.0, 1.0, needed="steps")


def test_a_cause_that_only_its_like_keeps_from_being_named_is_undecided() -> None:
    """0.49 beside one that is as good: both names and what would tell them; 0.2, or alone: none."""
    reason = undecided([_cause("actuation_delay", 0.49, ("current_gain_error",))])
    assert reason.startswith("actuation delay and current gain error look alike")
    assert "steps" in reason and "ecyl plan --from" in reason
    assert not undecided([_cause("actuation_delay", 0.2, ("current_gain_error",))])
    assert not undecided([_cause("actuation_delay", 0.49)])
    unsure = _cause("backlash_error", 0.3)
    assert not undecided([_cause("actuation_delay", 0.49, ("current_gain_error",)), unsure])


@pytest.mark.parametrize("effect", ["actuation_delay", "measurement_delay"])
def test_delays_are_tried_at_whole_control_ticks(effect: str) -> None:
    """One and two ticks, which drives have most, are among the starts: the fit has a valley at
    each of them, and at broken ticks the current is sampled off its mean."""
    drive = load_drive("bench")
    run = healthy_run(drive, moves(drive.limits, 2.0), 2.0)
    starts = CATALOGUE[effect].starts(gather(Replay(run, drive, "a.mcap"), {}))
    ticks = [start["delay_s"] * drive.controller.rate for start in starts]
    assert np.isclose(ticks, 1.0).any() and np.isclose(ticks, 2.0).any()
