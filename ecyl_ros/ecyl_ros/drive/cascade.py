"""The servo cascade: position, speed and current PI loops sampled in one control tick.

Integrals advance after use (forward Euler) and hold while the loop's own limit acts, which is the
anti-windup. State vector (float64[3]): integral of position error rad s, of speed error rad, of
current error A s.
"""

from __future__ import annotations

import numpy as np

from .compiled import kernel
from .interpolation import interpolate_reference

CASCADE_STATE_SIZE = 3


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
def cascade_step(state, reference, reference_velocity, measured, params, voltage):
    """One tick of the cascade: fills `voltage` (float64[2]: u_d, u_q in V).

    reference, reference_velocity: rod position m and its rate m/s wanted at this tick.
    measured: float64[>= 6] in the order of `plant.MEASURED`.
    """
    p = params[0]
    position = measured[2] / p.rod_per_rotor if p.feedback_rod else measured[0]
    error = reference / p.rod_per_rotor - position
    feedforward = p.velocity_feedforward * reference_velocity / p.rod_per_rotor
    speed, state[0] = _pi(
        error, state[0], p.position_kp, p.position_ki, feedforward, p.speed_limit, p.tick
    )
    current, state[1] = _pi(
        speed - measured[1], state[1], p.speed_kp, p.speed_ki, 0.0, p.current_limit, p.tick
    )
    u_q, state[2] = _pi(
        current - measured[5], state[2], p.current_kp, p.current_ki, 0.0, p.voltage_limit, p.tick
    )
    # Equation (3): with i_d = 0 the d axis needs only the decoupling voltage.
    u_d = -p.pole_pairs * measured[1] * p.inductance * measured[5]
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
    """Cascade state with all integrals at zero."""
    return np.zeros(CASCADE_STATE_SIZE)
