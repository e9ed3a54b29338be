"""An effort that shows nothing of the motion is no load: something else moves the output."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from rigid_machines import RATE_HZ, ROTARY, along, causes, motion, recorded

from ecyl_ros.gap.diagnose import diagnose

TORQUE_NM, NOISE_NM = 0.9, 0.003
UNSTATED = dataclasses.replace(ROTARY, inertia=None)


@pytest.mark.parametrize("cogging_nm", [0.0, 0.02])
def test_a_torque_at_its_limit_while_the_output_swings_is_not_called_a_load(cogging_nm) -> None:
    """Constant whatever the acceleration is: no inertia, no friction, so no cause either; a wave
    about it says nothing of its mean."""
    m = motion(0.8)
    effort = TORQUE_NM + cogging_nm * np.sin(24.0 * m.q)
    result = diagnose(recorded(m, effort, UNSTATED, NOISE_NM, 1e-5), UNSTATED)
    assert result.verdict == "not_judgeable" and not result.causes
    assert "the torque shows nothing of the motion" in result.reason


def test_a_constant_current_and_even_acceleration_are_not_called_friction() -> None:
    """A step of current from rest, friction 0.3 of it, the inertia left out of the file: with all
    of the current as friction the fit is as good, so that neither is named."""
    rest, run_s, inertia, coulomb, viscous = 0.5, 8.0, 0.5, 0.3, 0.02
    t = np.arange(int((rest + run_s) * RATE_HZ)) / RATE_HZ
    current = (t >= rest).astype(float)
    decay = viscous / inertia  # J dv/dt = 1 - C - B v, from rest
    past = np.maximum(t - rest, 0.0)
    v = (1.0 - coulomb) / viscous * (1.0 - np.exp(-decay * past))
    machine = dataclasses.replace(UNSTATED, actuation="current")
    result = diagnose(recorded(along(v), current, machine, 0.01, 1e-4), machine)
    assert result.verdict == "not_judgeable" and not result.causes
    assert "does not change" in result.reason


def test_a_load_beside_an_inertia_that_shows_is_named() -> None:
    """The same torque on top of what the acceleration needs is a constant load of that size."""
    m = motion(0.8)
    effort = TORQUE_NM + 0.02 * m.a
    result = diagnose(recorded(m, effort, UNSTATED, NOISE_NM, 1e-5), UNSTATED)
    load = causes(result)["constant_load"].parameters[0]
    assert load.low <= TORQUE_NM <= load.high


def test_a_last_speed_that_is_missing_does_not_hide_a_scale() -> None:
    """Recorded at half the rate of the position, one sample not a number: said first of all."""
    m = along(np.sin(np.arange(int(20.0 * RATE_HZ)) / RATE_HZ))
    speed = 0.5 * m.v
    speed[-1] = np.nan
    recording = recorded(m, 0.02 * m.a, ROTARY, 0.01, 1e-5)
    recording = dataclasses.replace(recording, rotor_velocity_rad_per_s=speed)
    assert "the recorded speed is 0.5 times" in diagnose(recording, ROTARY).caution
