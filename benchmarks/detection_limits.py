"""How often a fault of the stated smallest size is seen: drawn machines, 95 % is what is stated.

    python benchmarks/detection_limits.py --cases 100 --seed 1 --jobs 2

Each case draws a machine of the sealed study (equations of its own, constants off the sheet, a
motion of its own) and records it healthy; the diagnosis states from that how small a fault of one
effect would have been seen. The machine gets the fault in just that size, with other noise, and is
recorded again on the same motion. Seen: neither noise nor constants within their tolerances account
for the recording, so that the verdict would be neither `no_gap` nor `within_sheet`.
"""

from __future__ import annotations

import argparse
import sys
from collections import defaultdict
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from ecyl_ros.drive.drive_file import load_drive, resolve_drive
from ecyl_ros.drive.parameters import DriveParameters
from ecyl_ros.gap.compete.earn import at_noise
from ecyl_ros.gap.fit.descent import settle
from ecyl_ros.gap.fit.fit import Fit, Fitter
from ecyl_ros.gap.judge.verdict import at_floor
from ecyl_ros.gap.limits.cylinder import least_visible, seen_by
from ecyl_ros.gap.limits.seen import Seen
from ecyl_ros.gap.replay.replay import Replay
from ecyl_ros.gap.split import held_out_of
from ecyl_ros.gap.study.cylinder.cases import stated
from ecyl_ros.gap.study.cylinder.inside import INSIDE
from ecyl_ros.gap.study.cylinder.machine import record_machine
from ecyl_ros.gap.study.cylinder.stage import Setup, Stage
from ecyl_ros.gap.study.workers import in_processes
from ecyl_ros.recording.signals import Recording

WANTED = (0.90, 0.99)


class Drawn(NamedTuple):
    """A machine to be drawn: its number, its seed and the effect of its fault."""

    case: int
    seed: int
    name: str


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--cases", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--drive", default="bench")
    parser.add_argument("--sheet", type=float, default=0.01, help="relative sd off the sheet")
    parser.add_argument("--times", type=float, nargs="+", default=[0.5, 1.0], help="of the size")
    parser.add_argument("--effects", default=",".join(INSIDE))
    parser.add_argument("--jobs", type=int, default=1)
    options = parser.parse_args()
    drive = load_drive(resolve_drive(options.drive))
    names = options.effects.split(",")
    drawn = [
        Drawn(case, 1000 * options.seed + case, names[case % len(names)])
        for case in range(options.cases)
    ]
    examined = partial(_case, drive=drive, sheet=options.sheet, times=options.times)
    seen: dict[float, list[bool]] = defaultdict(list)
    missed: list[str] = []
    unseen = 0
    for (case, _, name), found in in_processes(examined, drawn, options.jobs):
        if found is None:
            unseen += 1
            continue
        size, unit, answers = found
        for times, answer in answers.items():
            seen[times].append(answer)
        if not answers.get(1.0, True):
            missed.append(name)
        print(f"{case:4d} {name:28s} {size:10.3g} {unit:12s} {answers}", flush=True)
    for times in options.times:
        rate = sum(seen[times]) / max(len(seen[times]), 1)
        print(f"{times:g} times the stated size: {100.0 * rate:.1f} % of {len(seen[times])} seen")
    print(f"not seen at any size: {unseen}; missed at the stated size: {', '.join(missed) or '-'}")
    rate = sum(seen[1.0]) / max(len(seen[1.0]), 1)
    return 0 if WANTED[0] <= rate <= WANTED[1] else 1


def _case(
    drawn: Drawn, drive: DriveParameters, sheet: float, times: list[float]
) -> tuple[Drawn, tuple[float, str, dict[float, bool]] | None]:
    """The machine, and (size, unit, whether it was seen at these multiples); None where no size
    is seen."""
    _, seed, name = drawn
    setup = Setup(drive)
    stage = Stage.of(seed, setup, sheet)
    nominal = stated(drive, sheet)
    healthy = record_machine(stage.with_effects({}, seed), stage.nuisances, drive, stage.reference)
    smallest = _smallest(healthy, nominal, name, stage)
    if smallest is None:
        return drawn, None
    nuisances = replace(stage.nuisances, noise_seed=stage.nuisances.noise_seed + 1)
    answers = {}
    for one in times:
        values = smallest.probe.made(one * smallest.size)
        machine = stage.with_effects({name: values}, seed)
        recording = record_machine(machine, nuisances, drive, stage.reference)
        answers[one] = _shows(recording, nominal, stage)
    return drawn, (smallest.size, smallest.probe.quantity.unit, answers)


def fitter_of(recording: Recording, drive: DriveParameters) -> Fitter:
    replay = Replay(recording, drive, "case")
    fitter = Fitter(replay, held_out_of(replay.time_s, replay.gap({}), replay.usable))
    fitter.test_floor(fitter.nominal)
    return fitter


def true_pulls(fitter: Fitter, stage: Stage) -> np.ndarray:
    """Where the machine's constants lie on its sheet."""
    sheet = fitter.sheet
    errors = np.array([stage.errors.get(key, 0.0) for key in sheet.keys])
    with np.errstate(divide="ignore", invalid="ignore"):
        pulls = np.log1p(errors) * sheet.nominal / sheet.tolerance
    return np.where(sheet.nominal > 0.0, pulls, 0.0)


def sheet_alone(fitter: Fitter, stage: Stage) -> Fit:
    """The sheet fitted, from where the machine truly lies: it leaves no more than from afar."""
    return settle(fitter, fitter.evaluate({}, true_pulls(fitter, stage)))


def _smallest(recording: Recording, drive: DriveParameters, name: str, stage: Stage) -> Seen | None:
    fitter = fitter_of(recording, drive)
    fit = fitter.nominal
    if not at_floor(fit, fitter.replay):
        fit = sheet_alone(fitter, stage)
    _, found = seen_by(fitter, fit, [name])
    least = least_visible(found)
    return least[0] if least and least[0].limit.smallest_seen is not None else None


def _shows(recording: Recording, drive: DriveParameters, stage: Stage) -> bool:
    """As the diagnosis begins: not at the floor, and no sheet accounts for it."""
    fitter = fitter_of(recording, drive)
    if at_floor(fitter.nominal, fitter.replay):
        return False
    null = sheet_alone(fitter, stage)
    fitter.test_floor(null)
    return not at_noise(fitter, null)


if __name__ == "__main__":
    sys.exit(main())
