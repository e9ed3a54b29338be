"""Stand-ins are told from causes by the size they need here and there."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from sheets import exact

from ecyl_ros.effects.catalogue import CATALOGUE
from ecyl_ros.gap.fit.descent import polish, search
from ecyl_ros.gap.fit.fit import Fitter
from ecyl_ros.gap.judge.constancy import Inconstancy, by_chance, inconstancies
from ecyl_ros.gap.replay.replay import Replay
from ecyl_ros.gap.split import held_out
from ecyl_ros.gap.study.cylinder.cases import Case, record_case

DRIVE = exact("bench")


def _worst(true: dict, fitted: str, start: dict[str, float]) -> tuple[Inconstancy, dict]:
    """What gives `fitted` away on the study's machine with the effects `true`."""
    recording = record_case(Case(0, 8, "pair", true), DRIVE)
    replay = Replay(recording, DRIVE, "recording")
    fitter = Fitter(replay, held_out(replay.time_s))
    fit = polish(fitter, search(fitter, fitter.evaluate({fitted: start}), fitter.nominal), 6)
    (worst,) = inconstancies(fit, fitter)
    return worst, fit.values[fitted]


@pytest.mark.parametrize(
    ("true", "fitted", "start", "condition"),
    [
        (
            {"x_warming_winding": {"rise_per_s": 0.08}},
            "resistance_error",
            {"resistance_ohm": 1.0},
            "time",
        ),
        (
            {"x_quadratic_drag": {"drag_nm_s2_per_rad2": 2e-4}},
            "rotor_viscous_friction",
            {"viscous_nm_s_per_rad": 2e-3},
            "speed",
        ),
    ],
)
def test_a_stand_in_needs_another_size_elsewhere(true, fitted, start, condition) -> None:
    """A winding that warms up, a drag with the square of speed: what is fitted in their place
    needs a size that rises with time, with speed."""
    worst, _ = _worst(true, fitted, start)
    assert worst.condition == condition
    assert worst.gain > 0.08
    assert list(worst.sizes) == sorted(worst.sizes) and worst.sizes[0] < worst.sizes[-1]


def test_a_true_cause_keeps_its_size_beside_another() -> None:
    """A wrong resistance beside an unknown second harmonic of the encoder: one size everywhere."""
    true = {
        "resistance_error": {"resistance_ohm": 1.1},
        "x_encoder_second_harmonic": {"amplitude_rad": 2e-3},
    }
    worst, values = _worst(true, "resistance_error", {"resistance_ohm": 0.9})
    assert values["resistance_ohm"] == pytest.approx(1.1, rel=0.05)
    assert worst.gain < 0.03


def test_every_effect_can_be_tried_in_other_sizes() -> None:
    """Scaling an effect by one leaves its parameters as they are, whatever they mean."""
    for effect in CATALOGUE.values():
        values = {
            one.name: 0.5 * (max(one.low, -1.0) + min(one.high, 1.0)) for one in effect.parameters
        }
        assert effect.scaled(values, 1.0, DRIVE) == pytest.approx(values, rel=1e-12)


def _amplifying(levels: list[float], amplified: bool) -> Any:
    """A fitter whose perfect model leaves another constant, in floors, in each draw of noise."""

    def healthy_with(effects: Any, draw: int) -> Any:
        return np.full((2, 100), levels[draw])

    usable = np.ones(100, dtype=bool)
    replay = SimpleNamespace(noise_in_loop=True, healthy_with=healthy_with, usable=usable)
    return SimpleNamespace(replay=replay, amplified=amplified)


def test_what_a_loop_makes_of_noise_is_no_surplus() -> None:
    """Two standard deviations of what six draws of noise in the loop leave are chance; draws that
    leave alike, or a loop that does not amplify, leave nothing to chance."""
    levels = [0.1, 0.2, 0.3, 0.1, 0.2, 0.3]  # so small that the robust square is the square
    fit: Any = SimpleNamespace(values={})
    spread = 2.0 * np.std([one**2 for one in levels], ddof=1)
    assert by_chance(fit, _amplifying(levels, True)) == pytest.approx(spread, rel=0.01)
    assert by_chance(fit, _amplifying([0.2] * 6, True)) == pytest.approx(0.0, abs=1e-12)
    assert by_chance(fit, _amplifying(levels, False)) == 0.0
