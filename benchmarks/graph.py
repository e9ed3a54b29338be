"""Running the node graph for a benchmark: a DDS domain of its own, and the plant's figures back."""

from __future__ import annotations

import json
import os
import signal
import tempfile
from pathlib import Path

from report import Report

SINE = "sine:amplitude=5e-3,frequency=1"
FASTEST = 1000.0  # Hz, of profile servo_1khz


def use_private_domain() -> int:
    """Move this process and its children to a DDS domain that nobody else is likely to use.

    Of those whose ports the kernel gives to nobody.
    """
    domain = 2 + os.getpid() % 99
    os.environ["ROS_DOMAIN_ID"] = str(domain)
    return domain


def held_rate(report: Report, asked: float | None) -> tuple[float, float]:
    """The rate to run a graph at, Hz, and the 99th percentile of the round trip, s; both told.

    asked: that rate; None for what the machine holds by its round trips, 1 kHz at most.
    """
    from ecyl_ros.nodes.round_trip import measure

    trip = measure(FASTEST)
    rate = asked or min(FASTEST, trip.rate)
    report.say(f"  {trip}; the graph runs at {rate:g} Hz")
    report.figures |= {"rate_hz": rate, "p99_s": trip.p99_s}
    return rate, trip.p99_s


def run_graph(
    profile: str,
    duration_s: float,
    *,
    realtime: bool = False,
    rate: float | None = None,
    in_process: bool = False,
    recorder: bool = True,
) -> dict:
    """Run the graph as `ecyl run` does and return the figures in the plant's summary file.

    rate: of the controller, Hz, in place of the drive file's.
    """
    from ecyl_ros.drive.drive_file import load_drive, resolve_drive
    from ecyl_ros.drive.warm_up import warm_up
    from ecyl_ros.nodes.launcher import NODES, NodeProcesses, node_parameters

    path = resolve_drive(profile)
    warm_up(load_drive(path))
    names = tuple(name for name in NODES if recorder or name != "recorder")
    with tempfile.TemporaryDirectory(prefix="ecyl_bench_") as folder:
        summary = Path(folder, "summary.json")
        parameters = node_parameters(
            SINE,
            Path(folder, "run.mcap"),
            summary,
            duration_s=duration_s,
            realtime=realtime,
            rate=rate,
            recorder=recorder,
        )
        if in_process:
            from ecyl_ros.nodes.in_process import run_in_process

            run_in_process(path, parameters, _nothing, names=names)
            signal.signal(signal.SIGINT, signal.default_int_handler)
        else:
            with NodeProcesses(path, parameters, nodes=names, realtime=realtime) as processes:
                processes.wait(_nothing, True)
        return json.loads(summary.read_text(encoding="utf-8"))


def _nothing() -> None:
    """No progress bar."""
