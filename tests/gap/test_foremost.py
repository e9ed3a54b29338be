"""Which starts go on: those that promise most, and what a replay has shown beside them."""

from __future__ import annotations

import dataclasses

from other_make import replayed

from ecyl_ros.gap.compete.promise import Promise, foremost
from ecyl_ros.gap.fit.fit import Fitter
from ecyl_ros.gap.split import held_out


def test_what_a_replay_has_shown_goes_on_beside_what_is_promised() -> None:
    """Of four that promise less than two others, the two go on whose replays leave least, and none
    that leaves more than its base."""
    replay = replayed({"constant_load": {"force_n": -150.0}}, seed=6)
    base = Fitter(replay, held_out(replay.time_s)).nominal

    def start(promised: float, left: float) -> Promise:
        fit = dataclasses.replace(base, fitted=left * base.fitted)
        return Promise(promised * base.fitted, 1.0, fit, base)

    promised = [start(0.2, 2.0), start(0.3, 1.5)]
    shown = [start(0.4, 0.9), start(0.5, 1.1), start(0.6, 0.5), start(0.7, 0.95)]
    assert foremost([*promised, *shown], 2) == [*promised, shown[2], shown[0]]
    assert foremost(promised, 2) == promised
