"""A parameter at the bound of its fit: pressed there by the data, or drifted there in noise."""

from __future__ import annotations

from typing import cast

import numpy as np
import pytest
from sheets import exact
from short_motions import recorded
from small_field import without_all_but

from ecyl_ros.effects.catalogue import CATALOGUE
from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.gap.fit.coordinate import Coordinate
from ecyl_ros.gap.fit.fit import Fit, Fitter
from ecyl_ros.gap.judge.intervals import intervals
from ecyl_ros.gap.judge.pressed import pressed
from ecyl_ros.gap.sheet import Sheet

ROWS = 4000
LOAD = CATALOGUE["constant_load"].parameters[0]
FRICTION = CATALOGUE["load_coulomb_friction"].parameters[0]


class _Fitter:
    """As much of a fitter as is asked for: white noise on one signal, an exact sheet."""

    def __init__(self) -> None:
        drive = exact("bench")
        self.sheet = Sheet.of(drive, 12.0)
        self.rows = np.ones(ROWS, dtype=bool)
        self.replay = type(
            "Replay", (), {"nominal": drive, "drive": drive, "time_s": np.linspace(0.0, 12.0, ROWS)}
        )()

    def shown(self, name: str) -> dict[str, float]:
        """Nothing is."""
        return {}


def _fit(coordinate: Coordinate, value: float, column: np.ndarray, left: np.ndarray) -> Fit:
    """A fit of one parameter that ended at a value; column: of the gap by its coordinate."""
    values = {coordinate.effect: {coordinate.quantity.name: value}}
    return Fit(values, np.zeros(0), left[None], 1.0, 1.0, 1.0, (coordinate,), (), column[None])


@pytest.mark.parametrize(
    ("beyond", "found"), [(0.0, False), (1.0, False), (8.0, True), (-8.0, False)]
)
def test_a_bound_holds_what_the_data_want_beyond_it(beyond: float, found: bool) -> None:
    """A load at its upper bound whose best value is so many standard deviations further out; one
    within the bounds is not pressed, however far the fit stopped from it."""
    coordinate = Coordinate("constant_load", LOAD, False, 1.0, -5.0, 5.0)
    fitter = _Fitter()
    column = np.cos(np.arange(ROWS))
    column /= np.linalg.norm(column)  # the load is known to 1 N
    noise = np.random.default_rng(1).standard_normal(ROWS)
    noise -= column * (noise @ column) / (column @ column)
    fit = _fit(coordinate, 5.0, column, noise - beyond * column)
    assert fit.bounds_hit == ("constant_load.force_n",)
    assert (pressed(fit, cast(Fitter, fitter)) == set(fit.bounds_hit)) == found


def test_what_is_not_told_from_nothing_has_an_interval_from_nothing_on() -> None:
    """A friction of a hundredth of its standard deviation, fitted in logarithms: 0 to what noise
    allows, not a thousand decades; one of 30 standard deviations is as before."""
    fitter = _Fitter()
    column = np.cos(np.arange(ROWS))
    spread = 0.02  # N m
    column /= spread * np.linalg.norm(column)
    noise = np.random.default_rng(2).standard_normal(ROWS)
    ends = {}
    for value in (2e-4, 0.6):
        coordinate = Coordinate.around("load_coulomb_friction", FRICTION, value)
        fit = _fit(coordinate, value, value * column, noise)
        spans, _ = intervals(fit, cast(Fitter, fitter))
        ends[value] = spans["load_coulomb_friction", "coulomb_nm"]
    low, high = ends[2e-4]
    assert low == 0.0 and 1.5 * spread < high < 4.0 * spread
    low, high = ends[0.6]
    assert 0.5 < low < 0.6 - 1.5 * spread and 0.6 + 1.5 * spread < high < 0.7


def test_friction_that_rises_with_speed_in_one_direction_alone_is_named() -> None:
    """No level either way: both drift to nothing, which does not stand in the way of the cause."""
    one_way = {
        "coulomb_positive_nm": 0.0,
        "coulomb_negative_nm": 0.0,
        "viscous_positive_nm_s_per_rad": 0.02,
        "viscous_negative_nm_s_per_rad": 0.0,
    }
    name = "direction_dependent_friction"
    field = without_all_but(name, "load_viscous_friction", "load_coulomb_friction", "constant_load")
    result = diagnose(recorded(0, {name: one_way}), exact("bench"), without=field)
    assert [one.effect for one in result.causes] == [name]
    assert result.verdict == "explained"
    for found in result.causes[0].parameters:
        assert found.low <= one_way[found.name] <= found.high, found.name
        assert not found.at_bound
