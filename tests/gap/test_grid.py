"""Where a recording's stamps and reference lie on the samples that a replay computes."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from ecyl_ros.gap.replay.grid import Grid
from ecyl_ros.recording.signals import Recording

CONTROL_HZ = 10_000.0


def _recording(time_s: np.ndarray) -> Recording:
    """One whose reference is a cubic in time, 1, 2, 3 and 4 times its powers."""
    known = {
        "reference_position_m": 1.0 + 2.0 * time_s + 3.0 * time_s**2 + 4.0 * time_s**3,
        "reference_velocity_m_per_s": 2.0 + 6.0 * time_s + 12.0 * time_s**2,
    }
    return Recording(stamp_ns=np.round(1e9 * time_s).astype(np.int64), **known)


@pytest.mark.parametrize("every", [1, 10, 40])
def test_even_stamps_are_rows_of_the_grid(every: int) -> None:
    """Whole ticks apart, each stamp at its row, and nothing interpolated."""
    time_s = np.arange(500) * every / CONTROL_HZ
    grid = Grid.under(time_s, CONTROL_HZ / every, CONTROL_HZ)
    assert grid.every == every and grid.samples == 500 and grid.ticks == 499 * every + 1
    columns = np.random.default_rng(1).standard_normal((500, 2))
    assert np.array_equal(grid.on_stamps(columns), columns.T)


def test_stamps_at_a_low_rate_with_gaps_keep_their_rows() -> None:
    """At 250 Hz with a sixth missing, by whose count the rate is no part of the controller's."""
    time_s = np.delete(np.arange(1200) * 4e-3, np.arange(100, 300))
    grid = Grid.under(time_s, 1000 / 4.8, CONTROL_HZ)
    assert grid.rows is not None
    assert np.allclose(grid.rows * grid.step_s, time_s, atol=1e-12)


def test_uneven_stamps_are_interpolated_on_a_fine_grid() -> None:
    """A smooth curve comes out at the stamps to a millionth."""
    time_s = np.sort(np.random.default_rng(2).uniform(0.0, 2.0, 900))
    time_s -= time_s[0]
    grid = Grid.under(time_s, 450.0, CONTROL_HZ)
    assert grid.rows is None and grid.step_s == pytest.approx(1e-3)
    course = np.sin(9.0 * grid.instants()[:-1])
    assert np.allclose(grid.on_stamps(course[:, None])[0], np.sin(9.0 * time_s), atol=1e-6)


def test_a_run_that_ran_away_is_carried_to_uneven_stamps() -> None:
    """No spline goes through values that are not finite: they stay so, the others stay near."""
    recording = _recording(np.cumsum(np.full(200, 1.07e-3)))
    grid = Grid.under(recording.time_s, 1000.0, 20_000.0)
    assert grid.rows is None
    columns = np.linspace(0.0, 1.0, grid.ticks // grid.every + 1)[:, None] * np.ones(2)
    columns[columns.shape[0] // 2 :, 1] = np.inf
    first, second = grid.on_stamps(columns)
    assert np.all(np.isfinite(first)) and np.all(np.diff(first) >= 0.0)
    assert np.isfinite(second[0]) and not np.isfinite(second[-1])


def test_the_reference_between_stamps_is_the_cubic_that_both_ends_tell() -> None:
    """A reference that is a cubic in time comes out exactly, stamped every 4 ms or unevenly."""
    for time_s in (np.arange(251) * 4e-3, np.cumsum(np.r_[0.0, np.tile([1e-3, 7e-3], 125)])):
        grid = Grid.under(time_s, 250.0, CONTROL_HZ)
        within = grid.instants() <= time_s[-1]
        true = _recording(grid.instants()[within])
        found = grid.reference(_recording(time_s))[within]
        assert within.sum() >= 251
        assert np.allclose(found[:, 0], true.reference_position_m, rtol=1e-12)
        assert np.allclose(found[:, 1], true.reference_velocity_m_per_s, rtol=1e-9)


def test_jitter_of_the_stamps_is_none_of_the_reference() -> None:
    """Sampled at ticks and stamped 0.2 us off them, at 250 Hz: the reference is that of the ticks,
    to a thousandth of what it moves in such a time."""
    ticks = np.arange(251) * 4e-3
    jitter = 2e-7 * np.random.default_rng(4).standard_normal(ticks.size)
    stamps = ticks + jitter - jitter[0]
    told = dataclasses.replace(_recording(ticks), stamp_ns=np.round(1e9 * stamps).astype(np.int64))
    grid = Grid.under(stamps, 250.0, CONTROL_HZ)
    true = _recording(grid.instants()[:-1]).reference_position_m
    found = grid.reference(told)[:-1, 0]
    assert np.allclose(found[:-1], true[:-1], rtol=0.0, atol=2e-10)


def test_a_shorter_grid_ends_with_its_last_stamp() -> None:
    """The rows of the stamps kept are those they had."""
    time_s = np.arange(1000) * 1e-3
    grid = Grid.under(time_s, 1000.0, CONTROL_HZ)
    kept = np.arange(0, 300)
    short = grid.of(kept).ended()
    assert grid.of(kept).samples == 1000 and short.samples == 300
    assert np.array_equal(short.rows, grid.rows[kept])
