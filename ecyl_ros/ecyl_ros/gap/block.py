"""The block a gap lies in where no cause is named: port checks first, then the nearest effects.

Each block's own equation, fed with what was measured at its ports, holds for a healthy block
whatever the loop does. So a balance that does not hold names its block, or says at least which
blocks are out of the question; among those left the effect that fits best decides.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

from ..effects.catalogue import CATALOGUE
from ..effects.effect import BLOCKS
from .attribute import Competition
from .diagnosis import PortCheck

# Levels over the floor from which a balance counts as broken: `typical`, which impacts do not lift,
# and RMS. A healthy drive shows 1.0 to 2.5 (electrical), 1.5, 2.0 (controller) and 1.0.
_ELECTRICAL, _TORQUE, _CONTROLLER, _ROD = 4.5, 2.6, 2.4, 1.9
_TORQUE_AT_TIMES = 60.0  # RMS: seldom, but then by far
_LIMIT_AT_TIMES = 10.0
# The electrical effects that leave the voltage balance whole and break the torque balance.
_TORQUE_ONLY = ("torque_constant_error",)
_FLANK_MOVED, _FLANK_STAYED = 3.0, 1.5  # RMS of rod against rotor: a load moves the load


def possible_blocks(ports: Sequence[PortCheck]) -> Collection[str]:
    """Blocks that the port checks leave possible; all where they say nothing."""
    typical = {one.block: one.typical_ratio for one in ports}
    rms = {one.block: one.ratio for one in ports}
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
    if typical.get("controller", 0.0) > _CONTROLLER:
        return ("timing", "controller")
    if rms["motor_mechanical"] > _LIMIT_AT_TIMES:
        return ("controller", "transmission")
    return ("timing", "transmission", "controller")


def unnamed_block(competition: Competition, ports: Sequence[PortCheck]) -> str | None:
    """The block that the gap most likely lies in."""
    possible = possible_blocks(ports)
    torque = "motor_mechanical" in possible and len(possible) < len(BLOCKS)
    best = _best_by_block(competition, torque)
    if len(possible) == 1:
        return next(iter(possible))
    tried = [block for block in possible if block in best]
    return min(tried, key=lambda block: best[block]) if tried else None


def _best_by_block(competition: Competition, torque: bool) -> Mapping[str, float]:
    """The least misfit of an effect of each block; torque: of those that act on torque."""
    best: dict[str, float] = {}
    for one in competition.singles:
        block = CATALOGUE[one.names[0]].block
        if torque and block == "motor_electrical" and one.names[0] not in _TORQUE_ONLY:
            continue
        best[block] = min(best.get(block, one.judged), one.judged)
    return best
