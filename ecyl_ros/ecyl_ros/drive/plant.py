"""The plant: motor, backlash transmission and load, advanced one control tick at a time.

State vector (float64[STATE_SIZE]): rotor angle rad, rotor speed rad/s, load angle rad (at the
rotor), load speed rad/s, i_d A, i_q A; then what only effects look at: the bristle deflections of
rotor and load friction, the count of ticks since the start, and the memory of a learned law (heat
A^2, travel since the last reversal rad, both held within a tick). Between contacts the equations
are smooth and a classical fourth-order Runge-Kutta step is used; where a flank meets or leaves, or
a stiffness segment ends, within a step, the instant is located and the step is split there, so that
the order survives contact. Where an effect makes the winding's equation stiff, the current goes
ahead of the rest (`stiff_current`).

`faults` is None or True: the compiler drops what stands under `if faults is not None` for None, so
that a drive without effects at the plant's ports runs without them.
"""

from __future__ import annotations

import math

import numpy as np

from ..effects import learned, ports
from .compiled import called, kernel
from .friction import deflected, friction_torque
from .motor import current_derivatives, rotor_torque
from .noise import gaussian
from .stiff_current import current_over
from .transmission import beyond, contact_mode, mode_torque

ROTOR_ANGLE, ROTOR_SPEED, LOAD_ANGLE, LOAD_SPEED, CURRENT_D, CURRENT_Q = range(6)
ROTOR_BRISTLE, LOAD_BRISTLE, TICKS, HEAT, TRAVEL = 6, 7, 8, 9, 10
STATE_SIZE = 11

# What the plant's sensors give each tick (float64[7]), in this order.
MEASURED = (
    "rotor_position_rad",
    "rotor_velocity_rad_per_s",
    "rod_position_m",
    "rod_velocity_m_per_s",
    "current_d_a",
    "current_q_a",
    "transmitted_torque_nm",
)

_INSTANT = 1e-12  # share of a step that a contact is located to
_STRAIGHT, _LOOKS = 12, 52  # by straight lines first, which take six or seven looks; then by halves
_MAX_EVENTS = 64  # per sub-step; beyond it contact is a blur at this step and is integrated through


@kernel
def _mechanics(y, twist_torque, u_q, into, time, faults, p):
    """Accelerations of rotor and load, `into` s into a step that began at `time` s, rad/s^2.

    With them the voltage that a learned law makes of the command u_q, V.
    """
    rotor = rotor_torque(y[5], y[1], p)
    load = -p.load_viscous * y[3]
    if faults is not None:
        if p.acts_at_rotor_torque:
            rotor += ports.rotor_torque(p, y[0], y[1], y[5])
        if p.acts_at_load_torque:
            load += ports.load_torque(p, time + into, y[2], y[3])
        # What the contacts could resist with: the level of all that rubs on the same bristle.
        rubs_rotor = rubs_load = 0.0
        if p.acts_at_rotor_friction:
            rubs_rotor = ports.rotor_friction(p, y[1], twist_torque, time + into)
        if p.acts_at_load_friction:
            rubs_load = ports.load_friction(p, y[3], twist_torque, y[2], time + into)
        if p.learned_port > 0:
            angle, speed = (y[2], y[3]) if p.learned_on_load else (y[0], y[1])
            law = learned.law_value(
                p, angle, speed, y[5], twist_torque, u_q, time + into, y[8], y[9]
            )
            if p.learned_port == learned.ROTOR_TORQUE:
                rotor += law
            elif p.learned_port == learned.LOAD_TORQUE:
                load += law
            elif p.learned_port == learned.ROTOR_FRICTION:
                rubs_rotor += max(law, 0.0)
            elif p.learned_port == learned.LOAD_FRICTION:
                rubs_load += max(law, 0.0)
            elif p.learned_port == learned.INVERTER_VOLTAGE:
                u_q += law
        if p.acts_at_rotor_friction:
            rotor -= friction_torque(
                y[6], y[1], into, rubs_rotor, p.rotor_breakaway, p.rotor_bristle_damping
            )
        if p.acts_at_load_friction:
            load -= friction_torque(
                y[7], y[3], into, rubs_load, p.load_breakaway, p.load_bristle_damping
            )
    return (
        (rotor - twist_torque) * p.per_rotor_inertia,
        (twist_torque + load) * p.per_load_inertia,
        u_q,
    )


