"""Rigid drives: what a recording cannot tell apart is shared, what it hides is not named."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from rigid_machines import LINEAR, RATE_HZ, ROTARY, Motion, along, causes, motion, recorded

from ecyl_ros.drive.rigid.machine import Machine
from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.gap.rigid.judge import Judgement
from ecyl_ros.gap.rigid.motion import motion_of
from ecyl_ros.gap.rigid.rest import at_rest

M = motion(0.1)
S = np.sign(M.v)


def _pausing() -> Motion:
    """Motion that stands for 1 s in every 4 s, by a smooth speed."""
    t = np.arange(int(24.0 * RATE_HZ)) / RATE_HZ
    phase = np.minimum(t % 4.0, 3.0) / 3.0
    way = np.where((t // 4.0) % 2 == 0, 1.0, -1.0)
    v = way * 0.1 * np.sin(np.pi * phase) ** 2 * (1.0 + 0.3 * np.sin(6.0 * np.pi * phase))
    v[phase >= 1.0] = 0.0
    return along(v)


def test_rest_is_rest() -> None:
    """Standing for 1 s in 4 s is found, and what is around it; of a swing hardly any."""
    m = _pausing()
    moved = motion_of(recorded(m, 20.0 * m.a, LINEAR, 0.3, 1e-6), LINEAR, "r")
    rest = at_rest(moved)
    inside = (m.t % 4.0 > 3.2) & (m.t % 4.0 < 3.8)
    assert rest[inside].mean() > 0.95 and rest.mean() < 0.4
    swinging = motion_of(recorded(M, 20.0 * M.a, LINEAR, 0.3, 1e-6), LINEAR, "r")
    assert at_rest(swinging).mean() < 0.05


def test_rest_is_rest_in_the_noise_of_its_sensor() -> None:
    """By an encoder whose noise, differentiated, is a tenth of the speed, the same rests are
    found, and no more of the motion counts as rest."""
    m = _pausing()
    noise = 3e-4 * np.random.default_rng(5).normal(size=m.q.size)
    noisy = dataclasses.replace(m, q=m.q + noise)
    rest = at_rest(motion_of(recorded(noisy, 20.0 * m.a, LINEAR, 0.3, 1e-6), LINEAR, "r"))
    inside = (m.t % 4.0 > 3.3) & (m.t % 4.0 < 3.7)
    assert rest[inside].mean() > 0.9 and rest.mean() < 0.45


@pytest.mark.parametrize("weight_hz", [np.inf, 4.0, 2.0])
def test_what_is_held_at_rest_has_faded_where_motion_counts(weight_hz: float) -> None:
    """An effort at rest alone, as the balance sees it, in its lower bands too: a tenth of it is
    left at the most in the samples that count."""
    m = _pausing()
    moved = motion_of(recorded(m, 20.0 * m.a, LINEAR, 0.3, 1e-6), LINEAR, "r")
    moved = dataclasses.replace(moved, weight_hz=weight_hz)
    held = moved.filtered((m.v == 0.0).astype(float))
    counts = ~at_rest(moved)[moved.rows]
    assert np.abs(held[counts]).max() < 0.1
    assert counts.mean() > 0.4


def test_an_output_that_stands_against_a_stop_is_not_judged() -> None:
    """It gives way by 0.01 rad for each N m, to either side of two places, in 70 s of which it
    moves for half a second: any sine of the angle fits what it is held with, and none is named."""
    t = np.arange(int(70.0 * RATE_HZ / 10.0)) / (RATE_HZ / 10.0)
    place = np.where((t < 25.0) | (t > 50.0), -1.5, 0.0)
    effort = 2.0 * np.floor(t % 25.0 / 5.0) * np.where(t > 50.0, -1.0, 1.0)
    hurry = np.exp(-(((t - 25.0) / 0.1) ** 2)) - np.exp(-(((t - 50.0) / 0.1) ** 2))
    q = place + 0.01 * effort + 0.3 * hurry
    q += 4e-4 * np.random.default_rng(3).normal(size=t.size)
    m = Motion(t, q, np.gradient(q, t), np.zeros(t.size))
    sheet = Machine(kind="rigid", output="rotary", actuation="torque", gain=1.0)
    found = diagnose(recorded(m, effort, sheet, 0.01, 1e-4), sheet)
    assert found.verdict == "not_judgeable" and not found.causes and not found.limits
    assert "hardly ever moves" in found.reason


def test_what_friction_holds_at_rest_is_no_gap() -> None:
    """Level 9 N in motion; at rest anything below it: friction of 9 N alone is named."""
    m = _pausing()
    holding = 9.0 * np.sign(m.v) + np.where(m.v == 0.0, 6.0 * np.sin(0.7 * m.t), 0.0)
    found = causes(diagnose(recorded(m, 20.0 * m.a + holding, LINEAR, 0.3, 1e-6), LINEAR))
    assert set(found) == {"load_coulomb_friction"}
    assert abs(found["load_coulomb_friction"].parameters[0].value - 9.0) < 0.3


def test_by_voltage_viscous_friction_and_back_emf_share() -> None:
    """With a known gain, too: below 0.9, and back EMF is listed."""
    machine = Machine(kind="rigid", output="rotary", actuation="voltage", gain=0.2, inertia=0.02)
    m = motion(1.5)
    volts = dataclasses.replace(machine, gain=1.0)
    effort = (0.02 * m.a + 0.05 * m.v) / 0.2
    recording = recorded(m, effort, volts, 0.02, 1e-5)
    found = causes(diagnose(recording, machine))
    assert "back_emf_error" in found["rotor_viscous_friction"].alternatives
    assert found["rotor_viscous_friction"].confidence < 0.9


def test_at_even_speed_a_line_is_not_surely_of_the_turn() -> None:
    """One way at an all but even speed, a line per turn is one over time: not at 0.9."""
    t = np.arange(int(30.0 * RATE_HZ)) / RATE_HZ
    m = Motion(t, 3.0 * t, np.full_like(t, 3.0), np.zeros_like(t))
    machine = dataclasses.replace(ROTARY, inertia=None, bandwidth_hz=20.0)
    effort = 0.1 + 0.05 * np.sin(7.0 * m.q)
    result = diagnose(recorded(m, effort, machine, 0.002, 1e-5), machine)
    assert all(one.confidence < 0.9 for one in result.causes)
    assert "rotor_viscous_friction" not in causes(result)


def test_an_effort_that_stands_while_the_output_moves_is_left_out() -> None:
    """Friction of 9 N with 6 s of a dead effort amid the motion: its value stays, a note tells."""
    effort = 20.0 * M.a + 9.0 * np.sign(M.v)
    good = recorded(M, effort, LINEAR, 0.3, 1e-6)
    force = np.array(good.rod_force_n)
    force[8000:14000] = 0.0
    result = diagnose(dataclasses.replace(good, rod_force_n=force), LINEAR)
    assert any("is constant for 6" in note for note in result.notes)
    for one in result.causes:
        assert one.confidence < 0.9
    levels = [one for one in result.measured if one.name in ("coulomb_n", "coulomb_positive_n")]
    assert levels and abs(levels[0].value - 9.0) < 0.3


def test_two_samples_of_lag_are_no_delay() -> None:
    """Effort 1.8 samples ahead of the motion beside friction: no delay is named, nor told of."""
    effort = np.interp(M.t + 1.8 / RATE_HZ, M.t, 20.0 * M.a + 9.0 * np.sign(M.v))
    result = diagnose(recorded(M, effort, LINEAR, 0.3, 1e-6), LINEAR)
    assert set(causes(result)) == {"load_coulomb_friction"}
    assert not any("delay" in note and "named" in note for note in result.notes)


def test_a_place_that_was_passed_once_is_no_jam() -> None:
    """Drag on 40 mm of a stroke: a jam where it was passed to and fro, not in one stroke alone."""
    drag = 9.0 * S * (np.abs(M.q - 0.05) < 0.02)
    both = diagnose(recorded(M, 20.0 * M.a + drag, LINEAR, 0.3, 1e-6), LINEAR)
    assert [one.effect for one in both.causes] == ["local_jam"]
    t = np.arange(int(12.0 * RATE_HZ)) / RATE_HZ
    v = 0.02 * (1.0 - np.cos(2.0 * np.pi * t / 1.5)) + 0.01
    once = Motion(t, np.cumsum(v) / RATE_HZ, v, np.gradient(v, 1.0 / RATE_HZ))
    drag = 9.0 * (np.abs(once.q - 0.2) < 0.06)
    alone = diagnose(recorded(once, 20.0 * once.a + drag, LINEAR, 0.3, 1e-6), LINEAR)
    assert "local_jam" not in causes(alone)
    assert any("passed once" in note for note in alone.notes)


def test_a_place_that_goes_on_to_the_end_of_the_stroke_is_no_jam() -> None:
    """Drag from 50 mm on, to where the motion turns: nothing tells that it ends."""
    drag = 9.0 * S * (M.q > 0.05)
    found = diagnose(recorded(M, 20.0 * M.a + drag, LINEAR, 0.3, 1e-6), LINEAR)
    assert "local_jam" not in causes(found)


def test_where_no_gain_is_named_values_count_by_that_of_the_file(monkeypatch) -> None:
    """An effort too small by a gain of 1.3 that is unsure: the weight of the arm is told as
    the file's gain counts it, where it would be 2 N m by the other."""
    unsure = Judgement._unsure
    monkeypatch.setattr(
        Judgement, "_unsure", lambda self, one: one.key == "gain" or unsure(self, one)
    )
    exact = {"actuation.gain": "exact", "load.inertia": "exact", "load.viscous_friction": "exact"}
    arm = dataclasses.replace(ROTARY, actuation="current", gain=0.5, viscous=0.2, tolerances=exact)
    m = motion(0.8)
    current = (0.02 * m.a + 0.2 * m.v + 2.0 * np.sin(m.q)) / (1.3 * 0.5)
    result = diagnose(recorded(m, current, arm, 0.02, 1e-5), arm)
    weight = causes(result)["gravity_on_arm"].parameters[0]
    assert weight.value == pytest.approx(2.0 / 1.3, rel=0.05)


