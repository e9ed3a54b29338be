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
        missed_ticks: control ticks that the drive says it missed from when it was first heard to
            the end of the motion; None where it does not say, as in lockstep.
    """

    recording: Path | None
    samples: int
    error_m: float
    current_a: float
    ended: str | None
    at_rest: bool
    missed_ticks: int | None = None


def missed(played: Played) -> str:
    """What missed ticks mean, in a sentence."""
    return (
        f"the drive missed {played.missed_ticks} of its control ticks: what it did then may not be "
        "the machine's, and may show as a gap that no effect explains"
    )
