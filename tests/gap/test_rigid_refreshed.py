"""Rigid drives whose effort is refreshed more slowly than the motion is logged."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from rigid_machines import LINEAR, RATE_HZ, causes, motion, recorded

from ecyl_ros.errors import InputError
from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.gap.rigid.refreshed import new_rows

M = motion(0.1)
S = np.sign(M.v)
RNG = np.random.default_rng(5)


def _held(values: np.ndarray, every: int, first: int = 3) -> np.ndarray:
    """The last of every so many values."""
    return values[np.maximum((np.arange(values.size) - first) // every, 0) * every + first]


def test_rows_with_a_new_effort_are_found() -> None:
    """Held for 8 rows, or 7 and 8 by turns: each row where it is new, and no other."""
    noisy = 20.0 * M.a + 9.0 * S + RNG.normal(size=M.t.size)
    found = new_rows(_held(noisy, 8), M.q)
    assert found is not None and set(np.diff(found)) == {8} and found[0] == 11
    lasts = np.cumsum(np.tile([7, 8], 1200))
    rows = np.searchsorted(lasts, np.arange(M.t.size), side="right")
    found = new_rows(noisy[lasts[np.maximum(rows - 1, 0)]], M.q)
    assert found is not None and set(np.diff(found)) == {7, 8}


@pytest.mark.parametrize("kind", ["fresh", "coarse", "at rest", "creeping", "by two", "relay"])
def test_an_effort_that_waits_for_a_step_or_a_motion_is_no_held_one(kind: str) -> None:
    """New in each row, rounded to 4 N, equal where nothing moves, of a P loop whose encoder rests
    every fourth row and then for long, held for two rows, a relay's on even stamps: all taken."""
    effort = 20.0 * M.a + 9.0 * S + 0.3 * RNG.normal(size=M.t.size)
    place = M.q
    if kind == "coarse":
        effort = np.round((20.0 * M.a + 9.0 * np.tanh(M.v / 0.05)) / 4.0) * 4.0
    if kind == "at rest":
        resting = np.arange(M.t.size) % 2000 < 1500
        effort, place = np.where(resting, 5.0, effort), np.where(resting, 0.1, M.q)
    if kind == "creeping":
        counts = RNG.integers(1, 4, M.t.size)
        counts[(np.arange(M.t.size) % 4 == 0) | (np.arange(M.t.size) % 2000 > 600)] = 0
        counts[np.arange(M.t.size) % 4000 >= 2000] *= -1
        place = 5e-5 * np.cumsum(counts)
        effort = 40.0 * (0.1 - place)
    if kind == "relay":
        effort = np.where(np.arange(M.t.size) % 66 < 33, 13.0, -13.0)
        effort = np.interp(M.t + 4e-4, M.t, effort)
    if kind == "by two":
        effort = _held(effort, 2)
    assert new_rows(effort, place) is None


def test_friction_is_found_in_an_effort_that_is_refreshed_slowly() -> None:
    """Every 20 ms at 1 kHz: Coulomb friction within its interval, and a note that says so."""
    fresh = recorded(M, 20.0 * M.a + 9.0 * S, LINEAR, 0.3, 1e-6)
    slow = dataclasses.replace(fresh, rod_force_n=_held(np.array(fresh.rod_force_n), 20))
    result = diagnose(slow, LINEAR)
    assert set(causes(result)) == {"load_coulomb_friction"}
    (level,) = causes(result)["load_coulomb_friction"].parameters
    assert level.low <= 9.0 <= level.high
    assert any("new only every 20 ms" in note for note in result.notes)


def test_an_effort_that_is_hardly_ever_new_is_refused_with_the_reason() -> None:
    """Every 0.2 s of 20 s: too few, and the line says how often it is new."""
    fresh = recorded(M, 20.0 * M.a + 9.0 * S, LINEAR, 0.3, 1e-6)
    slow = dataclasses.replace(
        fresh, rod_force_n=_held(np.array(fresh.rod_force_n), int(0.2 * RATE_HZ))
    )
    with pytest.raises(InputError, match=r"or an effort that is new more often than every 0\.2 s"):
        diagnose(slow, LINEAR)


@pytest.mark.parametrize("referred", [False, True])
def test_friction_is_found_in_a_motion_that_is_refreshed_slowly(referred: bool) -> None:
    """All that is measured is new every 10 ms at 1 kHz, beside a reference that is new in each row,
    or without one: Coulomb friction within its interval, and a note that says so."""
    fresh = recorded(M, 20.0 * M.a + 9.0 * S, LINEAR, 0.3, 1e-6)
    asked = {"reference_position_m": M.q, "reference_velocity_m_per_s": M.v} if referred else {}
    slow = dataclasses.replace(
        fresh,
        rod_force_n=_held(np.array(fresh.rod_force_n), 10),
        rod_position_m=_held(np.array(fresh.rod_position_m), 10),
        **asked,
    )
    result = diagnose(slow, LINEAR)
    assert set(causes(result)) == {"load_coulomb_friction"}
    (level,) = causes(result)["load_coulomb_friction"].parameters
    assert level.low <= 9.0 <= level.high
    assert any("the position is new only every 10 ms" in note for note in result.notes)
