"""Friction that grows with the load carried: by an acceleration that the encoder's noise swamps, by
the weight of an arm."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from rigid_machines import LINEAR, ROTARY, motion, recorded

from ecyl_ros.drive.rigid.model import Acting
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


def test_the_weight_of_an_arm_is_a_load_carried() -> None:
    """An arm whose file states its weight, with friction of a tenth of what gears carry: named,
    right within its interval, and the twin moves as the machine did."""
    weight = Acting("gravity_on_arm", {"amplitude": 2.0, "phase": 0.4})
    arm = dataclasses.replace(
        ROTARY, coulomb=0.1, effects=(weight,), effects_unit="N m", tolerances={"all": 0.1}
    )
    m = motion(0.8)
    carried = arm.inertia * m.a + 2.0 * np.sin(m.q + 0.4)
    effort = carried + (0.1 + 0.1 * np.abs(carried)) * np.sign(m.v)
    result = diagnose(recorded(m, effort, arm, noise=0.01, step=1e-5), arm)
    (cause,) = result.causes
    assert cause.effect == "load_dependent_friction"
    (coefficient,) = cause.parameters
    assert coefficient.low <= 0.1 <= coefficient.high
    assert coefficient.value == pytest.approx(0.1, rel=0.05)
    position = next(one for one in result.signals if one.name == "position")
    assert position.after < 0.1 * position.gap


@pytest.mark.parametrize("stated", [True, False])
def test_friction_goes_by_the_load_that_is_found(stated: bool) -> None:
    """A weight that the file lacks, an inertia that it has wrong or leaves out, and friction of a
    tenth of what all of it comes to: named beside what it goes by, right within its interval."""
    bare = dataclasses.replace(ROTARY, coulomb=0.1, effects_unit="N m", tolerances={"all": 0.1})
    arm = bare if stated else dataclasses.replace(bare, inertia=None)
    m = motion(0.8)
    carried = 2.5 * ROTARY.inertia * m.a + 2.0 * np.sin(m.q + 0.4)
    effort = carried + (0.1 + 0.1 * np.abs(carried)) * np.sign(m.v)
    result = diagnose(recorded(m, effort, arm, noise=0.01, step=1e-5), arm)
    found = {one.effect: one.parameters[0] for one in result.causes}
    beside = {"rotor_inertia_error"} if stated else set()
    assert set(found) == {"gravity_on_arm", "load_dependent_friction"} | beside
    coefficient = found["load_dependent_friction"]
    assert coefficient.low <= 0.1 <= coefficient.high
    assert coefficient.value == pytest.approx(0.1, rel=0.05)
