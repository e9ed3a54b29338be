"""The page: what was found first, then everything it stands on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from .. import __version__
from ..gap.report.markup import typeset
from ..gap.report.style import CSS
from . import published
from .figures import Picture
from .readings import half_clearance_m
from .results import Results, error_std
from .tables import Table, percent

NOT_GIVEN = (
    "number of pole pairs (4 assumed; they enter the cross terms alone)",
    "limits of voltage, current and speed (none)",
    "friction of motor, transmission and load (none in the servo)",
    "damping in contact (none, and 1e-4 N m s/rad for comparison)",
    "mass, stiffness and damping of the load, M2, K and D (in J_eq, none, none)",
    "solver, step and seconds simulated (fourth order at 100 kHz, 20 s, the last 10 s judged)",
    "how the lag was read (least squares of lag, gain and offset)",
    "how EMD was stopped, and how its ends were continued (PyEMD, ends mirrored)",
    "the width of the measured loop (1 N m and 2 % of the load)",
)


@dataclass(frozen=True)
class Part:
    """A section: heading, paragraphs, and (figure or None, tables) in their order."""

    heading: str
    paragraphs: tuple[str, ...]
    items: tuple[tuple[Picture | None, tuple[Table, ...]], ...]


def findings(results: Results) -> tuple[str, ...]:
    """The page's first paragraphs, made of its own numbers."""
    published_run, si = results.nominal("published"), results.nominal("si")
    worst = max(
        abs(results.at("published", "stiffness", share).error_std_m / paper - 1.0)
        for share, paper in published.ERROR_STD_M.items()
    )
    damped = max(
        abs(results.at("damped", "stiffness", share).error_std_m / paper - 1.0)
        for share, paper in published.ERROR_STD_M.items()
    )
    half = half_clearance_m(results.reading("si").drive)
    moved = {
        (key, change, share): results.over_starts(key, change, share, error_std).mean
        / results.over_starts(key, change, 1.0, error_std).mean
        - 1.0
        for key in ("published", "si")
        for change, share in (("stiffness", 1.3), ("clearance", 0.5))
    }
    texts = {key: percent(value, 0, "+") for key, value in moved.items()}
    return (
        "Table 1 gives k2 = 0.529 arcmin/(N m), so 1/k2 is 1.890 N m/arcmin, or 6499 N m/rad. The "
        "published results come out when the number 1.89 is used as N m/rad, 3438 times too soft: "
        f"IMF1 then is at {published_run.imfs[0].frequency_hz:.2f} Hz (paper: 3.45), and the "
        f"errors of Table 3 are met within {percent(worst)}, with a trace of contact damping "
        f"within {percent(damped)}.",
        f"In SI the error at 100 % is {si.error_std_m * 1e3:.4f} mm instead of "
        f"{published_run.error_std_m * 1e3:.4f} mm, no single line is near 3 Hz, and the "
        f"amplitude at 1 Hz is {si.line_1hz_m * 1e3:.4f} mm, near half the clearance of "
        f"{half * 1e3:.4f} mm, as the paper says of its IMF2.",
        "The paper's conclusion, that stiffness matters and clearance need not be considered, does "
        "not hold in SI: 30 % more stiffness change the error by "
        f"{texts['si', 'stiffness', 1.3]}, half the clearance by {texts['si', 'clearance', 0.5]}. "
        "In the published reading clearance matters, too: "
        f"{texts['published', 'stiffness', 1.3]} and {texts['published', 'clearance', 0.5]}.",
        f"The largest torque in these runs is {published_run.peak_torque_nm:.4f} N m as published "
        f"and {si.peak_torque_nm:.2f} N m in SI. The bench needed 1.5 N m to overcome internal "
        "friction and oil film, and its torque sensor resolves 0.4 N m: a motion of 0.02 mm "
        "without friction says little about the cylinder that was measured.",
    )


def html(results: Results, parts: Sequence[Part], facts: Mapping[str, str]) -> str:
    """The page as text."""
    return (
        _environment()
        .get_template("page.html.j2")
        .render(
            css=CSS,
            findings=findings(results),
            parts=parts,
            readings=results.readings,
            not_given=NOT_GIVEN,
            facts={**facts, "made by": f"ecyl {__version__}"},
        )
    )


def table_html(table: Table) -> str:
    """One table as a page of its own."""
    return _environment().get_template("table.html.j2").render(css=CSS, table=table)


def _environment() -> Environment:
    made = Environment(
        loader=PackageLoader("ecyl_ros.paper", "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.filters["t"] = lambda text: Markup(typeset(text))
    return made
