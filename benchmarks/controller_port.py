"""How far the controller's own equation is off: sealed drives with a sound controller, and others.

    python benchmarks/controller_port.py --cases 200 --seed 1
    python benchmarks/controller_port.py --drives random --cases 200 --seed 1

Each drive of the sealed study is recorded and its recording replayed through the nominal model. The
figure is the residual of the controller's equation on measured signals over what noise leaves of it
on the nominal machine: 1 for a healthy controller. Wrong limits are left out: below them the
equation holds. Drives on the other side of the level are listed (a current loop may be faster than
noise lets see).
"""

from __future__ import annotations

import argparse
import sys

import numpy as np

from ecyl_ros.drive.drive_file import load_drive, resolve_drive
from ecyl_ros.gap.locate.block import CONTROLLER_BROKEN
from ecyl_ros.gap.locate.controller_port import controller_check
from ecyl_ros.gap.replay.replay import Replay
from ecyl_ros.gap.study.case import KINDS
from ecyl_ros.gap.study.causes import cause_of
from ecyl_ros.gap.study.drives import BenchDrives, Choice, RandomDrives

LIMITS = {"current_limit", "voltage_limit"}
LATE = "measurement_delay"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--drives", choices=("bench", "random"), default="bench")
    parser.add_argument("--cases", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--sheet", type=float, default=0.02, help="relative sd off the sheet")
    options = parser.parse_args()
    drives: BenchDrives | RandomDrives = RandomDrives(options.sheet)
    if options.drives == "bench":
        drives = BenchDrives(load_drive(resolve_drive("bench")), options.sheet)
    kinds = tuple(kind for kind in drives.kinds if kind in KINDS)
    sound: list[float] = []
    broken: list[float] = []
    unknown = 0
    for planned in drives.plan(options.cases, options.seed, Choice(kinds)):
        if set(planned.effects) & LIMITS:
            continue
        case = drives.complete(planned)
        given = drives.given(case)
        check = controller_check(Replay(given.recording, given.drive, "recording"))
        if check is None:
            unknown += 1
            continue
        at_fault = any(
            name == LATE or cause_of(case.drives, name).block == "controller"
            for name in case.effects
        )
        (broken if at_fault else sound).append(check.ratio)
        if at_fault != (check.ratio > CONTROLLER_BROKEN):
            print(f"case {case.index}: {' + '.join(case.effects) or 'none'}: {check.ratio:.2f}")
    print(f"{unknown} recordings lack a signal that the controller measures or commands")
    for what, ratios in (("sound", sound), ("at fault", broken)):
        if ratios:
            low, middle, high = np.quantile(ratios, (0.0, 0.5, 1.0))
            seen = sum(one > CONTROLLER_BROKEN for one in ratios)
            print(
                f"controller {what}: {low:.2f} to {high:.4g} floors, median {middle:.4g}; "
                f"{seen} of {len(ratios)} above {CONTROLLER_BROKEN}"
            )
    return 0


if __name__ == "__main__":
    sys.exit(main())
