"""`ecyl bench`: the locked-output test, simulated or measured, and the transmission it shows."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import InputError
from .outputs import check_outputs
from .progress import progress_bar

if TYPE_CHECKING:  # not at run time, to keep `--help` fast
    from ..analysis.bench.loop import Loop
    from ..analysis.bench.simulated import BenchTest
    from ..drive.parameters import DriveParameters


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Flags of `ecyl bench`."""
    parser.add_argument(
        "--loop",
        type=Path,
        metavar="FILE",
        help="a measured loop, CSV or recording, in place of a simulated one",
    )
    parser.add_argument("--torque-column", default="torque_nm", metavar="NAME", help="CSV, N m")
    parser.add_argument("--angle-column", default="angle_rad", metavar="NAME", help="CSV")
    parser.add_argument(
        "--angle-unit", default="rad", metavar="UNIT", help="CSV: rad, mrad, deg, arcmin, arcsec"
    )
    parser.add_argument(
        "--drive",
        metavar="D.yaml",
        help="drive file or profile to put on the bench, and to write the result into; "
        "without it the transmission of the paper's Table 1",
    )
    parser.add_argument(
        "--friction",
        type=float,
        metavar="NM",
        help="simulated: internal friction, N m (1; the paper gives none)",
    )
    parser.add_argument(
        "--torque", type=float, default=50.0, metavar="NM", help="simulated: loop to +- this (50)"
    )
    parser.add_argument(
        "--readings", type=int, default=4000, metavar="N", help="simulated: per edge (4000)"
    )
    parser.add_argument("--loops", type=int, default=1, metavar="N", help="simulated: loops (1)")
    parser.add_argument("--seed", type=int, default=1, metavar="K", help="of the sensors' errors")
    parser.add_argument(
        "--no-noise", action="store_true", help="simulated: sensors that make no error"
    )
    parser.add_argument(
        "--draws",
        type=int,
        metavar="N",
        help="simulated: also identify N draws of the sensors' errors, and say how often the "
        "intervals hold the truth",
    )
    parser.add_argument(
        "--rated-torque",
        type=float,
        default=50.0,
        metavar="NM",
        help="the backlash is read at +-3 %% of it (50)",
    )
    parser.add_argument(
        "--shaft-twist",
        type=float,
        metavar="RAD_PER_NM",
        help="twist of the shaft up to the angle sensor, subtracted from the angle "
        "(simulated: 0.94 arcsec at 50 N m; measured: 0)",
    )
    parser.add_argument("--json", type=Path, metavar="OUT", help="write the figures as JSON")
    parser.add_argument("--plots", type=Path, metavar="DIR", help="write hysteresis.png")
    parser.add_argument("--csv", type=Path, metavar="OUT", help="write the simulated loop")
    parser.add_argument(
        "--write-drive", type=Path, metavar="OUT", help="write --drive with what was identified"
    )


def run(options: argparse.Namespace) -> int:
    """Simulate or read, identify, print."""
    from ..analysis.bench import report
    from ..analysis.bench.budget import error_budget
    from ..analysis.bench.identify import identify
    from ..analysis.bench.measured import read_loop, write_loop
    from ..analysis.bench.table1 import table_1_drive
    from ..drive.drive_file import load_drive, resolve_drive

    if options.draws is not None and options.draws < 2:
        raise InputError(f"--draws = {options.draws}, expected 2 or more")
    if options.write_drive is not None and options.drive is None:
        raise InputError("--write-drive needs --drive, the drive file to write the result into")
    check_outputs(
        {"--json": options.json, "--csv": options.csv, "--write-drive": options.write_drive},
        {
            "--loop": options.loop,
            "--drive": None if options.drive is None else resolve_drive(options.drive),
        },
        overwrite=True,
    )
    drive = load_drive(options.drive) if options.drive is not None else table_1_drive()
    twist = options.shaft_twist
    if options.loop is not None:
        for flag in ("csv", "friction", "draws"):
            if getattr(options, flag) is not None:
                raise InputError(f"--{flag} is for a simulated loop; leave it out with --loop")
        loop, notes = read_loop(
            options.loop,
            torque_column=options.torque_column,
            angle_column=options.angle_column,
            angle_unit=options.angle_unit,
        )
        for note in notes:
            print(f"ecyl bench: {note}", file=sys.stderr)
    else:
        test = _test(options)
        loop, twist = _simulated(options, drive, test), test.shaft_twist_rad_per_nm
    found = identify(
        loop, rated_torque_nm=options.rated_torque, shaft_twist_rad_per_nm=twist or 0.0
    )
    budget = error_budget(found.fit.lines, drive)
    for note in found.notes:
        print(f"ecyl bench: {note}", file=sys.stderr)
    if options.csv is not None:
        write_loop(loop, options.csv)
    if options.plots is not None:
        from ..analysis.bench.plot import write_plot

        write_plot(found, options.plots)
    if options.write_drive is not None:
        from ..analysis.bench.write_drive import write_drive

        write_drive(found, options.drive, options.write_drive)
    if options.json is not None:
        report.write_json(found, budget, options.json)
    report.print_identified(found, budget)
    if options.draws is not None:
        from ..analysis.bench.coverage import coverage
        from ..analysis.parallel import WorkerError

        try:
            with progress_bar(f"{options.draws} draws") as progress:
                covered = coverage(drive, options.draws, test=_test(options), progress=progress)
        except WorkerError as error:
            print(f"ecyl bench: {error}", file=sys.stderr)
            return 1
        report.print_coverage(covered, options.draws)
    return 0


def _test(options: argparse.Namespace) -> BenchTest:
    from ..analysis.bench.simulated import BenchTest

    chosen = {"torque_limit_nm": options.torque, "readings": options.readings}
    chosen["loops"] = options.loops
    if options.friction is not None:
        chosen["friction_nm"] = options.friction
    if options.shaft_twist is not None:
        chosen["shaft_twist_rad_per_nm"] = options.shaft_twist
    return BenchTest(**chosen)


def _simulated(options: argparse.Namespace, drive: DriveParameters, test: BenchTest) -> Loop:
    from ..analysis.bench.sensors import PERFECT, BenchSensors
    from ..analysis.bench.simulated import simulated_loop, with_sensors

    if options.seed < 0:
        raise InputError(f"--seed = {options.seed}, expected 0 or more")
    sensors = PERFECT if options.no_noise else BenchSensors()
    return with_sensors(simulated_loop(drive, test), sensors, options.seed)
