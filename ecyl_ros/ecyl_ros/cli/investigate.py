"""`ecyl investigate`: motions on a drive until what causes its gap is decided."""

from __future__ import annotations

import argparse
import dataclasses
import math
import os
import sys
import textwrap
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import InputError
from . import plan as plan_verb
from .progress import progress_bar
from .run import check_rclpy

if TYPE_CHECKING:  # not at run time, to keep `--help` fast
    from ..drive.parameters import DriveParameters
    from ..drive.reference.planned import Planned
    from ..investigate.bounds import Bounds
    from ..investigate.played import Played, Seen
    from ..investigate.question import Question
    from ..nodes.player import Task

_WIDTH = 96
_SHORTEST_S, _LONGEST_S = 2.0, 60.0
# A drive on setpoints reckons speed from one to the next as they arrive; where they are half as far
# apart as they were sent, half of its limit is what it accepts.
_SETPOINT_SPEED = 0.5
_SILENCE_S, _LOCKSTEP_SILENCE_S = 1.0, 15.0
_TOPICS = ("reference", "joint_states", "current", "voltage", "setpoint", "trajectory")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the verb's flags."""
    parser.add_argument(
        "--drive", required=True, metavar="D.yaml", help="drive file of a full cylinder, or profile"
    )
    parser.add_argument(
        "--out", type=Path, required=True, metavar="DIR", help="new folder for all results"
    )
    on = parser.add_argument_group("drive")
    on.add_argument(
        "--emulate",
        metavar="HIDDEN.yaml",
        help="launch the nodes of this drive and move them; without it, the running drive",
    )
    on.add_argument(
        "--realtime", action="store_true", help="with --emulate: pace by the wall clock"
    )
    on.add_argument("--namespace", default="", metavar="NS", help="of the running drive")
    on.add_argument(
        "--topic",
        action="append",
        default=[],
        metavar="KEY=NAME",
        help=f"a topic of the drive under another name; KEY: {', '.join(_TOPICS)}",
    )
    on.add_argument(
        "--follow",
        choices=("auto", "trajectory", "setpoint"),
        default="auto",
        help="what the drive follows (auto: a trajectory if it does)",
    )
    on.add_argument("--joint", default="rod", metavar="NAME", help="joint of trajectories (rod)")
    budget = parser.add_argument_group("budget")
    budget.add_argument(
        "--from",
        dest="diagnosis",
        type=Path,
        metavar="DIAGNOSIS.json",
        help="begin with what this diagnosis has left open",
    )
    budget.add_argument("--motions", type=int, default=4, metavar="N", help="at most (4)")
    budget.add_argument(
        "--minutes", type=float, default=60.0, metavar="M", help="no motion starts later (60)"
    )
    budget.add_argument(
        "--duration", type=float, default=8.0, metavar="S", help="of a motion, 2 to 60 s (8)"
    )
    bounds = parser.add_argument_group("bounds: beyond them the drive is brought to rest")
    bounds.add_argument(
        "--max-error", type=float, metavar="M", help="tracking error (3 times the healthy drive's)"
    )
    bounds.add_argument(
        "--max-current", type=float, metavar="A", help="(0.95 of controller.current_limit)"
    )
    bounds.add_argument(
        "--silence",
        type=float,
        metavar="S",
        help="without telemetry (1; 15 in the lockstep of --emulate)",
    )
    plan_verb.add_limits(bounds)


def run(options: argparse.Namespace) -> int:
    """Investigate; 0 where all is decided, 3 where something stays open, 1 where it was ended."""
    from ..drive.drive_file import load_drive, resolve_drive
    from ..drive.stability import check_stability
    from ..investigate.loop import Investigation, Settings
    from ..investigate.story import DECIDED, ENDED
    from ..investigate.survey import survey
    from ..plan.predict import check_noise

    check_rclpy()
    _check_numbers(options)
    path = resolve_drive(options.drive)
    drive = plan_verb.limited(options, path)
    check_stability(drive, str(path))
    check_noise(drive, ("rotor_position", "current_q", "rod_position"), str(path))
    if options.emulate is not None:
        hidden = resolve_drive(options.emulate)
        emulated = load_drive(hidden)
        check_stability(emulated, str(hidden))
        if options.realtime:
            from ..nodes.round_trip import require_real_time

            print(require_real_time(emulated, str(hidden)), file=sys.stderr)
    asked = _asked(options, drive, str(path))
    survey(drive, options.duration)  # limits that leave no motion: before a drive is asked for
    with ExitStack() as stack:
        machine, play, seen = _machine(options, stack)
        if seen is not None:
            follows = {"trajectory": "trajectories"}.get(seen.follows, "setpoints")
            print(f"the drive follows {follows} and rests at {1e3 * seen.at_m:.3g} mm")
            if seen.follows == "setpoint":
                speed = _SETPOINT_SPEED * drive.limits.speed
                limits = dataclasses.replace(drive.limits, speed=speed)
                drive = dataclasses.replace(drive, limits=limits)
        settings = Settings(
            options.motions,
            options.minutes,
            options.duration,
            options.max_error,
            options.max_current,
        )
        bars = stack.enter_context(_Bars())
        work = Investigation(
            drive, path, machine, options.out, settings, play, _tell(bars), bars.begin
        )
        try:
            story = work.run(asked)
        except KeyboardInterrupt:
            bars.end()
            story = work.interrupted()
    _tell(bars)(f"{story.outcome}: {story.said}")
    if story.steps:
        print(f"\nreport     {options.out / 'index.html'}")
    return 0 if story.outcome == DECIDED else 1 if story.outcome == ENDED else 3


