"""What it takes to describe a cause that the catalogue lacks, beside the diagnosis.

    python benchmarks/describing.py

Machines of the study whose cause is outside the catalogue (12 s at 1 kHz, constants off their
sheet) are diagnosed one after the other. Printed is the time of each diagnosis, and how much of it
goes into describing: for an idle computer.
"""

from __future__ import annotations

import time
from typing import Any
from unittest.mock import patch

import numpy as np
from report import Report, parser

from ecyl_ros.drive.drive_file import load_drive
from ecyl_ros.gap.describe import apply
from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.gap.study.drives import BenchDrives, Choice

MOST = "at most 20 s"


def main() -> None:
    """Run the benchmark."""
    made = parser(__doc__)
    made.add_argument("--cases", type=int, default=12, help="machines drawn (default 12)")
    made.add_argument("--seed", type=int, default=1, help="of the draw (default 1)")
    made.add_argument("--sheet", type=float, default=0.02, help="share off (default 0.02)")
    options = made.parse_args()
    report = Report(f"{options.cases} machines with a cause that the catalogue lacks")
    drives = BenchDrives(load_drive("bench"), options.sheet)
    plan = drives.plan(options.cases, options.seed, Choice(("law",), None, ()))
    describe, spent = apply.describe, [0.0] * options.cases

    def timed(*given: Any) -> Any:
        begin = time.perf_counter()
        found = describe(*given)
        spent[case.index] = time.perf_counter() - begin
        return found

    rows = []
    for case in map(drives.complete, plan):
        given = drives.given(case)
        begin = time.perf_counter()
        with patch.object(apply, "describe", timed):
            said = diagnose(given.recording, given.drive, without=case.withheld)
        whole = time.perf_counter() - begin
        law = f"{said.law.law.port} of {', '.join(said.law.law.of)}" if said.law else ""
        rows.append(
            [f"machine {case.index}", f"{whole:.1f}", f"{spent[case.index]:.1f}", said.verdict, law]
        )
        report.say("  ".join(rows[-1]))
    report.say("")
    report.table(["", "diagnosis, s", "of it describing, s", "verdict", "law"], rows)
    tried = [one for one in spent if one > 0.0]
    report.target("median_s", float(np.median(tried)), ".1f", MOST, "describing, median, s")
    report.target("longest_s", max(tried), ".1f", MOST, "describing, longest, s")
    report.finish(options.json)


if __name__ == "__main__":
    main()
