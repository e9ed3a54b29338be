"""Dry friction as a bristle that bends before it slips (Dahl's law on a level that may vary).

The contact resists with at most its *level*, N m, which effects give as a function of speed,
torque, place or time. The bristle's deflection, as a share of the one at which it slips, follows

    dz/dt = (v - |v| z) / d

with v the speed and d the breakaway deflection, rad; the torque is level x (z + c dz/dt). For a
speed held over a step this has a closed solution, so the stiff case (fast motion, z at once at its
end) costs no small steps.
"""

from __future__ import annotations

import math

from .compiled import kernel

# Unless an effect says otherwise: at the rotor; presliding of rolling contacts is some micrometres.
BREAKAWAY_RAD = 1e-4
BRISTLE_DAMPING_S = 2e-4  # c, lets the swing of an inertia on the bristle settle


@kernel
def deflected(z, speed, time, breakaway):
    """Bristle deflection `time` s after `z` at constant `speed` rad/s; breakaway: d, rad."""
    if time == 0.0:
        return z
    end = 1.0 if speed > 0.0 else -1.0
    pace = abs(speed) * time * (1.0 / breakaway)
    if pace > 30.0:
        return end
    return end + (z - end) * math.exp(-pace)


@kernel
def friction_torque(z, speed, time, level, breakaway, damping):
    """Torque against the motion, N m, `time` s into a step that began with deflection `z`."""
    now = deflected(z, speed, time, breakaway)
    rate = (speed - abs(speed) * now) * (1.0 / breakaway)
    return level * (now + damping * rate)