def _check_numbers(options: argparse.Namespace) -> None:
    if not _SHORTEST_S <= options.duration <= _LONGEST_S:
        raise InputError(
            f"--duration = {options.duration:g}, expected {_SHORTEST_S:g} to {_LONGEST_S:g} s"
        )
    if options.motions < 1:
        raise InputError(f"--motions = {options.motions}, expected 1 or more")
    for flag in ("minutes", "max_error", "max_current", "silence"):
        value = getattr(options, flag)
        if value is not None and not (math.isfinite(value) and value > 0.0):
            raise InputError(f"--{flag.replace('_', '-')} = {value:g}, expected more than 0")
    if options.realtime and options.emulate is None:
        raise InputError("--realtime: only with --emulate; a running drive keeps its own time")
    if options.out.exists() and (not options.out.is_dir() or any(options.out.iterdir())):
        raise InputError(f"--out {options.out}: exists; expected a new folder")


def _asked(options: argparse.Namespace, drive: DriveParameters, name: str) -> Question | None:
    """What the diagnosis of `--from` has left open."""
    from ..investigate.question import question
    from ..plan.diagnosis_file import read_diagnosis

    if options.diagnosis is None:
        return None
    asked = question(read_diagnosis(options.diagnosis, drive, name))
    if asked is None:
        raise InputError(
            f"--from {options.diagnosis}: leaves nothing open; expected one that does, or none"
        )
    return asked


def _names(options: argparse.Namespace) -> dict[str, str]:
    """The topics that `--topic` renames."""
    names = {}
    for one in options.topic:
        key, equals, name = one.partition("=")
        if key not in _TOPICS or not equals or not name:
            raise InputError(f"--topic {one}: expected KEY=NAME, KEY one of {', '.join(_TOPICS)}")
        names[key] = name
    return names


def _machine(
    options: argparse.Namespace, stack: ExitStack
) -> tuple[str, Callable[[Planned, Bounds, Path], Played], Seen | None]:
    """The machine in words, what plays a motion on it, and what was seen of one that runs."""
    from ..drive.drive_file import resolve_drive
    from ..investigate.played import Played, Seen
    from ..nodes.play import emulated, play
    from ..nodes.player import Task

    lockstep = options.emulate is not None and not options.realtime
    silence = options.silence or (_LOCKSTEP_SILENCE_S if lockstep else _SILENCE_S)
    common = {
        "follow": options.follow,
        "joint": options.joint,
        "names": _names(options),
        "silence_s": silence,
    }

    def task(motion: Planned, bounds: Bounds, out: Path) -> Task:
        return Task(bounds, tuple(motion.points()), out, **common)

    def of(result: Seen | Played) -> Played:
        assert isinstance(result, Played)  # of a task with points
        return result

    if options.emulate is None:

        def on_running(motion: Planned, bounds: Bounds, out: Path) -> Played:
            return of(play(task(motion, bounds, out), namespace=options.namespace))

        seen = play(Task(**common), namespace=options.namespace)
        assert isinstance(seen, Seen)
        where = f" in /{options.namespace.strip('/')}" if options.namespace else ""
        return f"the running drive{where}", on_running, seen

    hidden = resolve_drive(options.emulate)
    namespace = f"emulated_{os.getpid()}"

    def on_emulated(motion: Planned, bounds: Bounds, out: Path) -> Played:
        # A graph for each motion: in lockstep it would take every processor while a plan is made.
        with emulated(hidden, namespace, realtime=options.realtime) as alive:
            return of(play(task(motion, bounds, out), namespace=namespace, alive=alive))

    pace = "real time" if options.realtime else "lockstep"
    return f"{hidden.name}, emulated in {pace}", on_emulated, None


class _Bars:
    """One progress bar after the other; a new one ends that before."""

    def __init__(self) -> None:
        self._stack = ExitStack()

    def __enter__(self) -> _Bars:
        return self

    def __exit__(self, *_: object) -> None:
        self.end()

    def begin(self, title: str) -> Callable[[float], None]:
        """Show another bar; returns what takes the share done."""
        self.end()
        return self._stack.enter_context(progress_bar(title))

    def end(self) -> None:
        """Take the bar away."""
        self._stack.close()


def _tell(bars: _Bars) -> Callable[[str], None]:
    def tell(line: str) -> None:
        bars.end()
        indent = " " * (len(line) - len(line.lstrip()))
        print(textwrap.fill(line, _WIDTH, subsequent_indent=indent or "  "))
        sys.stdout.flush()

    return tell
