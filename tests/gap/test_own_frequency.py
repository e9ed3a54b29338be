"""A disturbance at the frequency of the motion itself."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ecyl_ros.gap.judge import own_frequency as module

TIME = np.arange(6000) / 1000.0
SINE = 7e-3 * np.sin(2.0 * np.pi * 0.94 * TIME + 0.4)


def motion(reference_m: np.ndarray) -> Any:
    """The replay of a recording, as far as it is asked here."""
    return SimpleNamespace(time_s=TIME, reference_m=reference_m)


def test_a_motion_of_one_sine_has_its_frequency_and_others_have_none() -> None:
    """To a thousandth, beside a small second sine; none of two, of strokes with rests, of rest."""
    assert module.swing_hz(motion(SINE)) == pytest.approx(0.94, rel=1e-6)
    small = 3e-4 * np.sin(2.0 * np.pi * 3.1 * TIME)
    assert module.swing_hz(motion(SINE + small)) == pytest.approx(0.94, rel=1e-3)
    assert module.swing_hz(motion(SINE + 10.0 * small)) is None
    strokes = np.clip(2.0 * SINE, -4e-3, 4e-3)
    assert module.swing_hz(motion(strokes)) is None
    assert module.swing_hz(motion(np.zeros(TIME.size))) is None


@pytest.mark.parametrize(
    ("hertz", "reference", "kept"), [(0.94, SINE, False), (2.7, SINE, True), (0.94, SINE**3, True)]
)
def test_a_disturbance_at_the_frequency_of_the_motion_is_not_named(
    monkeypatch: pytest.MonkeyPatch, hertz: float, reference: np.ndarray, kept: bool
) -> None:
    """It is taken out with a line that says why; one of another frequency, or in a motion of
    several, stays."""
    given = {"periodic_disturbance": {"amplitude_n": 265.0, "frequency_hz": hertz}}
    competition: Any = SimpleNamespace(winner=SimpleNamespace(values=given))
    fitter: Any = SimpleNamespace(replay=SimpleNamespace(parts=[motion(reference)]))
    monkeypatch.setattr(module, "without_effects", lambda competition, fitter, names: names)
    left, notes = module.without_own_frequency(competition, fitter)
    assert (left is competition) is kept
    assert kept or (left == ["periodic_disturbance"] and "0.94 Hz" in notes[0])
