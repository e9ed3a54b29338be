"""What the paper leaves open, and what each way to read it gives."""

from __future__ import annotations

import math

from ..drive.stability import growth_rate, smallest_stable_rate
from . import published
from .readings import DAMPING, spring_hz, swing_twist_rad, with_controller
from .results import Results
from .runs import SUBSTEPS, Ran
from .tables import Cell, Column, Table

MET = 0.06  # of the paper's figure
ALL_MET = "meets the paper's error and IMF1 and lag"
NONE_MET = " No reading meets all three."


def open_tables(results: Results) -> list[Table]:
    """Readings other than the stiffness, sampling, convergence."""
    return [_alternatives(results), _sampling(results), _convergence(results)]


def checks_table(results: Results) -> Table:
    """What can be checked on the paper's own figures, without a simulation."""
    drives = [results.reading(key).drive for key in ("published", "si")]
    wanted = swing_twist_rad(drives[0], published.RELATIVE_ANGLE_HZ)
    rows: tuple[tuple[Cell, ...], ...] = (
        ("C / (N m/rad)", *(one.transmission.stiffness[0] for one in drives)),
        ("load on the spring alone / Hz", *(spring_hz(one) for one in drives)),
        (
            "relative angle that swings freely at 3.45 Hz / mrad",
            *(1e3 * swing_twist_rad(one, published.RELATIVE_ANGLE_HZ) for one in drives),
        ),
        (
            f"torque that a relative angle of {wanted * 1e3:.2f} mrad takes / (N m)",
            *(
                one.transmission.stiffness[0] * (wanted - 0.5 * one.transmission.backlash)
                for one in drives
            ),
        ),
        (
            "largest torque in the runs / (N m)",
            *(results.nominal(key).peak_torque_nm for key in ("published", "si")),
        ),
    )
    return Table(
        "checks",
        "Checks without a simulation",
        (Column("quantity"), Column("as published", ".4g"), Column("in SI", ".4g")),
        rows,
        "Free swing: 1/f = 2 pi / w + 2 alpha / (w (A - alpha/2)), w = sqrt(C / J_eq). If Fig. 13 "
        "shows a relative angle well beyond half the clearance of 2.93 mrad, or 10 arcmin, the "
        "stiffness in the model was in N m/rad.",
    )


def _alternatives(results: Results) -> Table:
    rows = []
    for reading in ("published", "si"):
        name = results.reading(reading).name
        nominal = results.nominal(reading)
        rows.append((f"{name}, as taken here", *_figures(nominal), _met(nominal)))
        for change, value, what in (
            ("series", 0.0, "PI in series, equation (6)"),
            ("series", DAMPING, "PI in series, 1e-4 N m s/rad in contact"),
            ("kp", 18.0, "position gain 18 1/s"),
            ("metre", 0.0, "position gain on the error in metres"),
            ("rod", 0.0, "position loop closed on the rod"),
        ):
            ran = results.runs[(reading, change, value, 0)]
            rows.append((f"{name}, {what}", *_figures(ran), _remark(results, reading, change, ran)))
    measured = results.runs[("measured", "form", 0.0, 0)]
    rows.append(
        (
            "in SI, first line of Table 1 in place of the dead zone",
            *_figures(measured),
            "tracking error alone: the transmission does not show",
        )
    )
    return Table(
        "readings",
        "Other readings of what is open",
        (
            Column("reading"),
            Column("error std / mm", ".5f"),
            Column("strongest line / Hz", ".2f"),
            Column("IMF1 / Hz", ".2f"),
            Column("lag / s", ".4f"),
            Column("largest torque / (N m)", ".4f"),
            Column("remark"),
        ),
        tuple(rows),
        "Paper: 0.0054 mm, 3.45 Hz, 0.055 s. Table 2's units are those of parallel PI loops, "
        "equation (6) is a series form; '50 rad/(m s)' on an error in metres is 0.07 1/s. "
        "Met: within 6 %." + ("" if any(row[-1] == ALL_MET for row in rows) else NONE_MET),
    )


def _figures(ran: Ran) -> tuple[float | None, ...]:
    if ran.lost_s is not None:
        return (None,) * 5
    return (
        ran.error_std_m * 1e3,
        ran.error_line.frequency_hz if ran.error_line else None,
        ran.imfs[0].frequency_hz if ran.imfs else None,
        ran.lag_s if math.isfinite(ran.lag_s) else None,
        ran.peak_torque_nm,
    )


def _remark(results: Results, reading: str, change: str, ran: Ran) -> str:
    if ran.lost_s is not None:
        drive = with_controller(results.reading(reading).drive, feedback="rod")
        return (
            f"diverges: growth {growth_rate(drive):.1f} 1/s, error beyond 1 mm after "
            f"{ran.lost_s:.2f} s"
        )
    if change == "metre":
        return "the rod hardly moves"
    if change == "rod" and ran.error_line is not None:
        return f"limit cycle at {ran.error_line.frequency_hz:.0f} Hz"
    return _met(ran)


def _met(ran: Ran) -> str:
    """Which of the paper's three figures a run meets."""
    wanted = (
        ("error", ran.error_std_m, published.ERROR_STD_M[1.0]),
        ("IMF1", ran.imfs[0].frequency_hz, published.IMF1_HZ),
        ("lag", ran.lag_s, published.LAG_S[1.0]),
    )
    met = [name for name, value, paper in wanted if abs(value / paper - 1.0) < MET]
    return f"meets the paper's {' and '.join(met)}" if met else ""


def _sampling(results: Results) -> Table:
    rows = []
    for reading in ("published", "si"):
        drive = results.reading(reading).drive
        for ticks, what in ((0, "at once"), (1, "one sample late")):
            rate = smallest_stable_rate(with_controller(drive, delay_ticks=ticks))
            rows.append((results.reading(reading).name, what, None if rate is None else rate / 1e3))
    return Table(
        "sampling",
        "Smallest stable sampling rate of Table 2's gains",
        (Column("reading"), Column("voltage acts"), Column("rate / kHz", ".1f")),
        tuple(rows),
        "The gains are continuous-time ones; the paper gives no sampling.",
    )


def _convergence(results: Results) -> Table:
    rows = []
    for factor in SUBSTEPS:
        row: list[str | float | None] = [f"1/{factor}"]
        for reading in ("published", "si"):
            ran = results.runs[(reading, "substeps", float(factor), 0)]
            row.append(ran.error_std_m * 1e3)
        rows.append(tuple(row))
    return Table(
        "convergence",
        "Standard deviation of the error over the integration step",
        (
            Column("step / automatic"),
            Column("as published / mm", ".6f"),
            Column("in SI / mm", ".6f"),
        ),
        tuple(rows),
        "The published reading has converged. In SI a motion through the clearance is chaotic: "
        "traces part, statistics stay.",
    )
