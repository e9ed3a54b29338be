"""`ecyl demo`: what this is for, in a minute: a worn drive runs, is recorded and diagnosed."""

from __future__ import annotations

import argparse
import sys
import tempfile
import textwrap
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import InputError
from .outputs import add_overwrite
from .progress import progress_bar

if TYPE_CHECKING:
    from ..recording.signals import Recording

WORN, NOMINAL = "worn_1khz", "servo_1khz"
# Reversals in both directions, slow and fast motion: what a diagnosis of backlash needs.
REFERENCE = "moves:positions=0.004;-0.003;0.002;-0.001,speed=0.05,acceleration=1,jerk=50,dwell=0.1"
DURATION_S = 4.0
_WIDTH = 96


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the verb's flags."""
    parser.add_argument(
        "folder", type=Path, metavar="OUT_DIR", help="where recording, report and pictures go"
    )
    add_overwrite(parser)


def run(options: argparse.Namespace) -> int:
    """Run, record, diagnose, report; 0 when all of it was done, 1 when a node failed."""
    from ..nodes.launcher import GraphError

    folder: Path = options.folder
    bag, report, plots = folder / "worn.mcap", folder / "worn.html", folder / "worn_plots"
    for path in (bag, report):
        if path.exists() and not options.overwrite:
            raise InputError(f"{path}: exists; expected another folder, or --overwrite")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made: {error.strerror}") from None
    print(f"The nodes of a drive with a worn transmission ({WORN}) run as separate processes.")
    try:
        print(f"  {_ran(bag)}")
    except GraphError as error:
        print(f"ecyl demo: {error}", file=sys.stderr)
        return 1
    _show_tracking(bag, plots)
    print(f"\nIts recording is compared with the data sheet ({NOMINAL}):\n")
    print(textwrap.fill(_diagnosed(bag, report), _WIDTH))
    print(f"\nreport     {report}\npictures   {plots}\nrecording  {bag}")
    return 0


def _ran(bag: Path) -> str:
    """Run the graph and record it; how many ticks it took, and how long."""
    from . import run as run_verb
    from .run_options import checked_run

    run_verb.check_rclpy()
    parser = argparse.ArgumentParser()
    run_verb.add_arguments(parser)
    words = ["--drive", WORN, "--reference", REFERENCE, "--duration", str(DURATION_S)]
    chosen = parser.parse_args([*words, "--out", str(bag), "--overwrite"])
    checked = checked_run(chosen)
    with tempfile.TemporaryDirectory(prefix="ecyl_") as folder:
        summary = Path(folder, "summary.json")
        run_verb.run_graph(chosen, checked, summary)
        figures = run_verb.read_summary(summary)
    rate = checked.drive.controller.rate
    return f"{figures['ticks']} control ticks of {1e3 / rate:g} ms in {figures['wall_s']:.1f} s"


def _show_tracking(bag: Path, plots: Path) -> None:
    from ..analysis.plots import write_plots
    from ..analysis.tracking import analyse
    from ..recording.reader import read_recording

    recording: Recording = read_recording(bag)
    tracking = analyse(recording)
    write_plots(tracking, plots)
    print(
        f"  The rod follows its reference {1e3 * tracking.lag.lag_s:.1f} ms late; error "
        f"{1e6 * tracking.error_std_m:.0f} um (standard deviation), "
        f"{1e6 * tracking.error_max_m:.0f} um at most."
    )


def _diagnosed(bag: Path, report: Path) -> str:
    """The diagnosis in a sentence; its report is written."""
    from ..api.diagnosing import diagnose

    with progress_bar("diagnosing") as progress:
        found = diagnose(bag, NOMINAL, progress=progress)
    found.write_report(report)
    return found.sentence
