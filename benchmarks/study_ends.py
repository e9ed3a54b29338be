"""A sealed study ended by SIGTERM or Ctrl-C at random instants: no process of it is left.

Each study runs in a session of its own with two workers, so that whatever it started can be found
by the session's number; a temporary folder of its own shows what it leaves behind there.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from report import Report, parser

TO_END_S = 5.0
LATEST_S = 40.0  # of the instants: start, making the machines, and diagnoses under way
COMMAND = ["blind", "--cases", "40", "--seed", "7", "--jobs", "2"]


def in_session(session: int) -> list[str]:
    """Processes of a session that still run, with their command lines."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            state, _, _, own = (folder / "stat").read_text().rsplit(")", 1)[1].split()[:4]
            words = (folder / "cmdline").read_text().replace("\0", " ")
        except OSError:
            continue
        if int(own) == session and state != "Z":
            found.append(f"{folder.name} {words[:80]}")
    return found


def ended(number: int, after_s: float, folder: Path) -> tuple[float, list[str], list[str], str]:
    """Seconds until all had gone; who had not, files left in the folder, and what was said."""
    process = subprocess.Popen(
        [sys.executable, "-m", "ecyl_ros.cli.main", *COMMAND],
        start_new_session=True,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"TMPDIR": str(folder), "JOBLIB_TEMP_FOLDER": str(folder)},
        cwd=folder,
    )
    time.sleep(after_s)
    os.kill(process.pid, number)
    begin = time.monotonic()
    left = in_session(process.pid)
    while left and time.monotonic() < begin + TO_END_S:
        process.poll()
        time.sleep(0.02)
        left = in_session(process.pid)
    took = time.monotonic() - begin
    if left:  # not to burden the next
        os.killpg(process.pid, signal.SIGKILL)
    _, said = process.communicate()
    files = [path.name for path in folder.rglob("*") if path.is_file()]
    return took, left, files, said


def main() -> None:
    """Start studies and end them."""
    made = parser(__doc__)
    made.add_argument("--studies", type=int, default=20, help="(default 20)")
    made.add_argument("--seed", type=int, default=1, help="of the instants (default 1)")
    options = made.parse_args()
    report = Report(f"studies ended, {options.studies} times")
    random = np.random.default_rng(options.seed)
    took, left, files, tracebacks = [], 0, 0, 0
    for count in range(options.studies):
        number = signal.SIGTERM if count % 2 == 0 else signal.SIGINT
        after_s = float(random.uniform(0.2, LATEST_S))
        with tempfile.TemporaryDirectory(prefix="ecyl_study_") as folder:
            seconds, alive, kept, said = ended(number, after_s, Path(folder))
        took.append(seconds)
        left += len(alive)
        files += len(kept)
        tracebacks += "Traceback" in said
        for line in (*alive, *kept):
            report.say(f"  {signal.Signals(number).name} after {after_s:.1f} s left {line}")
        if "Traceback" in said:
            report.say(said[-400:])
    report.target(
        "longest_s", max(took), ".2f", f"{TO_END_S:g} or less", "all gone after s, at most"
    )
    report.target("left", left, "d", "0", "processes left over")
    report.target("files", files, "d", "0", "files left in the temporary folder")
    report.target("tracebacks", tracebacks, "d", "0", "studies that printed a traceback")
    report.finish(options.json)


if __name__ == "__main__":
    main()
