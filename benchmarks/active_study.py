"""One planned motion after a poor recording: machines decided by it, and by usual motions.

    python benchmarks/active_study.py --cases 60 --seed 1
    python benchmarks/active_study.py --cases 60 --seed 1 --others

Each machine of the sealed study (equations of its own, constants off the sheet by 2 %, most with
one hidden fault) is first recorded on a poor motion: a slow sine, moves one way, a tiny sine, or
constant speed. Where that diagnosis leaves something open, or sees no gap, a motion is planned from
it as `ecyl plan --from` does, the same machine plays it, and both recordings are diagnosed
together. With --others a chirp, a multisine and random moves of the same limits and time take its
place in turn. Labels are opened at the end.

Decided: the diagnosis leaves nothing open, as `ecyl investigate` has it. Right: its first cause is
the fault and no other is named, or the machine is healthy and said to be. Missed: said to be
healthy and is not. Motions keep the speed and acceleration of the study's own motions, for which
its faults have their sizes.
"""

from __future__ import annotations

import argparse
import dataclasses
import sys
import time
from collections import Counter
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ecyl_ros.cli.progress import progress_bar
from ecyl_ros.drive.drive_file import load_drive, resolve_drive
from ecyl_ros.drive.parameters import DriveParameters
from ecyl_ros.drive.reference.base import Reference
from ecyl_ros.drive.reference.moves import Moves
from ecyl_ros.drive.reference.sine import Sine
from ecyl_ros.effects.catalogue import CATALOGUE
from ecyl_ros.errors import InputError
from ecyl_ros.gap.replay.replay import SIGNALS
from ecyl_ros.gap.study.case import Case
from ecyl_ros.gap.study.cylinder.cases import record_on, stated
from ecyl_ros.gap.study.cylinder.stage import PEAK_SPEED_RAD_S, Setup, Stage
from ecyl_ros.gap.study.drives import BenchDrives, Choice, draw_cases
from ecyl_ros.gap.study.examine import Outcome
from ecyl_ros.gap.study.journal import Journal
from ecyl_ros.gap.study.score.answers import first_right, none_wrong
from ecyl_ros.gap.study.seal import seal
from ecyl_ros.gap.study.subject import product_diagnosis
from ecyl_ros.gap.study.workers import in_processes
from ecyl_ros.investigate.question import HEALTHY, question
from ecyl_ros.plan.hypotheses import open_or_alike
from ecyl_ros.plan.make import BUDGET_S, PLANNED, make_plan
from ecyl_ros.plan.others import usual

SHEET = 0.02
WANTED_RIGHT, WANTED_WRONG = 0.9, 0.03
OTHERS = ("chirp", "multisine", "moves")
FIRST, FIRST_S = "first recording", 6.0
# Of the study's motions: a chirp to 9 Hz at their peak speed asks for 2 m/s^2 (bench).
ACCELERATION, JERK = 2.0, 100.0
# The first is slow for all that turns with the rotor, the second has no reversal, the third hardly
# leaves the clearance, the fourth has neither reversal nor, beyond its ends, acceleration.
POOR: dict[str, Reference] = {
    "slow sine": Sine(1e-3, 0.25, phase=-np.pi / 2, offset=1e-3),
    "one way": Moves((2e-3, 4e-3, 6e-3, 8e-3), 3e-3, 0.2, 5.0, repeat=False),
    "tiny": Sine(1e-5, 1.0, phase=-np.pi / 2, offset=1e-5),
    "constant speed": Moves((0.05,), 0.01, 0.2, 5.0, repeat=False),
}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--cases", type=int, default=60)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--case", type=int, help="this one of them alone")
    parser.add_argument("--duration", type=float, default=8.0, help="of the second motion, s")
    parser.add_argument("--budget", type=float, default=BUDGET_S, help="for a plan, s of wall time")
    parser.add_argument("--others", action="store_true", help="usual motions beside the planned")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--journal", type=Path, default=Path("out/active_study.jsonl"))
    parser.add_argument("--resume", action="store_true", help="go on with the journal's study")
    options = parser.parse_args()
    drives = BenchDrives(limited(load_drive(resolve_drive("bench"))), SHEET)
    cases = drawn(drives, options)
    sealed = seal(cases)
    print(f"{len(cases)} cases drawn and sealed, SHA-256 {sealed.sha256}", flush=True)
    journal = Journal(options.journal, sealed.sha256, resume=options.resume)
    done = {one.index: one for one in journal.outcomes}
    todo = [case for case in cases if case.index not in done]
    study = partial(
        examined,
        drives=drives,
        duration_s=options.duration,
        budget_s=options.budget,
        others=OTHERS if options.others else (),
    )
    with progress_bar("diagnosing") as progress:
        for outcome in in_processes(study, todo, options.jobs):
            journal.add(outcome)
            done[outcome.index] = outcome
            progress(len(done) / len(cases))
    opened = sealed.open()
    return show(opened, [done[case.index] for case in opened], options)


