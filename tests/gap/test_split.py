"""Stretches that are fitted and stretches that are judged: each sees the gap."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from sheets import exact
from small_field import without_all_but

from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.gap.fit.fit import Fitter
from ecyl_ros.gap.replay.replay import Replay
from ecyl_ros.gap.split import held_out, held_out_of
from ecyl_ros.gap.study.cylinder.cases import Case, record_case

time_s = np.arange(12_000) / 1000.0
everywhere = np.ones(time_s.size, dtype=bool)
SUPPLY_V = 4.08245490297507
WITHOUT = without_all_but(
    "voltage_limit",
    "current_limit",
    "back_emf_error",
    "resistance_error",
    "inverter_dead_time",
    "rotor_viscous_friction",
)


def gap_between(begin: float, end: float) -> np.ndarray:
    """Noise in two signals, and in one of them ten floors from `begin` to `end`, s."""
    gap = np.random.default_rng(1).standard_normal((2, time_s.size))
    gap[1, (time_s >= begin) & (time_s < end)] += 10.0
    return gap


def test_one_stretch_in_three_is_judged() -> None:
    """The second half second of every one and a half."""
    assert np.array_equal(held_out(time_s), (time_s % 1.5 >= 0.5) & (time_s % 1.5 < 1.0))


@pytest.mark.parametrize(
    "begin", [0.1, 0.6, 1.1, 6.25], ids=["fitted", "judged", "fitted 2", "judged 2"]
)
@pytest.mark.parametrize("length", [0.06, 0.15, 0.35])
def test_a_gap_of_a_moment_is_both_fitted_and_judged(begin: float, length: float) -> None:
    """Wherever it lies in the stretches of half a second, a tenth of it at least on each side."""
    inside = (time_s >= begin) & (time_s < begin + length)
    chosen = held_out_of(time_s, gap_between(begin, begin + length), everywhere)
    assert 0.1 < np.mean(chosen[inside]) < 0.9
    assert np.mean(chosen) == pytest.approx(1.0 / 3.0, abs=0.02)


def test_a_gap_all_through_keeps_long_stretches() -> None:
    """And so do noise alone, and a gap of a sample that no cut divides."""
    for begin, end in ((0.0, 12.0), (2.0, 2.0), (3.0, 3.001)):
        assert np.array_equal(
            held_out_of(time_s, gap_between(begin, end), everywhere), held_out(time_s)
        )


def test_stretches_are_cut_anew_for_what_a_fit_leaves() -> None:
    """A moment within one stretch, seen once the sheet is fitted, comes to lie on both sides.

    A fit that leaves what was left before changes nothing.
    """
    drive = exact("bench")
    recording = record_case(Case(0, 5, "none"), drive)
    replay = Replay(recording, drive, "a healthy machine")
    fitter = Fitter(replay, replay.held_out())
    first = fitter.nominal
    assert np.array_equal(fitter.held, held_out(replay.time_s))
    assert not fitter.divided_by(first)
    moment = (replay.time_s >= 0.6) & (replay.time_s < 0.75)
    assert fitter.held[moment].all()
    left = first.gap + 10.0 * moment
    assert fitter.divided_by(dataclasses.replace(first, gap=left))
    assert 0.1 < np.mean(fitter.held[moment]) < 0.9
    assert np.array_equal(fitter.rows, ~fitter.held & replay.usable)
    assert fitter.nominal.judged != first.judged


@pytest.mark.slow
def test_a_limit_that_is_reached_once_is_named() -> None:
    """A supply that one move of the whole recording reaches, within two parts in a thousand."""
    drive = exact("bench")
    true = {"voltage_limit": {"voltage_v": SUPPLY_V}}
    recording = record_case(Case(0, 1721234942, "single", true), drive).slice(0.0, 6.0)
    found = diagnose(recording, drive, without=WITHOUT)
    assert [one.effect for one in found.causes] == ["voltage_limit"]
    (value,) = found.causes[0].parameters
    assert value.value == pytest.approx(SUPPLY_V, rel=2e-3)
