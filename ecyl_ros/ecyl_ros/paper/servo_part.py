"""Section 4: the servo's figures, Table 3, and its counterpart for the clearance."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from . import published
from .readings import Reading, half_clearance_m, largest_twist_rad, swing_hz
from .results import Results, error_std, imf_std
from .runs import CLEARANCE_SHARES, Ran
from .tables import PERCENT, Column, Table, difference

SHOWN = ("published", "si")


Quantity = tuple[str, float | None, Callable[[Ran, Reading], float], float, str]


def figure_tables(results: Results) -> dict[str, Table]:
    """Fig. 10 to 14 in numbers: by the name of the figure."""
    half = half_clearance_m(results.reading("published").drive)
    quantities: dict[str, tuple[str, tuple[Quantity, ...]]] = {
        "fig10_position": (
            "Fig. 10 in numbers",
            (
                ("lag / s", published.LAG_S[1.0], lambda ran, _: ran.lag_s, 1.0, ".4f"),
                (
                    "largest torque transmitted / (N m)",
                    None,
                    lambda ran, _: ran.peak_torque_nm,
                    1.0,
                    ".4f",
                ),
            ),
        ),
        "fig11_error": (
            "Fig. 11 in numbers",
            (
                (
                    "standard deviation of the error / mm",
                    published.ERROR_STD_M[1.0],
                    lambda ran, _: ran.error_std_m,
                    1e3,
                    ".5f",
                ),
                (
                    "amplitude at 1 Hz, beside half the clearance / mm",
                    half,
                    lambda ran, _: ran.line_1hz_m,
                    1e3,
                    ".5f",
                ),
                ("number of IMFs", float(published.IMFS), lambda ran, _: len(ran.imfs), 1.0, ".0f"),
            ),
        ),
        "fig12_imf1": ("Fig. 12 in numbers", _mode_rows(0, published.IMF1_HZ)),
        "fig13_relative_angle": (
            "Fig. 13 in numbers",
            (
                (
                    "line of its spectrum / Hz",
                    published.RELATIVE_ANGLE_HZ,
                    _relative_hz,
                    1.0,
                    ".3f",
                ),
                ("amplitude of that line / mrad", None, _relative, 1e3, ".3f"),
                ("largest angle over half the clearance", None, _over_half, 1.0, ".3f"),
                (
                    "free swing of the load at that angle / Hz",
                    published.RELATIVE_ANGLE_HZ,
                    _swing,
                    1.0,
                    ".3f",
                ),
                ("correlation with IMF1", None, lambda ran, _: ran.similarity, 1.0, ".3f"),
            ),
        ),
        "fig14_imf2": ("Fig. 14 in numbers", _mode_rows(1, published.IMF2_HZ)),
    }
    return {
        name: _figure_table(results, name, title, rows)
        for name, (title, rows) in quantities.items()
    }


def _mode_rows(number: int, paper_hz: float) -> tuple[Quantity, ...]:
    return (
        ("line of its spectrum (FFT) / Hz", paper_hz, _imf(number, "frequency_hz"), 1.0, ".3f"),
        (
            "mean instantaneous frequency (Hilbert) / Hz",
            paper_hz,
            _imf(number, "hilbert_hz"),
            1.0,
            ".3f",
        ),
        ("share of power away from its line", None, _imf(number, "mixed"), 1.0, ".2f"),
        ("amplitude of its line / mm", None, _imf(number, "amplitude_m"), 1e3, ".5f"),
        ("standard deviation / mm", None, _imf(number, "std_m"), 1e3, ".5f"),
    )


def _figure_table(
    results: Results, name: str, title: str, quantities: tuple[Quantity, ...]
) -> Table:
    rows = []
    for text, paper, of, scale, form in quantities:
        shown = None if paper is None else paper * scale
        row: list[str | float | None] = [text, _text(shown, form)]
        for key in SHOWN:
            value = of(results.nominal(key), results.reading(key)) * scale
            row += [_text(value, form), difference(value, shown)]
        rows.append(tuple(row))
    return Table(
        name,
        title,
        (
            Column("quantity"),
            Column("paper"),
            Column("as published"),
            Column("difference / %", PERCENT),
            Column("in SI"),
            Column("difference / %", PERCENT),
        ),
        tuple(rows),
    )


def _text(value: float | None, form: str) -> str | None:
    # Quantities of one table have digits of their own.
    if value is None or not math.isfinite(value):
        return None
    return format(value, form)


def _imf(number: int, item: str) -> Callable[[Ran, Reading], float]:
    return lambda ran, _: getattr(ran.imfs[number], item) if len(ran.imfs) > number else math.nan


def _over_half(ran: Ran, reading: Reading) -> float:
    drive = reading.drive
    return largest_twist_rad(drive, ran.peak_torque_nm) / (0.5 * drive.transmission.backlash)


def _swing(ran: Ran, reading: Reading) -> float:
    return swing_hz(reading.drive, largest_twist_rad(reading.drive, ran.peak_torque_nm))


def _relative_hz(ran: Ran, _: Reading) -> float:
    return ran.relative_line.frequency_hz if ran.relative_line else math.nan


def _relative(ran: Ran, _: Reading) -> float:
    return ran.relative_line.amplitude if ran.relative_line else math.nan


def table_3(results: Results) -> Table:
    """Error against stiffness, all readings beside the paper."""
    columns = [Column("stiffness / %", ".0f"), Column("paper / mm", ".4f")]
    for reading in results.readings:
        columns += [Column(f"{reading.name} / mm", ".5f"), Column("difference / %", PERCENT)]
    rows = []
    for share in published.STIFFNESS_SHARES:
        paper = published.ERROR_STD_M[share] * 1e3
        row: list[str | float | None] = [100.0 * share, paper]
        for reading in results.readings:
            value = results.at(reading.key, "stiffness", share).error_std_m * 1e3
            row += [value, difference(value, paper)]
        rows.append(tuple(row))
    return Table(
        "table3",
        "Table 3: standard deviation of the position error",
        tuple(columns),
        tuple(rows),
        "From rest in the middle of the clearance.",
    )


def starts_table(results: Results, change: str) -> Table:
    """How much of an error is its start's."""
    shares = published.STIFFNESS_SHARES if change == "stiffness" else CLEARANCE_SHARES
    columns = [Column(f"{change} / %", ".0f")]
    for reading in results.readings:
        columns += [Column(f"{reading.name}, mean / mm", ".5f"), Column("scatter / mm", ".5f")]
    rows = []
    for share in shares:
        row: list[str | float | None] = [100.0 * share]
        for reading in results.readings:
            one = results.over_starts(reading.key, change, share, error_std)
            row += [one.mean * 1e3, one.std * 1e3]
        rows.append(tuple(row))
    return Table(
        f"starts_{change}",
        f"Standard deviation of the error over {change}, from {results.starts} starts",
        tuple(columns),
        tuple(rows),
        "Mean and standard deviation of runs whose load starts at different places in the "
        "clearance. In SI the motion is chaotic: there this, not a single run, can be compared.",
    )


