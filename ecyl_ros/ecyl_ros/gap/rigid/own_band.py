"""A second look, in the band that the effort has, where nothing explains a wider one.

The compared band is wider than the effort's own where a recording is short, so that steps of
friction are seen in smooth motion, too. A machine is rigid up to some frequency: what swings above
the effort's band is then a gap beside which no cause shows.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from ...drive.rigid.machine import Machine
from ...errors import InputError
from ..diagnosis import Diagnosis
from ..judge.verdict import EXPLAINED_SHRINK
from .band import FEWEST_SAMPLES, effort_reach, leaving
from .motion import Motion

_NARROWER = 0.7  # of the compared band: else both are one
_SHORTEST = 16  # samples of a recording that have a spectrum


def looked_at_again(
    found: Diagnosis, motion: Motion, machine: Machine, again: Callable[[Machine], Diagnosis]
) -> Diagnosis:
    """A diagnosis, or in place of an unexplained gap that of the narrower band if it names causes.

    These have to close it there. What is left in the wider band stays unexplained; where there is
    no gap in the narrower one, a note says so. again: diagnoses with another machine's file.
    """
    if found.verdict != "unexplained" or machine.bandwidth_hz is not None:
        return found
    hertz = _own_band(motion)
    if hertz >= _NARROWER * motion.bandwidth_hz:
        return found
    try:
        second = again(replace(machine, bandwidth_hz=hertz))
    except InputError:
        return found
    if second.verdict in ("no_gap", "within_sheet"):
        note = (
            f"up to {hertz:.3g} Hz, where the {motion.effort_name} lies, there is no gap beyond "
            "the tolerances: what is unexplained is faster, as if parts are not rigid"
        )
        return replace(found, notes=(note, *found.notes))
    # Below what is not rigid the causes have to close the gap; else the band is not to blame.
    if not second.causes or second.shrink < EXPLAINED_SHRINK:
        return found
    note = (
        f"compared in the band of the {motion.effort_name}, up to {hertz:.3g} Hz: up to "
        f"{motion.bandwidth_hz:.3g} Hz nothing in the catalogue explains the gap, as if parts are "
        "not rigid there"
    )
    return replace(second, verdict="partly_explained", notes=(note, *second.notes))


def _own_band(motion: Motion) -> float:
    """Hz up to which nearly all of the effort lies, or that which leaves enough to compare."""
    fewest = leaving(FEWEST_SAMPLES, motion.usable.sum() / motion.rate_hz)
    reach = [
        effort_reach(motion.effort[one], motion.usable[one], motion.rate_hz)
        for one in motion.parts
        if motion.usable[one].sum() >= _SHORTEST
    ]
    return max([fewest, *reach])
