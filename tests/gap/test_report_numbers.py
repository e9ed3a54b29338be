"""Numbers, curves and axes of the report."""

from __future__ import annotations

import numpy as np
import pytest

from ecyl_ros.effects.catalogue import CATALOGUE
from ecyl_ros.gap.diagnosis import FittedParameter, Measured
from ecyl_ros.gap.report import quantities as q
from ecyl_ros.gap.report import words
from ecyl_ros.gap.report.decimate import envelope, quantiles_over
from ecyl_ros.gap.report.markup import escape, typeset
from ecyl_ros.gap.report.svg import Axis


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (0.38, "N m", "0.380 N m"),
        (0.0572, "N m", "57.2 mN m"),
        (9.652e-3, "rad", "9.65 mrad"),
        (5e-7, "m", "0.500 um"),
        (123.67, "N", "124 N"),
        (5230.0, "N", "5.23 kN"),
        (3.34e-3, "kg m^2", "33.4 kg cm^2"),
        (2.5e-4, "s", "0.250 ms"),
        (2.0, "1", "2.00"),
        (0.0, "A", "0 A"),
        (-0.0012, "A", "-1.20 mA"),
        (9.996, "V", "10.0 V"),
        (float("nan"), "V", "-"),
        (1e-12, "N m/rad", "1.00e-12 N m/rad"),
    ],
)
def test_amounts_keep_three_digits_and_short_units(value: float, unit: str, text: str) -> None:
    """An amount has three significant digits in a unit that an engineer would choose."""
    assert q.amount(value, unit) == text


@pytest.mark.parametrize(
    ("values", "floor", "unit", "row"),
    [
        ((0.649e-3, 10.4e-6), 10.1e-6, "rad", ["649", "10.4", "10.1", "urad"]),
        ((0.275, 0.958e-3), 5.52e-3, "V", ["275", "0.958", "5.52", "mV"]),
        ((2.0, float("nan")), 0.5, "rad", ["2.00", "runs away", "0.500", "rad"]),
        ((0.02, 0.01), float("nan"), "m", ["20.0", "10.0", "-", "mm"]),
        ((0.2,), 0.1, "1", ["0.200", "0.100", ""]),
    ],
)
def test_a_row_has_one_unit(
    values: tuple[float, ...], floor: float, unit: str, row: list[str]
) -> None:
    """Gap, after and floor of a signal are comparable at sight; what is unknown is said."""
    assert q.in_one_unit(values, floor, unit, words.RAN_AWAY) == row


@pytest.mark.parametrize(
    ("value", "low", "high", "text"),
    [
        (0.38024, 0.3790, 0.3814, "0.3802 N m (0.3790 to 0.3814)"),
        (0.38024, 0.2, 0.6, "0.38 N m (0.20 to 0.60)"),
        (0.380268609, 0.380247, 0.38029, "0.38027 N m (0.38025 to 0.38029)"),
        (123.667412, 123.66601, 123.6688, "123.667 N m (123.666 to 123.669)"),
        (12.0, 5.0, 19.0, "12.0 N m (5.0 to 19.0)"),
    ],
)
def test_digits_of_a_value_follow_its_interval(
    value: float, low: float, high: float, text: str
) -> None:
    """The interval's half width decides the digits shown, and both ends stay apart."""
    assert q.with_interval(FittedParameter("coulomb_nm", "N m", value, low, high)) == text


def test_a_count_has_no_interval() -> None:
    """Periods per turn are 7, neither 7.00 nor 7 (7 to 7)."""
    assert q.with_interval(FittedParameter("periods_per_rev", "1", 7.0, 7.0, 7.0)) == "7"


def test_a_nominal_value_is_in_the_unit_of_what_was_measured() -> None:
    """Of an inertia found far below its sheet both stand in kg cm^2."""
    one = Measured("inertia_kg_m2", "kg m^2", 0.0034, 0.0001, 0.0066, "all that moves", 0.15)
    assert q.measured(one) == ("34 kg cm^2", "1 to 66", "1500.0 kg cm^2")


def test_no_share_reads_100_percent_that_is_not() -> None:
    """Shares are rounded, but never up to everything; confidence never up to certainty."""
    assert q.percent(0.9962) == "99.6 %"
    assert q.percent(0.99993) == "99.99 %"
    assert q.percent(1.0) == "100 %"
    assert q.confidence(0.9999) == "0.99"


