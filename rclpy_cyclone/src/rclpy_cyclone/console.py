"""Where log messages go: the console, in rcutils' format, and the nodes' ``/rosout``.

``RCUTILS_CONSOLE_OUTPUT_FORMAT``, ``RCUTILS_LOGGING_USE_STDOUT`` and
``RCUTILS_COLORIZED_OUTPUT`` are heeded.
"""

from __future__ import annotations

import os
import re
import sys
import time
from collections.abc import Callable

SEPARATOR = "."
DEFAULT_LEVEL = 20
NAMES = {10: "DEBUG", 20: "INFO", 30: "WARN", 40: "ERROR", 50: "FATAL"}
_COLOURS = {10: "32", 20: "0", 30: "33", 40: "31", 50: "31"}
levels: dict[str, int] = {}  # logger name -> its own level; "" is the default's
enabled = True
# Called with (stamp, level, name, text, function, file, line) for every message of a logger.
Sink = Callable[[int, int, str, str, str, str, int], None]
sinks: dict[str, Sink] = {}  # logger name of a node -> its /rosout
_FORMAT = "[{severity}] [{time}] [{name}]: {message}"


def set_level(name: str, level: int) -> None:
    """Set a logger's level; 0 makes it follow its parent again."""
    if level:
        levels[name] = int(level)
    else:
        levels.pop(name, None)


def effective_level(name: str) -> int:
    """Return the level of a logger, or of the nearest ancestor that has one."""
    if not levels:
        return DEFAULT_LEVEL
    while name:
        if name in levels:
            return levels[name]
        name = name.rpartition(SEPARATOR)[0]
    return levels.get("", DEFAULT_LEVEL)


def log(level: int, name: str, text: str, function: str, file: str, line: int) -> None:
    """Write a message to the console and to the ``/rosout`` of the node it belongs to."""
    stamp = time.time_ns()
    if enabled:
        _print(stamp, level, name, text, function, file, line)
    owner = name
    while owner and owner not in sinks:
        owner = owner.rpartition(SEPARATOR)[0]
    if owner:
        sinks[owner](stamp, level, name, text, function, file, line)


def _print(
    stamp: int, level: int, name: str, text: str, function: str, file: str, line: int
) -> None:
    stream = sys.stdout if os.environ.get("RCUTILS_LOGGING_USE_STDOUT") == "1" else sys.stderr
    if stream is None:
        return
    seconds, rest = divmod(stamp, 1_000_000_000)
    values = {
        "severity": NAMES[level],
        "name": name,
        "message": text,
        "function_name": function,
        "file_name": file,
        "line_number": str(line),
        "time": f"{seconds}.{rest:09d}",
        "time_as_nanoseconds": str(stamp),
    }
    form = os.environ.get("RCUTILS_CONSOLE_OUTPUT_FORMAT", _FORMAT)
    # An unknown word in braces is left as it is.
    out = re.sub(r"\{(\w+)\}", lambda m: values.get(m.group(1), m.group(0)), form)
    if _coloured(stream):
        out = f"\033[{_COLOURS[level]}m{out}\033[0m"
    try:
        stream.write(out + "\n")
        stream.flush()
    except (OSError, ValueError):  # nobody reads the console any more
        pass


def _coloured(stream: object) -> bool:
    wanted = os.environ.get("RCUTILS_COLORIZED_OUTPUT")
    if wanted in ("0", "1"):
        return wanted == "1"
    return bool(getattr(stream, "isatty", lambda: False)())