@kernel
def _derivative(y, u_d, u_q, mode, into, time, faults, p):
    """Slopes of the six smooth states, `into` s into a step that began at `time` s."""
    twist_torque = mode_torque(y[0] - y[2], y[1] - y[3], mode, p)
    rotor, load, u_q = _mechanics(y, twist_torque, u_q, into, time, faults, p)
    if faults is not None and p.acts_at_inverter_voltage:
        u_q += ports.inverter_voltage(p, y[5], u_q)
    slope_d, slope_q = current_derivatives(y[4], y[5], y[1], u_d, u_q, p)
    return y[1], rotor, y[3], load, slope_d, slope_q


@kernel
def _shifted(y, step, slope):
    return (
        y[0] + step * slope[0],
        y[1] + step * slope[1],
        y[2] + step * slope[2],
        y[3] + step * slope[3],
        y[4] + step * slope[4],
        y[5] + step * slope[5],
        y[6],
        y[7],
        y[8],
        y[9],
    )


@kernel
def _at_current(y, current):
    return (y[0], y[1], y[2], y[3], y[4], current, y[6], y[7], y[8], y[9])


@kernel
def _combined(y, k1, k2, k3, k4, step, faults, p):
    """The end of a classical Runge-Kutta step with its four slopes."""
    sixth = step / 6.0
    rotor = y[0] + sixth * (k1[0] + 2.0 * (k2[0] + k3[0]) + k4[0])
    load = y[2] + sixth * (k1[2] + 2.0 * (k2[2] + k3[2]) + k4[2])
    # The bristles follow the way that was gone in the step.
    rotor_bristle, load_bristle = y[6], y[7]
    if faults is not None:
        if p.acts_at_rotor_friction and step > 0.0:
            rotor_bristle = deflected(y[6], (rotor - y[0]) / step, step, p.rotor_breakaway)
        if p.acts_at_load_friction and step > 0.0:
            load_bristle = deflected(y[7], (load - y[2]) / step, step, p.load_breakaway)
    return (
        rotor,
        y[1] + sixth * (k1[1] + 2.0 * (k2[1] + k3[1]) + k4[1]),
        load,
        y[3] + sixth * (k1[3] + 2.0 * (k2[3] + k3[3]) + k4[3]),
        y[4] + sixth * (k1[4] + 2.0 * (k2[4] + k3[4]) + k4[4]),
        y[5] + sixth * (k1[5] + 2.0 * (k2[5] + k3[5]) + k4[5]),
        rotor_bristle,
        load_bristle,
        y[8],
        y[9],
    )


@called
def _with_stiff_current(y, u_d, u_q, mode, step, time, p):
    """A step in which the current is taken first, see `stiff_current`."""
    if step <= 0.0:
        return y
    half = 0.5 * step
    twist_torque = mode_torque(y[0] - y[2], y[1] - y[3], mode, p)
    k1 = _derivative(y, u_d, u_q, mode, 0.0, time, True, p)
    held = _derivative(
        _at_current(_shifted(y, half, k1), y[5]), u_d, u_q, mode, half, time, True, p
    )
    jerk = (held[1] - k1[1]) / half
    end, half_way = current_over(y, twist_torque, k1[1], jerk, u_q, step, time, p)
    y2 = _at_current(_shifted(y, half, k1), half_way)
    k2 = _derivative(y2, u_d, u_q, mode, half, time, True, p)
    y3 = _at_current(_shifted(y, half, k2), half_way)
    k3 = _derivative(y3, u_d, u_q, mode, half, time, True, p)
    y4 = _at_current(_shifted(y, step, k3), end)
    k4 = _derivative(y4, u_d, u_q, mode, step, time, True, p)
    return _at_current(_combined(y, k1, k2, k3, k4, step, True, p), end)


