"""A recorded speed beside a position: whether both tell of one motion, in one unit."""

from __future__ import annotations

import numpy as np
import pytest
from rigid_machines import RATE_HZ, motion

from ecyl_ros.gap.rigid.other_motion import told_beside

M = motion(0.1)
RNG = np.random.default_rng(8)
NOISY = M.q + 5e-3 * RNG.standard_normal(M.q.size)  # its rate holds a hundred times the speed
ALL = np.ones(M.q.size, dtype=bool)


def test_a_speed_with_an_offset_agrees_with_a_noisy_position() -> None:
    """Integrated, it tells of the same motion; nothing is said."""
    told = told_beside(M.v + 0.01, NOISY, ALL, RATE_HZ)
    assert told.agrees and not told.caution and not told.note
    assert told.times == pytest.approx(1.0, abs=0.01)


def test_a_speed_whose_offset_wanders_agrees() -> None:
    """Over the whole run its integral drifts away by as much as the motion; piece by piece it tells
    of the same motion, and at its own scale."""
    wander = 0.15 * np.std(M.q) * np.cumsum(RNG.standard_normal(M.q.size)) / np.sqrt(RATE_HZ)
    told = told_beside(M.v + wander, M.q + 5e-4 * RNG.standard_normal(M.q.size), ALL, RATE_HZ)
    assert told.agrees and not told.caution and not told.note


def test_a_speed_of_another_gear_is_told_in_noise_and_across_gaps() -> None:
    """0.6 times as fast, with a fifth of the samples unusable: by how much, and not used."""
    usable = np.arange(M.q.size) % 1000 < 800
    told = told_beside(0.6 * M.v, NOISY, usable, RATE_HZ)
    assert not told.agrees and not told.note
    assert "the recorded speed is 0.6 times the rate of the position" in told.caution


def test_at_one_speed_the_way_itself_tells() -> None:
    """A run at 0.3 m/s one way: half of it is told."""
    place = 0.3 * M.t
    told = told_beside(np.full(M.t.size, 0.15), place, ALL, RATE_HZ)
    assert told.times == pytest.approx(0.5, rel=0.01) and told.caution


def test_a_speed_of_another_part_does_not_agree() -> None:
    """It is said, and not used."""
    told = told_beside(motion(0.1, seed=9).v, M.q, ALL, RATE_HZ)
    assert not told.agrees and not told.caution
    assert "does not go with the position" in told.note
