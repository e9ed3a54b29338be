"""`ecyl analyse BAG`: tracking figures, spectrum and IMFs of a recording."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from .outputs import check_outputs
from .recording_options import add_recording, read_map


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the verb's flags."""
    add_recording(parser, "bag")
    parser.add_argument(
        "--skip", type=float, default=0.0, metavar="S", help="seconds to leave out at the start"
    )
    parser.add_argument(
        "--rotor-to-rod",
        type=float,
        metavar="M_PER_RAD",
        help="where the rod is not measured: take the rotor's angle times this, "
        "lead / (2 pi gear_ratio)",
    )
    parser.add_argument(
        "--line",
        type=float,
        metavar="HZ",
        help="the error's amplitude at this frequency; refused where the part analysed is shorter "
        "than three periods",
    )
    parser.add_argument("--json", type=Path, metavar="OUT", help="write the figures as JSON")
    parser.add_argument("--plots", type=Path, metavar="DIR", help="write figures as PNG files")


def run(options: argparse.Namespace) -> int:
    """Analyse and print; JSON and plots are written first, so that a full disk is an error."""
    from ..analysis.report import print_analysis, write_json
    from ..analysis.tracking import analyse
    from ..errors import InputError
    from ..recording.load import load_recording

    inputs = {"BAG": options.bag, "--map": options.map}
    check_outputs({"--json": options.json}, inputs, overwrite=True)
    recording = load_recording(options.bag, read_map(options))
    try:
        analysis = analyse(
            recording,
            options.skip,
            rotor_to_rod_m_per_rad=options.rotor_to_rod,
            line_hz=options.line,
        )
    except InputError as error:
        raise InputError(f"{options.bag}: {error}") from None
    for note in analysis.notes:
        print(f"ecyl analyse: {note}", file=sys.stderr)
    if options.plots is not None:
        from ..analysis.plots import write_plots

        write_plots(analysis, options.plots)
    if options.json is not None:
        write_json(analysis, options.json)
    print_analysis(analysis)
    return 0
