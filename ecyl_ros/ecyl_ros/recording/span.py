"""The part of a recording that was asked for, in seconds from its first stamp."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

from ..errors import InputError
from .signals import Recording


@dataclass(frozen=True)
class Span:
    """begin_s <= time < end_s, from the first stamp.

    Attributes:
        begin_s, end_s: end_s is infinite where the recording's end is meant.

    Raises:
        InputError: negative, reversed or empty.
    """

    begin_s: float = 0.0
    end_s: float = math.inf

    def __post_init__(self) -> None:
        if not 0.0 <= self.begin_s < math.inf:
            raise InputError(f"--from is {self.begin_s:g} s, expected 0 or more")
        if not self.end_s > 0.0:
            raise InputError(f"--to is {self.end_s:g} s, expected more than 0")
        if not self.end_s > self.begin_s:
            raise InputError(
                f"--from is {self.begin_s:g} s and --to {self.end_s:g} s, expected --to the later"
            )

    @property
    def text(self) -> str:
        """When, in words."""
        end = "the end" if math.isinf(self.end_s) else f"{self.end_s:g} s"
        return f"from {self.begin_s:g} s to {end}"

    def part(self, recording: Recording, source: str) -> Recording:
        """The part of a recording, with a note that says which; InputError where it is empty."""
        part = recording.slice(self.begin_s, self.end_s)
        if len(part) < 2:
            raise self.empty(source, recording.duration_s)
        return dataclasses.replace(part, notes=(f"{source}: {self.note}", *part.notes))

    @property
    def note(self) -> str:
        """A line that says that only this part is judged."""
        return f"only {self.text} was read, as asked for"

    def empty(self, source: str, duration_s: float) -> InputError:
        """What to say of a part without samples."""
        return InputError(
            f"{source}: no samples {self.text}: the recording is {duration_s:.6g} s long; expected "
            "--from and --to within it"
        )
