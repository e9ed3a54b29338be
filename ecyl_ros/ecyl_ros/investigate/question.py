"""What a diagnosis leaves open, and with that, whether there is anything left to find out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ..effects.catalogue import CATALOGUE
from ..gap.listed import listed
from ..gap.report import words
from ..plan.hypotheses import open_in

_UNDECIDED = ("unexplained", "partly_explained", "not_judgeable")
HEALTHY = ("no_gap", "within_sheet")
_MOST_NAMED = 3


@dataclass(frozen=True)
class Question:
    """What the next motion is to decide.

    Attributes:
        pairs: effects to tell from each other. alone: effects to show beside the sheet.
        known: their sizes, where the diagnosis has found one. signals: that were recorded.
        why: what is open, in one line.
    """

    pairs: tuple[tuple[str, str], ...]
    alone: tuple[str, ...]
    known: Mapping[str, Mapping[str, float]]
    signals: tuple[str, ...]
    why: str

    @property
    def asked(self) -> frozenset[object]:
        """The question without its reasons: what two of the same have in common."""
        return frozenset(self.pairs) or frozenset(self.alone)


def question(data: Mapping[str, Any]) -> Question | None:
    """What the JSON of a diagnosis leaves open; None where it has decided.

    Open are a cause with alternatives; a gap that no named cause closes; a recording that could not
    be judged; and, of a machine without a gap, effects that would not have shown in any size.
    """
    found = open_in(data)
    verdict = data["verdict"]
    if found.pairs:
        pairs = listed([_pair(one) for one in found.pairs[:_MOST_NAMED]])
        more = len(found.pairs) - _MOST_NAMED
        why = f"{pairs}{f' and {more} more pairs' if more > 0 else ''}: {found.why}"
        return Question(found.pairs, (), found.values, found.signals, why)
    if verdict in _UNDECIDED:
        why = data.get("reason") or f"{words.verdict(verdict).lower()}: no effect comes close"
        return Question((), tuple(CATALOGUE), found.values, found.signals, why)
    if verdict in HEALTHY:
        hidden = tuple(
            dict.fromkeys(
                one["effect"]
                for one in data.get("limits") or ()
                if one.get("smallest_seen") is None and one["effect"] in CATALOGUE
            )
        )
        if hidden:
            named = listed([words.title(one) for one in hidden[:_MOST_NAMED]])
            more = len(hidden) - _MOST_NAMED
            why = f"{named}{f' and {more} more' if more > 0 else ''} would not have shown at all"
            return Question((), hidden, {}, found.signals, why)
    return None


def _pair(names: tuple[str, str]) -> str:
    return f"{words.title(names[0])} or {words.title(names[1])}"
