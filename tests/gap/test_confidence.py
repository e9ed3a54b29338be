"""How sure a set of causes is, beside what the catalogue does not hold."""

from __future__ import annotations

import pytest

from ecyl_ros.gap.judge.verdict import NAMED, Standing, confidence, settings, settings_alone


def test_several_settings_of_one_controller_may_be_one_that_is_not_known() -> None:
    """One is as sure as its fit; two are named, no longer as sure ones; three at once are not."""
    at_floor = confidence(Standing(1.0, 10.0), 0)
    tuned = ["position_gain_error", "velocity_feedforward_error", "feedback_filter"]
    assert settings_alone(tuned[:1]) == 1.0
    assert NAMED < at_floor * settings_alone(tuned[:2]) < 0.9
    assert at_floor * settings_alone(tuned) < NAMED


@pytest.mark.parametrize("name", ["current_limit", "voltage_limit", "load_coulomb_friction"])
def test_limits_and_faults_of_the_machine_are_no_settings(name) -> None:
    """They answer otherwise to large than to small motion, as no set of settings does."""
    assert settings([name, "speed_gain_error"]) == ["speed_gain_error"]
