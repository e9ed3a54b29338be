"""The servo cascade: position, speed and current loop sampled in one control tick.

Integrals advance after use (forward Euler) and hold while the loop's own limit acts, which is the
anti-windup. The state is made of three: float64[3], integral of position error rad s, of speed
error rad, of current error A s; for a delayed measurement, what was measured before; and for what
looks back by one tick (filters, differences) what it remembers. The latter two are None where the
drive has no such thing, and the compiler drops it: a plain cascade does not pay for it.
"""

from __future__ import annotations

import math

import numpy as np

from .compiled import kernel
from .interpolation import interpolate_reference, reference_cubic

CascadeState = tuple[np.ndarray, np.ndarray | None, np.ndarray | None]

# What the memory holds of the last tick; NaN before the first.
COMMAND, COMMAND_RATE, LAST_RATE, LAST_ANGLE, SPEED, CURRENT = range(6)
MEMORY = 6

# A drive with any of these in its record, other than zero, has a memory.
_LOOKS_BACK = (
    "acceleration_feedforward",
    "position_to_current",
    "speed_by_differences",
    "setpoint_kept",
    "current_command_kept",
    "speed_kept",
    "position_kd",
)


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
def _filtered(memory, slot, value, kept):
    """First-order low-pass of `value`; see `filters.kept_share`."""
    if not math.isnan(memory[slot]):
        value = kept * memory[slot] + (1.0 - kept) * value
    memory[slot] = value
    return value


@kernel
def _speed_reading(memory, measured, p):
    """Speed as the loop learns of it, rad/s: measured, or the encoder's steps."""
    if memory is None:
        return measured[1]
    last = memory[LAST_ANGLE]
    memory[LAST_ANGLE] = measured[0]
    if not p.speed_by_differences:
        return measured[1]
    return 0.0 if math.isnan(last) else (measured[0] - last) / p.tick


@kernel
def _speed_feedback(memory, speed, p):
    """Speed after its filter, rad/s."""
    if memory is None:
        return speed
    return _filtered(memory, SPEED, speed, p.speed_kept)


@kernel
def _command(memory, reference, velocity, p):
    """The reference as the position loop sees it: (position m, velocity m/s, acceleration m/s^2).

    The filter acts on position and velocity alike, so that one stays the rate of the other; the
    acceleration is the step of the velocity since the last tick.
    """
    if memory is None:
        return reference, velocity, 0.0
    if math.isnan(memory[COMMAND]):  # a filter that starts at this position has it standing still
        memory[COMMAND_RATE] = 0.0
    reference = _filtered(memory, COMMAND, reference, p.setpoint_kept)
    velocity = _filtered(memory, COMMAND_RATE, velocity, p.setpoint_kept)
    last = memory[LAST_RATE]
    memory[LAST_RATE] = velocity
    return reference, velocity, 0.0 if math.isnan(last) else (velocity - last) / p.tick


@kernel
def _wanted_current(memory, integrals, error, velocity, acceleration, rotor_speed, p):
    """Current that position and speed loop ask for, A; advances their integrals.

    error: of position, rad at the rotor. velocity, acceleration: of the rod's command.
    """
    feedforward = p.velocity_feedforward * velocity * p.believed_rotor_per_rod
    if memory is None:
        speed, integrals[0] = _pi(
            error, integrals[0], p.position_kp, p.position_ki, feedforward, p.speed_limit, p.tick
        )
        current, integrals[1] = _pi(
            speed - rotor_speed, integrals[1], p.speed_kp, p.speed_ki, 0.0, p.current_limit, p.tick
        )
        return current
    rate_error = velocity * p.believed_rotor_per_rod - rotor_speed
    push = p.acceleration_feedforward * acceleration * p.believed_rotor_per_rod
    if p.position_to_current:
        push += p.position_kd * rate_error
        current, integrals[0] = _pi(
            error, integrals[0], p.position_kp, p.position_ki, push, p.current_limit, p.tick
        )
    else:
        feedforward += p.position_kd * rate_error
        speed, integrals[0] = _pi(
            error, integrals[0], p.position_kp, p.position_ki, feedforward, p.speed_limit, p.tick
        )
        error = speed - rotor_speed
        current, integrals[1] = _pi(
            error, integrals[1], p.speed_kp, p.speed_ki, push, p.current_limit, p.tick
        )
    return _filtered(memory, CURRENT, current, p.current_command_kept)


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
    integrals, history, memory = state
    speed = _speed_reading(memory, measured, p)
    position, rotor_speed = _delayed(history, position, speed, p)
    rotor_speed = _speed_feedback(memory, rotor_speed, p)
    reference, velocity, acceleration = _command(memory, reference, reference_velocity, p)
    error = reference * per_ratio - position
    current = _wanted_current(memory, integrals, error, velocity, acceleration, rotor_speed, p)
    error = current - measured[5]
    u_q, integrals[2] = _pi(
        error, integrals[2], p.current_kp, p.current_ki, 0.0, p.voltage_limit, p.tick
    )
    # Equation (3): with i_d = 0 the d axis needs only the decoupling voltage. It stands for a loop
    # that holds i_d whatever the inductance is: no wrong value of the data sheet shows in it.
    u_d = -p.pole_pairs * speed * p.inductance * measured[5]
    voltage[0] = min(max(u_d, -p.voltage_limit), p.voltage_limit)
    voltage[1] = u_q


@kernel
def cascade_tick(state, before, after, phase, every, measured, params, voltage):
    """Interpolate the reference at `phase` between two samples and run `cascade_step` on it.

    before, after: float64[2], neighbouring reference samples, `every` ticks apart. The other
    arguments are those of `cascade_step`.
    """
    cubic = reference_cubic(before, after, every * params[0].tick)
    position, velocity = interpolate_reference(phase, cubic)
    cascade_step(state, position, velocity, measured, params, voltage)


def looks_back(params: np.ndarray) -> bool:
    """Whether a drive's cascade has filters, differences or anything else that needs a memory."""
    return any(float(params[name][0]) != 0.0 for name in _LOOKS_BACK)


def initial_cascade_state(params: np.ndarray) -> CascadeState:
    """Cascade state with all integrals at zero and nothing measured before."""
    delay = float(params["measurement_delay"][0])
    history = np.full((math.floor(delay) + 2, 2), math.nan) if delay > 0.0 else None
    memory = None
    if looks_back(params):
        memory = np.full(MEMORY, math.nan)
        memory[CURRENT] = 0.0  # no current was asked for before
    return np.zeros(3), history, memory