def drawn(drives: BenchDrives, options: argparse.Namespace) -> list[Case]:
    """The cases asked for."""
    choice = Choice(kinds=("single", "none"))
    if options.case is not None:
        return [drives.complete(drives.plan(options.cases, options.seed, choice)[options.case])]
    with progress_bar("drawing drives") as progress:
        return draw_cases(drives, options.cases, options.seed, choice, progress=progress)


def limited(drive: DriveParameters) -> DriveParameters:
    """The drive with the limits that the study's motions keep."""
    speed = PEAK_SPEED_RAD_S * drive.transmission.rod_per_rotor
    limits = dataclasses.replace(drive.limits, speed=speed, acceleration=ACCELERATION, jerk=JERK)
    return dataclasses.replace(drive, limits=limits)


def poor_of(case: Case) -> str:
    """The first motion of a case: each in turn."""
    return list(POOR)[case.index % len(POOR)]


def examined(
    case: Case, drives: BenchDrives, duration_s: float, budget_s: float, others: Sequence[str]
) -> Outcome:
    """What is said of a case's first recording and, as baselines, of it with each motion.

    Where the first recording decides, its answer stands for every motion.

    duration_s: of each second motion. budget_s: for the planned one. others: usual motions.
    """
    setup = drives.setup(case.seed)
    stage = Stage.of(case.seed, setup, case.sheet)
    sheet = stated(setup.drive, case.sheet)

    def said(*motions: tuple[Reference, float]) -> dict[str, Any]:
        recordings = [
            record_on(case, stage.on(ticked(motion, length, setup), number, setup.drive), setup)
            for number, (motion, length) in enumerate(motions)
        ]
        recorded = recordings[0] if len(recordings) == 1 else tuple(recordings)
        try:
            return product_diagnosis(recorded, sheet, frozenset(case.withheld))
        except InputError as error:
            return refused(error)

    first = POOR[poor_of(case)], FIRST_S
    begin = time.perf_counter()
    found = said(first)
    seconds = time.perf_counter() - begin
    second: dict[str, dict[str, Any]] = {}
    if question(found) is not None or found["verdict"] in HEALTHY:
        begin = time.perf_counter()
        every = usual(sheet.limits, duration_s)
        motions = {PLANNED: planned_from(found, sheet, duration_s, budget_s)}
        motions |= {name: every[name] for name in others}
        for name, motion in motions.items():
            both = said(first, (motion, duration_s))
            now = time.perf_counter()
            second[name] = {"diagnosis": both, "seconds": now - begin}
            begin = now
    return Outcome(case.index, found, None, seconds, second)


def refused(error: InputError) -> dict[str, Any]:
    """Recordings that a diagnosis refuses, as one that cannot judge them: nothing is decided."""
    reason = str(error)
    location: dict[str, Any] = {"signals": []}
    return {"verdict": "not_judgeable", "reason": reason, "causes": [], "location": location}


def planned_from(
    data: Mapping[str, Any], drive: DriveParameters, duration_s: float, budget_s: float
) -> Reference:
    """The motion that `ecyl plan --from` finds for a diagnosis."""
    left = open_or_alike(data)
    signals = left.signals or tuple(one.name for one in SIGNALS)
    alone = [] if left.pairs else list(CATALOGUE)
    plan = make_plan(
        drive,
        duration_s,
        left.pairs,
        alone,
        left.values,
        signals,
        [],
        beside=(),
        budget_s=budget_s,
    )
    return plan.motion


