"""What a diagnosis of several recordings says of each of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class OwnValue:
    """A value of the machine as one recording alone shows it, in its unit.

    of: the effect, or the constant of the data sheet, that it is of. low, high: 95 % interval.
    seen: whether the recording tells it at all. differs: whether the interval of another recording
    that does lies beside this one: it is not the same value.
    """

    of: str
    name: str
    unit: str
    value: float
    low: float
    high: float
    seen: bool = True
    differs: bool = False

    def beside(self, other: OwnValue) -> bool:
        """Whether both are seen, and their intervals have nothing in common."""
        apart = self.low > other.high or other.low > self.high
        return self.seen and other.seen and apart


@dataclass(frozen=True)
class OfRecording:
    """One of several recordings.

    Attributes:
        source: what it is called (a path). name: the same without folders, where that says which it
            is. duration_s, rate_hz: its own.
        unit: of before, after and floor: RMS on its held-out stretches of what the nominal model
            leaves, of what the fit to all recordings leaves, and of its noise.
        shrink: share of its gap above the floor that is gone.
        unseen: the same on the whole recording, by a fit of these causes to the others alone; None
            where no cause is named.
        values: of causes and of seen constants, as it alone shows them.
        rows: first row of its samples in the diagnosis's series, and the one behind the last.
    """

    source: str
    name: str
    duration_s: float
    rate_hz: float
    unit: str
    before: float
    after: float
    floor: float
    shrink: float
    unseen: float | None
    values: tuple[OwnValue, ...]
    rows: tuple[int, int] = (0, 0)

    def as_json(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "recording": self.source,
            "duration_s": self.duration_s,
            "rate_hz": self.rate_hz,
            "unit": self.unit,
            "gap": {
                "before": self.before,
                "after": self.after,
                "floor": self.floor,
                "shrink": self.shrink,
                "shrink_unseen": self.unseen,
            },
            "values": [
                {
                    "of": one.of,
                    "name": one.name,
                    "unit": one.unit,
                    "value": one.value,
                    "ci95": [one.low, one.high],
                    "seen": one.seen,
                    "differs": one.differs,
                }
                for one in self.values
            ],
        }


def names_of(sources: Sequence[str]) -> list[str]:
    """Paths without folders; as they are where two would then be called the same."""
    names = [Path(one).name for one in sources]
    return names if len(set(names)) == len(names) else list(sources)


@dataclass(frozen=True)
class Unseen:
    """The last recording against what the others alone say: no fit saw it.

    Attributes:
        source: the recording. named_on: the others. verdict, causes: what is said of these alone.
        before, after, floor: RMS on the recording, in its unit. shrink: share of its gap above the
            floor that these causes remove, with the values that the others give.
    """

    source: str
    named_on: tuple[str, ...]
    verdict: str
    causes: tuple[str, ...]
    before: float
    after: float
    floor: float
    shrink: float

    def as_json(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "recording": self.source,
            "named_on": list(self.named_on),
            "verdict": self.verdict,
            "causes": list(self.causes),
            "before": self.before,
            "after": self.after,
            "floor": self.floor,
            "shrink": self.shrink,
        }
