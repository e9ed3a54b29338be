"""What `sysid_peer` prints: a row a machine, counts, and how far both simulations agree."""

from __future__ import annotations

import math
import statistics
from typing import Any

from report import Report


def told(row: dict[str, Any]) -> list[str]:
    """What both say of a machine, one line each."""
    ours, peer_s = row["ours"], row["peer"]["values"]
    truth = row["truth"] or "not known"
    if row["truth_is_a_parameter"] is False:
        truth += ", none of the joint's parameters"
    if row["truth_can_be_seen"] is False:
        truth += ", too small to be told in this recording"
    numbers = ", ".join(f"{name} {value:.4g}" for name, value in peer_s.items())
    causes = ", ".join(ours["causes"]) or "no cause named"
    return [
        f"  {row['machine']}: {truth}",
        f"    mujoco.sysid: {numbers}",
        f"    ours: {ours['verdict']}; {causes}",
    ]


def at_most(rows: list[dict[str, Any]], whose: str, what: str) -> tuple[int, int, float]:
    """On how many rows our error is at most the peer's, of how many; median of ours over its.

    whose: "ours", or "closest".
    """
    pairs = [(row[whose][what], row["peer"][what]) for row in rows]
    pairs = [(math.inf if one is None else one, other) for one, other in pairs]
    ratios = [one / other for one, other in pairs]
    return sum(one <= other for one, other in pairs), len(pairs), statistics.median(ratios)


def show(report: Report, rows: list[dict[str, Any]]) -> None:
    """The table of some machines, what was said of them, and the counts."""

    def cell(value: float | None) -> str:
        return "-" if value is None else f"{value:.4f}" if value < 100.0 else f"{value:.1e}"

    whose = ("nominal", "peer", "ours", "closest")
    columns = ["mujoco.sysid", "ours", "closest"]
    header = ["", "motion: file", *columns, "effort: file", *columns]
    cells = [
        [
            row["machine"] + ("" if row["truth_is_a_parameter"] in (True, None) else " *"),
            *(cell(row[one]["motion"]) for one in whose),
            *(cell(row[one]["effort"]) for one in whose),
            f"{row['peer']['seconds']:.1f}",
            f"{row['ours']['seconds']:.1f}",
        ]
        for row in rows
    ]
    report.say("")
    report.table([*header, "its s", "our s"], cells)


def count(report: Report, key: str, rows: list[dict[str, Any]], meaning: str) -> None:
    """Print and keep on how many of some machines ours errs no more."""
    if not rows:
        return
    kept: dict[str, Any] = {}
    for whose in ("ours", "closest"):
        for what in ("motion", "effort"):
            good, of, ratio = at_most(rows, whose, what)
            report.say(
                f"  {meaning}, {what}: {whose} at most the peer's on {good} of {of}; "
                f"median over the peer's {ratio:.3f}"
            )
            own = {"at_most_the_peers": good, "of": of, "median_ratio": ratio}
            kept.setdefault(whose, {})[what] = own
    report.figures[key] = kept


def agreement(report: Report, rows: list[dict[str, Any]]) -> None:
    """How far errors of the file's own machine by MuJoCo are from those by our simulation."""
    known = [one for one in rows if one["nominal_by_mujoco"]]
    if not known:
        return
    apart = max(
        abs(one["nominal_by_mujoco"][what] / one["nominal"][what] - 1.0)
        for one in known
        for what in ("motion", "effort")
    )
    report.say(
        f"  MuJoCo {known[0]['peer']['mujoco']}; the file's machine, simulated and inverted by "
        f"both: its errors differ by {100.0 * apart:.1f} % at the most"
    )
    report.figures["nominal_differs"] = apart
