"""Friction that grows with the load carried, where the encoder's noise swamps the acceleration."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from rigid_machines import LINEAR, motion, recorded

from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.gap.rigid.motion import motion_of

M = motion(0.1)
COEFFICIENT = 0.25
WIDE = dataclasses.replace(LINEAR, bandwidth_hz=80.0)  # as the effort's own band may ask for


def test_noise_of_the_encoder_carries_no_load() -> None:
    """Noise of twice the acceleration: friction is named alone, its coefficient within 5 %."""
    effort = WIDE.inertia * M.a
    effort = effort + COEFFICIENT * np.abs(effort) * np.sign(M.v)
    recording = recorded(M, effort, WIDE, noise=2.0, step=3e-5)
    moved = motion_of(recording, WIDE, "r")
    rough = np.std((moved.acceleration - M.a)[moved.usable])
    assert rough > 2.0 * np.std(M.a)  # else this is no test of it
    result = diagnose(recording, WIDE)
    assert [one.effect for one in result.causes] == ["load_dependent_friction"]
    assert result.causes[0].parameters[0].value == pytest.approx(COEFFICIENT, rel=0.05)
