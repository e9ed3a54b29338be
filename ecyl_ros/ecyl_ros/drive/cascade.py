"""The servo cascade: position, speed and current PI loops sampled in one control tick.

Integrals advance after use (forward Euler) and hold while the loop's own limit acts, which is the
anti-windup. State vector (float64[CASCADE_STATE_SIZE]): integral of position error rad s, of speed
error rad, of current error A s; then, for a delayed measurement, what was measured before.
"""

from __future__ import annotations

import math

import numpy as np

from .compiled import kernel
from .interpolation import interpolate_reference

# Behind the integrals: how many measurements are held, and the latest positions and speeds.
MAX_MEASUREMENT_DELAY_TICKS = 510
_HELD = 3
_HISTORY = 4
_KEPT = MAX_MEASUREMENT_DELAY_TICKS + 2
CASCADE_STATE_SIZE = _HISTORY + 2 * _KEPT


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
def _delayed(state, position, speed, p):
    """Position and speed `p.measurement_delay` ticks ago; before the first, the first."""
    whole = math.floor(p.measurement_delay)
    part = p.measurement_delay - whole
    if state[_HELD] == 0.0:  # first tick: as if at rest here for long
        for slot in range(whole + 2):
            state[_HISTORY + 2 * slot] = position
            state[_HISTORY + 2 * slot + 1] = speed
        state[_HELD] = 1.0
    for slot in range(whole + 1, 0, -1):
        state[_HISTORY + 2 * slot] = state[_HISTORY + 2 * slot - 2]
        state[_HISTORY + 2 * slot + 1] = state[_HISTORY + 2 * slot - 1]
    state[_HISTORY] = position
    state[_HISTORY + 1] = speed
    late, later = _HISTORY + 2 * whole, _HISTORY + 2 * whole + 2
    return (
        (1.0 - part) * state[late] + part * state[later],
        (1.0 - part) * state[late + 1] + part * state[later + 1],
    )


@kernel
def cascade_step(state, reference, reference_velocity, measured, params, voltage):
    """One tick of the cascade: fills `voltage` (float64[2]: u_d, u_q in V).

    reference, reference_velocity: rod position m and its rate m/s wanted at this tick.
    measured: float64[>= 6] in the order of `plant.MEASURED`.
    """
    p = params[0]
    ratio = p.believed_rod_per_rotor
    position = measured[2] / ratio if p.feedback_rod else measured[0]
    rotor_speed = measured[1]
    if p.measurement_delay > 0.0:
        position, rotor_speed = _delayed(state, position, rotor_speed, p)
    error = reference / ratio - position
    feedforward = p.velocity_feedforward * reference_velocity / ratio
    speed, state[0] = _pi(
        error, state[0], p.position_kp, p.position_ki, feedforward, p.speed_limit, p.tick
    )
    current, state[1] = _pi(
        speed - rotor_speed, state[1], p.speed_kp, p.speed_ki, 0.0, p.current_limit, p.tick
    )
    u_q, state[2] = _pi(
        current - measured[5], state[2], p.current_kp, p.current_ki, 0.0, p.voltage_limit, p.tick
    )
    # Equation (3): with i_d = 0 the d axis needs only the decoupling voltage.
    u_d = -p.pole_pairs * measured[1] * p.believed_inductance * measured[5]
    voltage[0] = min(max(u_d, -p.voltage_limit), p.voltage_limit)
    voltage[1] = u_q


@kernel
def cascade_tick(state, before, after, phase, every, measured, params, wanted, voltage):
    """Interpolate the reference at `phase` between two samples and run `cascade_step` on it.

    before, after: float64[2], neighbouring reference samples, `every` ticks apart. wanted:
    float64[2] scratch. The other arguments are those of `cascade_step`.
    """
    interpolate_reference(phase, every * params[0].tick, before, after, wanted)
    cascade_step(state, wanted[0], wanted[1], measured, params, voltage)


def initial_cascade_state() -> np.ndarray:
    """Cascade state with all integrals at zero and nothing measured before."""
    return np.zeros(CASCADE_STATE_SIZE)
