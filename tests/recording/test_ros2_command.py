"""`ros2 ecyl VERB` and shell completion."""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from pathlib import Path

import pytest
from recording_samples import made

from ecyl_ros.cli.main import VERBS
from ecyl_ros.cli.ros2_command import EcylCommand
from ecyl_ros.recording.writer import write_recording


def called(*line: str) -> int:
    """What `ros2 LINE` returns: the steps of ros2cli's `add_subparsers_on_demand` and `main`."""
    parser = argparse.ArgumentParser(prog="ros2")
    commands = parser.add_subparsers()
    own = commands.add_parser("ecyl")
    extension = EcylCommand()
    own.set_defaults(_command=extension)
    extension.add_arguments(own, "ros2 ecyl", argv=list(line))
    options = parser.parse_args(list(line))
    return options._command.main(parser=parser, args=options)


def test_ros2_ecyl_runs_a_verb(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """`ros2 ecyl inspect FILE` prints what `ecyl inspect FILE` prints."""
    write_recording(made(50), tmp_path / "a.mcap")
    assert called("ecyl", "inspect", str(tmp_path / "a.mcap")) == 0
    out = capsys.readouterr().out
    assert "/ecyl/joint_states" in out and "Proposed map" in out


def test_ros2_ecyl_maps_errors_and_missing_verbs(capsys: pytest.CaptureFixture[str]) -> None:
    """Unusable input is exit code 2 and one line; no verb is the help with every verb, and 0."""
    assert called("ecyl", "inspect", "/nowhere.mcap") == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert called("ecyl") == 0
    out = capsys.readouterr().out
    assert all(verb in out for verb in VERBS)


def completions(tmp_path: Path, line: str) -> set[str]:
    """What the shell is offered behind `line`, by argcomplete's protocol."""
    out = tmp_path / "completions"
    environment = {
        **os.environ,
        "_ARGCOMPLETE": "1",
        "_ARGCOMPLETE_IFS": "\n",
        "_ARGCOMPLETE_STDOUT_FILENAME": str(out),
        "COMP_LINE": line,
        "COMP_POINT": str(len(line)),
    }
    subprocess.run(
        [sys.executable, "-m", "ecyl_ros.cli.main"], env=environment, check=False, timeout=60
    )
    return {word.strip() for word in out.read_text().split("\n")}


def test_the_shell_completes_verbs_and_flags(tmp_path: Path) -> None:
    """Behind `ecyl ins` comes inspect; behind `ecyl inspect --` come its flags and no others."""
    assert completions(tmp_path, "ecyl ins") == {"inspect"}
    flags = completions(tmp_path, "ecyl inspect --")
    assert {"--write-map", "--json", "--all"} <= flags
    assert "--drive" not in flags
    assert "--drive" in completions(tmp_path, "ecyl diagnose --")