def emd_table(results: Results) -> Table:
    """Every mode, and how far it can be trusted."""
    rows: list[tuple[str | float | None, ...]] = []
    for key in SHOWN:
        for number, mode in enumerate(results.nominal(key).imfs, start=1):
            rows.append(
                (
                    results.reading(key).name,
                    f"IMF{number}",
                    mode.frequency_hz,
                    mode.hilbert_hz,
                    mode.std_m * 1e3,
                    100.0 * mode.mixed,
                    100.0 * mode.edge_change,
                )
            )
    return Table(
        "emd",
        "All modes of the error",
        (
            Column("reading"),
            Column("mode"),
            Column("FFT / Hz", ".3f"),
            Column("Hilbert / Hz", ".3f"),
            Column("standard deviation / mm", ".5f"),
            Column("mixed / %", ".1f"),
            Column("edges / %", ".1f"),
        ),
        tuple(rows),
        "FFT: strongest line, where the signal holds three periods of it. Mixed: share of the "
        "mode's power more than half an octave from that line. Edges: change of the mode in the "
        "middle when 7 % are cut off at either end; from some 30 % on the ends make the mode.",
    )


def lag_table(results: Results) -> Table:
    """Lag against stiffness."""
    columns = [Column("stiffness / %", ".0f"), Column("paper / s", ".3f")]
    for reading in results.readings:
        columns += [Column(f"{reading.name} / s", ".4f"), Column("difference / %", PERCENT)]
    rows = []
    for share in published.STIFFNESS_SHARES:
        row: list[str | float | None] = [100.0 * share, published.LAG_S[share]]
        for reading in results.readings:
            value = results.at(reading.key, "stiffness", share).lag_s
            row += [value, difference(value, published.LAG_S[share])]
        rows.append(tuple(row))
    return Table(
        "table3_lag",
        "Table 3: lag after steady state",
        tuple(columns),
        tuple(rows),
        "Lag, gain and offset of the position behind the reference by least squares over the last "
        "10 s. The paper does not say how its lag was read. A proportional position loop of "
        "50 1/s lags by 1/50 s whatever the stiffness.",
    )


