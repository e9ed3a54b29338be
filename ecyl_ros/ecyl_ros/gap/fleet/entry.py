"""One line of the index: what a diagnosis comes to, or why there is none."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from ..diagnosis import Diagnosis
from ..listed import listed
from ..report import quantities as q
from ..report import words
from .find import Found


@dataclass(frozen=True)
class Size:
    """A cause's first parameter with its 95 % interval, SI."""

    effect: str
    parameter: str
    unit: str
    value: float
    low: float
    high: float


@dataclass(frozen=True)
class Entry:
    """A recording of the fleet.

    Attributes:
        name, machine: see `find.Found`. start_ns: its first stamp, 0 where it was not read.
        duration_s: its length.
        verdict: empty where there is no diagnosis. error: why there is none.
        gap: misfit of the nominal model in noise floors. after: with what was found.
        block: where the gap lies. causes: sizes of what is named, first parameters. confidence: of
            the least sure of these.
        shrink: share of the gap that is gone, held out.
        seconds: the diagnosis took.
    """

    name: str
    machine: str
    start_ns: int = 0
    duration_s: float = 0.0
    verdict: str = ""
    error: str = ""
    gap: float = 0.0
    after: float = 0.0
    block: str | None = None
    causes: tuple[Size, ...] = ()
    confidence: float | None = None
    shrink: float = 0.0
    seconds: float = 0.0

    @classmethod
    def of(cls, found: Found, diagnosis: Diagnosis) -> Entry:
        """Of a diagnosis."""
        sizes = tuple(
            Size(one.effect, first.name, first.unit, first.value, first.low, first.high)
            for one in diagnosis.causes
            for first in one.parameters[:1]
        )
        return cls(
            found.name,
            found.machine,
            diagnosis.series.start_ns,
            diagnosis.duration_s,
            diagnosis.verdict,
            "",
            diagnosis.misfit_before,
            diagnosis.misfit_after,
            diagnosis.block,
            sizes,
            min((one.confidence for one in diagnosis.causes), default=None),
            diagnosis.shrink,
            diagnosis.seconds,
        )

    def as_json(self) -> dict[str, Any]:
        """Plain data; `from_json` is the way back."""
        return asdict(self)

    @classmethod
    def from_json(cls, data: dict[str, Any]) -> Entry:
        """From `as_json`."""
        return cls(**{**data, "causes": tuple(Size(**one) for one in data["causes"])})

    @property
    def cause(self) -> str:
        """The titles of what is named."""
        return listed([words.title(one.effect) for one in self.causes])

    @property
    def size(self) -> str:
        """Their sizes."""
        return ", ".join(q.amount(one.value, one.unit) for one in self.causes)
