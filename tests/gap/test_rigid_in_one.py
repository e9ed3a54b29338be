"""Friction by direction, of which friction and a load were found before it."""

from __future__ import annotations

import numpy as np
import pytest
from rigid_machines import LINEAR, motion, recorded

from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.gap.study.case import Case
from ecyl_ros.gap.study.drives import RigidDrives

NAME = "direction_dependent_friction"


@pytest.mark.parametrize(("seed", "linear"), [(396336528, True), (1397923167, False)])
def test_one_friction_takes_the_place_of_the_parts_that_came_first(seed, linear) -> None:
    """Drives of the study, on which Coulomb friction and a load promise as much at first, and fit
    worse than the one that they make up: it alone is named, and its levels' intervals hold."""
    drives = RigidDrives(sheet=0.02)
    planned = Case(
        0, seed, "single", {NAME: {}}, drives="rigid", sheet=0.02, facts={"linear": linear}
    )
    case = drives.complete(planned)
    given = drives.given(case)
    (cause,) = diagnose(given.recording, given.drive).causes
    assert cause.effect == NAME
    found = {one.name: one for one in cause.parameters}
    for name, value in case.effects[NAME].items():
        if name.startswith("coulomb"):
            assert found[name].low < value < found[name].high


def test_friction_and_a_weight_stay_two() -> None:
    """Of one level and one slope both ways, beside a load: friction by direction is not named."""
    m = motion(0.05)
    effort = 20.0 * m.a + 4.0 * np.tanh(m.v / 1e-4) + 12.0 * m.v + 7.0
    found = diagnose(recorded(m, effort, LINEAR, 1.0, 1e-6), LINEAR)
    assert {one.effect for one in found.causes} == {
        "load_coulomb_friction",
        "constant_load",
        "load_viscous_friction",
    }
