"""The servo cascade: position, speed and current PI loops sampled in one control tick.

Integrals advance after use (forward Euler) and hold while the loop's own limit acts, which is the
anti-windup. The state is a pair: float64[3], integral of position error rad s, of speed error rad,
of current error A s; and, for a delayed measurement, what was measured before, else None, for which
the compiler drops the delay.
"""

from __future__ import annotations

import math

import numpy as np

from .compiled import kernel
from .interpolation import interpolate_reference, reference_cubic

CascadeState = tuple[np.ndarray, np.ndarray | None]


@kernel
def _pi(error, integral, kp, ki, feedforward, limit, tick):
    """Return (limited output, new integral)."""
    output = kp * error + ki * integral + feedforward
    if output > limit:
        return limit, integral
    if output < -limit:
        return -limit, integral
    return output, integral + error * tick


@kernel
def _delayed(history, position, speed, p):
    """Position and speed `p.measurement_delay` ticks ago; before the first, the first.

    history: float64[ticks + 2, 2], the newest first, NaN where nothing was measured yet; None
    without a delay.
    """
    if history is None:
        return position, speed
    whole = history.shape[0] - 2
    part = p.measurement_delay - whole
    if math.isnan(history[0, 0]):  # first tick: as if at rest here for long
        for slot in range(whole + 2):
            history[slot, 0] = position
            history[slot, 1] = speed
    for slot in range(whole + 1, 0, -1):
        history[slot, 0] = history[slot - 1, 0]
        history[slot, 1] = history[slot - 1, 1]
    history[0, 0] = position
    history[0, 1] = speed
    return (
        (1.0 - part) * history[whole, 0] + part * history[whole + 1, 0],
        (1.0 - part) * history[whole, 1] + part * history[whole + 1, 1],
    )


@kernel
def cascade_step(state, reference, reference_velocity, measured, params, voltage):
    """One tick of the cascade: fills `voltage` (float64[2]: u_d, u_q in V).

    state: see `initial_cascade_state`. reference, reference_velocity: rod position m and its rate
    m/s wanted at this tick.
    measured: float64[>= 6] in the order of `plant.MEASURED`.
    """
    p = params[0]
    per_ratio = p.believed_rotor_per_rod
    position = measured[2] * per_ratio if p.feedback_rod else measured[0]
    rotor_speed = measured[1]
    integrals, history = state
    position, rotor_speed = _delayed(history, position, rotor_speed, p)
    error = reference * per_ratio - position
    feedforward = p.velocity_feedforward * reference_velocity * per_ratio
    speed, integrals[0] = _pi(
        error, integrals[0], p.position_kp, p.position_ki, feedforward, p.speed_limit, p.tick
    )
    current, integrals[1] = _pi(
        speed - rotor_speed, integrals[1], p.speed_kp, p.speed_ki, 0.0, p.current_limit, p.tick
    )
    error = current - measured[5]
    u_q, integrals[2] = _pi(
        error, integrals[2], p.current_kp, p.current_ki, 0.0, p.voltage_limit, p.tick
    )
    # Equation (3): with i_d = 0 the d axis needs only the decoupling voltage.
    u_d = -p.pole_pairs * measured[1] * p.believed_inductance * measured[5]
    voltage[0] = min(max(u_d, -p.voltage_limit), p.voltage_limit)
    voltage[1] = u_q


@kernel
def cascade_tick(state, before, after, phase, every, cubic, measured, params, voltage):
    """Interpolate the reference at `phase` between two samples and run `cascade_step` on it.

    before, after: float64[2], neighbouring reference samples, `every` ticks apart. cubic:
    float64[CUBIC], scratch. The other arguments are those of `cascade_step`.
    """
    reference_cubic(before, after, every * params[0].tick, cubic)
    position, velocity = interpolate_reference(phase, cubic)
    cascade_step(state, position, velocity, measured, params, voltage)


def initial_cascade_state(params: np.ndarray) -> CascadeState:
    """Cascade state with all integrals at zero and nothing measured before."""
    delay = float(params["measurement_delay"][0])
    history = np.full((math.floor(delay) + 2, 2), math.nan) if delay > 0.0 else None
    return np.zeros(3), history
