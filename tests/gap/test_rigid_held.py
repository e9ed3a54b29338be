"""A stated inertia is what it is: no effect is named whose balance needs it gone."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from rigid_machines import RATE_HZ, Motion, motion, recorded

from ecyl_ros.drive.rigid.machine import Machine
from ecyl_ros.drive.rigid.model import Acting
from ecyl_ros.gap.diagnose import diagnose

WEIGHT = 3.1  # N m
ARM = Machine(
    kind="rigid",
    output="rotary",
    actuation="torque",
    gain=1.0,
    inertia=0.15,
    tolerances={"load.inertia": 0.2},
)
LEAST = 0.8 * 0.15 * (1.0 - 1e-9)


def _inertia(result) -> float:
    """What the sheet comes to; the file's where it is not fitted."""
    return next((one.value for one in result.sheet if one.parameter == "load.inertia"), 0.15)


def _weighs(result, amplitude: float, phase: float) -> None:
    """One weight is named, of this size and phase."""
    (cause,) = [one for one in result.causes if one.effect == "gravity_on_arm"]
    found = {one.name: one.value for one in cause.parameters}
    assert found["amplitude_nm"] == pytest.approx(amplitude, rel=0.03)
    assert found["phase_rad"] == pytest.approx(phase, abs=0.03)


def test_an_arm_that_a_hand_moves_has_its_inertia_still() -> None:
    """An effort that balances the weight alone, while a hand accelerates the arm: an inertia of 0
    leaves nothing of it. It is not believed, and a note says so."""
    m = motion(1.0)
    result = diagnose(recorded(m, WEIGHT * np.sin(m.q), ARM, 0.01, 1e-5), ARM)
    assert _inertia(result) >= LEAST
    assert any("asks for load.inertia to be" in note for note in result.notes)
    assert result.verdict not in ("no_gap", "within_sheet", "explained")


def test_a_pendulum_that_swings_by_itself_carries_no_constant_load() -> None:
    """A constant torque under which a pendulum swings freely (J a + m g l sin q = constant): a
    constant load without inertia leaves nothing of it, and is not named."""
    t = np.arange(int(20.0 * RATE_HZ)) / RATE_HZ
    q, v, state = np.zeros(t.size), np.zeros(t.size), np.array([0.6, 0.0])
    asked, h = 0.9, 1.0 / RATE_HZ
    for at in range(t.size):
        q[at], v[at] = state
        speed = state[1] + h * (asked - WEIGHT * np.sin(state[0])) / 0.15  # symplectic Euler
        state = np.array([state[0] + h * speed, speed])
    m = Motion(t, q, v, np.gradient(v, h))
    result = diagnose(recorded(m, np.full(t.size, asked), ARM, 1e-3, 1e-5), ARM)
    assert "constant_load" not in [one.effect for one in result.causes]
    assert _inertia(result) >= LEAST


def _shaken() -> tuple[Motion, np.ndarray]:
    """A slow motion of the whole arm, and 40 Hz in which its rotor of 1 % shakes alone."""
    m = motion(1.0)
    rate = 2.0 * np.pi * 40.0
    shake = 2e-3 * np.sin(rate * m.t) * np.sin(2.0 * np.pi * 0.4 * m.t)
    fast = np.gradient(np.gradient(shake, m.t), m.t)
    both = Motion(m.t, m.q + shake, m.v + np.gradient(shake, m.t), m.a + fast)
    return both, 0.15 * m.a + 0.0015 * fast


def test_a_rotor_that_shakes_alone_does_not_hide_the_arm() -> None:
    """Above its resonance an arm is not the one of the sheet: it is judged in the band in which its
    inertia holds, and the weight that the file lacks is found there."""
    m, effort = _shaken()
    machine = dataclasses.replace(ARM, bandwidth_hz=60.0)
    result = diagnose(
        recorded(m, effort + WEIGHT * np.sin(m.q + 0.2), machine, 0.01, 1e-6), machine
    )
    _weighs(result, WEIGHT, 0.2)
    assert _inertia(result) == pytest.approx(0.15, rel=0.05)
    assert any("have less weight" in note for note in result.notes)


