"""What was found on some of the recordings is not searched for again on all of them."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence

import pytest
from short_motions import DRIVE, recorded

from ecyl_ros.gap.compete.candidates import Candidates
from ecyl_ros.gap.compete.carried import carried_over
from ecyl_ros.gap.compete.compete import compete
from ecyl_ros.gap.compete.competition import Competition
from ecyl_ros.gap.compete.forms import Forms
from ecyl_ros.gap.fit.fit import Fitter
from ecyl_ros.gap.replay.replay import Replay
from ecyl_ros.gap.several.joined_replay import JoinedReplay

FRICTION, LOAD = "rotor_coulomb_friction", "constant_load"
NAMES = (FRICTION, LOAD, "load_coulomb_friction", "rotor_viscous_friction")


def _fitter(numbers: Sequence[int], effects: Mapping[str, Mapping[str, float]]) -> Fitter:
    """Of recordings of one machine on some of the motions."""
    parts = [Replay(recorded(number, effects), DRIVE, f"{number}") for number in numbers]
    replay = JoinedReplay(parts)
    return Fitter(replay, replay.held_out())


def _competition(fitter: Fitter, begun: Competition | None = None) -> Competition:
    return compete(fitter, NAMES, lambda stage, share: None, begun)


@pytest.fixture(scope="module")
def begun() -> Competition:
    """Of a friction of 0.11 N m in two recordings."""
    return _competition(_fitter((0, 1), {FRICTION: {"coulomb_nm": 0.11}}))


def test_what_two_recordings_named_is_fitted_to_all_three(begun: Competition) -> None:
    """The same cause as by a search, the true size, the same next best; a third fewer replays."""
    searched, carried = (_fitter((0, 1, 2), {FRICTION: {"coulomb_nm": 0.11}}) for _ in range(2))
    by_search, found = _competition(searched), _competition(carried, begun)
    assert found.winner.names == by_search.winner.names == (FRICTION,)
    assert found.winner.values[FRICTION]["coulomb_nm"] == pytest.approx(0.11, rel=0.01)
    assert found.winner.judged == pytest.approx(by_search.winner.judged, rel=0.02)
    assert found.rivals[0].names == by_search.rivals[0].names
    assert carried.replay.runs < 0.67 * searched.replay.runs


def test_what_they_named_is_dropped_where_it_is_not_enough(begun: Competition) -> None:
    """A machine under a constant load, of which two recordings are said to have named friction:
    nothing is carried over, and the search finds the load."""
    fitter = _fitter((0, 1, 2), {LOAD: {"force_n": 60.0}})
    field = Candidates(fitter, NAMES)
    only = dataclasses.replace(begun, singles=(begun.winner,), rivals=())
    assert carried_over(field, Forms(field), only) is None
    assert _competition(fitter, only).winner.names == (LOAD,)
