"""`ecyl new-effect`: an effect of the catalogue from a law that a diagnosis learned."""

from __future__ import annotations

import argparse
from pathlib import Path

from .outputs import add_overwrite, check_outputs


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the verb's flags."""
    parser.add_argument(
        "law",
        type=Path,
        metavar="DRIVE.yaml",
        help="a drive file that holds effects.learned, as ecyl diagnose --write-drive writes it",
    )
    parser.add_argument(
        "--name", required=True, metavar="NAME", help="of the effect: small letters, digits and _"
    )
    parser.add_argument(
        "--out",
        type=Path,
        required=True,
        metavar="NAME.py",
        help="the effect's file; it belongs into ecyl_ros/ecyl_ros/effects",
    )
    parser.add_argument(
        "--test", type=Path, metavar="test_NAME.py", help="write a test of it, for tests/effects"
    )
    add_overwrite(parser)


def run(options: argparse.Namespace) -> int:
    """Write the files; 0 when they are written."""
    from ..drive.drive_file import resolve_drive
    from ..drive.model_file import load_model
    from ..drive.rigid.machine import Machine
    from ..errors import InputError
    from ..gap.describe.effect_file import effect_text, test_text
    from ..gap.describe.rigid_effect_file import rigid_effect_text, rigid_test_text
    from ..recording.atomic import write_text

    source = resolve_drive(options.law)
    check_outputs(
        {"--out": options.out, "--test": options.test},
        {"DRIVE.yaml": source},
        overwrite=options.overwrite,
        suffixes={"--out": f"{options.name}.py", "--test": ".py"},
    )
    drive = load_model(source)
    law = drive.learned
    if law is None:
        raise InputError(f"{source}: no effects.learned; expected a learned law in it")
    if isinstance(drive, Machine):
        effect = rigid_effect_text(law, options.name, drive.linear)
        test = rigid_test_text(law, options.name, drive.linear)
    else:
        effect, test = effect_text(law, options.name), test_text(law, options.name)
    written = [options.out]
    write_text(options.out, effect)
    if options.test is not None:
        write_text(options.test, test)
        written.append(options.test)
    for path in written:
        print(f"written   {path}")
    print(
        'fill in   title, summary and excitation; docs/effects.md, "A new effect", makes its page'
    )
    return 0
