"""Rigid drives whose file states little: friction that every machine has, and what looks alike."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from rigid_machines import RATE_HZ, ROTARY, along, causes, motion, recorded

from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.gap.rigid.normal import solve


def test_a_joint_that_moves_for_a_tenth_of_the_time_shows_its_friction() -> None:
    """0.4 s in every 4 s, both ways; at rest the drive pushes with anything below the level."""
    t = np.arange(int(80.0 * RATE_HZ)) / RATE_HZ
    phase = np.minimum((t % 4.0) / 0.4, 1.0)
    way = np.where((t // 4.0) % 2 == 0, 1.0, -1.0)
    v = way * np.sin(np.pi * phase) ** 2
    v[phase >= 1.0] = 0.0
    m = along(v)
    rng = np.random.default_rng(5)
    held = np.repeat(rng.uniform(-0.25, 0.25, 80), int(RATE_HZ))
    effort = 0.02 * m.a + np.where(v == 0.0, held, 0.3 * np.sign(v))
    result = diagnose(recorded(m, effort, ROTARY, 0.01, 1e-5), ROTARY)
    found = causes(result)
    assert result.verdict == "explained" and set(found) == {"rotor_coulomb_friction"}
    assert found["rotor_coulomb_friction"].parameters[0].value == pytest.approx(0.3, rel=0.05)


def test_the_weight_of_an_arm_that_rests_most_of_a_short_recording_is_named() -> None:
    """Six moves of 0.35 s in 6 s: what moves is parted into stretches enough to be sure."""
    t = np.arange(int(6.0 * RATE_HZ)) / RATE_HZ
    phase = np.minimum((t % 1.0) / 0.35, 1.0)
    peaks = np.array([3.0, -1.8, 2.7, -4.2, 0.9, 2.4])[t.astype(int)]
    v = np.where(phase < 1.0, peaks * np.sin(np.pi * phase) ** 2, 0.0)
    m = along(v)
    effort = 0.02 * m.a + 0.5 * np.sin(m.q) + 0.05 * np.sign(m.v)
    result = diagnose(recorded(m, effort, ROTARY, 0.03, 1e-5), ROTARY)
    found = causes(result)
    assert result.verdict == "explained"
    assert set(found) == {"gravity_on_arm", "rotor_coulomb_friction"}
    assert found["gravity_on_arm"].parameters[0].value == pytest.approx(0.5, rel=0.05)


def test_friction_is_named_though_the_drive_chatters_at_its_top_speed() -> None:
    """Friction of both forms, which the file leaves out; what does not repeat is a third of it."""
    m = motion(1.5)
    top = np.abs(m.v) > np.quantile(np.abs(m.v), 0.8)
    rng = np.random.default_rng(6)
    chatter = np.convolve(rng.normal(size=m.t.size), np.hanning(60), "same")
    chatter *= 0.25 / np.std(chatter)
    effort = 0.02 * m.a + 0.3 * np.sign(m.v) + 0.05 * m.v + np.where(top, chatter, 0.0)
    found = causes(diagnose(recorded(m, effort, ROTARY, 0.02, 1e-5), ROTARY))
    assert set(found) == {"rotor_coulomb_friction", "rotor_viscous_friction"}
    assert found["rotor_coulomb_friction"].parameters[0].value == pytest.approx(0.3, rel=0.15)


@pytest.mark.parametrize(("reach", "told"), [(0.15, False), (1.5, True)])
def test_over_a_small_arc_a_spring_may_be_the_weight_of_an_arm(reach: float, told: bool) -> None:
    """Over 30 degrees a weight, which is more common, gives the same: no spring is named, and each
    is said to look like the other. Over most of a turn the spring is."""
    m = motion(reach)
    effort = 0.02 * m.a + 0.4 * m.q / reach
    result = diagnose(recorded(m, effort, ROTARY, 0.01, 1e-6), ROTARY)
    assert (set(causes(result)) == {"spring_load"}) is told
    if not told:
        assert all(one.alternatives == ("spring_load",) for one in result.causes)
        assert result.causes or "gravity on arm" in " ".join([result.reason, *result.notes])


def test_over_a_few_degrees_cogging_may_be_the_weight_of_an_arm() -> None:
    """Cogging seven times a turn over three degrees, a slope there: nothing is named, and the
    reason has both, with the spring that is one, too."""
    m = motion(0.01)
    effort = 0.02 * m.a + 0.4 * np.sin(7.0 * m.q + 0.4)
    result = diagnose(recorded(m, effort, ROTARY, 0.004, 1e-6), ROTARY)
    assert result.verdict == "not_judgeable" and not result.causes
    assert all(one in result.reason for one in ("gravity on arm", "cogging torque", "spring load"))


def test_a_weight_over_a_small_arc_is_there_all_the_time() -> None:
    """An arm that creeps through 35 degrees and back, to and fro on the way: its weight is named,
    whatever sine of the turn each quarter of the time would prefer on its few degrees."""
    t = np.arange(int(40.0 * RATE_HZ)) / RATE_HZ
    slow, fast = 2.0 * np.pi / 40.0, 2.0 * np.pi * 0.7
    m = along(0.3 * slow * np.cos(slow * t) + 0.03 * fast * np.cos(fast * t))
    effort = 0.2 * m.a + 8.0 * np.sin(m.q + 0.07) + 0.4 * np.sign(m.v)
    machine = dataclasses.replace(ROTARY, inertia=0.2)
    found = causes(diagnose(recorded(m, effort, machine, 0.4, 1e-5), machine))
    assert "gravity_on_arm" in found and "spring_load" not in found


def test_drag_of_a_spin_one_way_is_told_from_a_level_by_its_run_up() -> None:
    """Nine tenths of the time at one speed: too alike by their variance, told by what is left."""
    t = np.arange(int(30.0 * RATE_HZ)) / RATE_HZ
    m = along(200.0 * (1.0 - np.exp(-t / 1.5)) * (1.0 + 0.02 * np.sin(0.8 * t)))
    machine = dataclasses.replace(ROTARY, inertia=1e-4)
    effort = 1e-4 * m.a + 1.5e-4 * m.v
    found = causes(diagnose(recorded(m, effort, machine, 2e-4, 1e-4), machine))
    assert "rotor_viscous_friction" in found
    value = found["rotor_viscous_friction"].parameters[0].value
    assert value == pytest.approx(1.5e-4, rel=0.05)


@pytest.mark.parametrize(("inertia", "shown"), [(0.02, True), (2e-6, False)])
def test_an_inertia_that_the_recording_does_not_show_is_asked_for(
    inertia: float, shown: bool
) -> None:
    """Both are left out of the file; next to the friction the smaller one is nothing."""
    m, bare = motion(1.5), dataclasses.replace(ROTARY, inertia=None)
    effort = inertia * m.a + 0.3 * np.sign(m.v)
    result = diagnose(recorded(m, effort, bare, 0.01, 1e-5), bare)
    (note,) = (one for one in result.notes if one.startswith("load.inertia is left out"))
    assert ("fitted to the recording" in note) is shown
    assert ("does not show it: stated in the drive file" in note) is not shown


def test_a_speed_of_another_scale_is_said_first() -> None:
    """Recorded at half the rate of the position: that is said first; at the whole it is not."""
    m = motion(1.5)
    for factor in (0.5, 1.0):
        recording = recorded(m, 0.02 * m.a, ROTARY, 0.01, 1e-5)
        speed = factor * m.v + 0.01 * np.random.default_rng(8).normal(size=m.v.size)
        recording = dataclasses.replace(recording, rotor_velocity_rad_per_s=speed)
        said = diagnose(recording, ROTARY).caution
        assert ("the recorded speed is 0.5 times the rate of the position" in said) is (
            factor == 0.5
        )


def test_a_column_that_is_held_does_not_drown_the_others() -> None:
    """Least squares with a column of next to nothing at a high price, as without that column."""
    rng = np.random.default_rng(9)
    columns = rng.normal(size=(500, 3)) * (1.0, 1.0, 1e-9)
    target = columns[:, :2] @ (0.7, -0.2) + 1e-3 * rng.normal(size=500)
    free = (np.full(3, -np.inf), np.full(3, np.inf))
    price = np.array([0.0, 0.0, 1e5])
    found = solve(columns.T, target, np.ones(500), free, price, np.zeros(3), (0.0, 0.0))
    plain = np.linalg.lstsq(columns[:, :2], target, rcond=None)[0]
    np.testing.assert_allclose(found[:2], plain, rtol=1e-6)
    assert abs(found[2]) < 1e-6
