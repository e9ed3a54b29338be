"""What a description says: the data behind words, JSON and pictures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ...arrays import BoolArray, FloatArray
from ...drive.law import Law


@dataclass(frozen=True, eq=False)
class Resembled:
    """The named effect that comes nearest.

    Attributes:
        effect: its name. misfit: in noise floors, held out. law_misfit: the law's.
        curve: float64[2, k], what it gives over the law's variable, at the law's port; None for a
            law that has not one variable.
    """

    effect: str
    misfit: float
    law_misfit: float
    curve: FloatArray | None = None


@dataclass(frozen=True, eq=False)
class Course:
    """The missing quantity over time, at the recording's samples.

    values: float64[n], in `unit`. half: half the width of its 95 % band. known: bool[n], elsewhere
    it cannot be known. predicted: float64[n], what the law gives there.
    """

    time_s: FloatArray
    values: FloatArray
    half: float
    known: BoolArray
    predicted: FloatArray
    unit: str


@dataclass(frozen=True, eq=False)
class Description:
    """A cause that the library lacks.

    Attributes:
        law: as a drive file takes it. half: float64[values], half the width of its 95 % band.
        seen: bool[values], the places that were visited.
        shrink: share of the gap that it removes on stretches that it was not fitted to.
        formula: the simplest that does as well; None where none does.
        words: in words, without article's capital or full stop.
        chance: probability of finding so good a law where there is none.
        next_best: the variables that predict nearly as well, and how much worse: the ratio of their
            errors of prediction. ports: other ports that the recording cannot tell from its own.
        turns: how often each variable that repeats itself went round.
        resembles: the nearest named effect; None where none was tried.
        in_balance: whether it was held against a balance of efforts, not played in closed loop.
        course: the missing quantity. points: float64[variables + 1, m], what the law was read from:
            its variables, and the missing quantity at the port.
    """

    law: Law
    half: FloatArray
    seen: BoolArray
    shrink: float
    formula: str | None
    words: str
    chance: float
    next_best: tuple[tuple[tuple[str, ...], float], ...]
    ports: tuple[str, ...]
    turns: dict[str, float]
    resembles: Resembled | None
    course: Course
    points: FloatArray
    in_balance: bool = False

    def as_json(self) -> dict[str, Any]:
        """Plain data, as the contract has `law`."""
        law = self.law
        table: dict[str, Any] = {"values": list(law.values), "half_95": self.half.tolist()}
        table["seen"] = [bool(one) for one in self.seen]
        for number, places in enumerate(law.at):
            table["at" if number == 0 else "at_2"] = list(places)
        return {
            "port": law.port,
            "of": list(law.of),
            "units": list(law.units),
            "unit": law.unit,
            "period": list(law.periods),
            "time_constant_s": law.time_constant_s,
            "shrink": self.shrink,
            "formula": self.formula,
            "words": self.words,
            "chance": self.chance,
            "next_best": [{"of": list(of), "error": worse} for of, worse in self.next_best],
            "ports_alike": list(self.ports),
            "turns": self.turns,
            "resembles": None
            if self.resembles is None
            else {
                "effect": self.resembles.effect,
                "misfit": self.resembles.misfit,
                "law_misfit": self.resembles.law_misfit,
            },
            "table": table,
        }
