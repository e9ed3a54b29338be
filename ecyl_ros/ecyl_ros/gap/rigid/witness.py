"""What the motion says of causes that the balance of efforts has named.

Where something that is not recorded moves the output (the other joint of an arm), its acceleration
is in the balance without an effort, and an inertia next to nothing balances it best. What is left
of the effort is small then; over that inertia, it is as much acceleration that nothing explains.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

from ...effects.term import Term
from ..judge.verdict import STRUCTURELESS, in_words
from .balance import Balance
from .floor import white_part
from .replay import Replay
from .ruling import Ruling
from .solution import Solution

_FAR = 2.0  # times the gap that a signal has with the causes: as much again refutes them


def borne_out(ruling: Ruling, terms: Sequence[Term], balance: Balance) -> tuple[Ruling, str]:
    """The ruling, and a note where it is another than before; terms: of its causes.

    Causes that lighten the output and leave no less acceleration unexplained are none. White noise
    is no acceleration.
    """
    if not (ruling.named and any(one.inertia for one in terms)):
        return ruling, ""
    nominal, found = ruling.base.inertia(balance.model), ruling.final.inertia(balance.model)
    if not found < nominal:
        return ruling, ""

    def structure(fit: Solution, left: float) -> float:
        return math.sqrt(max(left**2 - white_part(balance, fit) ** 2, 0.0))

    before, after = structure(ruling.base, ruling.before), structure(ruling.final, ruling.after)
    if not after * nominal >= before * found:
        return ruling, ""
    titles = ", ".join(dict.fromkeys(one.title for one in ruling.causes))
    return _without_causes(ruling), (
        f"closest in the catalogue is {titles}: not named, because it lightens the output and "
        "leaves no less acceleration unexplained"
    )


def _without_causes(ruling: Ruling) -> Ruling:
    return dataclasses.replace(
        ruling,
        verdict="unexplained",
        causes=(),
        final=ruling.base,
        after=ruling.before,
        shrink=0.0,
    )


def refuted(ruling: Ruling, played: Replay, *, silent: bool) -> tuple[Ruling, str]:
    """The ruling in the light of its replay, and a note where it is another than before.

    Causes that take a signal further away again than it was are none. silent: the replay says
    nothing of them: a sine of time is among them (see `heard`), or it runs away without them.
    """
    if not ruling.named or silent:
        return ruling, ""
    off = [
        one for one in played.signals if one.after > max(_FAR * one.gap, STRUCTURELESS * one.floor)
    ]
    if not off:
        return ruling, ""
    titles = ", ".join(dict.fromkeys(one.title for one in ruling.causes))
    names = in_words([one.name for one in off])
    return _without_causes(ruling), (
        f"closest in the catalogue, but in the replay with it the {names} is more than "
        f"{_FAR:g} times as far off as without: {titles}"
    )


def heard(ruling: Ruling, played: Replay, *, over_time: bool) -> tuple[Ruling, str]:
    """The ruling in the light of its replay, and a note where it is another than before.

    With a signal that is further off than without the causes, the gap is not explained as a whole.

    over_time: one of them is a sine of time. Its phase, in several recordings one in each, is not
    known as well as its size, and so a replay says little of it.
    """
    if ruling.verdict != "explained" or over_time:
        return ruling, ""
    worse = [one for one in played.signals if one.after > max(one.gap, STRUCTURELESS * one.floor)]
    if not worse:
        return ruling, ""
    names = in_words([one.name for one in worse])
    note = f"in the replay with the named causes the {names} is further off than without them"
    return dataclasses.replace(ruling, verdict="partly_explained"), note
