"""Outcomes on disk as they come, so that a study that was interrupted can go on."""

from __future__ import annotations

import json
from pathlib import Path

from ...errors import InputError
from .examine import Outcome


class Journal:
    """A file of JSON lines: the labels' hash, then one outcome per line."""

    def __init__(self, path: Path, sha256: str, *, resume: bool) -> None:
        """Open `path` for a study with these labels; with `resume`, read what is there.

        Raises InputError if there is nothing to resume, or it belongs to another study.
        """
        self.path = path
        self.outcomes: list[Outcome] = []
        if resume:
            self._read(sha256)
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            with path.open("w", encoding="utf-8") as out:
                out.write(json.dumps({"sha256": sha256}) + "\n")
                for outcome in self.outcomes:
                    out.write(json.dumps(outcome.as_json()) + "\n")
        except OSError as error:
            raise InputError(f"{path}: cannot be written: {error.strerror}") from None

    def _read(self, sha256: str) -> None:
        try:
            lines = self.path.read_text(encoding="utf-8").splitlines()
        except OSError:
            raise InputError(f"{self.path}: nothing to resume; expected a study cut off") from None
        entries = []
        for line in lines:
            try:
                entries.append(json.loads(line))
            except ValueError:  # the line being written when the study was cut off
                break
        if not entries or entries[0].get("sha256") != sha256:
            raise InputError(
                f"{self.path}: belongs to another study; expected labels with hash {sha256[:16]}..."
            )
        self.outcomes = [Outcome(**entry) for entry in entries[1:]]

    def add(self, outcome: Outcome) -> None:
        """Append one outcome."""
        with self.path.open("a", encoding="utf-8") as out:
            out.write(json.dumps(outcome.as_json()) + "\n")

    def remove(self) -> None:
        """Remove the file: the study is complete and written elsewhere."""
        self.path.unlink(missing_ok=True)
