"""Intervals of what is named hold what the same recording shows beside it without naming it."""

from __future__ import annotations

import dataclasses

import numpy as np
from rigid_machines import ROTARY, along, causes, recorded

from ecyl_ros.effects import load_coulomb_friction as coulomb
from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.gap.rigid.balance import Balance
from ecyl_ros.gap.rigid.motion import motion_of
from ecyl_ros.gap.rigid.other_friction import as_a_sum
from ecyl_ros.gap.rigid.terms import Catalogue
from ecyl_ros.gap.rigid.uncertainty import intervals

LEVEL, VISCOUS = 1.4, 0.7  # N m, N m s/rad


def test_at_one_speed_a_level_is_as_unsure_as_its_share_of_the_friction() -> None:
    """An output that starts and goes on at 1.5 rad/s to a few percent, with friction of both kinds:
    whether one of them is named for both or each for itself, the intervals hold the true values."""
    t = np.arange(6000) / 1000.0
    m = along(1.5 * (1.0 - np.exp(-t / 0.1)) * (1.0 + 0.08 * np.sin(4.4 * t + 1.0)))
    ripple = 0.08 * np.sin(7.0 * m.q) + 0.05 * np.sin(69.0 * t)
    effort = 0.1 * m.a + LEVEL + VISCOUS * m.v + ripple
    machine = dataclasses.replace(ROTARY, inertia=None)
    found = causes(diagnose(recorded(m, effort, machine, 0.03, 1e-4), machine))
    true = {"rotor_coulomb_friction": LEVEL, "rotor_viscous_friction": VISCOUS}
    named = {name: one.parameters[0] for name, one in found.items() if name in true}
    assert named
    for name, one in named.items():
        assert one.low < true[name] < one.high, name


def test_a_level_that_may_be_all_viscous_shares_with_it() -> None:
    """The same start with friction of the viscous kind alone, told from a level by the start and no
    more: it is not called a level of which the report says that it may be nothing."""
    t = np.arange(6000) / 1000.0
    m = along(1.5 * (1.0 - np.exp(-t / 0.1)) * (1.0 + 0.03 * np.sin(4.4 * t + 1.0)))
    effort = 0.1 * m.a + 2.1 * m.v / 1.5 + 0.3 * np.sin(7.0 * m.q) + 0.2 * np.sin(31.0 * t)
    machine = dataclasses.replace(ROTARY, inertia=None)
    found = causes(diagnose(recorded(m, effort, machine, 0.03, 1e-4), machine))
    level = found.get("rotor_coulomb_friction")
    assert level is None or not level.parameters[0].low <= 0.0


def test_the_interval_of_a_sum_reaches_to_each_part_that_is_no_less_than_none() -> None:
    """Strokes at 20 rad/s each way under a level and friction by speed, the level fitted for both:
    its interval lies above the true level, and reaches it with what may be the other's."""
    t = np.arange(12_000) / 1000.0
    ramp = np.clip(10.0 * np.minimum(t % 6.0, 6.0 - t % 6.0), 0.0, 1.0)
    m = along(np.where(t < 6.0, 20.0, -20.0) * ramp)
    effort = 1e-4 * m.a + LEVEL * np.sign(m.v) + 0.01 * m.v
    machine = dataclasses.replace(ROTARY, inertia=1e-4)
    moved = motion_of(recorded(m, effort, machine, 0.3, 1e-4), machine, "strokes", None)
    catalogue = Catalogue(moved, machine)
    balance = Balance(moved, catalogue.nominal(), catalogue.model)
    alone = coulomb.term(catalogue.along)
    fit = balance.fit([alone], balance.usable)
    spans = intervals(balance, fit, balance.usable)
    wider, taken = as_a_sum(balance, catalogue.along, fit, spans)
    first = wider[alone.key]
    assert spans[alone.key][0].low > LEVEL + 0.1
    assert first.low < LEVEL and first.high == spans[alone.key][0].high
    assert not taken  # a level there is, for sure
    stated = dataclasses.replace(machine, viscous=0.01)
    known = Catalogue(moved, stated)
    held = Balance(moved, known.nominal(), known.model)
    fit = held.fit([alone], held.usable)
    assert as_a_sum(held, known.along, fit, intervals(held, fit, held.usable)) == ({}, {})
