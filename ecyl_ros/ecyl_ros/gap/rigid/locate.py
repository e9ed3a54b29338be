"""Where the gap of a rigid drive lies: by condition, by frequency and by block."""

from __future__ import annotations

import numpy as np
from scipy.signal import welch

from ...effects.along import Along
from ..diagnosis import ConditionShare, PortCheck
from ..locate.conditions import near_reversal, shares, strongest_lines
from .balance import Balance
from .noise import effort_noise
from .solution import Solution


def by_condition(balance: Balance, along: Along, base: Solution) -> tuple[ConditionShare, ...]:
    """Shares of the energy of what `base` leaves under the conditions of motion."""
    motion, rows = balance.motion, balance.usable
    energy = base.residual[rows] ** 2
    if float(energy.sum()) <= 0.0:
        return ()
    at = motion.rows
    speed, top = motion.velocity[at], along.top_speed
    near = near_reversal(speed, float(np.median(np.diff(balance.time_s))))
    near &= along.both_ways  # noise of a speed at rest changes its sign, too
    hard = np.abs(motion.acceleration[at])
    level = np.abs(balance.effort)
    masks = {
        "reversal": near,
        "rest": np.abs(speed) < 0.01 * top,
        "low_speed": (np.abs(speed) < 0.05 * top) & ~near,
        "high_speed": np.abs(speed) > 0.5 * top,
        "acceleration": hard > 0.5 * float(np.quantile(hard[rows], 0.995)),
        "high_torque": level > 0.5 * float(np.quantile(level[rows], 0.995)),
    }
    if along.both_ways:
        masks |= {"forwards": speed > along.soft, "backwards": speed < -along.soft}
    mode = motion.mode[at]
    values = np.unique(mode[rows & np.isfinite(mode)])
    if 1 < values.size <= 8:
        masks |= {f"mode_{value:g}": mode == value for value in values.tolist()}
    over = {"position": motion.position[at][rows], "time": balance.time_s[rows]}
    return shares(
        energy, {name: mask[rows] for name, mask in masks.items() if mask[rows].any()}, over
    )


def by_frequency(balance: Balance, base: Solution) -> tuple[float, ...]:
    """Hz of the strongest lines of what `base` leaves."""
    rate = balance.motion.rate_hz / balance.motion.step
    values = np.where(balance.usable, base.residual, 0.0)
    frequency, density = welch(values, rate, nperseg=min(values.size, int(4.0 * rate)))
    return strongest_lines(frequency, density, 4.0 * float(np.median(density)))


def by_port(
    balance: Balance, along: Along, before: float, floor: float, spread: float
) -> tuple[PortCheck, ...]:
    """The output's own balance, and the controller where its effort was recorded, too.

    before: RMS of what the nominal model leaves, `floor` of that. spread: of the effort.
    """
    motion = balance.motion
    side = "load" if along.machine.linear else "motor_mechanical"
    what = "effort minus what the motion needs"
    found = [PortCheck(side, what, motion.effort_unit, before, floor)]
    both = np.isfinite(motion.other_effort)
    if both.any():
        other = np.interp(motion.time_s, motion.time_s[both], motion.other_effort[both])
        left = motion.filtered(motion.effort - other)[balance.usable]
        white = max(effort_noise(balance.motion), 1e-3 * spread)
        what = "recorded effort against the command of the loop"
        rms = float(np.sqrt(np.mean(left**2)))
        found.insert(0, PortCheck("controller", what, motion.effort_unit, rms, white))
    return tuple(found)
