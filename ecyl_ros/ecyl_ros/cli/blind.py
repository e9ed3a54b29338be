"""`ecyl blind`: seal drawn drives, diagnose them without labels, open the labels, score."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import InputError
from .commas import names_in
from .outputs import check_outputs
from .progress import progress_bar

if TYPE_CHECKING:  # not at run time, to keep `--help` fast
    from ..gap.study.case import Case
    from ..gap.study.drives import Choice, Drives
    from ..gap.study.examine import Outcome
    from ..gap.study.seal import Sealed

SCHEMA = "ecyl.blind/1"
SECONDS_EACH = 6.0  # of several recordings
DRIVES = ("bench", "random", "rigid")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Flags of `ecyl blind`."""
    parser.add_argument("--cases", type=int, default=200, metavar="N", help="how many (200)")
    parser.add_argument("--seed", type=int, default=1, metavar="K", help="of all draws (1)")
    parser.add_argument(
        "--drives",
        choices=DRIVES,
        default="bench",
        help="machines of one drive file, each of its own random drive, or rigid drives (bench)",
    )
    parser.add_argument(
        "--drive", metavar="D.yaml", help="drive file or profile that --drives bench are of (bench)"
    )
    parser.add_argument(
        "--sheet",
        type=float,
        metavar="SD",
        help="relative standard deviation of the machines' constants off the sheet (0: exact; "
        "rigid: 0.05 in some of the cases)",
    )
    parser.add_argument(
        "--no-tolerances",
        action="store_true",
        help="drive files state no tolerances, as most files do: the documented ones hold, and a "
        "fault in a constant lies clear of them",
    )
    parser.add_argument(
        "--recordings",
        type=int,
        default=1,
        metavar="N",
        help="this many recordings of each machine, diagnosed together (1)",
    )
    parser.add_argument(
        "--seconds",
        type=float,
        metavar="S",
        help=f"that each of several recordings lasts ({SECONDS_EACH:g})",
    )
    parser.add_argument("--json", type=Path, metavar="OUT", help="write labels, answers, figures")
    parser.add_argument(
        "--plots", type=Path, metavar="DIR", help="write calibration.png and confusion.png"
    )
    parser.add_argument(
        "--kinds",
        metavar="A,B",
        help="cases of these kinds alone: single, pair, none, outside, withheld, beyond; and, only "
        "on request, law, of a cause that has no name, and structure, of one effect of a rigid "
        "drive beside effort that no model knows",
    )
    parser.add_argument(
        "--effects", metavar="A,B", help="cases of these effects alone (a pair's second is any)"
    )
    parser.add_argument(
        "--without",
        default="",
        metavar="A,B",
        help="leave these effects out of the diagnosis's catalogue in every case",
    )
    parser.add_argument("--case", type=int, metavar="I", help="this one case of the study alone")
    parser.add_argument(
        "--write-recordings", type=Path, metavar="DIR", help="keep each recording as case_NNN.mcap"
    )
    parser.add_argument("--no-baselines", action="store_true", help="run the diagnosis alone")
    parser.add_argument(
        "--jobs", type=int, default=2, metavar="J", help="worker processes (default 2)"
    )
    parser.add_argument(
        "--dask", metavar="ADDRESS", help="run on the Dask cluster of this scheduler instead"
    )
    parser.add_argument(
        "--resume", action="store_true", help="continue the interrupted study of --json OUT"
    )


def run(options: argparse.Namespace) -> int:
    """Run the study; 0 when it ran, whatever the figures say, 1 when a worker died."""
    from ..analysis.ended_together import ended_together
    from ..gap.study.examine import StudyError
    from ..gap.study.workers import WorkerDied

    _check(options)
    drives, source = _drives(options)
    check_outputs({"--json": options.json}, {"--drive": source} if source else {}, overwrite=True)
    with ended_together():
        try:
            return _run(options, drives)
        except (StudyError, WorkerDied) as error:
            hint = "; --resume continues with the others" if options.json is not None else ""
            print(f"ecyl blind: {error}{hint}", file=sys.stderr)
            return 1


def _run(options: argparse.Namespace, drives: Drives) -> int:
    from ..gap.study.seal import seal

    cases = _draw(options, drives)
    sealed = seal(cases)
    print(f"{len(cases)} cases drawn and sealed, SHA-256 {sealed.sha256}", flush=True)
    if options.write_recordings is not None:
        _write_recordings(cases, drives, options.write_recordings)
    outcomes = _study(options, cases, drives, sealed)
    opened = sealed.open()
    print("labels opened, hash verified")
    if options.write_recordings is not None:
        _write_json(options.write_recordings / "labels.json", json.loads(sealed.text))
    _report(options, opened, outcomes, sealed)
    return 0


def _drives(options: argparse.Namespace) -> tuple[Drives, Path | None]:
    """The drives asked for, and the file that they are of."""
    from ..drive.drive_file import load_drive, resolve_drive
    from ..gap.study.drives import BenchDrives, RandomDrives, RigidDrives

    several = None
    if options.recordings > 1:
        several = options.recordings, options.seconds or SECONDS_EACH
    sheet, silent = options.sheet, options.no_tolerances
    if options.drives == "random":
        return RandomDrives(sheet or 0.0, several, silent), None
    if options.drives == "rigid":
        return RigidDrives(sheet, several, silent), None
    drive_file = resolve_drive(options.drive or "bench")
    return BenchDrives(load_drive(drive_file), sheet or 0.0, several, silent), drive_file


def _known(flag: str, names: tuple[str, ...], known: Any) -> tuple[str, ...]:
    import difflib

    for name in names:
        if name not in known:
            near = difflib.get_close_matches(name, known, n=1)
            hint = f"did you mean {near[0]}?" if near else f"expected {', '.join(known)}"
            raise InputError(f"{flag}: unknown name {name}; {hint}")
    return names


