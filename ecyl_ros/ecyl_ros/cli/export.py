"""`ecyl export`: a drive for other simulators, and a joint of theirs as a drive file."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from ..errors import InputError
from .outputs import add_overwrite, check_outputs

FORMATS = {"mjcf": ".xml", "urdf": ".urdf", "sdf": ".sdf", "rigid": ".yaml"}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the verb's flags."""
    parser.add_argument(
        "model",
        metavar="DRIVE",
        help="drive file or profile; with --to rigid the MJCF or URDF file to read",
    )
    parser.add_argument(
        "--to",
        required=True,
        choices=tuple(FORMATS),
        help="MuJoCo's MJCF, URDF (robot_state_publisher), Gazebo's SDF; rigid: the other way, a "
        "joint of an MJCF or URDF file as the start of a rigid drive file",
    )
    parser.add_argument(
        "--out", type=Path, metavar="FILE", help="file to write; without it, standard output"
    )
    parser.add_argument(
        "--actuator",
        choices=("servo", "motor"),
        help="mjcf: the position loop (default), controlled in m or rad; or the bare motor, "
        "controlled by its current",
    )
    parser.add_argument("--joint", metavar="NAME", help="rigid: which joint, where there are more")
    add_overwrite(parser)


def run(options: argparse.Namespace) -> int:
    """Write the file; what the format cannot express goes to standard error, a line each."""
    for flag, formats in (("actuator", ("mjcf",)), ("joint", ("rigid",))):
        if getattr(options, flag) is not None and options.to not in formats:
            raise InputError(f"--{flag} is for --to {formats[0]}; this is --to {options.to}")
    source = Path(options.model)
    if options.to != "rigid":
        from ..drive.drive_file import resolve_drive

        source = resolve_drive(options.model)
    check_outputs(
        {"--out": options.out},
        {"DRIVE": source},
        overwrite=options.overwrite,
        suffixes={"--out": FORMATS[options.to]},
    )
    text, said = _rigid(source, options) if options.to == "rigid" else _exported(source, options)
    if options.out is None:
        print(text, end="")
    else:
        from ..recording.atomic import write_text

        write_text(options.out, text)
    for line in said:
        print(f"ecyl export: {line}", file=sys.stderr)
    return 0


def _exported(source: Path, options: argparse.Namespace) -> tuple[str, list[str]]:
    from ..drive.model_file import load_model
    from ..export import mjcf, sdf, urdf
    from ..export.mechanism import of

    mechanism = of(load_model(source), source.stem)
    if options.to == "mjcf":
        actuator = options.actuator or "servo"
        if actuator == "servo" and mechanism.servo is None and options.actuator is not None:
            raise InputError(
                f"{source}: no gains of a position loop; expected --actuator motor, or "
                "controller.position.kp and controller.speed.kp"
            )
        text, left = mjcf.mjcf(mechanism, actuator), mjcf.left_out(mechanism, actuator)
    elif options.to == "urdf":
        text, left = urdf.urdf(mechanism), urdf.left_out(mechanism)
    else:
        text, left = sdf.sdf(mechanism), sdf.left_out(mechanism)
    return text, [f"not in the {options.to.upper()}: {one}" for one in left]


def _rigid(source: Path, options: argparse.Namespace) -> tuple[str, list[str]]:
    from ..drive.rigid.machine_file import machine_from_flat
    from ..export.joint_values import parameters, read_joint, rigid_file

    joint = read_joint(source, options.joint)
    machine_from_flat(parameters(joint), str(source))  # refuses what no drive can have
    return rigid_file(joint, source.name), list(joint.remarks)
