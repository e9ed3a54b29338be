"""The recordings of a folder, and which machine each is of."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from ...errors import InputError
from ...recording.source import BAG_SUFFIXES, CSV_SUFFIXES, MAT_SUFFIX

_SUFFIXES = (*BAG_SUFFIXES, *CSV_SUFFIXES, MAT_SUFFIX)
_BAG_FOLDER = "metadata.yaml"
# What numbers a machine's recordings: digits, dates and times at the end of a name.
_NUMBER = re.compile(r"[-_. ]*[0-9][-_0-9T:.]*$")


@dataclass(frozen=True)
class Found:
    """One recording of a folder.

    path: to read. name: within the folder, without suffix; also that of its page. machine: the
    folder that it lies in, or else its name without the number at the end.
    """

    path: Path
    name: str
    machine: str


def recordings_in(folder: Path, out: Path) -> list[Found]:
    """Every recording below `folder`, by name; what lies in `out` is none.

    Raises:
        InputError: no folder, or nothing in it that is read as a recording.
    """
    if not folder.is_dir():
        raise InputError(f"{folder}: is no folder; expected one of recordings with --each")
    paths = sorted(_paths(folder, out.resolve()))
    if not paths:
        raise InputError(
            f"{folder}: holds no recording; expected files that end in {', '.join(_SUFFIXES)}, or "
            "rosbag2 folders"
        )
    names = [str(path.relative_to(folder).with_suffix("")) for path in paths]
    found = []
    for path, name in zip(paths, names, strict=True):
        # Two that differ in the suffix alone keep it, so that each has a page of its own.
        plain = name if names.count(name) == 1 else str(path.relative_to(folder))
        found.append(Found(path, plain, _machine(Path(name))))
    return found


def _paths(folder: Path, out: Path) -> list[Path]:
    found: list[Path] = []
    for path in folder.iterdir():
        if path.name.startswith(".") or path.resolve() == out:
            continue
        if path.is_dir():
            found += [path] if (path / _BAG_FOLDER).exists() else _paths(path, out)
        elif path.suffix.lower() in _SUFFIXES:
            found.append(path)
    return found


def _machine(name: Path) -> str:
    if len(name.parts) > 1:
        return str(name.parent)
    return _NUMBER.sub("", name.name) or name.name