@kernel
def _runge_kutta(y, u_d, u_q, mode, step, time, faults, p):
    if faults is not None and p.current_span > 0.0:
        return _with_stiff_current(y, u_d, u_q, mode, step, time, p)
    half = 0.5 * step
    k1 = _derivative(y, u_d, u_q, mode, 0.0, time, faults, p)
    k2 = _derivative(_shifted(y, half, k1), u_d, u_q, mode, half, time, faults, p)
    k3 = _derivative(_shifted(y, half, k2), u_d, u_q, mode, half, time, faults, p)
    k4 = _derivative(_shifted(y, step, k3), u_d, u_q, mode, step, time, faults, p)
    return _combined(y, k1, k2, k3, k4, step, faults, p)


@kernel
def _mode_of(y, p):
    return contact_mode(y[0] - y[2], y[1] - y[3], p)


@called
def _step(y, u_d, u_q, mode, step, time, faults, p):
    return _runge_kutta(y, u_d, u_q, mode, step, time, faults, p)


@kernel
def _out_of(y, mode, p):
    return beyond(y[0] - y[2], y[1] - y[3], mode, p)


@kernel
def _up_to_change(y, after, u_d, u_q, mode, step, time, faults, p):
    """The state at the first instant at which `mode` no longer holds, and how long it takes, s.

    after: state at the end of the step, out of the mode. False position as Illinois has it: an end
    that stays where it is counts for half.
    """
    early, late = 0.0, step
    inside, outside = _out_of(y, mode, p), _out_of(after, mode, p)
    stayed = 0
    for look in range(_LOOKS):
        between = early + (late - early) * inside / (inside - outside)
        if look >= _STRAIGHT or not early < between < late:
            between = 0.5 * (early + late)
        tried = _step(y, u_d, u_q, mode, between, time, faults, p)
        found = _out_of(tried, mode, p)
        if _mode_of(tried, p) == mode:
            early, inside = between, min(found, 0.0)
            outside = 0.5 * outside if stayed < 0 else outside
            stayed = -1
        else:
            late, after, outside = between, tried, max(found, 0.0)
            inside = 0.5 * inside if stayed > 0 else inside
            stayed = 1
        if late - early <= _INSTANT * step:
            break
    return after, late


@called
def _across(y, after, mode, u_d, u_q, step, time, faults, p):
    """The state after a step that begins in `mode` and, taken whole, ends at `after` out of it."""
    remaining = step
    for _ in range(_MAX_EVENTS):
        now = time + (step - remaining)
        y, gone = _up_to_change(y, after, u_d, u_q, mode, remaining, now, faults, p)
        remaining -= gone
        if remaining <= 0.0:
            return y
        mode = _mode_of(y, p)
        now = time + (step - remaining)
        after = _step(y, u_d, u_q, mode, remaining, now, faults, p)
        if _mode_of(after, p) == mode:
            break
    return after


@kernel
def _substep(y, u_d, u_q, step, time, faults, p):
    mode = _mode_of(y, p)
    after = _runge_kutta(y, u_d, u_q, mode, step, time, faults, p)
    if _mode_of(after, p) == mode:
        return after
    return _across(y, after, mode, u_d, u_q, step, time, faults, p)


@kernel
def _advance(state, u_d, u_q, share, params):
    """`plant_step` for a share of a control tick; its sub-steps are shared out in proportion."""
    p = params[0]
    y = (
        state[0],
        state[1],
        state[2],
        state[3],
        state[4],
        state[5],
        state[6],
        state[7],
        state[HEAT],
        state[TRAVEL],
    )
    steps = p.substeps
    if share != 1.0:
        steps = math.ceil(share * p.substeps)
    step = share * p.tick / steps
    time = state[TICKS] * p.tick
    # Two compilations of one step: a drive without effects in its plant does not pay for them.
    if p.acts_in_plant:
        for index in range(steps):
            y = _substep(y, u_d, u_q, step, time + index * step, True, p)
    else:
        for index in range(steps):
            y = _substep(y, u_d, u_q, step, time + index * step, None, p)
    for index in range(8):
        state[index] = y[index]
    if p.learned_port > 0:
        speed = y[3] if p.learned_on_load else y[1]
        state[HEAT], state[TRAVEL] = learned.remember(
            p, speed, y[5], state[HEAT], state[TRAVEL], share * p.tick, share
        )
    state[TICKS] += share


@called
def _advance_part(state, u_d, u_q, share, params):
    _advance(state, u_d, u_q, share, params)


