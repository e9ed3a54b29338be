"""`ecyl plan`: the motion whose recording tells what a diagnosis has left open."""

from __future__ import annotations

import argparse
import dataclasses
import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import InputError
from .commas import names_in
from .outputs import add_overwrite, check_outputs
from .progress import progress_bar

if TYPE_CHECKING:  # not at run time, to keep `--help` fast
    from ..drive.parameters import DriveParameters, LimitParameters
    from ..gap.limits.limit import Limit
    from ..plan.make import Plan

_LIMITS = ("stroke_min", "stroke_max", "speed", "acceleration", "jerk")
_SHORTEST_S, _LONGEST_S = 2.0, 60.0
# Effects whose smallest sizes are shown beside those that the motion is planned for.
_SHOWN = (
    "rotor_coulomb_friction",
    "load_coulomb_friction",
    "backlash_error",
    "torque_constant_error",
    "resistance_error",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the verb's flags."""
    parser.add_argument(
        "--drive", required=True, metavar="D.yaml", help="drive file of a full cylinder, or profile"
    )
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument(
        "--from",
        dest="diagnosis",
        type=Path,
        metavar="DIAGNOSIS.json",
        help="separate what this diagnosis left open",
    )
    what.add_argument("--between", metavar="A,B", help="separate these effects, every pair of them")
    what.add_argument(
        "--all", action="store_true", help="lower the detection limit of every effect"
    )
    parser.add_argument(
        "--duration", type=float, required=True, metavar="S", help="of the motion, 2 to 60 s"
    )
    parser.add_argument(
        "--out", type=Path, required=True, metavar="MOTION.yaml", help="motion to write"
    )
    parser.add_argument(
        "--write-trajectory",
        type=Path,
        metavar="OUT.yaml",
        help="write it as trajectory_msgs/JointTrajectory, for ros2 topic pub, too",
    )
    parser.add_argument(
        "--joint", default="rod", metavar="NAME", help="joint of the trajectory (rod)"
    )
    parser.add_argument(
        "--plots", type=Path, metavar="DIR", help="write pictures of motion and predictions"
    )
    parser.add_argument("--json", type=Path, metavar="OUT", help="write the predictions as JSON")
    add_limits(parser)
    add_overwrite(parser)


def add_limits(parser: argparse.ArgumentParser | argparse._ArgumentGroup) -> None:
    """Declare the flags that tighten the drive's limits; `limited` applies them."""
    for name in _LIMITS:
        parser.add_argument(
            f"--{name.replace('_', '-')}",
            type=float,
            metavar="X",
            help=f"tighter than limits.{name} of the drive file, SI",
        )


def run(options: argparse.Namespace) -> int:
    """Plan, write, print what the motion is predicted to show."""
    from ..drive.drive_file import resolve_drive
    from ..drive.stability import check_stability
    from ..plan.make import make_plan
    from ..plan.pictures import write_pictures
    from ..plan.predict import check_noise
    from ..plan.trajectory import as_yaml
    from ..recording.atomic import write_text

    path = resolve_drive(options.drive)
    if not _SHORTEST_S <= options.duration <= _LONGEST_S:
        raise InputError(
            f"--duration = {options.duration:g}, expected {_SHORTEST_S:g} to {_LONGEST_S:g} s"
        )
    check_outputs(
        {
            "--out": options.out,
            "--write-trajectory": options.write_trajectory,
            "--json": options.json,
        },
        {"--drive": path, "--from": options.diagnosis},
        overwrite=options.overwrite,
        suffixes={"--out": ".yaml", "--write-trajectory": ".yaml"},
    )
    drive = limited(options, path)
    check_stability(drive, str(path))
    pairs, alone, known, signals, why = _asked(options, drive, str(path))
    check_noise(drive, signals, str(path))
    print(why)
    shown = list(dict.fromkeys([*(one for pair in pairs for one in pair), *alone, *_SHOWN]))
    with progress_bar("planning") as progress:
        plan = make_plan(
            drive, options.duration, pairs, alone, known, signals, shown, tell=progress
        )
    about = {"drive": path.name, "for": [pair.name for pair in plan.pairs] or ["all effects"]}
    write_text(options.out, plan.motion.as_file(about))
    written = [str(options.out)]
    if options.write_trajectory is not None:
        write_text(options.write_trajectory, as_yaml(plan.motion, options.joint))
        written.append(str(options.write_trajectory))
    if options.json is not None:
        write_text(options.json, json.dumps(plan.as_json(), indent=2) + "\n")
        written.append(str(options.json))
    if options.plots is not None:
        written += [str(one) for one in write_pictures(plan, options.plots)]
    _print(plan)
    if not plan.whole:
        print("the search reached its time limit: a less busy machine may find a better motion")
    print()
    for one in written:
        print(f"{'written':<10}{one}")
    return 0


def limited(options: argparse.Namespace, path: Path) -> DriveParameters:
    """The drive of a file with the limits that a motion is to keep.

    Raises:
        InputError: not a full cylinder, or a limit that is no tighter than the file's.
    """
    from ..drive.model_file import load_model
    from ..drive.parameters import DriveParameters

    drive = load_model(path)
    if not isinstance(drive, DriveParameters):
        raise InputError(
            f"{path}: describes a drive of kind {drive.kind}; expected a full cylinder, whose "
            "recordings can be predicted"
        )
    tighter = {}
    for name in _LIMITS:
        value = getattr(options, name)
        if value is None:
            continue
        flag, limit = f"--{name.replace('_', '-')}", getattr(drive.limits, name)
        inside = value >= limit if name == "stroke_min" else 0.0 < value <= limit
        if name == "stroke_max":
            inside = drive.limits.stroke_min < value <= limit
        if not (math.isfinite(value) and inside):
            raise InputError(
                f"{flag} = {value:g}: expected within limits.{name} = {limit:g} of {path}"
            )
        tighter[name] = value
    limits: LimitParameters = dataclasses.replace(drive.limits, **tighter)
    return dataclasses.replace(drive, limits=limits)


def _asked(
    options: argparse.Namespace, drive: DriveParameters, name: str
) -> tuple[list[tuple[str, str]], list[str], dict[str, dict[str, float]], tuple[str, ...], str]:
    """Pairs, effects by themselves, known sizes, signals, and one line of what is planned for."""
    import itertools

    from ..effects.catalogue import CATALOGUE
    from ..gap.replay.replay import SIGNALS
    from ..plan.diagnosis_file import read_diagnosis
    from ..plan.hypotheses import open_or_alike

    every = tuple(one.name for one in SIGNALS)
    if options.all:
        return [], list(CATALOGUE), {}, every, "planned for: every effect, beside the sheet"
    if options.between is not None:
        names = names_in(options.between)
        for one in names:
            if one not in CATALOGUE:
                import difflib

                near = difflib.get_close_matches(one, CATALOGUE, n=1)
                hint = f"did you mean {near[0]}?" if near else "see docs/effects.md"
                raise InputError(f"--between: no effect called {one}; {hint}")
        if len(set(names)) < 2:
            raise InputError(f"--between {options.between}: expected two effects or more")
        pairs = list(itertools.combinations(dict.fromkeys(names), 2))
        return pairs, [], {}, every, f"planned for: {_listed(pairs)}"
    found = open_or_alike(read_diagnosis(options.diagnosis, drive, name))
    known = {effect: dict(values) for effect, values in found.values.items()}
    if not found.pairs:
        return (
            [],
            list(CATALOGUE),
            known,
            found.signals or every,
            f"{options.diagnosis} leaves nothing open: planned for every effect, beside the sheet",
        )
    said = f"planned for: {_listed(found.pairs)} ({found.why})"
    return list(found.pairs), [], known, found.signals or every, said


def _listed(pairs: Sequence[tuple[str, str]]) -> str:
    return ", ".join(f"{first} | {second}" for first, second in pairs)


def _print(plan: Plan) -> None:
    motions = [one.motion for one in plan.predictions]
    if plan.pairs:
        rows = [["separation, noise floors", *motions]]
        for number, pair in enumerate(plan.pairs):
            label = f"{pair.name} ({pair.first.size} | {pair.second.size})"
            rows.append([label, *(f"{one.apart[number]:.2f}" for one in plan.predictions)])
        print()
        _table(rows)
        print(f"a diagnosis separates two effects from {plan.needed:.2f} noise floors on")
    rows = [["detection limit, 95 %", *motions]]
    sizes = [{one.effect: one for one in motion.limits} for motion in plan.predictions]
    for effect in sizes[0]:
        rows.append([effect, *(_size(one.get(effect)) for one in sizes)])
    print()
    _table(rows)


def _size(one: Limit | None) -> str:
    from ..gap.report import limits

    return "-" if one is None or one.smallest_seen is None else limits.size(one)


def _table(rows: Sequence[Sequence[str]]) -> None:
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    for row in rows:
        cells = [row[0].ljust(widths[0])]
        cells += [cell.rjust(width) for cell, width in zip(row[1:], widths[1:], strict=True)]
        print("  ".join(cells).rstrip())
