"""What a judgement of a rigid drive comes to: the verdict, the causes, and the figures of both."""

from __future__ import annotations

from dataclasses import dataclass

from ..diagnosis import Cause
from .solution import Solution


@dataclass(frozen=True, eq=False)
class Ruling:
    """What a judgement comes to.

    Attributes:
        verdict: one of `VERDICTS`. causes: one per term of the contest, empty unless named.
        base, final: fits of what the file knows, and of what is named with it.
        before, after, best: RMS of what is left on held-out stretches by `base`, by `final`, and by
            the closest set, named or not. shrink: share of what stands above the floor.
        margin: the best rival's RMS over the closest set's. reason: of `not_judgeable`, what
            recording would do.
        undecided: what would tell apart what was found beside what is named.
    """

    verdict: str
    causes: tuple[Cause, ...]
    base: Solution
    final: Solution
    before: float
    after: float
    best: float
    shrink: float
    margin: float
    reason: str = ""
    undecided: str = ""

    @property
    def named(self) -> bool:
        """Whether causes are named."""
        return bool(self.causes)

    @property
    def said_undecided(self) -> str:
        """The note of what is undecided, whether or not what was named beside it still is."""
        return f"not decided{' beside what is named' if self.named else ''}: {self.undecided}"
