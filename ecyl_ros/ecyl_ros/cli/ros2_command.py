"""`ros2 ecyl VERB ...`: the same verbs as a command of ros2cli, where that is installed."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Any

from .main import add_verbs, run_verb, words


def _extension() -> Any:
    """ros2cli's base class; without ROS the module can still be imported."""
    try:
        from ros2cli.command import CommandExtension
    except ModuleNotFoundError:
        return object
    return CommandExtension


_Base: Any = _extension()


class EcylCommand(_Base):
    """Emulate an electric-cylinder drive and find out why a real one differs."""

    def add_arguments(
        self,
        parser: argparse.ArgumentParser,
        cli_name: str,
        *,
        argv: Sequence[str] | None = None,
    ) -> None:
        """Called by ros2cli with the parser of `ros2 ecyl`; argv is that of `ros2`."""
        self._parser = parser
        line = words(argv)
        # What precedes `ecyl` belongs to ros2 itself.
        after = line[line.index("ecyl") + 1 :] if "ecyl" in line else line
        add_verbs(parser, after, required=False)

    def main(self, *, parser: Any, args: argparse.Namespace) -> int:
        """Run the verb; without one print the help, as ros2's own commands do."""
        if getattr(args, "verb", None) is None:
            self._parser.print_help()
            return 0
        return run_verb(args)
