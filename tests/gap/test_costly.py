"""What replays cost: too much for sets of three, which the diagnosis says, or for any replay."""

from __future__ import annotations

import numpy as np
import pytest
from other_make import DRIVE, replayed

from ecyl_ros.gap.compete import candidates
from ecyl_ros.gap.compete.compete import compete
from ecyl_ros.gap.fit.fit import Fitter
from ecyl_ros.gap.split import held_out

TRUE = {
    "rotor_coulomb_friction": {"coulomb_nm": 0.1},
    "load_viscous_friction": {"viscous_nm_s_per_rad": 0.008},
    "load_inertia_error": {"inertia_kg_m2": 0.0021},
}


def test_the_search_ends_at_two_causes_where_replays_cost_too_much(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Three causes and no work to spare: no more than two are named, and the rest is told."""
    monkeypatch.setattr(candidates, "_ENOUGH_WORK_PER_S", 0.0)
    replay = replayed(TRUE, seed=7, end_s=3.0)
    fitter = Fitter(replay, held_out(replay.time_s))
    found = compete(fitter, tuple(TRUE), lambda stage, share: None)
    assert len(found.winner.names) <= 2
    assert found.unsearched == 3


def test_what_is_stiff_within_a_step_counts_as_more_work() -> None:
    """A dead time, which takes parts of a sub-step in small currents, costs more than a spring."""
    replay = replayed(TRUE, seed=7, end_s=None)
    before = replay.work
    replay.run({"spring_load": {"stiffness_n_per_m": 1e4}})
    spring = replay.work - before
    replay.run(
        replay.complete({"inverter_dead_time": {"voltage_v": 2.25, "transition_a": 0.005}}, {})
    )
    assert replay.work - before - spring > 1.2 * spring > 0


def test_a_drive_that_no_recording_is_of_is_not_simulated() -> None:
    """A load of a hundred-thousandth counts as a loop that runs away; one of a sixtieth is run."""
    replay = replayed(TRUE, seed=7, end_s=None)
    before, inertia = replay.work, DRIVE.load.inertia
    lost = replay.gap({"load_inertia_error": {"inertia_kg_m2": 1e-5 * inertia}})
    assert replay.work == before
    assert np.all(lost[:, replay.usable] == 1e6)
    light = replay.gap({"load_inertia_error": {"inertia_kg_m2": inertia / 60.0}})
    assert replay.work > before
    assert np.abs(light).max() < 1e6
