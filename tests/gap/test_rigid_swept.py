"""A sweep of the frequency: friction that depends on how it moves is none that drifts with time."""

from __future__ import annotations

import numpy as np
import pytest
from rigid_machines import LINEAR, RATE_HZ, Motion, causes, motion, recorded

from ecyl_ros.gap.diagnose import diagnose

SECONDS = 20.0
TIME = np.arange(int(SECONDS * RATE_HZ)) / RATE_HZ


def _sweep() -> Motion:
    """10 mm either way, from 0.5 to 2.5 Hz."""
    rate = 2.0 * np.pi * (0.5 + 0.1 * TIME)
    turned, per_s = 2.0 * np.pi * (0.5 * TIME + 0.05 * TIME**2), 0.2 * np.pi
    speed = 0.01 * rate * np.cos(turned)
    acceleration = 0.01 * (per_s * np.cos(turned) - rate**2 * np.sin(turned))
    return Motion(TIME, 0.01 * np.sin(turned), speed, acceleration)


@pytest.mark.parametrize(
    ("moved", "drifts"), [(_sweep(), False), (motion(0.02, duration_s=SECONDS), True)]
)
def test_what_drifts_is_told_where_the_motion_is_the_same_early_and_late(
    moved: Motion, drifts: bool
) -> None:
    """A level that falls from 13 to 5.2 N: named as a drift in a motion that stays as it is; in a
    sweep, where it may as well fall with the frequency, it is not, and friction that is named for
    it is a plain level, which a drift has, too, or no surer than the drift."""
    level = 13.0 * (1.0 - 0.03 * TIME)
    effort = 20.0 * moved.a + level * np.sign(moved.v)
    found = causes(diagnose(recorded(moved, effort, LINEAR, 0.3, 1e-6), LINEAR))
    assert ("friction_drift" in found) is drifts
    if not drifts:
        assert found
        for name, cause in found.items():
            unsure = "friction_drift" in cause.alternatives and cause.confidence < 0.9
            assert name == "load_coulomb_friction" or unsure