def test_every_effect_has_words_and_units() -> None:
    """Titles fit a sentence, and no parameter's label repeats its unit."""
    for name, effect in CATALOGUE.items():
        article = words.with_article(name)
        assert article.split()[0] in ("a", "an") or words.title(name) == article
        assert words.heading(name)[0].isupper()
        for one in effect.parameters:
            label = q.parameter_label(one.name)
            assert label and not label.endswith((" nm", " rad", " m", " hz", " kg m2")), one.name
    assert q.parameter_label("kp_a_s_per_rad") == "proportional gain"
    assert {q.parameter_label(f"ki_{unit}") for unit in ("per_s2", "a_per_rad", "v_per_a_s")} == {
        "integral gain"
    }
    assert words.with_article("actuation_delay") == "an actuation delay"
    assert words.with_article("cogging_torque") == "cogging torque"
    assert words.with_article("gravity_on_arm") == "gravity on arm"
    assert words.title("rotor_coulomb_friction").startswith("Coulomb")
    assert words.title("rotor_viscous_friction").startswith("viscous")
    assert words.title("never_heard_of") == "never heard of"


def test_type_is_set_in_our_text_alone() -> None:
    """Units get their signs in our own sentences; what comes from files is only escaped."""
    plain = typeset("5 um and 3e-05 kg m^2, 7 mohm; current / uA").replace(
        "\N{NO-BREAK SPACE}", " "
    )
    assert plain == "5 µm and 3 × 10⁻⁵ kg m², 7 mΩ; current / µA"
    assert typeset("um/s") == "µm/s"  # alone in a column of units
    assert typeset("a < b, us and them") == "a &lt; b, us and them"
    assert escape('a"<b>\x1b[0m um') == "a&quot;&lt;b&gt;\ufffd[0m um"


def test_a_thinned_curve_keeps_every_peak() -> None:
    """Decimation to pixel columns keeps single-sample spikes and stays within its size."""
    x = np.arange(120_000) / 1000.0
    y = np.sin(x)
    y[[17_003, 90_001]] = 5.0, -7.0
    thin_x, thin_y = envelope(x, y, 364)
    assert thin_x.size <= 3 * 364
    assert np.all(np.diff(thin_x) >= 0.0)
    assert thin_y.max() == 5.0 and thin_y.min() == -7.0
    assert np.isin(thin_x, x).all()


def test_a_thinned_curve_keeps_its_gaps() -> None:
    """Where values are unknown the curve is broken, not drawn across."""
    x = np.arange(20_000.0)
    y = np.zeros(20_000)
    y[8_000:12_000] = np.nan
    thin_x, thin_y = envelope(x, y, 100)
    inside = (thin_x > 8_100) & (thin_x < 11_900)
    assert inside.any() and np.isnan(thin_y[inside]).all()
    assert np.isfinite(thin_y[(thin_x < 7_800) | (thin_x > 12_200)]).all()


def test_quantiles_over_a_sign_are_a_step() -> None:
    """The median of a friction-like residual over speed is the step it is."""
    random = np.random.default_rng(1)
    speed = random.uniform(-1.0, 1.0, 20_000)
    middles, spread = quantiles_over(speed, np.sign(speed) + random.normal(0, 0.1, 20_000), 20)
    assert np.allclose(spread[1], np.sign(middles), atol=0.02)
    assert np.allclose(spread[2] - spread[0], 2 * 1.645 * 0.1, atol=0.04)


def test_ticks_are_round_and_within() -> None:
    """Ticks are multiples of 1, 2 or 5 within the range; decades on a logarithmic axis."""
    random = np.random.default_rng(2)
    for _ in range(200):
        low = float(random.normal(0, 100))
        high = low + 10.0 ** float(random.uniform(-4, 4))
        ticks = Axis(low, high, "x").ticks(5)
        assert 1 <= len(ticks) <= 7
        steps = np.diff([value for value, _ in ticks])
        if steps.size:
            mantissa = steps[0] / 10.0 ** np.floor(np.log10(steps[0]) + 1e-9)
            assert min(abs(mantissa - one) for one in (1.0, 2.0, 5.0)) < 1e-6
        assert len({text for _, text in ticks}) == len(ticks)
        slack = 1e-6 * (high - low)
        assert all(low - slack <= value <= high + slack for value, _ in ticks)
    decades = Axis(3e-5, 40.0, "x", logarithmic=True).ticks(6)
    assert [value for value, _ in decades] == pytest.approx([1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0])
