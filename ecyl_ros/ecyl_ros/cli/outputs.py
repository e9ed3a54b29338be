"""The files that a verb writes: checked before any work, for all verbs alike."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path

from ..errors import InputError


def add_overwrite(parser: argparse.ArgumentParser) -> None:
    """Declare `--overwrite`."""
    parser.add_argument("--overwrite", action="store_true", help="replace existing outputs")


def check_outputs(
    outputs: Mapping[str, Path | None],
    inputs: Mapping[str, Path | None],
    *,
    overwrite: bool,
    suffixes: Mapping[str, str] | None = None,
) -> None:
    """Refuse outputs that cannot be written, or that would take an input's place or each other's.

    Args:
        outputs: flag -> file to write; None where it was not asked for.
        inputs: what messages call it -> file that is read.
        overwrite: whether files that exist may be replaced (inputs never are).
        suffixes: flag -> how the file's name has to end.

    Raises:
        InputError: names the flag and the file.
    """
    taken = {path.resolve(): name for name, path in inputs.items() if path is not None}
    for flag, path in outputs.items():
        if path is None:
            continue
        place = path.resolve()
        if place in taken:
            raise InputError(f"{flag} {path}: is {taken[place]} too; expected a file of its own")
        taken[place] = flag
        suffix = (suffixes or {}).get(flag, "")
        if not path.name.endswith(suffix):
            raise InputError(f"{flag} {path}: expected a name that ends in {suffix}")
        if path.is_dir():
            raise InputError(f"{flag} {path}: is a folder; expected the name of a file")
        if path.exists() and not overwrite:
            raise InputError(f"{flag} {path}: exists; expected a new name, or --overwrite")
