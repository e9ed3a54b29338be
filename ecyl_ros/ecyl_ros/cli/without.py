"""`--without`: effects of the catalogue that a diagnosis does without."""

from __future__ import annotations

import argparse

from .commas import names_in


def add_without(parser: argparse.ArgumentParser) -> None:
    """Declare the flag."""
    parser.add_argument(
        "--without",
        default="",
        metavar="A,B",
        help="effects that this machine surely has not; they are left out of the catalogue",
    )


def without_of(options: argparse.Namespace) -> tuple[str, ...]:
    """The names that were given, each once, in their order."""
    return tuple(dict.fromkeys(names_in(options.without)))
