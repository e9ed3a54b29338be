"""How long it takes to start: the import, the command's help, and compiling the kernels once."""

from __future__ import annotations

import functools
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from report import Report, median_wall_time_s, parser

WARM_UP = (
    "from ecyl_ros.drive.drive_file import load_drive\n"
    "from ecyl_ros.drive.warm_up import warm_up\n"
    "print(warm_up(load_drive('bench')))"
)


def run(command: list[str], environment: dict[str, str] | None = None) -> str:
    """Run a command to its end and return what it printed."""
    done = subprocess.run(
        command, check=True, capture_output=True, text=True, env=os.environ | (environment or {})
    )
    return done.stdout


def starts(report: Report, runs: int) -> None:
    """Import and help."""
    ecyl = str(Path(sys.executable).with_name("ecyl"))
    commands = {
        "python -c pass": [sys.executable, "-c", "pass"],
        "python -c 'import ecyl_ros'": [sys.executable, "-c", "import ecyl_ros"],
        "ecyl --help": [ecyl, "--help"],
        "ecyl run --help": [ecyl, "run", "--help"],
    }
    for name, command in commands.items():
        run(command)  # once for the file cache and the byte code
        seconds = median_wall_time_s(functools.partial(run, command), runs)
        report.target(name, seconds, ".3f", "less than 0.5", f"{name}, s")


def kernels(report: Report) -> None:
    """A new process's first drive with an empty cache, and with a filled one."""
    report.say("\nAll compiled functions of a drive, in a new process:")
    rows = []
    with tempfile.TemporaryDirectory(prefix="ecyl_bench_") as folder:
        for name in ("empty cache", "cached"):
            begin = time.perf_counter()
            seconds = float(run([sys.executable, "-c", WARM_UP], {"NUMBA_CACHE_DIR": folder}))
            whole = time.perf_counter() - begin
            rows.append([name, f"{seconds:.2f}", f"{whole:.2f}"])
            report.figures[f"kernels_{name.replace(' ', '_')}_s"] = seconds
            report.figures[f"process_{name.replace(' ', '_')}_s"] = whole
    report.table(["", "kernels ready after s", "whole process s"], rows)


def main() -> None:
    """Print both parts."""
    made = parser(__doc__)
    made.add_argument("--runs", type=int, default=10, help="the median counts (default 10)")
    options = made.parse_args()
    report = Report("start-up")
    starts(report, options.runs)
    kernels(report)
    report.finish(options.json)


if __name__ == "__main__":
    main()
