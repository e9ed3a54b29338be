"""Gaps of rigid drives that are looked at again in the band of the effort."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from rigid_machines import ROTARY, Motion, motion, recorded

from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.gap.diagnosis import Diagnosis
from ecyl_ros.gap.report.verdict import sentence

INERTIA, VISCOUS = 0.06, 0.4
M = motion(1.0, duration_s=16.0)


def _shaken(stated_viscous: float) -> Diagnosis:
    """A drive whose output shakes at 17 to 23 Hz as it moves, which its effort has nothing of."""
    rate = 2.0 * np.pi * 20.0
    size = 2e-2 * M.v / np.abs(M.v).max()
    shake = size * np.sin(rate * M.t + 1.5 * np.sin(2.0 * np.pi * 0.9 * M.t))
    seen = Motion(M.t, M.q + shake, M.v, M.a)
    machine = dataclasses.replace(ROTARY, inertia=INERTIA, viscous=stated_viscous)
    effort = INERTIA * M.a + VISCOUS * M.v
    return diagnose(recorded(seen, effort, machine, 0.005, 1e-4), machine)


def test_friction_is_named_below_what_shakes_the_output() -> None:
    """The band of the comparison holds the shaking, which no effect explains; that of the effort
    does not: the friction that the file lacks is named there, and the rest stays unexplained."""
    found = _shaken(0.25 * VISCOUS)
    (cause,) = found.causes
    assert cause.effect == "rotor_viscous_friction" and found.verdict == "partly_explained"
    assert cause.parameters[0].value == pytest.approx(0.75 * VISCOUS, rel=0.05)
    assert "compared in the band of the torque" in found.notes[0]


def test_a_right_sheet_stays_unexplained_above_the_band_of_the_effort() -> None:
    """Nothing is named, and a note says that there is no gap where the effort lies."""
    found = _shaken(VISCOUS)
    assert found.verdict == "unexplained" and not found.causes
    assert "there is no gap beyond the tolerances" in found.notes[0]
    assert "of the torque is left" in sentence(found)
