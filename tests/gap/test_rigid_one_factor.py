"""A gain and another constant off by one factor: the rest of the file is off by the inverse."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from rigid_machines import LINEAR, causes, motion, recorded

from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.gap.diagnosis import Diagnosis, SheetValue
from ecyl_ros.gap.rigid.one_factor import off_by_one

M = motion(0.05)
KEYS = ("load.mass", "actuation.gain", "load.viscous_friction", "load.coulomb_friction")
FILE = dataclasses.replace(
    LINEAR,
    actuation="voltage",
    gain=5.0,
    viscous=200.0,
    coulomb=30.0,
    tolerances=dict.fromkeys(KEYS, 0.04),
)


def judged(mass: float, viscous: float, gain: float, without: tuple[str, ...] = ()) -> Diagnosis:
    """Of a machine with these constants; 20 kg, 200 N s/m and 5 N/V are on its sheet."""
    force = mass * M.a + viscous * M.v + 30.0 * np.tanh(M.v / 1e-4)
    return diagnose(recorded(M, force / gain, FILE, 0.02, 1e-6), FILE, without=without)


def test_one_wrong_friction_without_its_name_is_not_a_gain_and_a_mass() -> None:
    """A quarter more viscous friction, which must not be named: nothing is, and it is said that
    all else would have to be off by a fifth."""
    found = judged(20.2, 255.0, 5.1, ("load_viscous_friction",))
    assert found.causes == ()
    (said,) = (note for note in found.notes if "one factor" in note)
    assert said.startswith("actuation.gain and ") and "load.mass" in said


def test_with_its_name_it_is_named_alone() -> None:
    """The same machine: friction with its size, and no note."""
    found = judged(20.2, 255.0, 5.1)
    assert list(causes(found)) == ["load_viscous_friction"]
    assert not any("one factor" in note for note in found.notes)


def test_constants_off_by_other_factors_are_two_faults() -> None:
    """A gain a fifth too small beside a mass that is a third larger: both are named."""
    found = causes(judged(27.0, 200.0, 4.0))
    assert set(found) == {"torque_constant_error", "load_inertia_error"}
    mass = found["load_inertia_error"].parameters[0]
    assert mass.value == pytest.approx(27.0, rel=0.05)
    assert np.isfinite([mass.low, mass.high]).all()


@pytest.mark.parametrize(("half", "one"), [(0.02, False), (0.2, True)])
def test_constants_are_off_by_one_factor_as_far_as_the_recording_tells_them(half, one) -> None:
    """A gain of 0.69 and a friction of 0.55 of the sheet, both known to 10 %: one factor where the
    recording tells the friction to a fifth, not where it tells it to a fiftieth."""
    gain, friction = (
        SheetValue("", "", 1.0, 0.1, found, found * (1.0 - known), found * (1.0 + known), seen=True)
        for found, known in ((0.69, 0.02), (0.55, half))
    )
    assert off_by_one(gain, friction) is one
