"""What few strokes say: a direction gone in once is a time of day, and a load has either sign."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest
from rigid_machines import LINEAR, ROTARY, Motion, along, causes, recorded

from ecyl_ros.effects import constant_load, load_coulomb_friction
from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.gap.rigid import diagnose as rigid
from ecyl_ros.gap.rigid import void


def _strokes(each_way: int) -> Motion:
    t = np.arange(10_000) / 1000.0
    return along(0.6 * np.sin(2.0 * np.pi * each_way * t / 10.0) * (1.0 + 0.3 * np.sin(7.0 * t)))


@pytest.mark.parametrize("each_way", [1, 3])
def test_friction_of_a_direction_needs_a_second_stroke(each_way: int) -> None:
    """A joint that rubs more backwards than forwards: named so where it goes each way three times,
    and as friction, whatever its form, where it goes once; the whole arm may have changed then."""
    m = _strokes(each_way)
    friction = np.where(m.v > 0.0, 100.0 + 40.0 * m.v, -130.0 + 280.0 * m.v)
    machine = dataclasses.replace(ROTARY, inertia=None)
    found = causes(diagnose(recorded(m, 95.0 * m.a + friction, machine, 5.0, 1e-4), machine))
    assert ("direction_dependent_friction" in found) is (each_way > 1)
    assert each_way > 1 or {"rotor_coulomb_friction", "rotor_viscous_friction"}.intersection(found)


def test_a_load_is_less_where_it_goes_against_that_of_the_file(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of a model that explains little: a negative load is as good as a positive one where the file
    states none, and friction below zero is less than the file's in any case."""
    monkeypatch.setattr(void, "white_part", lambda *_: 0.1)
    balance = SimpleNamespace(usable=np.ones(4, bool), effort=np.array([1.0, -1.0, 1.0, -1.0]))
    for term, value, stated, less in (
        (constant_load, -2.0, 0.0, False),
        (constant_load, 2.0, 0.0, False),
        (constant_load, -2.0, 5.0, True),
        (constant_load, -2.0, -5.0, False),
        (load_coulomb_friction, -2.0, 0.0, True),
    ):
        fit = SimpleNamespace(of=lambda term, v=value: np.array([v]), rms=lambda rows: 0.9)
        seen = SimpleNamespace(model=SimpleNamespace(constant=stated))
        one = SimpleNamespace(effect=term.EFFECT.name)
        assert void._drowns(balance, seen, fit, one) is less


def test_no_set_is_its_own_floor(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the set that won leaves far less than what does not repeat, the floor is what the
    closest of all sets leaves, so that a set further off does not count as a perfect model."""
    rows = np.ones(4, bool)
    monkeypatch.setattr(rigid, "_floor", lambda *_: (1.0, "what the same motion does not repeat"))
    monkeypatch.setattr(rigid, "white_part", lambda *_: 0.1)
    monkeypatch.setattr(rigid, "moving", lambda *_: rows)
    balance = SimpleNamespace(judged=rows, usable=rows, motion=None, effort=np.ones(4))
    catalogue = SimpleNamespace(machine=LINEAR, along=None)

    def left(size: float) -> SimpleNamespace:
        return SimpleNamespace(rms=lambda rows: size)

    for winner, rival, floor in ((0.4, 0.25, 0.25), (0.4, 0.5, 0.4), (0.6, 0.3, 1.0)):
        contest = SimpleNamespace(winner=left(winner), rivals=(left(rival),), singles=(left(0.9),))
        assert rigid._finer_floor(balance, catalogue, contest)[0] == floor
