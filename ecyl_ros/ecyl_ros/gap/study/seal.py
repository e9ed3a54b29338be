"""Labels that stay shut while a study runs: their hash is shown first, they are checked after."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from dataclasses import dataclass

from .case import Case


class BrokenSeal(Exception):
    """Labels that are not those whose hash was shown."""


@dataclass(frozen=True)
class Sealed:
    """Labels as canonical JSON (sorted keys, no spaces) and its SHA-256, hexadecimal."""

    text: str
    sha256: str

    def open(self) -> list[Case]:
        """The cases; raises BrokenSeal if the text is not what was sealed."""
        if _hash(self.text) != self.sha256:
            raise BrokenSeal("the labels do not match the hash shown before the first diagnosis")
        return [Case.from_label(label) for label in json.loads(self.text)]


def _hash(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def seal(cases: Iterable[Case]) -> Sealed:
    """Seal the labels of `cases`."""
    labels = [case.label() for case in cases]
    text = json.dumps(labels, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return Sealed(text, _hash(text))