def test_another_weight_than_the_file_has_is_named_as_what_it_is() -> None:
    """A weight of 2 N m at 0.3 rad where the file has 3.1 N m at 0: named so, not as what cancels a
    part of it, and the closest machine has one weight."""
    m = motion(1.0)
    stated = dataclasses.replace(
        ARM,
        effects=(Acting("gravity_on_arm", {"amplitude": WEIGHT, "phase": 0.0}),),
        effects_unit="N m",
    )
    effort = 0.15 * m.a + 2.0 * np.sin(m.q + 0.3)
    result = diagnose(recorded(m, effort, stated, 0.01, 1e-5), stated)
    assert result.verdict == "explained"
    _weighs(result, 2.0, 0.3)
    (weight,) = result.closest.effects
    assert weight.values["amplitude"] == pytest.approx(2.0, rel=0.03)
    assert weight.values["phase"] == pytest.approx(0.3, abs=0.03)


def test_an_exact_inertia_is_not_measured() -> None:
    """What the file is sure of has no other value beside it."""
    m = motion(1.0)
    exact = dataclasses.replace(ARM, tolerances={"load.inertia": "exact"})
    result = diagnose(recorded(m, 0.15 * m.a + 0.4 * np.tanh(m.v / 1e-3), exact, 0.01, 1e-5), exact)
    assert [one.effect for one in result.causes] == ["rotor_coulomb_friction"]
    assert all(not one.name.startswith("inertia") for one in result.measured)


def test_an_injected_torque_tells_the_gain_of_the_drive() -> None:
    """The file states that its torque may be 20 % off, and no inertia: what was put on the output
    and is known in N m tells that it reads 8 % too little."""
    m = motion(1.0)
    machine = dataclasses.replace(ARM, inertia=None, tolerances={"actuation.gain": 0.2})
    injected = 0.8 * np.sin(2.0 * np.pi * 0.23 * m.t)
    torque = 0.15 * m.a + 0.3 * m.v - injected
    recording = dataclasses.replace(
        recorded(m, torque / 1.08, machine, 1e-3, 1e-5), injected_torque_nm=injected
    )
    result = diagnose(recording, machine)
    assert [one.effect for one in result.causes] == ["rotor_viscous_friction"]
    assert result.causes[0].parameters[0].value == pytest.approx(0.3, rel=0.02)
    (gain,) = result.sheet
    assert gain.parameter == "actuation.gain" and gain.value == pytest.approx(1.08, rel=0.01)


@pytest.mark.parametrize("stated", [0.5, 1.0, 2.0])
def test_a_wrong_gain_counts_the_effects_of_the_file_as_well(stated: float) -> None:
    """Half and twice the true gain, 1 A that is 2 N m: the gain is named, not the weight of the
    file, which is as stated; a stated gain of 1 is a gain, too."""
    m = motion(1.0)
    weight = Acting("gravity_on_arm", {"amplitude": WEIGHT, "phase": 0.4})
    machine = dataclasses.replace(ARM, actuation="current", gain=stated, effects=(weight,))
    true = 2.0 if stated == 1.0 else 1.0
    torque = 0.15 * m.a + WEIGHT * np.sin(m.q + 0.4)
    result = diagnose(recorded(m, torque / true, machine, 0.01 / true, 1e-5), machine)
    (cause,) = result.causes
    assert cause.effect == "torque_constant_error" and cause.confidence > 0.9
    assert cause.parameters[0].low < true < cause.parameters[0].high


def test_what_stands_at_its_floor_explains_nothing() -> None:
    """Friction of 0.4 N m in an effort that wanders by 1 N m: no cause is named, and the reason
    says what recording could be judged."""
    m = motion(1.0)
    free = dataclasses.replace(ARM, inertia=None, tolerances={})
    loud = np.convolve(
        np.random.default_rng(5).normal(size=m.t.size), np.ones(20) / 20**0.5, "same"
    )
    effort = 0.02 * m.a + 0.4 * np.tanh(m.v / 1e-3) + loud
    result = diagnose(recorded(m, effort, free, 0.01, 1e-5), free)
    assert result.verdict == "not_judgeable" and not result.causes
    assert "more motion or load" in result.reason
