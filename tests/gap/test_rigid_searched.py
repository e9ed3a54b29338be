"""Parameters that are searched: tuned beside all that acts, with intervals that hold the truth."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from rigid_machines import LINEAR, causes, motion, recorded

from ecyl_ros.gap.diagnose import diagnose

M = motion(0.1)
TOP = float(np.quantile(np.abs(M.v), 0.99))
FILE = dataclasses.replace(LINEAR, viscous=0.0, coulomb=0.0, tolerances={"all": 0.04})


def _parameters(effort: np.ndarray, effect: str, noise: float = 0.05, seed: int = 7) -> dict:
    found = causes(diagnose(recorded(M, effort, FILE, noise, 1e-6, seed), FILE))
    return {one.name: one for one in found[effect].parameters}


@pytest.mark.parametrize("share", [0.05, 0.083, 0.2])
def test_a_stribeck_speed_is_found_between_those_that_are_tried(share: float) -> None:
    """Beside a viscous friction of the same size: named with it, within 3 %, and its levels too."""
    coulomb, static, speed, viscous = 2.0, 6.0, share * TOP, 4.0 / TOP
    level = coulomb + (static - coulomb) * np.exp(-((M.v / speed) ** 2))
    effort = FILE.inertia * M.a + level * np.sign(M.v) + viscous * M.v
    result = diagnose(recorded(M, effort, FILE, 0.05, 1e-6), FILE)
    found = causes(result)
    assert set(found) == {"stribeck_friction", "load_viscous_friction"}
    told = {one.name: one for one in found["stribeck_friction"].parameters}
    true = {"coulomb_n": coulomb, "static_n": static, "stribeck_m_s": speed}
    for name, value in true.items():
        assert told[name].value == pytest.approx(value, rel=0.03), name
        assert told[name].low <= value <= told[name].high, name


def test_a_period_lies_within_its_interval() -> None:
    """Cogging of a period that nothing tells beforehand, in noise of its own size: its 95 %
    interval holds the truth in 11 of 12 recordings, and is no wider than a tenth of what two
    periods have to differ by to be told apart."""
    period, amplitude = 0.01234, 3.0
    inside, widths = 0, []
    for seed in range(12):
        effort = FILE.inertia * M.a + amplitude * np.sin(math.tau * M.q / period + 0.1 * seed)
        found = _parameters(effort, "cogging_torque", noise=amplitude, seed=seed)["period_m"]
        inside += found.low <= period <= found.high
        widths.append(0.5 * (found.high - found.low))
    assert inside >= 11
    assert np.median(widths) < 0.1 * period**2 / np.ptp(M.q)


def test_a_place_is_tuned_to_where_the_drag_is() -> None:
    """Drag on a part of the travel: middle and width within a tenth of its width, and within their
    intervals."""
    middle, width = 0.02, 0.03
    drag = 5.0 * 0.5 * (1.0 - np.tanh((np.abs(M.q - middle) - 0.5 * width) / (0.1 * width)))
    found = _parameters(FILE.inertia * M.a + drag * np.sign(M.v), "local_jam")
    for name, value in (("position_m", middle), ("width_m", width)):
        assert found[name].value == pytest.approx(value, abs=0.1 * width)
        assert found[name].low <= value <= found[name].high


def test_what_no_model_explains_bends_a_constant_as_far_as_its_tolerance() -> None:
    """Friction beside a gain that is known to 4 % and an inertia that is not known: nothing but the
    tolerance tells how both share an effort, and the interval is no wider than that."""
    file = dataclasses.replace(
        LINEAR, actuation="current", gain=10.0, inertia=None, coulomb=2.0, tolerances={"all": 0.04}
    )
    current = (20.0 * M.a + 6.0 * np.sign(M.v)) / 10.0
    found = causes(diagnose(recorded(M, current, file, 1e-4, 1e-8), file))
    (level,) = found["load_coulomb_friction"].parameters
    half = 0.5 * (level.high - level.low)
    assert level.low <= 4.0 <= level.high
    assert 0.04 * 4.0 < half < 2.0 * 0.04 * 6.0
