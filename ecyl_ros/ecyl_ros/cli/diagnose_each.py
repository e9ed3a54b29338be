"""`ecyl diagnose FOLDER --each`: every recording of a folder, an index, and trends."""

from __future__ import annotations

import argparse
import functools
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from .. import __version__
from ..errors import InputError
from .drive_kind import check_kind
from .progress import progress_bar
from .recording_options import read_map, read_span
from .without import without_of

if TYPE_CHECKING:  # not at run time, to keep `--help` fast
    from ..gap.diagnosis import Diagnosis
    from ..gap.fleet.entry import Entry
    from ..recording.map import SignalMap

_SINGLE = ("json", "report", "write_drive", "write_mcap")
_MOST_LINES = 12


def add_each(parser: argparse.ArgumentParser) -> None:
    """Declare the flags of a whole folder."""
    parser.add_argument(
        "--each",
        action="store_true",
        help="RECORDING is a folder: diagnose every recording in it by itself, into --out",
    )
    parser.add_argument("--out", type=Path, metavar="DIR", help="with --each: index and pages")
    parser.add_argument(
        "--resume", action="store_true", help="with --each: keep what is there and has not changed"
    )
    parser.add_argument(
        "--jobs", type=int, metavar="J", help="with --each: worker processes (all cores)"
    )
    parser.add_argument(
        "--dask", metavar="ADDRESS", help="with --each: a Dask scheduler, tcp://HOST:PORT"
    )


def refuse_alone(options: argparse.Namespace) -> None:
    """Flags of --each without it; raises InputError."""
    for flag in ("out", "resume", "jobs", "dask"):
        if getattr(options, flag) not in (None, False):
            raise InputError(f"--{flag} goes with --each alone; expected --each and a folder")


def run_each(options: argparse.Namespace, drive_file: Path) -> int:
    """Diagnose all, write pages and index, print a summary; 0 where any diagnosis was made."""
    from ..analysis.parallel import WorkerError
    from ..gap.fleet.find import recordings_in
    from ..gap.fleet.index import as_csv, as_html
    from ..gap.fleet.run import Fleet, run_fleet
    from ..recording.atomic import write_text

    for flag in _SINGLE:
        if getattr(options, flag) is not None:
            raise InputError(f"--{flag.replace('_', '-')} does not go with --each, expected --out")
    if len(options.recording) > 1:
        raise InputError("--each takes one folder; several recordings together go without it")
    (folder,) = options.recording
    out = options.out
    if out is None:
        raise InputError("--each needs --out DIR, a folder for index and pages")
    if options.jobs is not None and options.jobs < 1:
        raise InputError(f"--jobs = {options.jobs}, expected 1 or more")
    if out.exists() and not out.is_dir():
        raise InputError(f"--out {out}: is a file; expected the name of a folder")
    index = out / "index.html"
    if index.exists() and not (options.resume or options.overwrite):
        raise InputError(f"--out {out}: holds an index; expected --resume or --overwrite")
    recordings = recordings_in(folder, out)
    check_kind(options, drive_file)
    read_span(options)
    signal_map = read_map(options)
    fleet = Fleet(out, _asked(options, drive_file))
    judge = functools.partial(_one, options, drive_file, signal_map)
    with progress_bar(f"diagnosing {len(recordings)} recordings") as progress:
        try:
            entries = run_fleet(
                fleet,
                recordings,
                judge,
                resume=options.resume,
                jobs=options.jobs,
                dask=options.dask,
                progress=progress,
            )
        except WorkerError as error:
            print(f"ecyl diagnose: {error}; --resume continues with the others", file=sys.stderr)
            return 1
    write_text(out / "index.csv", as_csv(entries))
    write_text(index, as_html(entries, str(folder), drive_file.name))
    _print(entries)
    print(f"\n{'written':<10}{index}\n{'written':<10}{out / 'index.csv'}")
    return 0 if any(not one.error for one in entries) else 2


def _one(
    options: argparse.Namespace, drive_file: Path, signal_map: SignalMap | None, path: Path
) -> Diagnosis:
    """Read and diagnose one recording, in whatever process."""
    from ..api.diagnosing import diagnose

    return diagnose(
        path,
        drive_file,
        signal_map,
        begin_s=options.begin_s,
        end_s=options.end_s,
        mode=options.mode,
        without=without_of(options),
    )


def _asked(options: argparse.Namespace, drive_file: Path) -> bytes:
    """What a kept page must have been made with."""
    parts = [__version__.encode(), drive_file.read_bytes()]
    if options.map is not None:
        parts.append(options.map.read_bytes())
    asked = (options.mode, options.begin_s, options.end_s, without_of(options))
    parts.append(repr(asked).encode())
    return b"\0".join(parts)


def _print(entries: list[Entry]) -> None:
    from ..gap.fleet.index import by_gap
    from ..gap.report import quantities as q
    from ..gap.report import words

    good = [one for one in by_gap(entries) if not one.error]
    rows = [["recording", "gap", "verdict", "cause", "size", "confidence"]]
    for one in good[:_MOST_LINES]:
        sure = "" if one.confidence is None else q.confidence(one.confidence)
        verdict = words.verdict(one.verdict).lower()
        rows.append([one.name, q.number(one.gap), verdict, one.cause, one.size, sure])
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    for row in rows if good else []:
        cells = [cell.ljust(width) for cell, width in zip(row, widths, strict=True)]
        print("  ".join(cells).rstrip())
    if len(good) > _MOST_LINES:
        print(f"{len(good) - _MOST_LINES} more in the index")
    for one in entries:
        if one.error:
            print(f"ecyl diagnose: {one.name}: {one.error}", file=sys.stderr)
