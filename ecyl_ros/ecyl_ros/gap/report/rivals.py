"""What came second: sets of effects that are true rivals of what is named."""

from __future__ import annotations

from collections.abc import Collection

from ...effects.catalogue import CATALOGUE
from ..diagnosis import Candidate, Diagnosis


def contains(effects: Collection[str], named: Collection[str]) -> bool:
    """Whether a set holds all that is named, itself or as a special case of a finer effect.

    Such a set cannot fit worse by much, and fits better only by its freedom: it is no rival.
    """
    finer = {simple for one in effects if one in CATALOGUE for simple in CATALOGUE[one].refines}
    return bool(named) and all(one in effects or one in finer for one in named)


def runner_up(diagnosis: Diagnosis) -> Candidate | None:
    """The best set that could take the place of what is named; None where there is none."""
    named = {one.effect for one in diagnosis.causes}
    rivals = [
        one for one in diagnosis.candidates if one.effects and not contains(one.effects, named)
    ]
    return min(rivals, key=lambda one: one.judged, default=None) if named else None
