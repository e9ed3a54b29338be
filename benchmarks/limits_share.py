"""What the detection limits cost a diagnosis, as a share of its own processor time.

python benchmarks/limits_share.py
"""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import Any

from ecyl_ros.drive.drive_file import load_drive, resolve_drive
from ecyl_ros.gap import cylinder
from ecyl_ros.gap.diagnose import diagnose
from ecyl_ros.recording.load import load_recording

BAGS = Path(__file__).resolve().parents[1] / "bags"
RECORDINGS = ("bench_moves.mcap", "worn_drive.mcap")


def main() -> int:
    drive = load_drive(resolve_drive("bench"))
    whole = cylinder.limits_of
    spent = 0.0

    def timed(*given: Any) -> Any:
        nonlocal spent
        begin = time.process_time()
        found = whole(*given)
        spent += time.process_time() - begin
        return found

    cylinder.limits_of = timed
    diagnose(load_recording(BAGS / RECORDINGS[0]), drive)  # compiles what is not yet
    for name in RECORDINGS:
        recording = load_recording(BAGS / name)
        spent, begin = 0.0, time.process_time()
        found = diagnose(recording, drive)
        total = time.process_time() - begin
        print(
            f"{name}: {found.verdict}, limits {spent:.2f} s of {total:.2f} s of processor time, "
            f"{100.0 * spent / total:.0f} %"
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
