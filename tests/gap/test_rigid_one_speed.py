"""Rigid drives at nearly one speed in one direction: which friction it is cannot be known."""

from __future__ import annotations

import numpy as np
from rigid_machines import LINEAR, RATE_HZ, along, recorded

from ecyl_ros.gap.diagnose import diagnose

DRAG_N = 8.0


def test_speed_that_creeps_up_as_friction_falls_does_not_tell_its_form() -> None:
    """Viscous friction that warms by 15 % under a constant force: no level is named for it.

    The force is the same throughout while the speed rises, as of a level; a friction that was
    always the same would exclude that it goes by the speed.
    """
    share = np.linspace(0.0, 1.0, int(24.0 * RATE_HZ))
    m = along(0.01 / (1.0 - 0.15 * share))
    result = diagnose(recorded(m, np.full(len(share), DRAG_N), LINEAR, 0.5, 1e-7), LINEAR)
    assert result.verdict == "not_judgeable"
    assert not result.causes
    assert "coulomb friction" in result.reason and "viscous friction" in result.reason


def test_speeds_apart_tell_a_level_in_one_direction() -> None:
    """The same force at speeds from 5 to 15 mm/s is a level, or a load: not friction by speed."""
    t = np.arange(int(24.0 * RATE_HZ)) / RATE_HZ
    m = along(0.01 + 0.005 * np.sin(2.0 * np.pi * 0.8 * t))
    effort = DRAG_N + LINEAR.inertia * m.a
    result = diagnose(recorded(m, effort, LINEAR, 0.5, 1e-7), LINEAR)
    assert [one.effect for one in result.causes] == ["load_coulomb_friction"]
    assert not any("viscous" in name for name in result.causes[0].alternatives)
