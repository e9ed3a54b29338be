"""All of it: run, identify, tabulate, draw, write."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..recording.atomic import write_text
from . import figures
from .bench_part import DRAWS, bench_part, bench_tables
from .open_part import checks_table, open_tables
from .page import Part, html, table_html
from .published import ERROR_STD_M, LAG_S
from .readings import readings
from .results import Results
from .runs import STARTS, cases, run_all
from .servo_part import (
    clearance_table,
    elasticity_table,
    emd_table,
    figure_tables,
    lag_table,
    starts_table,
    table_3,
    waves_table,
)
from .statements import statement_table, verdicts
from .tables import Table

SCHEMA = "ecyl.paper/1"


def results_of(
    starts: int, *, jobs: int | None = None, progress: Callable[[float], None] | None = None
) -> Results:
    """All closed-loop runs.

    Raises:
        InputError: `starts` is not 1 to 8.
    """
    if not 1 <= starts <= len(STARTS):
        raise InputError(f"starts = {starts}, expected 1 to {len(STARTS)}")
    chosen = readings()
    return Results(chosen, run_all(cases(chosen, starts), jobs=jobs, progress=progress), starts)


def write(
    results: Results, folder: Path, *, draws: int = DRAWS, jobs: int | None = None
) -> list[Table]:
    """Write index.html, tables/, figures/ and results.json; the page comes last.

    draws: of the bench's sensor errors.

    Returns:
        All tables, in the order of the page.

    Raises:
        InputError: something cannot be written.
    """
    bench = bench_part(draws, jobs)
    drawn = {one.name: one for one in figures.pictures(results, bench.read)}
    numbers = figure_tables(results)
    parts = (
        Part(
            "Which reading gives what",
            (),
            (
                (drawn["conclusion"], (elasticity_table(results), table_3(results))),
                (None, (statement_table(results), checks_table(results))),
            ),
        ),
        Part(
            "The servo, section 4.1",
            (
                "0.02 mm at 1 Hz for 20 s from rest, the last 10 s judged. Dashed: the paper's "
                "frequency, or half the clearance.",
                "At most five IMFs are extracted by PyEMD (cubic envelopes, ends mirrored) after a "
                "low-pass at 37.5 Hz. Each has its frequency from the FFT and from the Hilbert "
                "transform; where the two part, or where much of its power is away from its line, "
                "the mode is not one oscillation.",
            ),
            (
                *((drawn[name], (table,)) for name, table in numbers.items()),
                (None, (emd_table(results),)),
            ),
        ),
        Part(
            "Sensitivity, section 4.2",
            (),
            (
                (
                    drawn["fig15_stiffness"],
                    (
                        waves_table(results, "fig15_stiffness", "stiffness", 0),
                        starts_table(results, "stiffness"),
                        lag_table(results),
                    ),
                ),
                (
                    drawn["fig16_clearance"],
                    (
                        waves_table(results, "fig16_clearance", "clearance", 1),
                        clearance_table(results),
                        starts_table(results, "clearance"),
                    ),
                ),
            ),
        ),
        Part(
            "The bench, section 3",
            (),
            ((drawn["fig09_hysteresis"], tuple(bench_tables(bench))),),
        ),
        Part("What the paper leaves open", (), ((None, tuple(open_tables(results))),)),
    )
    tables = [table for part in parts for _, found in part.items for table in found]
    for table in tables:
        write_text(folder / "tables" / f"{table.name}.csv", table.csv())
        write_text(folder / "tables" / f"{table.name}.html", table_html(table))
    for picture in drawn.values():
        figures.write(picture, folder / "figures")
    write_text(
        folder / "results.json", json.dumps(as_json(results), indent=1, allow_nan=False) + "\n"
    )
    facts = {
        "runs": f"{len(results.runs)} of up to 20 s at 100 kHz, {results.starts} starts each",
        "again": "ecyl paper OUT_DIR; every number is in tables/ and results.json",
    }
    write_text(folder / "index.html", html(results, parts, facts))
    return tables


def as_json(results: Results) -> dict[str, Any]:
    """Every run's figures and the verdict on every statement; None where there is no figure."""
    return {
        "schema": SCHEMA,
        "paper": {
            "error_std_m": {str(key): value for key, value in ERROR_STD_M.items()},
            "lag_s": {str(key): value for key, value in LAG_S.items()},
        },
        "statements": verdicts(results),
        "elasticity": {
            one.key: {
                change: results.elasticity(one.key, change) for change in ("stiffness", "clearance")
            }
            for one in results.readings
        },
        "runs": [
            {
                "reading": key[0],
                "changed": key[1],
                "to": key[2],
                "start": STARTS[key[3]],
                "error_std_m": _number(ran.error_std_m),
                "lag_s": _number(ran.lag_s),
                "line_1hz_m": _number(ran.line_1hz_m),
                "peak_torque_nm": _number(ran.peak_torque_nm),
                "lost_s": ran.lost_s,
                "imfs": [
                    {name: _number(value) for name, value in asdict(mode).items()}
                    for mode in ran.imfs
                ],
            }
            for key, ran in results.runs.items()
        ],
    }


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None
