"""`ecyl simulate`: the run on the engine alone, bit for bit what the lockstep graph gives."""

from __future__ import annotations

import argparse
import sys

from ..errors import InputError
from .progress import progress_bar
from .run_options import add_run_arguments, checked_run, print_tracking

add_arguments = add_run_arguments


def run(options: argparse.Namespace) -> int:
    """Simulate, record, print the tracking figures."""
    from ..drive.engine import simulate
    from ..drive.reference.setpoint import SetpointFollower
    from ..drive.telemetry import simulation_recording
    from ..recording.writer import write_recording

    checked = checked_run(options)
    if isinstance(checked.reference, SetpointFollower):
        raise InputError("--reference setpoint needs the node graph; expected ecyl run")
    for flag in ("realtime", "in_process"):
        if getattr(options, flag):
            print(f"--{flag.replace('_', '-')} has no effect: no node is started", file=sys.stderr)
    if checked.duration_s is None:
        raise InputError("--duration is missing; expected seconds to run")
    rate = checked.drive.sample_rate
    with progress_bar("simulating") as progress:
        simulation = simulate(
            checked.drive,
            lambda index: checked.reference.sample(index / rate),
            checked.duration_s,
            progress=progress,
        )
    recording = simulation_recording(simulation, checked.drive)
    write_recording(recording, checked.out, overwrite=options.overwrite)
    print_tracking(checked.out, options.skip)
    return 0
