"""Statements of the paper, and whether they hold in either reading, each by a rule of its own."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable

from . import published
from .readings import half_clearance_m
from .results import Results, error_std, imf_std
from .runs import CLEARANCE_SHARES, Ran
from .tables import Column, Table, percent

NEAR = 0.15  # two numbers are near each other if they differ by less
ALIKE = 0.9  # correlation
ONE_LINE = 0.15  # power away from its line that a mode of one frequency may have
SMALL = 0.5

Verdict = tuple[bool, str]
Rule = Callable[[Results, str], Verdict]


def statement_table(results: Results) -> Table:
    """One row per statement of section 4 and the conclusion."""
    rows = []
    for where, statement, rule in STATEMENTS:
        row: list[str] = [where, statement]
        for reading in ("published", "si"):
            holds, why = rule(results, reading)
            row.append(f"{'holds' if holds else 'does not hold'}: {why}")
        rows.append(tuple(row))
    return Table(
        "statements",
        "Statements of the paper in the two readings",
        (
            Column("section"),
            Column("statement"),
            Column("as published"),
            Column("in SI"),
        ),
        tuple(rows),
        f"Near: within {percent(NEAR)}. Alike: correlation above {ALIKE:g}. One frequency: less "
        f"than {percent(ONE_LINE)} of the power more than half an octave away.",
    )


def verdicts(results: Results) -> dict[str, dict[str, bool]]:
    """{statement: {reading: holds}}, for JSON."""
    return {
        statement: {key: rule(results, key)[0] for key in ("published", "si")}
        for _, statement, rule in STATEMENTS
    }


def _near(value: float, wanted: float) -> bool:
    return abs(value / wanted - 1.0) < NEAR


def _main_frequency(results: Results, reading: str) -> Verdict:
    ran = results.nominal(reading)
    line, mixed = ran.imfs[0].frequency_hz, ran.imfs[0].mixed
    relative = ran.relative_line.frequency_hz if ran.relative_line else math.nan
    holds = _near(line, published.IMF1_HZ) and _near(relative, published.IMF1_HZ)
    return (
        holds and mixed < ONE_LINE,
        f"IMF1 {line:.2f} Hz with {percent(mixed)} of its power elsewhere, relative angle "
        f"{relative:.2f} Hz",
    )


def _alike(results: Results, reading: str) -> Verdict:
    value = results.nominal(reading).similarity
    return value > ALIKE, f"correlation {value:.2f}"


def _second(results: Results, reading: str) -> Verdict:
    line = results.nominal(reading).imfs[1].frequency_hz
    return abs(line - published.IMF2_HZ) < 0.05, f"{line:.3f} Hz"


def _half(results: Results, reading: str) -> Verdict:
    half = half_clearance_m(results.reading(reading).drive)
    value = results.nominal(reading).line_1hz_m
    return (
        _near(value, half),
        f"{value * 1e3:.4f} mm at 1 Hz, half the clearance is {half * 1e3:.4f} mm",
    )


def _lesser(results: Results, reading: str) -> Verdict:
    ran = results.nominal(reading)
    ratio = imf_std(1)(ran) / imf_std(0)(ran)
    return ratio < SMALL, f"IMF2 is {ratio:.2f} times IMF1"


def _first_zone(results: Results, reading: str) -> Verdict:
    peak = results.nominal(reading).peak_torque_nm
    t1, t2 = published.TABLE_1["T1"][0], published.TABLE_1["T2"][0]
    return (
        peak < t2,
        f"at most {peak:.4f} N m; that is also {t1 / peak:.0f} times less than T1, where the "
        "measured curve still has the slope k1",
    )


def _thirty(results: Results, reading: str) -> Verdict:
    fall = _change(results, reading, "stiffness", 1.3)
    return fall < -0.12, f"{percent(fall, 1, '+')} (Table 3 itself: -9.3 %)"


def _change(results: Results, reading: str, change: str, share: float) -> float:
    values = [results.over_starts(reading, change, one, error_std).mean for one in (share, 1.0)]
    return values[0] / values[1] - 1.0


def _imf1_falls(results: Results, reading: str) -> Verdict:
    values = [
        results.over_starts(reading, "stiffness", one, imf_std(0)).mean
        for one in published.STIFFNESS_SHARES
    ]
    falling = all(later < earlier for earlier, later in itertools.pairwise(values))
    whole = values[-1] / values[0] - 1.0
    return (
        falling and whole < -0.1,
        f"IMF1 {percent(whole, 0, '+')} from 70 to 130 %, {_way(falling)}",
    )


def _way(falling: bool) -> str:
    return "falling all the way" if falling else "not falling all the way"


def _lag_falls(results: Results, reading: str) -> Verdict:
    low, high = (results.at(reading, "stiffness", one).lag_s for one in (0.7, 1.3))
    return high < 0.5 * low, f"{low:.4f} s at 70 %, {high:.4f} s at 130 %; paper 0.125 and 0.010"


def _clearance_less(results: Results, reading: str) -> Verdict:
    stiffness = abs(results.elasticity(reading, "stiffness"))
    clearance = abs(results.elasticity(reading, "clearance"))
    return (
        clearance < SMALL * stiffness,
        f"{clearance:.2f} % of error per % of clearance, {stiffness:.2f} per % of stiffness",
    )


def _only_half(results: Results, reading: str) -> Verdict:
    nominal = results.over_starts(reading, "clearance", 1.0, imf_std(1)).mean
    moved = {
        share: results.over_starts(reading, "clearance", share, imf_std(1)).mean / nominal - 1.0
        for share in CLEARANCE_SHARES
    }
    small = all(abs(moved[one]) < 0.1 for one in (0.75, 1.25))
    large = all(abs(moved[one]) >= 0.1 for one in (0.5, 1.5))
    text = ", ".join(
        f"{percent(moved[one], 0, '+')} at {percent(one)}" for one in CLEARANCE_SHARES if one != 1.0
    )
    return small and large, f"IMF2 {text}"


def _stiffness_helps(results: Results, reading: str) -> Verdict:
    spread = results.over_starts(reading, "stiffness", 1.0, error_std)
    fall = _change(results, reading, "stiffness", 1.3)
    rise = _change(results, reading, "stiffness", 0.7)
    noise = spread.std / spread.mean
    return (
        fall < -max(0.05, 2.0 * noise),
        f"{percent(fall, 1, '+')} at 130 % stiffness, {percent(rise, 1, '+')} at 70 %; starts "
        f"alone scatter by {percent(noise, 1)}",
    )


def _clearance_ignored(results: Results, reading: str) -> Verdict:
    fall = _change(results, reading, "clearance", 0.5)
    return abs(fall) < 0.1, f"{percent(fall, 0, '+')} of error at half the clearance"


def _count(results: Results, reading: str) -> Verdict:
    ran: Ran = results.nominal(reading)
    count = len(ran.imfs)
    return count == published.IMFS, f"{count}; how many there are depends on where sifting stops"


STATEMENTS: tuple[tuple[str, str, Rule], ...] = (
    ("4.1", "EMD gives five IMFs.", _count),
    ("4.1", "IMF1 and relative angle have one main frequency, about 3.45 Hz.", _main_frequency),
    ("4.1", "IMF1 is alike to the relative angle.", _alike),
    ("4.1", "IMF2 is at 1 Hz, the frequency of the reference.", _second),
    ("4.1", "The amplitude at 1 Hz is near half the clearance.", _half),
    ("4.2.1", "The torque stays in the first stiffness zone.", _first_zone),
    ("4.2.1", "IMF1 falls markedly as stiffness grows.", _imf1_falls),
    ("4.2.1", "30 % more stiffness take 15 % off the error.", _thirty),
    ("4.2.1", "The lag falls markedly as stiffness grows.", _lag_falls),
    ("4.2.2", "IMF2 is much smaller than IMF1.", _lesser),
    ("4.2.2", "The error is much less sensitive to clearance than to stiffness.", _clearance_less),
    ("4.2.2", "IMF2 changes markedly only at about 50 % of change in clearance.", _only_half),
    ("5", "Raising the stiffness reduces the error.", _stiffness_helps),
    ("5", "Reducing the clearance need not be considered.", _clearance_ignored),
)
