"""White noise of an effort hides a value that is small, and speaks neither for nor against it."""

from __future__ import annotations

import numpy as np
from rigid_machines import ROTARY, motion, recorded

from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.gap.diagnosis import Diagnosis

M = motion(1.0)
STATED = ROTARY.inertia or 0.0


def _diagnosed(effort: np.ndarray) -> Diagnosis:
    """Under noise of one and a half times what half the stated inertia asks for."""
    noise = 1.5 * float(np.std(0.5 * STATED * M.a))
    return diagnose(recorded(M, effort, ROTARY, noise, 1e-5), ROTARY)


def test_half_the_inertia_is_named_under_more_noise_than_it_asks_for() -> None:
    """The model explains the effort as far as it is no noise: the inertia is named, the true one
    within its interval."""
    result = _diagnosed(0.5 * STATED * M.a)
    (cause,) = result.causes
    (inertia,) = cause.parameters
    assert cause.effect == "rotor_inertia_error"
    assert inertia.low <= 0.5 * STATED <= inertia.high


def test_an_effort_of_noise_alone_is_no_lighter_machine() -> None:
    """Something else moves the output, the drive asks for nothing but its noise: no inertia of
    next to nothing is named for it."""
    assert not _diagnosed(np.zeros(M.t.size)).causes
