"""`ecyl blind`: seal drawn drives, diagnose them without labels, open the labels, score."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import InputError
from .outputs import check_outputs
from .progress import progress_bar

if TYPE_CHECKING:  # not at run time, to keep `--help` fast
    from ..drive.parameters import DriveParameters
    from ..gap.blind.cases import Case
    from ..gap.blind.seal import Sealed
    from ..gap.blind.study import Outcome

SCHEMA = "ecyl.blind/1"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Flags of `ecyl blind`."""
    parser.add_argument("--cases", type=int, default=200, metavar="N", help="how many (200)")
    parser.add_argument("--seed", type=int, default=1, metavar="K", help="of all draws (1)")
    parser.add_argument(
        "--drive", default="bench", metavar="D.yaml", help="nominal drive file or profile (bench)"
    )
    parser.add_argument("--json", type=Path, metavar="OUT", help="write labels, answers, figures")
    parser.add_argument(
        "--plots", type=Path, metavar="DIR", help="write calibration.png and confusion.png"
    )
    parser.add_argument(
        "--kinds",
        metavar="A,B",
        help="cases of these kinds alone: single, pair, none, outside, withheld, beyond",
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
        "--resume", action="store_true", help="go on with the study that --json OUT was cut off at"
    )


def run(options: argparse.Namespace) -> int:
    """Run the study; 0 when it ran, whatever the figures say, 1 when a worker died."""
    from ..drive.drive_file import load_drive, resolve_drive
    from ..gap.blind.seal import seal
    from ..gap.blind.study import StudyError

    _check(options)
    drive_file = resolve_drive(options.drive)
    check_outputs({"--json": options.json}, {"--drive": drive_file}, overwrite=True)
    drive = load_drive(drive_file)
    cases = _draw(options, drive)
    sealed = seal(cases)
    print(f"{len(cases)} cases drawn and sealed, SHA-256 {sealed.sha256}", flush=True)
    if options.write_recordings is not None:
        _write_recordings(cases, drive, options.write_recordings)
    try:
        outcomes = _study(options, cases, drive, sealed)
    except StudyError as error:
        hint = "; --resume goes on with the others" if options.json is not None else ""
        print(f"ecyl blind: {error}{hint}", file=sys.stderr)
        return 1
    opened = sealed.open()
    print("labels opened, hash verified")
    if options.write_recordings is not None:
        _write_json(options.write_recordings / "labels.json", json.loads(sealed.text))
    _report(options, opened, outcomes, drive, sealed)
    return 0


def _names(text: str) -> tuple[str, ...]:
    return tuple(word.strip() for word in text.split(",") if word.strip())


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
    if options.resume and options.json is None:
        raise InputError("--resume needs --json OUT, the file of the study to go on with")


def _draw(options: argparse.Namespace, drive: DriveParameters) -> list[Case]:
    from ..gap.blind.cases import EFFECTS, KINDS, complete_case, draw_cases, plan_cases
    from ..gap.blind.inside import INSIDE

    twins = [effect.twin for effect in EFFECTS.values() if effect.twin]
    choice: dict[str, Any] = {
        "without": _known("--without", _names(options.without), [*INSIDE, *twins])
    }
    if options.kinds is not None:
        choice["kinds"] = _known("--kinds", _names(options.kinds), KINDS)
    if options.effects is not None:
        choice["effects"] = _known("--effects", _names(options.effects), EFFECTS)
    if options.case is not None:
        plan = plan_cases(options.cases, options.seed, **choice)
        return [complete_case(plan[options.case], drive)]
    with progress_bar("drawing drives") as progress:
        return draw_cases(
            options.cases, options.seed, drive, **choice, workers=options.jobs, progress=progress
        )


def _write_recordings(cases: list[Case], drive: DriveParameters, folder: Path) -> None:
    from ..gap.blind.cases import record_case
    from ..recording.writer import write_recording

    with progress_bar("writing recordings") as progress:
        for number, case in enumerate(cases, start=1):
            recording = record_case(case, drive)
            write_recording(recording, folder / f"case_{case.index:03d}.mcap", overwrite=True)
            progress(number / len(cases))


def _study(
    options: argparse.Namespace, cases: list[Case], drive: DriveParameters, sealed: Sealed
) -> list[Outcome]:
    from ..gap.blind.journal import Journal
    from ..gap.blind.study import run_study
    from ..gap.blind.subject import product_diagnosis

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
            drive,
            product_diagnosis,
            baselines=not options.no_baselines,
            workers=options.jobs,
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
    drive: DriveParameters,
    sealed: Sealed,
) -> None:
    from ..gap.blind.score import report
    from ..gap.blind.table import case_line, outcome_line, study_text

    scored = report(cases, outcomes, drive)
    if options.json is not None:
        entries = [
            {"label": case.label(), **outcome.as_json()}
            for case, outcome in zip(cases, outcomes, strict=True)
        ]
        _write_json(
            options.json,
            {
                "schema": SCHEMA,
                "drive": str(options.drive),
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
        print(f"\n{study_text(cases, outcomes, scored, drive)}")
    if options.plots is not None:
        from ..gap.blind.plots import write_plots

        write_plots(scored, options.plots)
