"""`ros2 ecyl VERB ...`: the same verbs as a command of ros2cli, where that is installed."""

from __future__ import annotations

import argparse
import importlib.util
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from .main import add_verbs, run_verb, words

# What the distribution does not have and pip brings: where one is missing, so are they all.
MODULES = ("numba", "mcap", "mcap_ros2", "rosbags", "ruckig", "PyEMD", "joblib", "threadpoolctl")
_TRIED = "ECYL_ROS2_COMMAND"  # set for the command that runs in our stead


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
        self._after = after
        add_verbs(parser, after, required=False)

    def main(self, *, parser: Any, args: argparse.Namespace) -> int:
        """Run the verb; without one print the help, as ros2's own commands do."""
        if getattr(args, "verb", None) is None:
            self._parser.print_help()
            return 0
        missing = next((name for name in MODULES if importlib.util.find_spec(name) is None), None)
        if missing is not None:
            return _run_elsewhere(missing, self._after)
        return run_verb(args)


def _run_elsewhere(missing: str, arguments: Sequence[str]) -> int:
    """Run the verb under the Python that the package was built with; 2 if that is this one.

    `ros2` runs under the system's Python, which does not see a virtual environment. The command
    that colcon installed beside the nodes knows the right one.
    """
    script = _installed_command()
    if script is None or os.environ.get(_TRIED) == "1":
        print(
            f"ros2 ecyl: {sys.executable} has no module {missing}; expected a workspace built by a "
            "Python that has it: `python3 -m colcon build` in the venv of README's recipe",
            file=sys.stderr,
        )
        return 2
    sys.stdout.flush()
    os.environ[_TRIED] = "1"
    os.execv(script, [str(script), *arguments])


def _installed_command() -> Path | None:
    """`lib/ecyl_ros/ecyl` of the workspace, where there is one."""
    try:
        from ament_index_python.packages import PackageNotFoundError, get_package_prefix
    except ModuleNotFoundError:
        return None
    try:
        script = Path(get_package_prefix("ecyl_ros"), "lib", "ecyl_ros", "ecyl")
    except PackageNotFoundError:
        return None
    return script if os.access(script, os.X_OK) else None