def _check(options: argparse.Namespace) -> None:
    if options.cases < 1:
        raise InputError(f"--cases = {options.cases}, expected 1 or more")
    if options.seed < 0:
        raise InputError(f"--seed = {options.seed}, expected 0 or more")
    if options.jobs < 1:
        raise InputError(f"--jobs = {options.jobs}, expected 1 or more")
    if options.case is not None and not 0 <= options.case < options.cases:
        raise InputError(f"--case = {options.case}, expected 0 to {options.cases - 1}")
    if options.sheet is not None and not 0.0 <= options.sheet <= 0.1:
        raise InputError(f"--sheet = {options.sheet:g}, expected 0 to 0.1")
    if options.drive is not None and options.drives != "bench":
        raise InputError(f"--drive does not go with --drives {options.drives}, expected bench")
    if options.recordings < 1:
        raise InputError(f"--recordings = {options.recordings}, expected 1 or more")
    if options.seconds is not None and options.recordings == 1:
        raise InputError("--seconds is of several recordings, expected --recordings 2 or more")
    if options.seconds is not None and not 3.0 <= options.seconds <= 600.0:
        raise InputError(f"--seconds = {options.seconds:g}, expected 3 to 600")
    if options.resume and options.json is None:
        raise InputError("--resume needs --json OUT, the file of the study to continue")


def _draw(options: argparse.Namespace, drives: Drives) -> list[Case]:
    from ..gap.study.drives import draw_cases

    choice = _choice(options, drives)
    if options.case is not None:
        return [drives.complete(drives.plan(options.cases, options.seed, choice)[options.case])]
    with progress_bar("drawing drives") as progress:
        return draw_cases(
            drives, options.cases, options.seed, choice, workers=options.jobs, progress=progress
        )


def _choice(options: argparse.Namespace, drives: Drives) -> Choice:
    from ..gap.study.case import KINDS
    from ..gap.study.drives import Choice

    kinds, effects = tuple(one for one in drives.kinds if one in KINDS), None
    if options.kinds is not None:
        kinds = _known("--kinds", names_in(options.kinds), drives.kinds)
    if options.effects is not None:
        effects = _known("--effects", names_in(options.effects), drives.effects)
    without = _known("--without", names_in(options.without), drives.nameable)
    return Choice(kinds, effects, without)


def _write_recordings(cases: list[Case], drives: Drives, folder: Path) -> None:
    from ..recording.writer import write_recording

    with progress_bar("writing recordings") as progress:
        for number, case in enumerate(cases, start=1):
            recording, _, others = drives.given(case)
            name = f"case_{case.index:03d}"
            write_recording(recording, folder / f"{name}.mcap", overwrite=True)
            for other, more in enumerate(others, start=2):
                write_recording(more, folder / f"{name}_{other}.mcap", overwrite=True)
            progress(number / len(cases))


def _study(
    options: argparse.Namespace, cases: list[Case], drives: Drives, sealed: Sealed
) -> list[Outcome]:
    from ..gap.study.examine import run_study
    from ..gap.study.journal import Journal
    from ..gap.study.subject import product_diagnosis

    journal: Journal | None = None
    done: dict[int, Outcome] = {}
    if options.json is not None:
        path = options.json.with_name(f"{options.json.name}.partial")
        journal = Journal(path, sealed.sha256, resume=options.resume)
        done = {one.index: one for one in journal.outcomes if one.error is None}
        if done:
            print(f"{len(done)} cases taken over from {path}", file=sys.stderr)
    with progress_bar("diagnosing") as progress:

        def came(outcome: Outcome) -> None:
            done[outcome.index] = outcome
            if journal is not None:
                journal.add(outcome)
            progress(len(done) / len(cases))

        run_study(
            [case for case in cases if case.index not in done],
            drives,
            product_diagnosis,
            baselines=not options.no_baselines,
            workers=options.jobs,
            dask=options.dask,
            on_outcome=came,
        )
    return [done[case.index] for case in cases]


def _write_json(path: Path, data: Any) -> None:
    from ..recording.atomic import write_text

    write_text(path, json.dumps(data, indent=1, allow_nan=False) + "\n")


def _report(
    options: argparse.Namespace,
    cases: list[Case],
    outcomes: list[Outcome],
    sealed: Sealed,
) -> None:
    from ..gap.study.score.report import report
    from ..gap.study.score.table import case_line, outcome_line, study_text

    scored = report(cases, outcomes)
    if options.json is not None:
        entries = [
            {"label": case.label(), **outcome.as_json()}
            for case, outcome in zip(cases, outcomes, strict=True)
        ]
        _write_json(
            options.json,
            {
                "schema": SCHEMA,
                "drives": options.drives,
                "drive": options.drive or "bench" if options.drives == "bench" else None,
                "sheet": options.sheet,
                "tolerances": "documented" if options.no_tolerances else "stated",
                "seed": options.seed,
                "sha256": sealed.sha256,
                **scored,
                "cases": entries,
            },
        )
        options.json.with_name(f"{options.json.name}.partial").unlink(missing_ok=True)
    if options.case is not None:
        print(f"{case_line(cases[0])}\nsaid {outcome_line(outcomes[0])}")
        for name, found in outcomes[0].baselines.items():
            print(f"{name}: {', '.join(found['named']) or 'nothing'}")
    else:
        print(f"\n{study_text(cases, outcomes, scored)}")
    if options.plots is not None:
        from ..gap.study.score.plots import write_plots

        write_plots(scored, options.plots)
