"""An effort commanded as a ramp: what drifts with time explains the command, not the machine."""

from __future__ import annotations

import numpy as np
import pytest
from rigid_machines import RATE_HZ, Motion, causes, recorded

from ecyl_ros.drive.rigid.machine import Machine
from ecyl_ros.errors import InputError
from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.gap.several.together import diagnose_together

MOTOR = Machine(kind="rigid", output="rotary", actuation="voltage", gain=1.0)
INERTIA, VISCOUS, COULOMB, PER_S = 0.02, 0.11, 0.7, 0.25


def _ramp(way: float) -> tuple[Motion, np.ndarray]:
    """A ramp of the effort from breakaway on, and a motion that it is nearly in balance with: the
    speed swings by 0.3 rad/s, as no friction of the model makes it."""
    time = np.arange(int(12.0 * RATE_HZ)) / RATE_HZ
    rate, swing = PER_S / VISCOUS, 2.0 * np.pi / 5.0
    effort = COULOMB + INERTIA * rate + PER_S * time
    position = 0.5 * rate * time**2 - 0.3 / swing * np.cos(swing * time)
    speed = rate * time + 0.3 * np.sin(swing * time)
    acceleration = rate + 0.3 * swing * np.cos(swing * time)
    return Motion(time, way * position, way * speed, way * acceleration), way * effort


def test_frictions_of_a_ramp_are_told_by_ramps_both_ways() -> None:
    """Voltage ramps forwards and backwards: viscous and Coulomb friction, not a drift that would
    leave nothing of the command."""
    runs = [recorded(*_ramp(way), MOTOR, noise=0.0, step=1e-3) for way in (1.0, -1.0)]
    result = diagnose_together(runs, MOTOR, sources=["f", "b"])
    found = causes(result)
    assert result.verdict == "explained"
    assert set(found) == {"rotor_viscous_friction", "rotor_coulomb_friction"}
    viscous, level = found["rotor_viscous_friction"], found["rotor_coulomb_friction"]
    assert "friction_drift" not in viscous.alternatives
    assert viscous.parameters[0].value == pytest.approx(VISCOUS, rel=0.01)
    # The acceleration is nearly as constant as the level.
    asked = COULOMB + INERTIA * PER_S / VISCOUS
    assert level.parameters[0].value == pytest.approx(asked, rel=0.05)


def _step(level: float) -> tuple[Motion, np.ndarray]:
    """A constant effort from rest on, and the motion that it is in balance with."""
    time = np.arange(int(3.0 * RATE_HZ)) / RATE_HZ
    settles, last_s = np.exp(-time * VISCOUS / INERTIA), INERTIA / VISCOUS
    top = (level - COULOMB) / VISCOUS
    position = top * (time - last_s * (1.0 - settles))
    moved = Motion(time, position, top * (1.0 - settles), top / last_s * settles)
    return moved, np.full(time.size, level)


def test_a_constant_effort_is_compared_beside_another() -> None:
    """A step of the voltage is refused alone; beside ramps it says no friction of its own, and what
    the ramps name holds on it."""
    ramps = [recorded(*_ramp(way), MOTOR, noise=0.0, step=1e-3) for way in (1.0, -1.0)]
    step = recorded(*_step(4.0), MOTOR, noise=0.0, step=1e-3)
    with pytest.raises(InputError, match="the effort never changes"):
        diagnose(step, MOTOR)
    result = diagnose_together([*ramps, step], MOTOR, sources=["f", "b", "step"])
    assert set(causes(result)) == {"rotor_viscous_friction", "rotor_coulomb_friction"}
    assert not any(one.differs for of in result.recordings for one in of.values)
    step_of = result.recordings[2]
    assert step_of.unseen is not None and step_of.unseen > 0.9
