"""Values of a rigid drive as a whole: what it is measured to be beside what is named."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
import pytest
from rigid_machines import ROTARY, Motion, motion, recorded

from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.gap.diagnosis import Diagnosis, Measured

INERTIA, VISCOUS = 1e-4, 6e-5  # kg m^2, N m s/rad
ENCODER = dataclasses.replace(ROTARY, inertia=1.2 * INERTIA, viscous=VISCOUS)


def _moved(torque: Callable[[float], float], levels: tuple[float, float], inertia: float) -> Motion:
    """An output from rest by a torque of time, with viscous friction and a level each way."""
    t = np.arange(12_000) / 1000.0
    q, v, a = np.zeros(t.size), np.zeros(t.size), np.zeros(t.size)
    angle = speed = 0.0
    for index, now in enumerate(t.tolist()):
        for _ in range(10):
            asked = torque(now) - VISCOUS * speed
            way = speed or asked
            level = levels[0] if way > 0.0 else levels[1]
            rate = (asked - level * np.sign(way)) / inertia
            if speed == 0.0 and abs(asked) <= level:
                rate = 0.0
            then = speed + 1e-4 * rate
            speed = 0.0 if speed * then < 0.0 else then
            angle += 1e-4 * speed
        q[index], v[index], a[index] = angle, speed, rate
    return Motion(t, q, v, a)


def _by_name(result: Diagnosis) -> dict[str, Measured]:
    return {one.name: one for one in result.measured}


@pytest.mark.parametrize("off_rad", [0.0, 1e-3, 3e-3])
def test_an_encoder_off_its_centre_does_not_bend_the_inertia(off_rad) -> None:
    """Steps of a noisy torque up to 30 turns a second: the inertia's interval holds the true one,
    and is no wider than 40 % of it, by a true encoder and by one whose angle sways once a turn."""

    def torque(now: float) -> float:
        return 0.035 if now < 5.0 else 0.045

    m = _moved(torque, (0.03, 0.03), INERTIA)
    effort = np.array([torque(now) for now in m.t.tolist()])
    seen = dataclasses.replace(m, q=m.q + off_rad * np.sin(m.q))
    inertia = _by_name(diagnose(recorded(seen, effort, ENCODER, 0.01, 6e-4), ENCODER))[
        "inertia_kg_m2"
    ]
    assert inertia.low < INERTIA < inertia.high
    assert inertia.high - inertia.low < 0.4 * INERTIA


def test_friction_and_load_are_measured_beside_what_is_named() -> None:
    """Two triangles of torque, all but Coulomb friction kept out of the competition: both kinds of
    friction and the load are measured all the same, and next to nothing of the torque is left."""

    def torque(now: float) -> float:
        return 0.05 * (2.0 / np.pi) * np.arcsin(np.sin(0.5 * np.pi * (now - 2.0)))

    machine = dataclasses.replace(ROTARY, inertia=2.0 * INERTIA)
    m = _moved(torque, (0.026, 0.034), 2.0 * INERTIA)
    effort = np.array([torque(now) for now in m.t.tolist()])
    barred = ("direction_dependent_friction", "constant_load", "rotor_viscous_friction")
    found = _by_name(diagnose(recorded(m, effort, machine, 1e-4, 6e-4), machine, without=barred))
    for name, true in (
        ("viscous_nm_s_per_rad", VISCOUS),
        ("coulomb_nm", 0.030),
        ("torque_nm", -0.004),
        ("inertia_kg_m2", 2.0 * INERTIA),
    ):
        assert found[name].low < true < found[name].high, name
    assert found["relative_torque_error"].value < 0.02


def test_a_friction_that_the_file_leaves_out_does_not_bend_the_stated_one() -> None:
    """Coulomb friction as stated, and viscous friction of which the file has none, below what
    would be named: measured beside each other, both intervals hold the true values."""
    m = motion(1.5)
    level, slope = 0.05, 4e-3
    machine = dataclasses.replace(ROTARY, inertia=0.02, coulomb=level)
    effort = 0.02 * m.a + level * np.sign(m.v) + slope * m.v
    result = diagnose(recorded(m, effort, machine, 0.03, 1e-5), machine)
    found = _by_name(result)
    assert found["coulomb_nm"].low < level < found["coulomb_nm"].high
    assert found["viscous_nm_s_per_rad"].low < slope < found["viscous_nm_s_per_rad"].high


def test_beside_a_wrong_gain_the_stated_constants_are_not_measured_too() -> None:
    """Half the stated gain, told by inertia and friction of the file: it is named, and values that
    only it together with them could give are not told; friction that is new is, in N m."""
    m = motion(1.5)
    machine = dataclasses.replace(ROTARY, gain=2.0, inertia=0.02, viscous=0.01)
    torque = 0.02 * m.a + 0.01 * m.v + 0.08 * np.sign(m.v)
    result = diagnose(recorded(m, torque, machine, 0.01, 1e-5), machine)
    assert [one.effect for one in result.causes] == [
        "rotor_coulomb_friction",
        "torque_constant_error",
    ]
    found = _by_name(result)
    assert set(found) == {"coulomb_nm", "torque_constant_nm_per_a", "relative_torque_error"}
    assert found["coulomb_nm"].low < 0.08 < found["coulomb_nm"].high
    gain = found["torque_constant_nm_per_a"]
    assert gain.low < 1.0 < gain.high
