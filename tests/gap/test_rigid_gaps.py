"""What a motion is taken to have been where nothing was recorded."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from rigid_machines import LINEAR, along, motion, recorded

from ecyl_ros.gap.rigid.grid import carried_on
from ecyl_ros.gap.rigid.motion import motion_of
from ecyl_ros.gap.rigid.offsets import without_offsets
from ecyl_ros.gap.rigid.terms import Catalogue

M = motion(0.1)


def test_a_parabola_is_carried_on_exactly() -> None:
    """Across gaps of 3 and 200 samples, as far as the file's numbers go."""
    time = np.arange(1000.0)
    values = 3.0 - 0.2 * time + 1e-3 * time**2
    known = np.ones(time.size, dtype=bool)
    known[100:103] = known[500:700] = False
    found = carried_on(np.where(known, values, -1e6), known, 10)
    assert np.allclose(found, values, rtol=0.0, atol=1e-6)


def test_a_gap_amid_the_motion_shakes_nothing_beside_it() -> None:
    """0.3 s left out at full speed: the acceleration beside stays within 2 % of its size."""
    recording = recorded(M, 20.0 * M.a, LINEAR, 0.3, 1e-8)
    fastest = int(np.argmax(np.abs(M.v[4000:16000]))) + 4000
    position = np.array(recording.rod_position_m)
    position[fastest : fastest + 300] = np.nan
    gappy = type(recording)(
        stamp_ns=recording.stamp_ns, rod_position_m=position, rod_force_n=recording.rod_force_n
    )
    moved = motion_of(gappy, LINEAR, "r")
    off = moved.acceleration - M.a
    assert not moved.usable[fastest : fastest + 300].any()
    assert np.abs(off[moved.usable]).max() < 0.02 * np.abs(M.a).max()


def test_the_integral_of_a_gap_is_told_while_the_output_moves() -> None:
    """An offset of 5 N after a gap: taken away within 1 %, whatever friction holds at rest."""
    loop = dataclasses.replace(
        LINEAR, actuation="loop", coulomb=3.0, position_kp=30.0, speed_kp=600.0, speed_ki=1e4
    )
    m = along(np.where(np.sin(2.0 * M.t) > 0.0, 0.1 * np.sin(6.0 * M.t) ** 3, 0.0))
    gap = slice(7_000, 7_300)
    held = np.where(m.v == 0.0, 3.0 * np.sin(m.t), 3.0 * np.sign(m.v))
    recording = recorded(m, 20.0 * m.a + held + 5.0 * (m.t > 7.15), LINEAR, 0.3, 1e-8)
    position = np.array(recording.rod_position_m)
    position[gap] = np.nan
    recording = dataclasses.replace(recording, rod_position_m=position)
    moved = motion_of(recording, LINEAR, "r")
    freed = without_offsets(moved, Catalogue(moved, loop).along)
    taken = (moved.effort - freed.effort)[moved.time_s > 7.5]
    assert taken == pytest.approx(np.full(taken.size, 5.0), rel=0.01)
