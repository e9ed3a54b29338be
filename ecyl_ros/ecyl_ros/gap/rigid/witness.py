"""A replay as a second witness of causes that the balance of efforts has named.

Where something that is not recorded moves the output (the other joint of an arm), its acceleration
is in the balance without an effort, and an inertia next to nothing balances it best. A machine of
that inertia does not move like the one recorded.
"""

from __future__ import annotations

import dataclasses

from ..verdict import STRUCTURELESS
from .judge import Ruling
from .replay import Replay


def heard(ruling: Ruling, played: Replay, *, over_time: bool) -> tuple[Ruling, str]:
    """The ruling in the light of its replay, and what a note is to say of it.

    Causes with which no signal that is off comes nearer to the recording are none. With a signal
    that is further off than without them, the gap is not explained as a whole.

    over_time: one of them is a sine of time. Its phase, in several recordings one in each, is not
    known as well as its size, and so a replay says little of it.
    """
    if not ruling.named or over_time:
        return ruling, ""
    off = [one for one in played.signals if one.gap > STRUCTURELESS * one.floor]
    if off and all(one.after >= one.gap for one in off):
        titles = ", ".join(dict.fromkeys(one.title for one in ruling.causes))
        refuted = dataclasses.replace(
            ruling,
            verdict="unexplained",
            causes=(),
            final=ruling.base,
            after=ruling.before,
            shrink=0.0,
        )
        return refuted, (
            f"closest in the catalogue, but replayed with it the machine comes no nearer to the "
            f"recording: {titles}"
        )
    worse = [one for one in played.signals if one.after > max(one.gap, STRUCTURELESS * one.floor)]
    if ruling.verdict == "explained" and worse:
        names = " and ".join(one.name.replace("_", " ") for one in worse)
        note = f"replayed with what is named, the {names} comes out further off than without"
        return dataclasses.replace(ruling, verdict="partly_explained"), note
    return ruling, ""
