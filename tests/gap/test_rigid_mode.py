"""A drive that is not rigid, and an effort that jumps at the same places again and again."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from rigid_machines import LINEAR, causes

from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.gap.rigid.jumps import jumping
from ecyl_ros.recording.signals import Recording

MASS_KG = 6.28
FRICTION_N = 1.5
LOGGED_HZ = 150.0
PAST_M = 2e-3  # the middle, where the relay turns: what it gives there friction takes
COUNT_M = 8.8e-5
ANTIRESONANCE_HZ = 18.0  # of what hangs at the belt
MACHINE = dataclasses.replace(LINEAR, inertia=MASS_KG)


def _on_a_belt(share: float, seconds: float = 20.0) -> Recording:
    """A cart under a relay that turns at the middle of its stroke: its motor's speed, by counts.

    share: of the mass that lies behind the belt. 0.95 of it gives a resonance at 80 Hz.
    """
    step = 1e-4
    every = round(1.0 / (LOGGED_HZ * step))
    motor, load = (1.0 - share) * MASS_KG, share * MASS_KG
    stiffness = load * (2.0 * np.pi * ANTIRESONANCE_HZ) ** 2
    damping = 0.03 * np.sqrt(stiffness * load)
    place, speed = np.zeros(2), np.array([0.28, 0.28])
    rng = np.random.default_rng(4)
    force, past = 13.0, PAST_M
    places, forces = [], []
    for number in range(int(seconds / step)):
        if number % every == 0:
            if force * (place[0] - np.sign(force) * past) > 0.0 and force * speed[0] > 0.0:
                force, past = -force, PAST_M + 2e-4 * rng.standard_normal()
            places.append(place[0])
            forces.append(force)
        belt = stiffness * (place[0] - place[1]) + damping * (speed[0] - speed[1])
        drag = FRICTION_N * np.tanh(speed[0] / 1e-3)
        speed += step * np.array([(force - belt - drag) / motor, belt / load])
        place += step * speed
    counted = np.round(np.array(places) / COUNT_M) * COUNT_M
    made = np.diff(counted, prepend=counted[0]) * LOGGED_HZ
    stamps = np.round(np.arange(made.size) / LOGGED_HZ * 1e9).astype(np.int64)
    return Recording(stamp_ns=stamps, rod_velocity_m_per_s=made, rod_force_n=np.array(forces))


@pytest.mark.parametrize("share", [0.95, 0.9])
def test_what_a_belt_does_at_the_turns_of_a_relay_is_no_jam(share: float) -> None:
    """Friction of 1.5 N alone is named, its level within 10 %: no jam where the relay turns."""
    found = causes(diagnose(_on_a_belt(share), MACHINE))
    assert set(found) == {"load_coulomb_friction"}
    assert found["load_coulomb_friction"].parameters[0].value == pytest.approx(FRICTION_N, rel=0.1)


def test_an_effort_jumps_where_it_changes_alone() -> None:
    """Edges of a square wave, sharp or between two stamps; none of a sine, of noise, of a ramp."""
    time = np.arange(3000) / 150.0
    usable = np.ones(time.size, dtype=bool)
    square = np.sign(np.sin(2.0 * np.pi * 2.3 * time + 0.01))
    edges = np.flatnonzero(np.diff(square))
    assert set(edges) <= set(np.flatnonzero(jumping(square, usable)))
    between = 0.3 * square[:-1] + 0.7 * square[1:]
    found = np.flatnonzero(jumping(between, usable[1:]))
    assert all(np.any(np.abs(found - edge) <= 1) for edge in edges[1:-1])
    noise = np.random.default_rng(2).standard_normal(time.size)
    for smooth in (np.sin(2.0 * np.pi * 5.0 * time), time, 0.0 * time):
        assert not jumping(smooth, usable).any()
    assert np.mean(jumping(noise, usable)) < 0.05
    assert set(edges) <= set(np.flatnonzero(jumping(square + 0.02 * noise, usable)))
