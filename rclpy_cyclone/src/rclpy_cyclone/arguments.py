"""The part of a command line that ROS 2 claims: ``--ros-args ... --``."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from rclpy_cyclone import parameterfiles, remapping


class UnknownArguments(ValueError):
    """Arguments behind ``--ros-args`` that nobody knows."""


@dataclass
class Arguments:
    """What a command line says about nodes.

    :param remaps: renaming rules, in order.
    :param parameters: ``(node pattern, name, value)``, later ones win.
    :param log_levels: logger name -> severity name; the empty name is the default level.
    :param enclave: security enclave.
    :param rosout: whether log messages go to ``/rosout``.
    :param stdout: whether log messages go to the console.
    :param others: arguments that are not ROS 2's.
    """

    remaps: list[remapping.Rule] = field(default_factory=list)
    parameters: list[tuple[str, str, Any]] = field(default_factory=list)
    log_levels: dict[str, str] = field(default_factory=dict)
    enclave: str = "/"
    rosout: bool = True
    stdout: bool = True
    others: list[str] = field(default_factory=list)


LEVELS = ("debug", "info", "warn", "error", "fatal")
_VALUED = {
    "-r": "remap", "--remap": "remap", "-p": "param", "--param": "param",
    "--params-file": "file", "--log-level": "level", "-e": "enclave", "--enclave": "enclave",
    "--log-config-file": "log config", "--log-file-name": "log file",
}  # fmt: skip
_SWITCHES = {
    "--enable-rosout-logs": ("rosout", True), "--disable-rosout-logs": ("rosout", False),
    "--enable-stdout-logs": ("stdout", True), "--disable-stdout-logs": ("stdout", False),
}  # fmt: skip
_IGNORED = ("--enable-external-lib-logs", "--disable-external-lib-logs")


def parse(args: list[str]) -> Arguments:
    """Read a command line.

    :param args: the whole command line, program name included or not.
    :raises ValueError: if a ROS argument is malformed, or a parameter file cannot be read.
    :raises UnknownArguments: if there is a ROS argument nobody knows.
    """
    found = Arguments()
    unknown = []
    position, inside = 0, False
    while position < len(args):
        word = args[position]
        position += 1
        if word == "--ros-args":
            inside = True
        elif not inside:
            found.others.append(word)
        elif word == "--":
            inside = False
        elif word in _VALUED:
            if position >= len(args):
                raise ValueError(f"Couldn't parse trailing {word} flag. No value found.")
            _apply(found, _VALUED[word], word, args[position])
            position += 1
        elif word in _SWITCHES:
            name, value = _SWITCHES[word]
            setattr(found, name, value)
        elif word not in _IGNORED:
            unknown.append(word)
    if unknown:
        raise UnknownArguments(f"Found unknown ROS arguments: {' '.join(unknown)}")
    return found


def _apply(found: Arguments, kind: str, flag: str, value: str) -> None:
    try:
        if kind == "remap":
            found.remaps.append(remapping.parse_rule(value))
        elif kind == "param":
            found.parameters.append(parameterfiles.parse_rule(value))
        elif kind == "file":
            found.parameters.extend(parameterfiles.read(value))
        elif kind == "level":
            _level(found, value)
        elif kind == "enclave":
            found.enclave = value
        else:
            raise ValueError("external log configuration is not offered by rclpy_cyclone")
    except ValueError as error:
        raise ValueError(f"Couldn't parse argument {flag} {value!r}: {error}") from error


def _level(found: Arguments, value: str) -> None:
    name, assigned, level = value.rpartition(":=")
    if level.lower() not in LEVELS or (assigned and not name):
        raise ValueError(f"{value!r} is not a log level, nor <logger>:=<level>")
    found.log_levels[name] = level.lower()