@pytest.mark.parametrize(("unknown", "named"), [(0.0, True), (0.01, False)])
def test_what_a_fit_leaves_bounds_what_it_may_have_taken(unknown: float, named: bool) -> None:
    """A spring of 20 N/m on a swing of nearly one frequency, nearly all of which a mass within its
    tolerance does as well: named where noise alone is left, not beside an effort of 1 % that no
    model explains."""
    t = np.arange(int(20.0 * RATE_HZ)) / RATE_HZ
    m = along(0.1 * np.sin(5.0 * t) + 0.02 * np.sin(7.0 * t + 1.0))
    effort = 20.6 * m.a + 20.0 * (m.q - m.q.mean())
    strange = np.sin(2.3 * t) * np.sign(np.sin(1.4 * t))
    effort = effort + unknown * np.std(20.0 * m.a) * strange / np.std(strange)
    sheet = dataclasses.replace(LINEAR, tolerances={"load.mass": 0.1})
    found = causes(diagnose(recorded(m, effort, LINEAR, 0.002, 1e-7), sheet))
    assert set(found) == ({"spring_load"} if named else set())
    if named:
        (stiffness,) = found["spring_load"].parameters
        assert stiffness.low < 20.0 < stiffness.high and stiffness.low > 10.0


def test_values_are_as_wide_as_a_gain_that_is_not_told_from_an_inertia() -> None:
    """A file whose gain is 0.7 of the true one, or whose inertia is a 0.7th: neither is named, and
    the frictions, told by the file's gain, may be those of the true one."""
    m = motion(1.5)
    torque = 0.02 * m.a + 0.03 * m.v + 0.12 * np.sign(m.v)
    sheet = Machine(
        kind="rigid",
        output="rotary",
        actuation="current",
        gain=0.07,
        inertia=0.02,
        tolerances={"actuation.gain": 0.05, "load.inertia": 0.05},
    )
    result = diagnose(recorded(m, torque / 0.1, sheet, 0.02, 1e-5), sheet)
    found = causes(result)
    assert set(found) == {"rotor_coulomb_friction", "rotor_viscous_friction"}
    for name, true in (("rotor_coulomb_friction", 0.12), ("rotor_viscous_friction", 0.03)):
        (value,) = found[name].parameters
        assert value.low < 0.7 * true < true < value.high
    assert any("it looks like" in note and "inertia" in note for note in result.notes)