def ticked(motion: Reference, length_s: float, setup: Setup) -> tuple[np.ndarray, np.ndarray]:
    """Position m and velocity m/s at each control tick."""
    rate = setup.drive.controller.rate
    shown = np.array([motion.sample(tick / rate) for tick in range(round(length_s * rate))])
    return shown[:, 0].copy(), shown[:, 1].copy()


def answer(case: Case, said: Mapping[str, Any], planned: bool) -> str:
    """`right`, `wrong`, `missed` or `undecided`.

    planned: a motion was played for what was open, so that what it could not show of a machine
    without a gap is no reason to go on, as in `ecyl investigate`.
    """
    named = [one["effect"] for one in said["causes"]]
    healthy = said["verdict"] in HEALTHY
    if not none_wrong(case, named):
        return "wrong"
    if question(said) is not None and not (healthy and planned):
        return "undecided"
    if healthy:
        return "right" if case.kind == "none" else "missed"
    return "right" if first_right(case, named) else "undecided"


ANSWERS = ("right", "wrong", "missed", "undecided")


def answers(case: Case, outcome: Outcome, motion: str) -> str:
    """The answer after a motion; that of the first recording where it took no second."""
    if motion == FIRST or not outcome.baselines:
        return answer(case, outcome.diagnosis or {}, planned=False)
    return answer(case, outcome.baselines[motion]["diagnosis"], planned=True)


def show(cases: Sequence[Case], outcomes: Sequence[Outcome], options: argparse.Namespace) -> int:
    """Print a line for each case and the table; 0 where the planned motion reaches its figures."""
    motions = [FIRST, PLANNED, *(OTHERS if options.others else ())]
    every = {
        motion: [answers(case, one, motion) for case, one in zip(cases, outcomes, strict=True)]
        for motion in motions
    }
    for row, (case, one) in enumerate(zip(cases, outcomes, strict=True)):
        label = ", ".join(case.effects) or "healthy"
        told = [f"{every[motion][row]} ({_said(one, motion)})" for motion in motions]
        print(f"{case.index:3d} {label:24s} {poor_of(case):15s} {' | '.join(told)}")
    print(f"\nseed {options.seed}, {len(cases)} machines, {options.duration:g} s each motion")
    print(f"{'':18s}{''.join(f'{name:>11s}' for name in ANSWERS)}{'median s':>11s}")
    for motion in motions:
        count = Counter(every[motion])
        times = [one.baselines.get(motion, {"seconds": np.nan})["seconds"] for one in outcomes]
        times = [one.seconds for one in outcomes] if motion == FIRST else times
        spent = "-" if np.isnan(times).all() else f"{np.nanmedian(times):.0f}"
        print(f"{motion:18s}{''.join(f'{count[name]:11d}' for name in ANSWERS)}{spent:>11s}")
    for poor in POOR:
        rows = [row for row, case in enumerate(cases) if poor_of(case) == poor]
        right = [sum(every[motion][row] == "right" for row in rows) for motion in motions]
        pairs = zip(motions, right, strict=True)
        print(f"{poor}: right {', '.join(f'{n} ({name})' for name, n in pairs)} of {len(rows)}")
    share = {name: every[PLANNED].count(name) / max(len(cases), 1) for name in ANSWERS}
    return 0 if share["right"] >= WANTED_RIGHT and share["wrong"] <= WANTED_WRONG else 1


def _said(outcome: Outcome, motion: str) -> str:
    said = outcome.diagnosis or {}
    if motion != FIRST and outcome.baselines:
        said = outcome.baselines[motion]["diagnosis"]
    named = [" or ".join([one["effect"], *one.get("alternatives", [])]) for one in said["causes"]]
    return ", ".join([said["verdict"], *named, *([said["reason"]] if said.get("reason") else [])])


if __name__ == "__main__":
    sys.exit(main())
