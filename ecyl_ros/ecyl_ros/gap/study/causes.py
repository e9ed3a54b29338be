"""What a catalogue calls the faults of a study, where they act, and what is as good a name."""

from __future__ import annotations

from typing import NamedTuple

from .cylinder.effects import EFFECTS


class Cause(NamedTuple):
    """A fault: its name in a catalogue, where it acts, names that are no error in its place."""

    name: str
    block: str
    akin: frozenset[str]


def cause_of(drives: str, effect: str) -> Cause:
    """The cause behind an effect's name in a label. drives: bench or random."""
    imposed = EFFECTS[effect]
    return Cause(imposed.twin or effect, imposed.block, imposed.akin)
