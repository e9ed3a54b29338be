"""The floor of a rigid drive against noise that was put in."""

from __future__ import annotations

import dataclasses
import warnings

import numpy as np
import pytest
from rigid_machines import LINEAR, ROTARY, along, motion, recorded

from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.gap.diagnosis import VERDICTS
from ecyl_ros.gap.rigid.band import position_noise
from ecyl_ros.gap.rigid.motion import motion_of
from ecyl_ros.gap.rigid.noise import acceleration_noise
from ecyl_ros.gap.rigid.white import least_density

M = motion(0.1)
S = np.sign(M.v)


@pytest.mark.parametrize("noise", [0.1, 0.5])
def test_fast_true_effort_is_no_noise(noise) -> None:
    """Beside strong effort at 100 to 250 Hz and blows, the noise is found within 20 %."""
    rng = np.random.default_rng(4)
    effort = 20.0 * M.a + 9.0 * S + noise * rng.normal(size=M.t.size)
    effort += 5.0 * np.sin(2.0 * np.pi * (100.0 * M.t + 75.0 * M.t**2 / 20.0))  # 100 to 250 Hz
    effort[::4000] += 300.0
    found = least_density(effort, np.ones(M.t.size, dtype=bool), 1000.0, 20.0)
    # One-sided: all of the variance lies up to 500 Hz.
    assert np.sqrt(500.0 * found) == pytest.approx(noise, rel=0.2)


def test_white_noise_alone_is_neither_over_nor_underrated() -> None:
    """The least of the estimates is not biased: right within 5 % in the mean over seeds."""
    usable = np.ones(6000, dtype=bool)
    usable[2000:2050] = False
    found = [
        least_density(np.random.default_rng(seed).normal(size=6000), usable, 200.0, 20.0)
        for seed in range(60)
    ]
    assert np.mean(found) == pytest.approx(1.0 / 100.0, rel=0.05)


def test_a_floor_that_a_model_falls_below_is_found_anew() -> None:
    """A noise stated 100 times too large hides no friction: it is named with its level."""
    machine = dataclasses.replace(LINEAR, effort_noise=30.0)
    result = diagnose(recorded(M, 20.0 * M.a + 9.0 * S, machine, 0.3, 1e-6), machine)
    assert [one.effect for one in result.causes] == ["load_coulomb_friction"]
    assert result.causes[0].parameters[0].value == pytest.approx(9.0, rel=0.02)
    assert result.verdict == "explained"


def test_noise_of_the_position_is_noise_of_the_balance() -> None:
    """A coarse encoder alone: the noise foretold is what differentiating it leaves, within 20 %."""
    machine = dataclasses.replace(LINEAR, bandwidth_hz=30.0)
    for step in (1e-5, 4e-5):
        moved = motion_of(recorded(M, 20.0 * M.a, machine, 0.0, step), machine, "r")
        exact = motion_of(recorded(M, 20.0 * M.a, machine, 0.0, 1e-12), machine, "r")
        off = moved.filtered(moved.acceleration) - exact.filtered(exact.acceleration)
        left = float(np.std(off[moved.usable[moved.rows]]))
        assert acceleration_noise(moved) == pytest.approx(left, rel=0.2)


def test_a_gap_in_a_recording_is_no_noise() -> None:
    """Half a second left out while it moves on: the noise found is that of the encoder."""
    step = 1e-5
    position = step * np.round(M.q / step)
    usable = (M.t < 7.0) | (M.t > 7.5)
    assert position_noise(position, 1000.0, usable) == pytest.approx(step / 12**0.5, rel=0.2)


def test_rounding_of_a_slow_encoder_is_no_gap() -> None:
    """A machine as its file has it, by counts so coarse that their noise is not white: no cause,
    and no gap."""
    coarse = dataclasses.replace(LINEAR, coulomb=9.0, position_resolution=2e-3)
    result = diagnose(recorded(M, 20.0 * M.a + 9.0 * S, coarse, 0.05, 2e-3), coarse)
    assert result.verdict in ("no_gap", "within_sheet")


def test_an_effort_that_a_set_gives_to_the_last_digit_is_fitted() -> None:
    """A command that holds, without noise: what is left is rounding, and nothing overflows."""
    t = np.arange(12_000) / 1000.0
    m = along(1.0 - np.exp(-t / 0.2))
    machine = dataclasses.replace(ROTARY, inertia=None, gain=1.0, actuation="voltage")
    recording = recorded(m, np.where(t < 0.5, 0.0, 0.25), machine, 0.0, 1e-9)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        result = diagnose(recording, machine)
    assert result.verdict in VERDICTS