def clearance_table(results: Results) -> Table:
    """The counterpart of Table 3 that the paper leaves out."""
    columns = [Column("clearance / %", ".0f")]
    for reading in results.readings:
        columns += [Column(f"{reading.name} / mm", ".5f"), Column("of 100 %", ".3f")]
    rows = []
    for share in CLEARANCE_SHARES:
        row: list[str | float | None] = [100.0 * share]
        for reading in results.readings:
            value = results.at(reading.key, "clearance", share).error_std_m
            row += [value * 1e3, value / results.nominal(reading.key).error_std_m]
        rows.append(tuple(row))
    return Table(
        "clearance",
        "Standard deviation of the position error over clearance",
        tuple(columns),
        tuple(rows),
        "From rest. The paper gives no table of this, only Fig. 16.",
    )


def waves_table(results: Results, name: str, change: str, number: int) -> Table:
    """Fig. 15 or 16 in numbers: a mode's size over the parameter."""
    shares = published.STIFFNESS_SHARES if change == "stiffness" else CLEARANCE_SHARES
    columns = [Column(f"{change} / %", ".0f")]
    for key in SHOWN:
        columns += [Column(f"{results.reading(key).name} / mm", ".5f"), Column("of 100 %", ".3f")]
    rows = []
    for share in shares:
        row: list[str | float | None] = [100.0 * share]
        for key in SHOWN:
            one, nominal = (
                results.over_starts(key, change, place, imf_std(number)).mean
                for place in (share, 1.0)
            )
            row += [one * 1e3, one / nominal]
        rows.append(tuple(row))
    return Table(
        name,
        f"Standard deviation of IMF{number + 1} over {change}",
        tuple(columns),
        tuple(rows),
        "Mean over the starts. The paper gives no numbers with its figure.",
    )


def elasticity_table(results: Results) -> Table:
    """What the paper's conclusion is about, in one number each."""
    rows = tuple(
        (
            reading.name,
            reading.meaning,
            results.elasticity(reading.key, "stiffness"),
            results.elasticity(reading.key, "clearance"),
        )
        for reading in results.readings
    )
    paper = _paper_elasticity()
    return Table(
        "elasticity",
        "Percent of error per percent of stiffness and of clearance",
        (
            Column("reading"),
            Column("meaning"),
            Column("stiffness", "+.2f"),
            Column("clearance", "+.2f"),
        ),
        (("paper", "Table 3", paper, None), *rows),
        "Slope of log error over log parameter, 70 to 130 % of stiffness and 50 to 150 % of "
        "clearance, means over the starts.",
    )


def _paper_elasticity() -> float:
    shares = np.array(published.STIFFNESS_SHARES)
    errors = np.array([published.ERROR_STD_M[one] for one in published.STIFFNESS_SHARES])
    return float(np.polyfit(np.log(shares), np.log(errors), 1)[0])
