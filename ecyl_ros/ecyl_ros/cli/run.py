"""`ecyl run`: launch the nodes, record the graph, print the tracking figures."""

from __future__ import annotations

import argparse
import importlib.util
import json
import signal
import sys
import tempfile
from pathlib import Path

from ..errors import InputError
from .progress import progress_bar
from .run_options import Run, add_run_arguments, checked_run, print_tracking


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Flags of `ecyl run`."""
    add_run_arguments(parser)
    parser.add_argument(
        "--log-level",
        default="warn",
        choices=("debug", "info", "warn", "error"),
        help="of the nodes (default warn)",
    )


def check_rclpy() -> None:
    """Raise InputError where there is no rclpy to run nodes on."""
    if importlib.util.find_spec("rclpy") is None:
        raise InputError(
            "the nodes need rclpy: source a ROS 2 installation or install rclpy_cyclone"
        )


def run(options: argparse.Namespace) -> int:
    """Run the graph; 0 when it ran to its end or was stopped with Ctrl-C, 1 when a node failed."""
    from ..nodes.launcher import GraphError

    check_rclpy()
    checked = checked_run(options)
    if options.realtime:
        from ..nodes.round_trip import require_real_time

        source, together = str(checked.drive_file), options.in_process
        print(require_real_time(checked.drive, source, together=together), file=sys.stderr)
    # SIGTERM as Ctrl-C: the nodes are ended and the recording is closed.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    interrupted = False
    with tempfile.TemporaryDirectory(prefix="ecyl_") as folder:
        summary = Path(folder, "summary.json")
        try:
            run_graph(options, checked, summary)
        except GraphError as error:
            print(f"ecyl run: {error}", file=sys.stderr)
            return 1
        except KeyboardInterrupt:
            interrupted = True
            print("ecyl run: stopped; what was recorded is kept", file=sys.stderr)
        figures = read_summary(summary)
    if figures:
        _print_timing(figures)
    print_tracking(checked.out, options.skip)
    return 130 if interrupted and checked.duration_s is not None else 0


def run_graph(options: argparse.Namespace, checked: Run, summary: Path) -> None:
    """Launch the nodes and wait for the end of the run; `summary` is where the plant reports.

    Raises:
        GraphError: a node ended early.
    """
    from ..nodes.launcher import NodeProcesses, node_parameters

    parameters = node_parameters(
        checked.spec,
        checked.out,
        summary,
        duration_s=checked.duration_s,
        realtime=options.realtime,
        overwrite=options.overwrite,
        rate=options.rate,
    )
    with progress_bar("running the graph") as bar:

        def progress() -> None:
            if checked.duration_s:
                ticks = read_summary(summary).get("ticks", 0)
                bar(ticks / (checked.duration_s * checked.drive.controller.rate))

        if options.in_process:
            from ..nodes.in_process import run_in_process

            run_in_process(checked.drive_file, parameters, progress, log_level=options.log_level)
            return
        with NodeProcesses(
            checked.drive_file,
            parameters,
            log_level=options.log_level,
            realtime=options.realtime,
        ) as processes:
            processes.wait(progress, checked.duration_s is not None)


def read_summary(summary: Path) -> dict:
    """What the plant has reported of the run; empty before it has."""
    try:
        return json.loads(summary.read_text(encoding="utf-8"))
    except FileNotFoundError:
        return {}


def _print_timing(figures: dict) -> None:
    line = f"{figures['ticks']} ticks in {figures['wall_s']:.1f} s"
    if figures["realtime"]:
        line += (
            f", {100 * figures['met_share']:.2f} % met ({figures['late_ticks']} late, "
            f"{figures['stale_ticks']} stale), jitter p50 {1e6 * figures['jitter_p50_s']:.0f} us, "
            f"p99.9 {1e6 * figures['jitter_p999_s']:.0f} us"
        )
    else:
        line += f" ({figures['ticks_per_s']:.0f} ticks/s)"
    print(line)
