"""What an investigation did and found, motion by motion: plain data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from ..gap.diagnosis import Diagnosis
from ..plan.make import Plan
from .bounds import Bounds
from .played import Played
from .question import Question

DECIDED, OPEN, ENDED = "decided", "open", "ended"
SCHEMA = "ecyl.investigation/1"


@dataclass(frozen=True, eq=False)
class Step:
    """One motion.

    Attributes:
        number: from 1 on. why: what was open, in one line. duration_s: of the motion.
        motion: its file. played: what came of it. bounds: that it was held to.
        plan: how it was found; None for the first, which asks for nothing in particular.
        diagnosis: of the recordings until then; None where it was not played to its end.
        sentence: that diagnosis in words. left: what it leaves open; None where it decides.
    """

    number: int
    why: str
    duration_s: float
    motion: Path
    played: Played
    bounds: Bounds
    plan: Plan | None = None
    diagnosis: Diagnosis | None = None
    sentence: str = ""
    left: Question | None = None

    @property
    def stem(self) -> str:
        """What its files are called."""
        return self.motion.stem

    def as_json(self) -> dict[str, Any]:
        """Plain data."""
        found = self.diagnosis
        return {
            "motion": self.motion.name,
            "why": self.why,
            "duration_s": self.duration_s,
            "recording": None if self.played.recording is None else self.played.recording.name,
            "samples": self.played.samples,
            "error_m": {"largest": self.played.error_m, "bound": self.bounds.error_m},
            "current_a": {"largest": self.played.current_a, "bound": self.bounds.current_a},
            "ended": self.played.ended,
            "at_rest": self.played.at_rest,
            "missed_ticks": self.played.missed_ticks,
            "separations": self._separations(),
            "verdict": None if found is None else found.verdict,
            "causes": [] if found is None else [one.effect for one in found.causes],
            "left_open": None if self.left is None else self.left.why,
        }

    def _separations(self) -> list[dict[str, Any]]:
        if self.plan is None:
            return []
        return [
            {
                "effects": [pair.first.effect, pair.second.effect],
                "predicted": self.plan.predictions[0].apart[row],
                "needed": self.plan.needed,
            }
            for row, pair in enumerate(self.plan.pairs)
        ]


@dataclass(frozen=True, eq=False)
class Story:
    """The whole of it.

    Attributes:
        drive: the nominal model's file. machine: what was moved.
        outcome: `decided`, `open` (the budget is spent, or no motion would tell more) or `ended`
            (the drive was brought to rest); said: which of these, with the reason.
        steps: in order.
    """

    drive: str
    machine: str
    outcome: str = OPEN
    said: str = ""
    steps: Sequence[Step] = field(default_factory=tuple)

    def and_then(self, step: Step) -> Story:
        """The story with one more motion."""
        return replace(self, steps=(*self.steps, step))

    def closed(self, outcome: str, said: str) -> Story:
        """The story with its end."""
        return replace(self, outcome=outcome, said=said)

    @property
    def last(self) -> Step | None:
        """The last motion that was diagnosed."""
        return next((one for one in reversed(self.steps) if one.diagnosis is not None), None)

    def as_json(self) -> dict[str, Any]:
        """Plain data, schema `ecyl.investigation/1`."""
        return {
            "schema": SCHEMA,
            "drive": self.drive,
            "machine": self.machine,
            "outcome": self.outcome,
            "reason": self.said,
            "steps": [one.as_json() for one in self.steps],
        }
