"""`ecyl replay BAG`: publish a recording again with its own timing."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Collection
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..recording.bag_contents import Bag

CLOCK_HZ = 40.0  # of `--clock` without a number, as in `ros2 bag play`
WAIT_S = 10.0
CLOCK = "/clock"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the verb's flags, named as in `ros2 bag play` where that has them."""
    parser.add_argument(
        "bag",
        type=Path,
        metavar="BAG",
        help="MCAP or sqlite3 file, or rosbag2 folder; with --map any recording",
    )
    parser.add_argument(
        "--map",
        type=Path,
        metavar="M.yaml",
        help="play the signals of any recording (CSV and MAT too) on this project's topics",
    )
    parser.add_argument("-r", "--rate", type=float, default=1.0, help="speed (default 1)")
    parser.add_argument("--topics", nargs="+", metavar="TOPIC", help="play only these")
    parser.add_argument(
        "-m", "--remap", nargs="+", default=[], metavar="OLD:=NEW", help="publish under other names"
    )
    parser.add_argument(
        "--start-offset", type=float, default=0.0, metavar="S", help="begin S seconds into the bag"
    )
    parser.add_argument("-d", "--delay", type=float, default=0.0, metavar="S", help="wait first")
    parser.add_argument("-l", "--loop", action="store_true", help="start again at the end")
    parser.add_argument(
        "--clock",
        type=float,
        nargs="?",
        const=CLOCK_HZ,
        default=0.0,
        metavar="HZ",
        help=f"publish the bag's time on /clock ({CLOCK_HZ:g} Hz by default); one in the bag is "
        "left out",
    )
    parser.add_argument(
        "--wait-for-subscribers",
        type=float,
        nargs="?",
        const=WAIT_S,
        metavar="S",
        help=f"begin when each topic has a subscriber, after S seconds ({WAIT_S:g}) at the latest",
    )


def run(options: argparse.Namespace) -> int:
    """Play; 0 at the end and on Ctrl-C."""
    from ..errors import InputError
    from ..recording.bag import read_bag
    from ..recording.timeline import Timeline

    if not 0.0 <= options.delay < float("inf"):
        raise InputError(f"--delay is {options.delay:g} s, expected 0 or more")
    bag = read_bag(options.bag) if options.map is None else _mapped(options.bag, options.map)
    names = options.topics
    if names is None:
        names = [n for n, t in bag.topics.items() if t.data and not (options.clock and n == CLOCK)]
    timeline = Timeline(
        bag,
        topics=names,
        rate=options.rate,
        start_offset_s=options.start_offset,
        clock_hz=options.clock,
        loop=options.loop,
    )
    remap = _remapped(options.remap, bag.topics)
    for note in bag.notes:
        print(f"ecyl replay: {note}", file=sys.stderr)
    try:
        import rclpy

        from ..nodes.replayer import Replayer
    except ModuleNotFoundError as error:
        raise InputError(
            f"replay needs {error.name}: source a ROS 2 installation or install rclpy_cyclone"
        ) from None
    from ..nodes.quiet_signals import quiet_signals
    from .progress import progress_bar

    node = None
    # A signal shuts the context down, which the node notices: wherever the signal comes, what
    # was sent is said.
    with quiet_signals():
        rclpy.init()
        try:
            node = Replayer(bag, timeline, remap=remap, names=names, clock=bool(options.clock))
            if options.wait_for_subscribers is not None and not node.wait_for_subscribers(
                options.wait_for_subscribers
            ):
                print("ecyl replay: not every topic has a subscriber", file=sys.stderr)
            node.wait(options.delay)
            with progress_bar("replaying") as progress:
                node.play(progress)
        except Exception:
            if rclpy.ok():
                raise
            # The context was shut down while a call ran; what that needed is gone.
        finally:
            published, latest_s = (node.published, node.latest_s) if node else (0, 0.0)
            if node is not None:
                node.destroy_node()
            rclpy.try_shutdown()
    print(f"{published} messages published, {latest_s * 1e3:.1f} ms late at most")
    return 0


def _mapped(path: Path, map_file: Path) -> Bag:
    """The mapped signals as a bag of this project's topics, each sample's messages in one stamp."""
    import dataclasses
    import tempfile

    from ..recording.bag import read_bag
    from ..recording.map_file import load_map
    from ..recording.mapped import read_mapped
    from ..recording.writer import write_recording

    recording = read_mapped(path, load_map(map_file))
    stamps = recording.stamp_ns
    if len(stamps) and stamps[0] < 0:  # a table's time may begin before zero
        recording = dataclasses.replace(recording, stamp_ns=stamps - stamps[0])
    with tempfile.TemporaryDirectory() as folder:
        skipped = write_recording(recording, Path(folder, "mapped.mcap"))
        bag = read_bag(Path(folder, "mapped.mcap"))
    notes = (*recording.notes, *bag.notes)
    if skipped:
        notes = (*notes, f"{path}: no topic carries {', '.join(skipped)}: not played")
    return dataclasses.replace(bag, path=path, notes=notes)


def _remapped(rules: list[str], topics: Collection[str]) -> dict[str, str]:
    from ..errors import InputError

    remap = {}
    for rule in rules:
        old, separator, new = rule.partition(":=")
        if not (separator and old.startswith("/") and new.startswith("/") and len(new) > 1):
            raise InputError(f"--remap is {rule}, expected /old:=/new")
        if old not in topics:
            raise InputError(f"--remap is {rule}, but the bag holds no topic {old}")
        remap[old] = new
    return remap
