"""What is not clear of a healthy machine is no cause."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from sheets import exact

from ecyl_ros.gap.fit.fit import Fit
from ecyl_ros.gap.judge import clear
from ecyl_ros.gap.sheet import Sheet


class Fitter:
    """As much of a fitter as is asked for."""

    def __init__(self, tolerance: float | str) -> None:
        drive = dataclasses.replace(exact("bench"), tolerances={"all": tolerance})
        self.sheet = Sheet.of(drive, 12.0)
        self.rows = np.ones(1, dtype=bool)
        self.replay = type("Replay", (), {"nominal": drive, "time_s": np.zeros(1)})()


def found(monkeypatch, tolerance, effect: str, spans: dict[str, tuple[float, float]]):
    """What is unclear about one effect with these 95 % intervals by parameter."""
    given = {(effect, name): span for name, span in spans.items()}
    monkeypatch.setattr(clear, "intervals", lambda *_: (given, np.zeros(0)))
    values = {effect: {name: sum(span) / 2.0 for name, span in spans.items()}}
    fit = Fit(values, np.zeros(0), np.zeros((1, 1)), 1.0, 1.0, 1.0)
    return clear.unclear(fit, Fitter(tolerance))


@pytest.mark.parametrize(
    ("tolerance", "low", "high", "unclear"),
    [
        ("exact", 0.74, 0.78, False),  # 0.73 ohm nominal
        ("exact", 0.72, 0.78, True),
        (0.1, 0.79, 0.83, True),  # up to 0.803 ohm is sound
        (0.1, 0.81, 0.85, False),
        (0.1, 0.60, 0.65, False),
    ],
)
def test_a_constant_is_a_cause_beyond_its_tolerance(
    monkeypatch, tolerance, low, high, unclear
) -> None:
    """The interval must be clear of nominal +- tolerance."""
    said = found(monkeypatch, tolerance, "resistance_error", {"resistance_ohm": (low, high)})
    assert (list(said) == ["resistance_error"]) == unclear


def test_a_load_of_zero_within_its_interval_is_none(monkeypatch) -> None:
    """-20 to 30 N is no load; 20 to 30 N is one."""
    assert found(monkeypatch, "exact", "constant_load", {"force_n": (-20.0, 30.0)})
    assert not found(monkeypatch, "exact", "constant_load", {"force_n": (20.0, 30.0)})


def test_an_effect_of_several_sizes_vanishes_with_all_of_them(monkeypatch) -> None:
    """Friction in one direction alone is a friction."""
    one_way = {"coulomb_positive_nm": (0.1, 0.2), "coulomb_negative_nm": (-0.1, 0.1)}
    assert not found(monkeypatch, "exact", "direction_dependent_friction", one_way)
