# PYTHON_ARGCOMPLETE_OK
"""Entry point of `ecyl`: finds the verb's module, parses, runs, maps errors to exit codes."""

from __future__ import annotations

import argparse
import importlib
import os
import sys
from collections.abc import Sequence
from types import ModuleType

from .. import __version__
from ..errors import InputError

# One module of this package per verb, with the line `ecyl --help` shows for it. Modules are
# imported only when their verb is called, so that help stays fast.
VERBS = {
    "demo": "a worn drive as a node graph, recorded, diagnosed and reported, in a minute",
    "run": "launch the nodes, record the graph, print the tracking figures",
    "simulate": "the same run on the engine alone, without a graph",
    "analyse": "tracking figures, spectrum and IMFs of a recording",
    "plan": "a motion that separates what a diagnosis left open, with its predicted result",
    "investigate": "plan, play and diagnose motions on a drive until its gap is decided",
    "replay": "publish a recording again with its own timing",
    "mend": "close a recording whose recorder was killed",
    "inspect": "what a recording holds: topics, rates, gaps, clocks, ranges, a proposed map",
    "diagnose": "where the gap to a recording lies, what causes it, how far it shrinks",
    "export": "the drive as MJCF, URDF or SDF; a joint of these as a rigid drive file",
    "sensitivity": "tracking figures over one or two parameters of a drive file",
    "paper": "every table and figure of the paper, in both readings, beside its numbers",
    "bench": "the paper's locked-output test: hysteresis loop, backlash, stiffness",
    "new-effect": "an effect of the catalogue from a law that a diagnosis learned",
    "blind": "the sealed study: drives with hidden faults diagnosed, labels opened, scored",
}


def words(argv: Sequence[str] | None) -> list[str]:
    """The command line without the program: as given, of the process, or of a shell's completion.

    A shell that asks for completions hands the line over in COMP_LINE (argcomplete's protocol).
    """
    if argv is None and "_ARGCOMPLETE" in os.environ:
        return os.environ.get("COMP_LINE", "").split()[1:]
    return list(sys.argv[1:] if argv is None else argv)


def add_verbs(
    parser: argparse.ArgumentParser, arguments: Sequence[str], *, required: bool = True
) -> None:
    """Declare all verbs, and the flags of the one that the command line names.

    required: whether a command line without a verb is an error.
    """
    verb = next((word for word in arguments if word in VERBS), None)
    verbs = parser.add_subparsers(dest="verb", metavar="VERB", required=required)
    for name, summary in VERBS.items():
        sub = verbs.add_parser(name, help=summary, description=summary.capitalize() + ".")
        if name == verb:
            _module(name).add_arguments(sub)


def _module(verb: str) -> ModuleType:
    return importlib.import_module(f"{__package__}.{verb.replace('-', '_')}")


def run_verb(options: argparse.Namespace) -> int:
    """Run the verb and return the exit code: 0 done, 2 unusable input, 130 interrupted."""
    module = _module(options.verb)
    try:
        return int(module.run(options))
    except InputError as error:
        print(f"ecyl {options.verb}: {error}", file=sys.stderr)
        return 2
    except BrokenPipeError:  # the reader of our output has gone: not an error of ours
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except KeyboardInterrupt:
        print(f"ecyl {options.verb}: interrupted", file=sys.stderr)
        return 130


def main(argv: Sequence[str] | None = None) -> int:
    """Run `ecyl VERB ...` and return its exit code; see `run_verb`."""
    parser = argparse.ArgumentParser(
        prog="ecyl",
        description="Emulate an electric-cylinder drive on ROS 2 and analyse its recordings.",
    )
    parser.add_argument("--version", action="version", version=f"ecyl {__version__}")
    arguments = words(argv)
    add_verbs(parser, arguments)
    if "_ARGCOMPLETE" in os.environ:
        import argcomplete

        argcomplete.autocomplete(parser)
    return run_verb(parser.parse_args(arguments))


if __name__ == "__main__":
    sys.exit(main())
