"""A diagnosis beside other work: its linear algebra on one thread, and on one per core.

    python benchmarks/busy_diagnosis.py

Rigid drives of the study, their cause withheld from the catalogue so that laws are looked for, are
diagnosed while a process per core computes: as the product does, and with the threads that NumPy
takes by itself, in turn. Printed is the processor time of either.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from typing import Any

from report import Report, parser
from threadpoolctl import threadpool_limits

from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.gap.study.drives import Choice, Given, RigidDrives


def seconds(work: Callable[..., Any], given: Given, without: Sequence[str]) -> float:
    """Processor time of one diagnosis."""
    begin = time.process_time()
    work(given.recording, given.drive, without=without)
    return time.process_time() - begin


def main() -> None:
    """Run the benchmark."""
    made = parser(__doc__)
    made.add_argument("--cases", type=int, default=6, help="machines drawn (default 6)")
    made.add_argument("--seed", type=int, default=1, help="of the draw (default 1)")
    options = made.parse_args()
    cores = os.cpu_count() or 1
    report = Report(f"{options.cases} rigid drives diagnosed beside a busy process per core")
    drives = RigidDrives()
    plan = drives.plan(options.cases, options.seed, Choice(("withheld",)))
    cases = [drives.complete(case) for case in plan]
    subjects = [(drives.given(case), case.withheld) for case in cases]
    free: Callable[..., Any] = diagnose.__wrapped__  # type: ignore[attr-defined]
    seconds(diagnose, *subjects[0])  # compiles what is not yet
    busy = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(cores)]
    rows, spent = [], [0.0, 0.0]
    try:
        with threadpool_limits(cores):
            for number, one in enumerate(subjects):
                pair = [seconds(work, *one) for work in (diagnose, free)]
                spent = [total + new for total, new in zip(spent, pair, strict=True)]
                rows.append([f"machine {number}", *(f"{value:.2f}" for value in pair)])
    finally:
        for process in busy:
            process.kill()
            process.wait()
    rows.append(["all", *(f"{value:.2f}" for value in spent)])
    report.table(["processor time, s", "one thread", f"{cores} threads"], rows)
    report.target("ratio", spent[0] / spent[1], ".2f", "below 1", "one thread over several")
    report.finish(options.json)


if __name__ == "__main__":
    main()
