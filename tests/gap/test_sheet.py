"""The data sheet as a distribution, and a competition that has to beat it."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from sheets import exact

from ecyl_ros.effects.catalogue import CATALOGUE
from ecyl_ros.gap.compete.earn import earns
from ecyl_ros.gap.compete.strain import strains
from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.gap.fit.fit import Fit
from ecyl_ros.gap.fit.gram import weighted_products
from ecyl_ros.gap.judge.strained import strained
from ecyl_ros.gap.sheet import Sheet
from ecyl_ros.gap.study.case import Case
from ecyl_ros.gap.study.cylinder.cases import record_case, stated
from ecyl_ros.gap.study.cylinder.sheet import true_constants
from ecyl_ros.gap.study.cylinder.stage import Stage

DRIVE = exact("bench")


def sheet(**tolerances: float | str) -> Sheet:
    """Of the bench drive with these tolerances, "__" for a dot, all others exact; over 12 s."""
    given = {key.replace("__", "."): value for key, value in tolerances.items()}
    drive = dataclasses.replace(DRIVE, tolerances={"all": "exact", **given})
    return Sheet.of(drive, 12.0)


def test_a_pull_is_a_distance_in_tolerances_on_a_logarithmic_scale() -> None:
    """A hundredth of 10 % of 0.73 ohm; far off by factors, so that nothing turns its sign."""
    one = sheet(motor__resistance=0.1)
    assert one.constants(np.array([0.01]))["motor.resistance"] == pytest.approx(0.73073, rel=1e-6)
    up, down = (one.values(np.array([pull]))[0] for pull in (20.0, -20.0))
    assert up * down == pytest.approx(0.73**2) and up == pytest.approx(0.73 * math.exp(2.0))


def test_the_price_is_that_of_a_normal_distribution() -> None:
    """At the edge of the sheet, two standard deviations, the logarithm has fallen by 2."""
    one = sheet(motor__resistance=0.1, load__inertia=0.1)
    pulls = np.array([1.0, -1.0])
    assert one.price(pulls) == pytest.approx(2.0 * (2.0 + 2.0))
    # A mean square counts in logarithms, as often as there is evidence.
    assert math.log(one.priced(3.0, pulls) / 3.0) * one.evidence == pytest.approx(8.0)


@pytest.mark.parametrize(
    ("effect", "value"), [("resistance_error", 0.9), ("load_viscous_friction", 0.004)]
)
def test_an_effect_and_the_pull_of_its_constant_are_one_machine(effect, value) -> None:
    """What an effect stands for is left out of the sheet, and comes back at the same value."""
    one = sheet(motor__resistance=0.1, load__viscous_friction=0.1)
    name = CATALOGUE[effect].parameters[0].name
    row = one.index(CATALOGUE[effect].constant)
    assert not one.free([effect])[row] and one.free([]).all()
    pulls = one.pulled_to(effect, {name: value}, DRIVE)
    on_top = value + (one.nominal[row] if CATALOGUE[effect].on_top else 0.0)
    assert one.values(pulls)[row] == pytest.approx(on_top)


def test_exact_constants_are_not_fitted() -> None:
    """A sheet without tolerances holds nothing."""
    assert len(sheet()) == 0 and sheet().price(np.zeros(0)) == 0.0


class _Fitter:
    """As much of a fitter as strains ask for."""

    def __init__(self, rows: int, **tolerances: float) -> None:
        tolerances = tolerances or {
            "motor__torque_constant": 0.1,
            "load__inertia": 0.1,
            "motor__resistance": 0.1,
        }
        self.sheet = sheet(**tolerances)
        self.rows = np.ones(rows, dtype=bool)

    def perfect_with(self, values: object) -> float:
        return 1.0


def test_a_shared_fault_is_laid_to_the_constant_whose_freedom_saves_all() -> None:
    """Torque constant and inertia show their difference alone; resistance shows by itself.

    With a difference of 6 the least price is 3 each: 4 x (9 + 9). Freeing either of the two saves
    all of it, and moves the other back to 0; freeing the resistance, well seen at 1, saves 4.
    """
    fitter = _Fitter(3000)
    keys = [key.split(".")[1] for key in fitter.sheet.keys]
    order = [keys.index(name) for name in ("torque_constant", "inertia", "resistance")]
    noise = np.random.default_rng(0).standard_normal((2, 3000))
    jacobian = np.zeros((3, 3000))
    jacobian[order[0]], jacobian[order[1]] = 50.0 * noise[0], -50.0 * noise[0]
    jacobian[order[2]] = 50.0 * noise[1]
    pulls = np.zeros(3)
    pulls[order] = 3.0, -3.0, 1.0
    fit = Fit({}, pulls, 0.5 * noise[:1], 1.0, 1.0, 1.0, (), (0, 1, 2), jacobian)
    found = {keys[one.row]: one for one in strains(fit, fitter)}
    for name, other in (("torque_constant", 1), ("inertia", 0)):
        assert found[name].saved == pytest.approx(72.0, rel=0.01)
        assert found[name].pulls[order[other]] == pytest.approx(0.0, abs=0.05)
        assert abs(found[name].pull) == pytest.approx(6.0, rel=0.01)
    assert found["resistance"].saved == pytest.approx(4.0, rel=0.01)


@pytest.mark.parametrize(
    ("pull", "left", "name"),
    [(6.0, 1.0, "resistance"), (1.0, 1.0, None), (6.0, 9.0, None)],
)
def test_at_the_noise_floor_a_constant_far_off_its_sheet_is_strained(pull, left, name) -> None:
    """6 tolerances off where noise accounts for the rest; not 1, nor where structure is left."""
    fitter = _Fitter(3000)
    jacobian = np.zeros((3, 3000))
    row = [key.split(".")[1] for key in fitter.sheet.keys].index("resistance")
    jacobian[row] = 50.0
    pulls = np.zeros(3)
    pulls[row] = pull
    fit = Fit({}, pulls, np.full((1, 3000), 0.5), 1.0, 1.0, left, (), (0, 1, 2), jacobian)
    found = strained(fit, fitter)
    assert (found and fitter.sheet.keys[found.row].split(".")[1]) == name


@pytest.mark.parametrize(
    ("key", "told"), [("motor.inductance", True), ("transmission.contact_damping", False)]
)
def test_a_constant_that_no_effect_stands_for_is_strained_too(key, told) -> None:
    """An inductance 6 tolerances off refutes a set; not how impacts die away, which is a form."""
    fitter = _Fitter(3000, **{key.replace(".", "__"): 0.1})
    fit = Fit(
        {},
        np.array([6.0]),
        np.full((1, 3000), 0.5),
        1.0,
        1.0,
        1.0,
        (),
        (0,),
        np.full((1, 3000), 50.0),
    )
    assert fitter.sheet.keys == (key,)
    assert (strained(fit, fitter) is not None) == told


@pytest.mark.parametrize(
    ("added", "left", "after", "needed"),
    [
        ("resistance_error", 1.0, 0.0, True),
        ("resistance_error", 1.3, 0.0, True),
        ("resistance_error", 1.6, 0.0, False),
        ("load_inertia_error", 1.0, 0.0, False),
        ("resistance_error", 1.0, 6.0, False),
    ],
)
def test_what_frees_a_strained_constant_earns_its_place(added, left, after, needed) -> None:
    """A resistance 6 tolerances off is worth 144: more than structure of 0.3 x 300, not of 0.6.

    By its own effect alone, and where no other constant is strained beside it.
    """
    fitter = _Fitter(3000)
    keys = [key.split(".")[1] for key in fitter.sheet.keys]
    resistance, inertia = keys.index("resistance"), keys.index("inertia")
    jacobian = np.zeros((3, 3000))
    jacobian[resistance], jacobian[inertia] = 50.0, 50.0 * np.resize([1.0, -1.0], 3000)
    gap = np.full((1, 3000), 0.5)

    def fitted(values, cost, **pulls) -> Fit:
        off = np.array([pulls.get(key, 0.0) for key in keys])
        return Fit(values, off, gap, cost, cost, left, (), (0, 1, 2), jacobian)

    without = fitted({}, 1.0, resistance=6.0)
    # Hardly closer: other constants shared what the resistance is off by.
    assert earns(fitter, fitted({added: {}}, 0.99, inertia=after), without) == needed


def test_products_of_long_rows_are_those_of_numpy() -> None:
    """Any length, also one that is no multiple of a block."""
    rng = np.random.default_rng(3)
    rows, weights, values = rng.random((17, 9001)), rng.random(9001), rng.random(9001)
    gram, along = weighted_products(rows, weights, values)
    np.testing.assert_allclose(gram, (rows * weights) @ rows.T, rtol=1e-12)
    np.testing.assert_allclose(along, rows @ (weights * values), rtol=1e-12)


@pytest.mark.slow
def test_a_sound_machine_off_its_sheet_is_within_it() -> None:
    """Every constant off by 2 %: no cause, and the constants that are seen in their intervals."""
    case = Case(0, 3, "none", sheet=0.02)
    drive = stated(DRIVE, 0.02)
    result = diagnose(record_case(case, drive).slice(0.0, 6.0), drive)
    assert result.verdict == "within_sheet" and result.causes == () and result.block is None
    assert result.shrink > 0.97
    true = true_constants(Stage.of(3, drive, 0.02).with_effects({}, 3), drive)
    seen = [one for one in result.sheet if one.seen]
    inside = [one.low <= true[one.parameter] <= one.high for one in seen]
    assert len(seen) >= 8 and np.mean(inside) >= 0.8
    data = result.as_json()
    assert data["gap"]["sheet"] == data["gap"]["after"] < 0.25 * data["gap"]["before"]
    assert {one["parameter"] for one in data["sheet"]} == set(true)


@pytest.mark.slow
def test_a_fault_is_found_on_a_machine_off_its_sheet() -> None:
    """Coulomb friction with every constant off by 2 %: named alone, its size in its interval."""
    size = 0.11
    effects = {"rotor_coulomb_friction": {"coulomb_nm": size}}
    drive = stated(DRIVE, 0.02)
    recording = record_case(Case(0, 8, "single", effects, sheet=0.02), drive).slice(0.0, 2.5)
    result = diagnose(recording, drive)
    assert [one.effect for one in result.causes] == ["rotor_coulomb_friction"]
    assert result.verdict == "explained" and result.causes[0].confidence > 0.9
    (level,) = result.causes[0].parameters
    assert level.low <= size <= level.high and level.value == pytest.approx(size, rel=0.03)
