"""How sure a set of causes is, beside what the catalogue does not hold."""

from __future__ import annotations

import pytest

from ecyl_ros.gap.judge.verdict import (
    NAMED,
    Standing,
    confidence,
    helped,
    settings,
    settings_alone,
    share_of,
    shrink_of,
)


def test_several_settings_of_one_controller_may_be_one_that_is_not_known() -> None:
    """One is as sure as its fit; two are named, no longer as sure ones; three at once are not."""
    at_floor = confidence(Standing(1.0, 10.0), 0)
    tuned = ["position_gain_error", "velocity_feedforward_error", "feedback_filter"]
    assert settings_alone(tuned[:1]) == 1.0
    assert NAMED < at_floor * settings_alone(tuned[:2]) < 0.9
    assert at_floor * settings_alone(tuned) < NAMED
    # A delay beside one may be the other half of a filter; alone, or two of them, it is none.
    late = ["actuation_delay", "measurement_delay"]
    assert settings_alone(late) == 1.0
    assert NAMED < at_floor * settings_alone([late[0], "position_gain_error"]) < 0.9


@pytest.mark.parametrize("name", ["current_limit", "voltage_limit", "load_coulomb_friction"])
def test_limits_and_faults_of_the_machine_are_no_settings(name) -> None:
    """They answer otherwise to large than to small motion, as no set of settings does."""
    assert settings([name, "speed_gain_error"]) == ["speed_gain_error"]


@pytest.mark.parametrize(
    ("after", "left", "gone", "wanted"),
    [
        (0.4, 2.0, 0.3, True),  # more than half of the RMS
        (0.6, 1.2, 0.7, True),  # less: but of a sound machine impacts leave as much
        (0.6, 1.5, 0.7, False),  # more is left than they leave
        (0.6, 1.2, 0.4, False),  # hardly anything is gone between them
    ],
)
def test_a_set_helps_by_rms_or_by_what_impacts_do_not_hide(
    after: float, left: float, gone: float, wanted: bool
) -> None:
    """A gap of 1 over noise of 0.05: half of it gone, or of the misfit where impacts remain."""
    assert helped(1.0, after, 0.05, Standing(left, 2.0), gone) is wanted


def test_what_a_cause_removes_is_a_share_of_what_stands_above_the_floor() -> None:
    """Half of it, all of it at the most, less than nothing where it adds; of none, where causes
    that let noise through raise the floor above the gap, nothing."""
    assert share_of(0.5, 1.0) == 0.5
    assert share_of(3.0, 1.0) == 1.0 and share_of(-3.0, 1.0) == -1.0
    assert share_of(1e-3, 0.0) == share_of(-1e-3, -2.0) == 0.0
    assert shrink_of(2.0, 2.5, 1.0) == 0.0 and shrink_of(2.0, 1.2, 1.0) == pytest.approx(0.8)
