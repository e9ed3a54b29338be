"""Two faults of a rigid drive at once, one of them far off the sheet."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from rigid_machines import LINEAR, ROTARY, causes, motion, recorded

from ecyl_ros.gap.diagnose import diagnose

M = motion(0.1)
WAY = np.sign(M.v)
TOP = float(np.quantile(np.abs(M.v), 0.99))
FILE = dataclasses.replace(LINEAR, viscous=2.0 / TOP, coulomb=2.0, tolerances={"all": 0.04})
INERTIA = FILE.inertia or 0.0


@pytest.mark.parametrize(
    ("friction", "other"),
    [("by_direction", "inertia"), ("drift", "spring"), ("drift", "disturbance")],
)
def test_a_friction_far_off_the_sheet_does_not_make_another_cause_unsure(
    friction: str, other: str
) -> None:
    """Both are named at 0.9 or surer, and no other; friction of any form is 30 tolerances off."""
    t = M.t
    mass = INERTIA * (1.3 if other == "inertia" else 1.0)
    rubs = {
        "by_direction": np.where(WAY > 0.0, 8.0 + 6.0 / TOP * M.v, 4.0 - 2.0 / TOP * M.v),
        "drift": 5.0 * (1.0 + 0.02 * t),
    }[friction]
    more = {
        "inertia": 0.0 * t,
        "spring": 60.0 * M.q,
        "disturbance": 2.0 * np.sin(2.0 * np.pi * 7.3 * t),
    }[other]
    effort = mass * M.a + FILE.viscous * M.v + rubs * WAY + more
    found = causes(diagnose(recorded(M, effort, FILE, 0.2, 1e-6), FILE))
    names = {
        "by_direction": "direction_dependent_friction",
        "drift": "friction_drift",
        "inertia": "load_inertia_error",
        "spring": "spring_load",
        "disturbance": "periodic_disturbance",
    }
    assert set(found) == {names[friction], names[other]}
    assert found[names[friction]].confidence >= 0.9
    least = 0.7 if other == "disturbance" else 0.9  # another axis may swing, too
    assert found[names[other]].confidence >= least


def test_a_weight_and_a_spring_are_both_named_where_the_arm_turns_far() -> None:
    """Over more than a turn one is no form of the other."""
    arm = dataclasses.replace(ROTARY, coulomb=0.1, tolerances={"all": 0.04})
    m = motion(2.5)
    effort = (arm.inertia or 0.0) * m.a + 0.1 * np.sign(m.v) + 1.5 * np.sin(m.q + 0.3) + 0.2 * m.q
    found = causes(diagnose(recorded(m, effort, arm, 0.03, 1e-5), arm))
    assert set(found) == {"gravity_on_arm", "spring_load"}
    (stiffness,) = found["spring_load"].parameters
    assert stiffness.value == pytest.approx(0.2, rel=0.05)


def test_a_spring_beside_friction_by_direction_is_slack_at_zero() -> None:
    """Levels by direction hold a load, and so may a spring's rest position: both together are
    known once the spring is slack at position 0. All values within their intervals."""
    level = np.where(WAY > 0.0, 8.0 + 6.0 / TOP * M.v, 4.0 - 2.0 / TOP * M.v)
    effort = INERTIA * M.a + FILE.viscous * M.v + level * WAY + 300.0 * M.q
    found = causes(diagnose(recorded(M, effort, FILE, 0.2, 1e-6), FILE))
    assert set(found) == {"direction_dependent_friction", "spring_load"}
    told = {p.name: p for one in found.values() for p in one.parameters}
    true = {
        "coulomb_positive_n": 8.0 - FILE.coulomb,
        "coulomb_negative_n": 4.0 - FILE.coulomb,
        "stiffness_n_per_m": 300.0,
    }
    for name, value in true.items():
        assert told[name].low <= value <= told[name].high, name


def test_what_is_small_is_named_where_it_alone_takes_the_rest_to_the_floor() -> None:
    """Cogging that holds 2 % of a gap of friction, and all that is left of it above noise: named.
    Beside as much of a form that the catalogue does not have nothing so small is named."""
    cogging = 1.1 * np.sin(2.0 * np.pi * M.q / 0.0123)
    other = np.sin(40.0 * M.q / np.std(M.q)) * np.cos(3.0 * M.v / TOP) * np.abs(M.v) / TOP
    bare = INERTIA * M.a + FILE.viscous * M.v + 40.0 * WAY
    found = causes(diagnose(recorded(M, bare + cogging, FILE, 0.2, 1e-6), FILE))
    assert set(found) == {"load_coulomb_friction", "cogging_torque"}
    assert found["cogging_torque"].shrink < 0.03
    beside = bare + cogging + 4.0 * other
    found = causes(diagnose(recorded(M, beside, FILE, 0.2, 1e-6), FILE))
    assert "cogging_torque" not in found and "load_coulomb_friction" in found
