"""Flanks that rattle make a comb of valleys along a size: the deepest of them is sought."""

from __future__ import annotations

import pytest

from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.drive.reference.spec import make_reference
from ecyl_ros.effects.catalogue import CATALOGUE
from ecyl_ros.gap.fit.coordinate import Coordinate
from ecyl_ros.gap.fit.fit import Fitter
from ecyl_ros.gap.fit.valley import along
from ecyl_ros.gap.replay.replay import Replay
from ecyl_ros.plan.healthy import healthy_run

WORN, SOUND = load_drive("worn_1khz"), load_drive("servo_1khz")


@pytest.mark.parametrize("start", [0.0054, 0.0088, 0.0176])
def test_the_deepest_valley_of_a_comb_is_found_from_any_other(start: float) -> None:
    """Along the backlash of a worn drive that rattles, from valleys beside the true one: the true
    backlash within 2 %."""
    moves = "moves:positions=0.004;-0.003;0.002;-0.001,speed=0.05,acceleration=1,jerk=50,dwell=0.1"
    run = healthy_run(WORN, make_reference(moves, WORN, 4.0), 4.0)
    replay = Replay(run, SOUND, "worn.mcap")
    fitter = Fitter(replay, replay.held_out())
    assert fitter.amplified
    (quantity,) = CATALOGUE["backlash_error"].parameters
    begun = fitter.evaluate({"backlash_error": {quantity.name: start}})
    found = along(fitter, begun, Coordinate.around("backlash_error", quantity, start))
    true = WORN.effects["backlash_error"][quantity.name]
    assert found.values["backlash_error"][quantity.name] == pytest.approx(true, rel=0.02)
