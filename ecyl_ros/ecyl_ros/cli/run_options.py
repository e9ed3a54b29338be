"""What `ecyl run` and `ecyl simulate` have in common: flags, checks, and the figures at the end."""

from __future__ import annotations

import argparse
import math
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import InputError

if TYPE_CHECKING:  # not at run time, to keep `--help` fast
    from ..drive.parameters import DriveParameters
    from ..drive.reference.base import Reference

SLOW_COMPILE_S = 1.0


def add_run_arguments(parser: argparse.ArgumentParser) -> None:
    """The flags of the contract, and `--skip`, `--overwrite`."""
    parser.add_argument(
        "--drive",
        required=True,
        metavar="D.yaml",
        help="drive file, or a profile: paper, si, bench, servo_1khz, worn_1khz",
    )
    parser.add_argument(
        "--reference",
        required=True,
        metavar="SPEC",
        help="sine:amplitude=2e-5,frequency=1 | chirp:... | multisine:... | "
        "moves:... | setpoint | a recording whose reference is played | motion.yaml of ecyl plan",
    )
    parser.add_argument(
        "--duration",
        type=float,
        metavar="S",
        help="seconds to run; without it the length of a recording or motion, or until Ctrl-C",
    )
    parser.add_argument(
        "--rate", type=float, metavar="HZ", help="control rate instead of the drive file's"
    )
    parser.add_argument(
        "--out",
        required=True,
        metavar="BAG",
        help="recording to write: NAME.mcap, or a folder bag NAME",
    )
    parser.add_argument("--overwrite", action="store_true", help="replace an existing recording")
    parser.add_argument(
        "--skip",
        type=float,
        default=0.0,
        metavar="S",
        help="seconds left out of the tracking figures (default 0)",
    )
    parser.add_argument(
        "--realtime", action="store_true", help="pace by the wall clock instead of in lockstep"
    )
    parser.add_argument(
        "--in-process", action="store_true", help="all nodes in one process instead of one each"
    )


@dataclass(frozen=True)
class Run:
    """Checked input of a run."""

    drive_file: Path
    drive: DriveParameters
    reference: Reference
    spec: str
    duration_s: float | None
    out: Path


def checked_run(options: argparse.Namespace) -> Run:
    """Check everything that can be checked before a node is started; raises InputError."""
    from ..drive.drive_file import load_drive, resolve_drive, with_rate
    from ..drive.reference.planned import Planned
    from ..drive.reference.recorded import Recorded
    from ..drive.reference.spec import make_reference
    from ..drive.stability import check_stability
    from ..drive.warm_up import warm_up

    duration = options.duration
    if duration is not None and not (math.isfinite(duration) and duration > 0.0):
        raise InputError(f"--duration = {duration:g}, expected more than 0 s")
    if not (math.isfinite(options.skip) and options.skip >= 0.0):
        raise InputError(f"--skip = {options.skip:g}, expected 0 s or more")
    out = Path(options.out)
    if out.exists() and not options.overwrite:
        raise InputError(f"--out {out}: exists; expected a new name, or --overwrite")
    path = resolve_drive(options.drive)
    drive = with_rate(load_drive(path), options.rate, f"{path} with --rate")
    check_stability(drive, str(path))
    reference = make_reference(options.reference, drive, duration or 60.0)
    if duration is None and isinstance(reference, Recorded | Planned):
        duration = reference.duration_s + 1.0 / drive.sample_rate
    if duration is not None and options.skip >= duration:
        raise InputError(f"--skip = {options.skip:g}, expected less than {duration:g} s of run")
    if duration is not None and duration * drive.controller.rate < 1.0:
        raise InputError(f"--duration = {duration:g}, expected at least one tick")
    if abs(drive.sample_rate / drive.telemetry_rate - 1.0) > 1e-9:
        print(
            f"telemetry comes at {drive.sample_rate:g} Hz, the control rate over a whole number, "
            f"not at telemetry_rate = {drive.telemetry_rate:g} Hz",
            file=sys.stderr,
        )
    seconds = warm_up(drive)
    if seconds > SLOW_COMPILE_S:
        print(
            f"compiled the drive's equations in {seconds:.1f} s (cached from now on)",
            file=sys.stderr,
        )
    spec = options.reference
    if isinstance(reference, Recorded | Planned):
        spec = str(Path(spec).resolve())
    return Run(path, drive, reference, spec, duration, out)


def print_tracking(out: Path, skip_s: float) -> None:
    """Print the tracking figures of a recording, or why there are none."""
    from ..analysis.report import print_analysis
    from ..analysis.tracking import analyse
    from ..recording.reader import read_recording

    try:
        print_analysis(analyse(read_recording(out), skip_s))
    except InputError as error:
        print(f"no tracking figures: {error}", file=sys.stderr)
    print(f"recording  {out}")
