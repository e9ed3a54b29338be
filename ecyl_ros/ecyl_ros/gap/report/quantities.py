"""Numbers as an engineer writes them: a unit that keeps them short, digits that mean something.

Plain ASCII throughout ("um", "kg m^2"); the page sets them in type (see `markup.typeset`).
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

from ..diagnosis import FittedParameter, Measured, SheetValue

# Larger to smaller: factor from SI, and what the unit is then called.
_LADDERS: dict[str, tuple[tuple[float, str], ...]] = {
    "m": ((1.0, "m"), (1e3, "mm"), (1e6, "um"), (1e9, "nm")),
    "m/s": ((1.0, "m/s"), (1e3, "mm/s"), (1e6, "um/s")),
    "m/rev": ((1.0, "m/rev"), (1e3, "mm/rev")),
    "rad": ((1.0, "rad"), (1e3, "mrad"), (1e6, "urad")),
    "rad/s": ((1.0, "rad/s"), (1e3, "mrad/s")),
    "s": ((1.0, "s"), (1e3, "ms"), (1e6, "us")),
    "A": ((1.0, "A"), (1e3, "mA")),
    "V": ((1.0, "V"), (1e3, "mV")),
    "N": ((1e-3, "kN"), (1.0, "N"), (1e3, "mN")),
    "N m": ((1.0, "N m"), (1e3, "mN m"), (1e6, "uN m")),
    "N s/m": ((1e-3, "kN s/m"), (1.0, "N s/m"), (1e3, "mN s/m")),
    "kg": ((1.0, "kg"), (1e3, "g")),
    "N m s/rad": ((1.0, "N m s/rad"), (1e3, "mN m s/rad")),
    "N/m": ((1e-6, "MN/m"), (1e-3, "kN/m"), (1.0, "N/m")),
    "kg m^2": ((1.0, "kg m^2"), (1e4, "kg cm^2"), (1e7, "g cm^2")),
    "ohm": ((1.0, "ohm"), (1e3, "mohm")),
    "H": ((1.0, "H"), (1e3, "mH"), (1e6, "uH")),
}
_SMALLEST = 0.1  # a unit is taken if the number then is no smaller
_LONGEST = 1e5  # a number is no longer than this for the sake of a shorter one beside it
_MOST_DIGITS = 5  # of a value beside its interval, unless both ends then read the same
_FURTHER = 3  # digits more, to tell the ends of an interval apart

# Endings of parameter names that only repeat the unit.
_TOKENS = ["kg", "m", "m2", "s", "s2", "rad", "nm", "n", "a", "v", "ohm", "hz", "h", "per"]
_UNIT_ENDING = re.compile(rf"(_({'|'.join(_TOKENS)}))+$")
# What is left of these names says too little.
_FULLER = {
    "relative_gap_taken_off": "relative gap removed",
    "kp": "proportional gain",
    "ki": "integral gain",
    "coulomb": "Coulomb {}",
    "static": "static {}",
    "stribeck": "Stribeck speed",
    "viscous": "viscous coefficient",
    "coulomb_positive": "Coulomb level forwards",
    "coulomb_negative": "Coulomb level backwards",
    "viscous_positive": "viscous coefficient forwards",
    "viscous_negative": "viscous coefficient backwards",
}
_LEVELS = {"_nm": "torque", "_n": "force"}  # of friction, by its unit


def engineering(largest: float, unit: str) -> tuple[float, str]:
    """Factor from SI and name of the unit that keeps numbers up to `largest` short."""
    ladder = _LADDERS.get(unit, ((1.0, unit),))
    size = abs(largest)
    if size == 0.0 or not math.isfinite(size):
        return next((step for step in ladder if step[0] == 1.0), ladder[0])
    for factor, name in ladder:
        if size * factor >= (_SMALLEST if factor >= 1.0 else 1.0):
            return factor, name
    return ladder[-1]


def number(value: float, digits: int = 3) -> str:
    """`value` to `digits` significant digits, without an exponent where that stays short."""
    if not math.isfinite(value):
        return "-"
    if value == 0.0:
        return "0"
    power = math.floor(math.log10(abs(float(f"{value:.{digits - 1}e}"))))
    if not -4 <= power < 7:
        mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
        return f"{mantissa}e{int(exponent)}"
    return f"{value:.{max(0, digits - 1 - power)}f}"


def amount(value: float, unit: str, digits: int = 3) -> str:
    """A number with its unit, both kept short; "-" for none."""
    if not math.isfinite(value):
        return "-"
    factor, name = engineering(value, unit)
    return joined(number(value * factor, digits), name)


def in_one_unit(values: Sequence[float], floor: float, unit: str, unknown: str = "-") -> list[str]:
    """A row of a table: numbers of one signal, its floor, and the unit that they all are in.

    It is the unit that keeps the floor short, so that a gap is seen to be many floors, unless that
    makes the largest too long. unknown: for a value that is NaN.
    """
    largest = max((abs(value) for value in values if math.isfinite(value)), default=0.0)
    factor, name = engineering(floor if floor > 0.0 else largest, unit)
    if largest * factor >= _LONGEST:
        factor, name = engineering(largest, unit)
    numbers = [unknown if math.isnan(value) else number(value * factor) for value in values]
    return [*numbers, number(floor * factor), "" if name == "1" else name]


def joined(figure: str, unit: str) -> str:
    """Number and unit; nothing after a bare number."""
    return figure if unit in ("", "1") else f"{figure} {unit}"


def decimals(value: float, low: float, high: float) -> int:
    """Decimals that show an interval's half width to two digits, within five digits in all, or
    up to eight where its ends would look the same."""
    half = 0.5 * abs(high - low)
    largest = max(abs(value), abs(low), abs(high))
    if not (math.isfinite(half) and math.isfinite(largest)) or largest == 0.0:
        return 3
    top = math.floor(math.log10(largest))
    finest = _MOST_DIGITS - 1 - top
    wanted = 1 - math.floor(math.log10(half)) if half > 0.0 else finest
    places = max(0, min(wanted, finest))
    while low < high and places < finest + _FURTHER and f"{low:.{places}f}" == f"{high:.{places}f}":
        places += 1
    return places


def interval(one: FittedParameter) -> tuple[str, str, str, str]:
    """Value, low and high end of a parameter as numbers, and the unit they are in."""
    factor, unit = engineering(one.value or max(abs(one.low), abs(one.high)), one.unit)
    value, low, high = one.value * factor, one.low * factor, one.high * factor
    if one.low == one.high == one.value == round(one.value) and unit in ("", "1"):
        return f"{value:.0f}", f"{value:.0f}", f"{value:.0f}", unit  # a count
    places = decimals(value, low, high)
    return f"{value:.{places}f}", f"{low:.{places}f}", f"{high:.{places}f}", unit


def measured(one: Measured) -> tuple[str, str, str]:
    """Value with unit, interval and nominal value of what was measured; "-" where unknown."""
    value, low, high, unit = interval(
        FittedParameter(one.name, one.unit, one.value, one.low, one.high)
    )
    if one.name.startswith("relative_"):
        return percent(one.value), "-", "-"
    nominal = "-"
    if one.nominal is not None:  # in the unit of the value beside it
        factor, _ = engineering(one.value or max(abs(one.low), abs(one.high)), one.unit)
        nominal = joined(number(one.nominal * factor, 5), unit)
    if one.low == one.high:
        return amount(one.value, one.unit), "-", nominal
    return joined(value, unit), f"{low} to {high}", nominal


def sheet_value(one: SheetValue) -> tuple[str, str, str, str]:
    """Nominal with its tolerance, value found, its 95 % interval and pull of a constant."""
    factor, unit = engineering(one.nominal, one.unit)
    places = decimals(one.nominal * factor, one.low * factor, one.high * factor)
    value, low, high = (f"{x * factor:.{places}f}" for x in (one.value, one.low, one.high))
    # A tolerance to two digits, the nominal value to as many decimals.
    half = one.tolerance * factor
    stated = max(0, 1 - math.floor(math.log10(half))) if half > 0.0 else places
    nominal = joined(f"{one.nominal * factor:.{stated}f} +- {half:.{stated}f}", unit)
    nominal = nominal if one.stated else "left out"
    if not one.told:
        return nominal, "not determined here", "-", "-"
    pull = f"{round(one.pull, 2) + 0.0:+.2f}" if one.stated else "-"  # no "-0.00"
    return nominal, joined(value, unit), f"{low} to {high}", pull


def with_interval(one: FittedParameter) -> str:
    """For example "0.3802 N m (0.3790 to 0.3814)"."""
    value, low, high, unit = interval(one)
    return joined(value, unit) + ("" if low == high else f" ({low} to {high})")


def ends(low: str, high: str) -> str:
    """An interval by its ends; "-" of a count, which has none."""
    return "-" if low == high else f"{low} to {high}"


def parameter_label(name: str) -> str:
    """A parameter's name in words, without its unit: "coulomb_nm" is "Coulomb torque"."""
    stem = _UNIT_ENDING.sub("", name)
    full = _FULLER.get(stem, stem.replace("_", " "))
    return full.format(_LEVELS.get(name[len(stem) :], "level"))


def percent(share: float) -> str:
    """A share to a tenth of a per cent; never 100 unless it is."""
    if not math.isfinite(share):
        return "-"
    value = 100.0 * share
    if 99.95 <= value < 99.995:
        return f"{math.floor(value * 100.0 + 1e-9) / 100.0:.2f} %"
    return "100 %" if value >= 99.995 else f"{value:.1f} %"


def whole_percent(share: float) -> str:
    """A share to a whole per cent."""
    return f"{100.0 * share:.0f} %" if math.isfinite(share) else "-"


def times(value: float, floor: float) -> str:
    """How many times the floor; "-" where there is none."""
    return number(value / floor) if floor > 0.0 else "-"


def confidence(value: float) -> str:
    """A probability to two decimals, never rounded up to certainty."""
    return f"{min(value, 0.99):.2f}"
