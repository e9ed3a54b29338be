"""What a catalogue calls the faults of a study, where they act, and what is as good a name."""

from __future__ import annotations

from typing import NamedTuple

from ...effects.catalogue import CATALOGUE
from .cylinder.effects import EFFECTS
from .rigid.faults import AKIN, STRANGE


class Cause(NamedTuple):
    """A fault: its name in a catalogue, where it acts, names that are no error in its place."""

    name: str
    block: str
    akin: frozenset[str]


def cause_of(drives: str, effect: str) -> Cause:
    """The cause behind an effect's name in a label. drives: bench, random or rigid."""
    if drives == "rigid":
        known = CATALOGUE.get(effect)
        block = known.block if known else STRANGE.get(effect, "load")
        return Cause(effect, block, frozenset(AKIN.get(effect, ())))
    imposed = EFFECTS[effect]
    return Cause(imposed.twin or effect, imposed.block, imposed.akin)
