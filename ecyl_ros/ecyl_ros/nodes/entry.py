"""Entry points of the nodes: light to import, so that Ctrl-C during start ends quietly too."""

from __future__ import annotations

import importlib
import signal
import sys


def run(name: str, args: list[str] | None = None) -> int:
    """Import the module of node `name` and run its `main`."""
    try:
        return importlib.import_module(f"{__package__}.{name}").main(args)
    except KeyboardInterrupt:
        return 0
    finally:
        # All is done: what comes now, as the launcher ends the others, changes no exit code.
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, signal.SIG_IGN)


def plant() -> int:
    """`ros2 run ecyl_ros plant`."""
    return run("plant")


def controller() -> int:
    """`ros2 run ecyl_ros controller`."""
    return run("controller")


def reference() -> int:
    """`ros2 run ecyl_ros reference`."""
    return run("reference")


def analyser() -> int:
    """`ros2 run ecyl_ros analyser`."""
    return run("analyser")


def recorder() -> int:
    """`ros2 run ecyl_ros recorder`."""
    return run("recorder")


def gap_monitor() -> int:
    """`ros2 run ecyl_ros gap_monitor`."""
    return run("gap_monitor")


def round_trip() -> int:
    """`ros2 run ecyl_ros round_trip`: what rate this machine holds in real time."""
    return run("round_trip")


if __name__ == "__main__":
    sys.exit(run(sys.argv[1], sys.argv[1:]))
