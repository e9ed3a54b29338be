"""Replays that run away from what was recorded."""

from __future__ import annotations

import json

import numpy as np
import pytest

from ecyl_ros.gap.diagnosis import SignalGap
from ecyl_ros.gap.rigid.replay import Replay
from ecyl_ros.gap.rigid.runaway import ran_away, without_runaways

RECORDED = 0.3 * np.sin(0.1 * np.arange(500))


def _played(before: float, after: float) -> Replay:
    signals = tuple(
        SignalGap(name, unit, before, after, 0.01)
        for name, unit in (("position", "rad"), ("speed", "rad/s"))
    )
    rows = np.stack([RECORDED, RECORDED])
    return Replay(signals, rows, rows + before, rows + after)


@pytest.mark.parametrize(
    ("before", "after", "told"),
    [
        (0.5, 0.1, (0.5, 0.1, 0.01)),
        (88.0, 0.1, (None, 0.1, 0.01)),
        (88.0, 70.0, (None, None, None)),
    ],
)
def test_what_is_off_by_more_than_the_travel_has_no_figures(before, after, told) -> None:
    """A travel of 0.6 rad: 0.5 rad off is a figure, 88 rad is a replay that runs away, which is
    null in JSON; the figures of the other run stay."""
    played = _played(before, after)
    found = without_runaways(played, ran_away(played, np.ones(500, dtype=bool)))
    for one in found.signals:
        data = json.loads(json.dumps(one.as_json(), allow_nan=False))
        assert (data["gap"], data["after"], data["floor"]) == told
    assert np.isnan(found.before).all() == (told[0] is None)
    assert any("runs away" in note for note in found.notes) == (told[0] is None)
