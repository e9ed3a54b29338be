"""The block a gap lies in where no cause is named: what gives the gap away, step by step.

Each block's own equation, fed with what was measured at its ports, holds for a healthy block
whatever the loop does. So a balance that does not hold names its block, or says at least which
blocks are out of the question. Among those left decide a limit that is seen to hold, what the gap
goes with, the side of the clearance on which missing torque acts, and last the nearest effect.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

from ...effects.catalogue import CATALOGUE
from ...effects.effect import BLOCKS
from ..compete.competition import Competition
from ..diagnosis import PortCheck
from ..replay.evidence import gather
from ..replay.replay import Replay
from .controller_port import delay_restores
from .injection import acts_on_load
from .signature import (
    goes_along_stroke,
    goes_with_acceleration,
    goes_with_carried_torque,
    goes_with_current,
    goes_with_current_reading,
    goes_with_encoder,
    limit_reached,
)

# Levels over the floor from which a balance counts as broken: `typical`, which impacts do not lift,
# and RMS. A healthy drive shows 1.0 to 2.5 (electrical), 1.5 and 1.0; see
# benchmarks/controller_port.py for the controller's.
_ELECTRICAL, _TORQUE, _ROD = 4.5, 2.6, 1.9
CONTROLLER_BROKEN = 1.5
_TORQUE_AT_TIMES = 60.0  # RMS: seldom, but then by far
_LIMIT_AT_TIMES = 10.0
_FLANK_MOVED, _FLANK_STAYED = 3.0, 1.5  # RMS of rod against rotor: a load moves the load
_MOVED = 2.0  # RMS of the same where no torque is missing
_NO_HELP = 0.8  # of the cost of the sheet alone: an effect that leaves more is not on the way
_READING = 0.9  # share of the missing torque that a wrong reading of the current would make
_CONSTANT = 0.99  # the same of a wrong torque constant
# The same of a friction that grows with what it carries, and of a force that only rises or falls
# along the stroke; others stay below 0.75.
_CARRIED = 0.85


def possible_blocks(ports: Sequence[PortCheck]) -> Collection[str]:
    """Blocks that the port checks leave possible; all where they say nothing."""
    typical = {one.block: one.typical_ratio for one in ports}
    rms = {one.block: one.ratio for one in ports}
    if typical.get("controller", 0.0) > CONTROLLER_BROKEN:
        return ("timing", "controller")
    needed = ("motor_electrical", "motor_mechanical", "transmission")
    if any(name not in typical for name in needed):
        return BLOCKS
    electrical, torque, rod = (typical[name] for name in needed)
    if electrical > _ELECTRICAL and electrical > 0.4 * torque:
        # A wrong current reading breaks both balances, each as far as the other.
        return ("sensor",) if torque > _TORQUE and torque > 0.4 * electrical else needed[:1]
    if torque > _TORQUE or rms["motor_mechanical"] > _TORQUE_AT_TIMES:
        if rms["transmission"] > _FLANK_MOVED:
            return ("load",)
        turning = ("motor_mechanical", "motor_electrical")
        return turning if rms["transmission"] < _FLANK_STAYED else ("load", *turning)
    if rod > _ROD:
        return ("transmission", "sensor")
    if rms["motor_mechanical"] > _LIMIT_AT_TIMES:
        return ("controller", "transmission")
    return ("timing", "transmission", "controller")


def unnamed_block(
    competition: Competition, ports: Sequence[PortCheck], replay: Replay
) -> str | None:
    """The block that the gap most likely lies in."""
    possible = possible_blocks(ports)
    best = _best_by_block(competition)
    if set(possible) == set(BLOCKS):
        return min(best, key=lambda block: best[block]) if best else None
    if "controller" in possible and limit_reached(replay):
        return "controller"
    if set(possible) == {"timing", "controller"}:
        return "timing" if delay_restores(replay, CONTROLLER_BROKEN) else "controller"
    evidence = gather(replay, {})
    (rod,) = (one for one in ports if one.block == "transmission")
    if rod.typical_ratio > _ROD and goes_with_encoder(evidence, rod.floor):
        return "sensor"
    if tuple(possible) == ("sensor",) and goes_with_current_reading(evidence) < _READING:
        possible = ("load", "motor_mechanical", "motor_electrical")
    at_times = tuple(possible) == ("controller", "transmission")  # torque, and no limit holds
    if at_times or {"load", "motor_mechanical"} & set(possible):
        inertia = goes_with_acceleration(evidence)
        if goes_with_current(evidence) > max(_CONSTANT, inertia):
            return "motor_electrical"
        if goes_with_carried_torque(evidence) > _CARRIED:
            return "load"
        if goes_along_stroke(evidence) > max(_CARRIED, inertia):
            return "load"
        on_load = acts_on_load(replay)
        if on_load is not None:
            return "load" if on_load else "motor_mechanical"
        possible = [block for block in possible if block != "motor_electrical"]
    moved = set(possible) == {"transmission", "sensor"} or rod.ratio > _MOVED
    if at_times or (moved and "transmission" in possible):
        return "transmission"
    # No limit holds, and the controller's own equation does: what is left of it is its timing, and
    # a delay of any kind would take something off.
    tried = [block for block in possible if block in best and block != "controller"]
    if "transmission" in tried and best.get("timing", 0.0) > _NO_HELP * competition.sheet.judged:
        return "transmission"
    return min(tried, key=lambda block: best[block]) if tried else next(iter(possible), None)


def _best_by_block(competition: Competition) -> Mapping[str, float]:
    """The least misfit of an effect of each block."""
    best: dict[str, float] = {}
    for one in competition.singles:
        block = CATALOGUE[one.names[0]].block
        best[block] = min(best.get(block, one.judged), one.judged)
    return best
