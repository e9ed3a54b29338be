"""What came of one motion on the drive: plain data."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Seen:
    """The drive before anything moves.

    Attributes:
        follows: `trajectory` or `setpoint`. topics: keys of the telemetry that it sends.
        at_m: where its reference rests.
    """

    follows: str
    topics: tuple[str, ...]
    at_m: float


@dataclass(frozen=True)
class Played:
    """A motion played, or broken off.

    Attributes:
        recording: what was recorded; None if the motion had not begun.
        samples: that were recorded, each of them within the bounds unless `ended` says otherwise.
        error_m, current_a: largest tracking error and current.
        ended: why the drive was brought to rest; None when the motion was played to its end.
        at_rest: whether the reference was seen to come to rest.
    """

    recording: Path | None
    samples: int
    error_m: float
    current_a: float
    ended: str | None
    at_rest: bool