@kernel
def plant_step(state, u_d, u_q, params):
    """Advance `state` (float64[STATE_SIZE], in place) by one control tick, voltages held, V."""
    _advance(state, u_d, u_q, 1.0, params)


@kernel
def _quantised(value, resolution):
    if resolution > 0.0:
        return resolution * math.floor(value / resolution + 0.5)
    return value


@kernel
def _noise(std, seed, tick, channel):
    if std > 0.0:
        return std * gaussian(seed, tick, channel)
    return 0.0


@kernel
def measure(state, tick, params, measured):
    """Fill `measured` (float64[7], see `MEASURED`) with what the sensors give at `tick`.

    Rod velocity, d current noise aside, and transmitted torque are the emulator's own truth: no
    sensor model is given for them.
    """
    p = params[0]
    seed = p.noise_seed
    twist = state[0] - state[2]
    rate = state[1] - state[3]
    angle, speed, load, current = state[0], state[1], state[2], state[5]
    if p.acts_at_rotor_angle_error:
        angle += ports.rotor_angle_error(p, state[0])
    if p.acts_at_rotor_speed_error:
        speed += ports.rotor_speed_error(p, state[0], state[1])
    if p.acts_at_rod_error:
        load += ports.rod_error(p, state[2])
    if p.acts_at_current_error:
        current += ports.current_error(p, state[5])
    if p.learned_port >= learned.ROTOR_ANGLE_ERROR:
        side = 2 if p.learned_on_load else 0
        error, slope = learned.reading_error(
            p, state[side], state[side + 1], state[5], tick * p.tick, state[HEAT], state[TRAVEL]
        )
        if p.learned_port == learned.ROTOR_ANGLE_ERROR:
            angle += error
            speed += slope * state[1]
        elif p.learned_port == learned.CURRENT_ERROR:
            current += error
        else:
            load += error
    measured[0] = _quantised(
        angle + _noise(p.rotor_position_noise, seed, tick, 0), p.rotor_position_resolution
    )
    measured[1] = speed + _noise(p.rotor_velocity_noise, seed, tick, 1)
    measured[2] = _quantised(
        load * p.rod_per_rotor + _noise(p.rod_position_noise, seed, tick, 2),
        p.rod_position_resolution,
    )
    measured[3] = state[3] * p.rod_per_rotor
    measured[4] = state[4] + _noise(p.current_noise, seed, tick, 3)
    measured[5] = current + _noise(p.current_noise, seed, tick, 4)
    measured[6] = mode_torque(twist, rate, contact_mode(twist, rate, p), p)


@kernel
def apply_voltage(state, pending, params):
    """Advance one tick with the oldest of the `pending` voltages and move the queue up.

    pending: float64[n, 2], (u_d, u_q) in V, see `voltage_queue`; the newest stands last and stays
    there, held, until it is overwritten. A delay of broken ticks changes over within the tick.
    """
    p = params[0]
    part = p.actuation_delay - math.floor(p.actuation_delay)
    if part > 0.0:
        _advance_part(state, pending[0, 0], pending[0, 1], part, params)
        _advance_part(state, pending[1, 0], pending[1, 1], 1.0 - part, params)
        state[TICKS] = math.floor(state[TICKS] + 0.5)
    else:
        plant_step(state, pending[0, 0], pending[0, 1], params)
    for slot in range(pending.shape[0] - 1):
        pending[slot, 0] = pending[slot + 1, 0]
        pending[slot, 1] = pending[slot + 1, 1]


def voltage_queue(params: np.ndarray) -> np.ndarray:
    """Queue of voltages on their way to the inverter, all 0 V: float64[delay in ticks + 1, 2]."""
    return np.zeros((math.ceil(params["actuation_delay"][0]) + 1, 2))


@kernel
def apply_and_measure(state, pending, next_tick, params, measured):
    """`apply_voltage`, then `measure` at `next_tick`: what the plant node does with a command."""
    apply_voltage(state, pending, params)
    measure(state, next_tick, params, measured)


def initial_state() -> np.ndarray:
    """Plant state at rest, the transmission in the middle of its clearance."""
    return np.zeros(STATE_SIZE)
