"""Rigid drives: what moves with time and what moves with the motion, each told from the other."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from rigid_machines import LINEAR, RATE_HZ, ROTARY, Motion, motion, recorded

from ecyl_ros.gap.diagnose import diagnose

BY_CURRENT = dataclasses.replace(ROTARY, actuation="current", inertia=1.0)


def _forwards() -> Motion:
    """24 s forwards at a speed that swings between 5 and 15 mm/s."""
    t = np.arange(int(24.0 * RATE_HZ)) / RATE_HZ
    v = 0.01 + 0.005 * np.sin(2.0 * np.pi * 0.8 * t)
    return Motion(t, np.cumsum(v) / RATE_HZ, v, np.gradient(v, 1.0 / RATE_HZ))


def test_forwards_alone_a_drift_of_friction_is_not_called_a_spring() -> None:
    """A level that rises evenly with time: no spring is named, the reader is told of both."""
    m = _forwards()
    result = diagnose(recorded(m, 20.0 * m.a + 3.0 * m.t / m.t[-1], LINEAR, 0.1, 1e-7), LINEAR)
    assert not result.causes
    told = " ".join((result.reason, *result.notes))
    assert "friction drift" in told and "spring load" in told


def test_forwards_alone_a_spring_is_named_where_time_does_not_tell_it() -> None:
    """A force that rises with the place, which swings about an even rise in time: the spring."""
    m = _forwards()
    exact = dataclasses.replace(LINEAR, tolerances={"all": "exact"})  # else the mass swings along
    result = diagnose(recorded(m, 20.0 * m.a + 20.0 * m.q, exact, 0.1, 1e-7), exact)
    assert [one.effect for one in result.causes] == ["spring_load"]
    assert result.causes[0].parameters[0].value == pytest.approx(20.0, rel=0.05)


def test_a_disturbance_that_shakes_the_machine_is_named() -> None:
    """A strong force of 8.7 Hz that a third of goes into acceleration: named, of its size."""
    m = motion(0.1)
    rate, size = 2.0 * np.pi * 8.7, 40.0
    force = size * np.sin(rate * m.t + 0.4)
    shaken = -0.35 * force / 20.0  # m/s^2 that the controller lets through
    moved = Motion(m.t, m.q - shaken / rate**2, m.v, m.a + shaken)
    machine = dataclasses.replace(LINEAR, bandwidth_hz=30.0)
    effort = 20.0 * moved.a + force
    result = diagnose(recorded(moved, effort, machine, 0.3, 1e-7), machine)
    assert [one.effect for one in result.causes] == ["periodic_disturbance"]
    found = {one.name: one.value for one in result.causes[0].parameters}
    assert found["frequency_hz"] == pytest.approx(8.7, rel=1e-3)
    assert found["amplitude_n"] == pytest.approx(size, rel=0.05)


@pytest.mark.parametrize(("actuation", "gain"), [("force", None), ("current", 8.0)])
def test_a_load_may_be_an_offset_of_a_current_that_is_read(actuation: str, gain) -> None:
    """12 N throughout: by a current its sensor's offset is as good; a force has none."""
    machine = dataclasses.replace(LINEAR, actuation=actuation, gain=gain)
    m = motion(0.1)
    effort = (20.0 * m.a + 12.0) / (gain or 1.0)
    result = diagnose(recorded(m, effort, machine, 0.3 / (gain or 1.0), 1e-6), machine)
    (cause,) = result.causes
    assert cause.effect == "constant_load"
    assert ("current_sensor_offset" in cause.alternatives) is (actuation == "current")
    assert (cause.confidence > 0.9) is (actuation == "force")


@pytest.mark.parametrize(
    ("inertia", "gain", "friction"), [(2.0, 1.0, 1.2), (2.0, 1.0, 1.45), (1.0, 0.5, 0.7)]
)
def test_an_inertia_and_a_gain_that_friction_alone_tells_apart_are_both_told(
    inertia: float, gain: float, friction: float
) -> None:
    """Twice the inertia, or half the gain, with frictions off within their tolerance: whichever is
    named, the other is told beside it, and it is not sure."""
    m = motion(1.0, duration_s=12.0)
    machine = dataclasses.replace(BY_CURRENT, viscous=0.3, coulomb=0.05)
    rubs = friction * (0.3 * m.v + 0.05 * np.tanh(m.v / 1e-3))
    result = diagnose(recorded(m, (inertia * m.a + rubs) / gain, machine, 0.02, 1e-5), machine)
    both = {"rotor_inertia_error", "torque_constant_error"}
    if result.causes:
        (cause,) = result.causes
        assert {cause.effect, *cause.alternatives} == both and cause.confidence < 0.9
    else:
        assert all(name.replace("_", " ") in result.reason for name in both)
        assert "a closer tolerance of one of them" in result.reason


def test_a_gain_is_named_where_the_frictions_are_off_by_it_as_well() -> None:
    """Inertia and both frictions appear twice as large: half the gain, and no other name."""
    m = motion(1.0, duration_s=12.0)
    machine = dataclasses.replace(BY_CURRENT, viscous=0.3, coulomb=0.05)
    effort = 2.0 * (1.0 * m.a + 0.3 * m.v + 0.05 * np.tanh(m.v / 1e-3))
    result = diagnose(recorded(m, effort, machine, 0.02, 1e-5), machine)
    assert [one.effect for one in result.causes] == ["torque_constant_error"]
    assert result.causes[0].confidence > 0.9
    assert result.causes[0].parameters[0].value == pytest.approx(0.5, rel=0.02)


def test_what_is_not_decided_beside_a_cause_is_told() -> None:
    """Twice the inertia beside friction that the file does not state: the friction is named, and a
    note says that inertia and gain look alike, which here they do in every motion."""
    m = motion(1.0, duration_s=12.0)
    effort = 2.0 * m.a + 1.5 * m.v
    result = diagnose(recorded(m, effort, BY_CURRENT, 0.02, 1e-5), BY_CURRENT)
    assert [one.effect for one in result.causes] == ["rotor_viscous_friction"]
    note = result.notes[0]
    assert note.startswith("not decided beside what is named")
    assert "rotor inertia error" in note and "torque constant error" in note
