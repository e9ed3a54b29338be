"""The stand-in's equations of motion and its control code, compiled.

Written from the physics and on purpose unlike the model a diagnosis fits: fixed steps of 10 us or
less, Heun's method for the mechanics and the current, bristles advanced exactly with the speed
held, contact as a penalty without locating its instants, friction after LuGre.
"""

from __future__ import annotations

import math

import numpy as np

from ....drive.compiled import kernel
from . import law as laws

# Columns of what a run leaves for each sample.
ROTOR_ANGLE, ROTOR_SPEED, LOAD_ANGLE, CURRENT, VOLTAGE, ROD = range(6)
COLUMNS = 6


@kernel
def _bristle(deflection, speed, sliding, step):
    """Bristle deflection a step later, the speed held; it saturates at `sliding` rad."""
    if speed == 0.0 or sliding <= 0.0:
        return deflection
    end = sliding if speed > 0.0 else -sliding
    return end + (deflection - end) * math.exp(-abs(speed) / sliding * step)


@kernel
def _bristle_torque(deflection, speed, level, sliding, inertia, p):
    """LuGre friction, N m: stiffness level/sliding, and damping of the bristle's own rate.

    The damping fades with speed; without that a fast reversal would meet a spurious impulse.
    """
    if level <= 0.0 or sliding <= 0.0:
        return 0.0
    stiffness = level / sliding
    fast = speed / p.bristle_fade
    damping = 2.0 * p.bristle_ratio * math.sqrt(stiffness * inertia) / (1.0 + fast * fast)
    return stiffness * deflection + damping * (speed - abs(speed) * deflection / sliding)


@kernel
def _rotor_sliding(speed, time, p):
    """(sliding friction torque N m, bristle deflection rad at which it stands)."""
    level = p.rotor_coulomb
    if p.rotor_static > p.rotor_coulomb:
        ratio = speed / p.rotor_stribeck
        level += (p.rotor_static - p.rotor_coulomb) * math.exp(-ratio * ratio)
    if p.rotor_friction_decay > 0.0:
        level *= math.exp(-p.rotor_friction_decay * time)
    stiffness = p.rotor_coulomb / p.rotor_bristle_rad
    return level, level / stiffness if stiffness > 0.0 else 0.0


@kernel
def _load_sliding(angle, transmitted, p):
    """The same for the load, where friction may depend on place and transmitted torque."""
    level = p.load_coulomb
    if p.jam_nm > 0.0:
        off = (angle - p.jam_place) / p.jam_width
        if abs(off) < 6.0:
            level += p.jam_nm * math.exp(-off * off)
    if p.load_dependent > 0.0:
        level += p.load_dependent * abs(transmitted)
    return level


@kernel
def _transmitted(twist, rate, angle, p):
    """Torque through the flanks, N m; contact damping never makes a flank pull."""
    half = p.half_backlash
    if p.wear != 0.0:
        off = (angle - p.wear_place) / p.wear_width
        if abs(off) < 6.0:
            half *= 1.0 + p.wear * math.exp(-off * off)
    overlap = abs(twist) - half
    if overlap <= 0.0:
        return 0.0
    part = 0
    while part + 1 < p.segments and overlap > p.bend_rad[part + 1]:
        part += 1
    torque = p.bend_nm[part] + p.slope[part] * (overlap - p.bend_rad[part])
    if p.hardening != 0.0:
        torque *= 1.0 + p.hardening * overlap
    side = 1.0 if twist > 0.0 else -1.0
    torque += p.contact_damping * side * rate
    return side * torque if torque > 0.0 else 0.0


@kernel
def _slopes(y, bristles, time, voltage, disturbance, memory, p):
    """Time derivatives of (rotor angle, speed, load angle, speed, current, swing, swing rate).

    bristles: deflections (rotor, load, transmission), rad. memory: (heat A^2, travel rad) of a law.
    """
    angle, speed, load_angle, load_speed, current, swing, swing_rate = y
    twist_rate = speed - load_speed
    transmitted = _transmitted(angle - load_angle, twist_rate, load_angle, p)
    if p.hysteresis_nm > 0.0:
        transmitted += p.hysteresis_nm * bristles[2] / p.hysteresis_rad

    torque = p.torque_constant * current
    if p.ripple != 0.0:
        torque *= 1.0 + p.ripple * math.sin(p.ripple_periods * angle + p.ripple_phase)
    torque += disturbance - p.rotor_viscous * speed - transmitted
    if p.rotor_drag != 0.0:
        torque -= p.rotor_drag * abs(speed) * speed
    if p.cogging_nm != 0.0:
        torque += p.cogging_nm * math.sin(p.cogging_periods * angle + p.cogging_phase)
    if p.second_cogging_nm != 0.0:
        torque += p.second_cogging_nm * math.sin(
            p.second_cogging_periods * angle + p.second_cogging_phase
        )
    if p.rotor_coulomb > 0.0:
        level, sliding = _rotor_sliding(speed, time, p)
        torque -= _bristle_torque(bristles[0], speed, level, sliding, p.rotor_inertia, p)
    law = 0.0
    if p.law_port > 0.0:
        at, rate = (load_angle, load_speed) if _law_on_load(p) else (angle, speed)
        law = laws.law_value(p, at, rate, current, transmitted, time, memory[0], memory[1])
    if p.law_port == laws.ROTOR_TORQUE:
        torque += law
    if p.law_port == laws.ROTOR_FRICTION:
        sliding = p.rotor_bristle_rad
        torque -= _bristle_torque(bristles[0], speed, max(law, 0.0), sliding, p.rotor_inertia, p)

    rod = p.rod_per_rotor * load_angle
    force = p.force_n + p.spring_n_per_m * rod
    if p.periodic_n != 0.0:
        force -= p.periodic_n * math.sin(2.0 * math.pi * p.periodic_hz * time + p.periodic_phase)
    if p.end_stop_n_per_m > 0.0 and rod > p.end_stop_m:
        force += p.end_stop_n_per_m * (rod - p.end_stop_m)
    load_torque = transmitted - p.load_viscous * load_speed - p.rod_per_rotor * force
    if p.load_one_way_viscous != 0.0 and load_speed > 0.0:
        load_torque -= p.load_one_way_viscous * load_speed
    level = _load_sliding(load_angle, transmitted, p)
    if level > 0.0:
        load_torque -= _bristle_torque(
            bristles[1], load_speed, level, p.load_bristle_rad, p.load_inertia, p
        )

    if p.law_port == laws.LOAD_TORQUE:
        load_torque += law
    if p.law_port == laws.LOAD_FRICTION:
        load_torque -= _bristle_torque(
            bristles[1], load_speed, max(law, 0.0), p.load_bristle_rad, p.load_inertia, p
        )

    load_inertia = p.load_inertia
    swing_slope = 0.0
    if p.structure_inertia > 0.0:  # part of the load's inertia swings on a spring of its own
        load_inertia -= p.structure_inertia
        swing_slope = p.structure_rate * (
            p.structure_rate * (load_angle - swing)
            + 2.0 * p.structure_damping * (load_speed - swing_rate)
        )
        load_torque -= p.structure_inertia * swing_slope

    applied = voltage * p.inverter_gain
    if p.dead_time_v != 0.0:
        share = current / p.dead_time_transition_a
        applied -= p.dead_time_v * min(max(share, -1.0), 1.0)
    if p.law_port == laws.INVERTER_VOLTAGE:
        applied += law
    resistance = p.resistance * (1.0 + p.resistance_rise * time)
    current_slope = (applied - resistance * current - p.back_emf_constant * speed) / p.inductance
    return (
        speed,
        torque / p.rotor_inertia,
        load_speed,
        load_torque / load_inertia,
        current_slope,
        swing_rate,
        swing_slope,
    )


@kernel
def _moved(y, slope, step):
    return (
        y[0] + step * slope[0],
        y[1] + step * slope[1],
        y[2] + step * slope[2],
        y[3] + step * slope[3],
        y[4] + step * slope[4],
        y[5] + step * slope[5],
        y[6] + step * slope[6],
    )


@kernel
def _law_on_load(p):
    """Whether a law goes by the load's angle and speed."""
    return (
        p.law_port == laws.LOAD_TORQUE
        or p.law_port == laws.LOAD_FRICTION
        or p.law_port == laws.ROD_ERROR
    )


@kernel
def _remembered(memory, y, step, p):
    """A law's (heat, travel) a step later."""
    heat, travel = memory
    speed = y[3] if _law_on_load(p) else y[1]
    heat += (y[4] * y[4] - heat) * step / p.law_heat_s
    if travel * speed < 0.0:
        travel = 0.0
    return heat, travel + speed * step


@kernel
def _law_in_reading(y, time, memory, port, p):
    """What a law adds to a reading at the sensors' `port`."""
    if p.law_port != port:
        return 0.0
    angle, speed = (y[2], y[3]) if _law_on_load(p) else (y[0], y[1])
    return laws.law_value(p, angle, speed, y[4], 0.0, time, memory[0], memory[1])


@kernel
def _advanced(y, bristles, time, voltage, disturbance, memory, step, p):
    """(state, bristles) a step later."""
    first = _slopes(y, bristles, time, voltage, disturbance, memory, p)
    guess = _moved(y, first, step)
    rotor_speed, load_speed = 0.5 * (y[1] + guess[1]), 0.5 * (y[3] + guess[3])
    rotor, load, twist = bristles
    if p.rotor_coulomb > 0.0:
        _, sliding = _rotor_sliding(rotor_speed, time, p)
        rotor = _bristle(rotor, rotor_speed, sliding, step)
    if p.law_port == laws.ROTOR_FRICTION:
        rotor = _bristle(rotor, rotor_speed, p.rotor_bristle_rad, step)
    if p.law_port == laws.LOAD_FRICTION:
        load = _bristle(load, load_speed, p.load_bristle_rad, step)
    if p.load_coulomb > 0.0 or p.jam_nm > 0.0 or p.load_dependent > 0.0:
        load = _bristle(load, load_speed, p.load_bristle_rad, step)
    if p.hysteresis_nm > 0.0:
        twist = _bristle(twist, rotor_speed - load_speed, p.hysteresis_rad, step)
    bristles = (rotor, load, twist)
    second = _slopes(guess, bristles, time + step, voltage, disturbance, memory, p)
    y = _moved(_moved(y, first, 0.5 * step), second, 0.5 * step)
    return y, bristles


@kernel
def _limited(value, limit):
    return min(max(value, -limit), limit)


@kernel
def _smoothed(last, new, tick_s, time_constant_s):
    """A first-order low-pass a tick later, its input held; `new` itself without one."""
    if time_constant_s <= 0.0:
        return new
    return new + (last - new) * math.exp(-tick_s / time_constant_s)


@kernel
def _encoder(angle, speed, p):
    """What an eccentric encoder makes of an angle and a speed: (rad, rad/s)."""
    seen, rate = angle, 1.0
    if p.eccentricity != 0.0:
        seen += p.eccentricity * math.sin(angle + p.eccentricity_phase)
        rate += p.eccentricity * math.cos(angle + p.eccentricity_phase)
    if p.second_eccentricity != 0.0:
        seen += p.second_eccentricity * math.sin(2.0 * angle + p.second_eccentricity_phase)
        rate += 2.0 * p.second_eccentricity * math.cos(2.0 * angle + p.second_eccentricity_phase)
    return seen, rate * speed


@kernel
def _rod_scale(load_angle, p):
    """Rod position, m, where its scale is read: the kinematic error of the screw is in it."""
    seen = load_angle
    if p.error_rad != 0.0:
        seen += p.error_rad * math.sin(p.error_periods * load_angle / p.gear_ratio + p.error_phase)
    return p.rod_per_rotor * seen


@kernel
def _stepped(value, step):
    return step * math.floor(value / step + 0.5) if step > 0.0 else value


def run(
    record, position, velocity, tick_s, steps_per_tick, every, loop_noise, resolution, torque_noise
):
    """Run the machine under its cascade; float64[n, COLUMNS], one row per `every` ticks.

    record: `Physics.packed`. position, velocity: float64[ticks], reference m and m/s at each
    control tick. tick_s: control period, s. loop_noise: float64[ticks, 4], added to rotor angle,
    rotor speed, current and rod position as the loop and the recording see them, or float64[0, 4]
    for a loop without noise. resolution: float64[2], encoder rad and rod scale m as the loop sees
    them, 0 for none. torque_noise: float64[ticks], N m on the rotor, or float64[0].
    Stops at the first value that is not finite; the rows from there on are NaN.
    """
    step = tick_s / steps_per_tick
    samples = np.full(((len(position) + every - 1) // every, COLUMNS), np.nan)
    late = round(float(record["measurement_delay_s"][0]) / step)
    held = round(float(record["actuation_delay_s"][0]) / step)
    past, commands = np.zeros((late + 1, 3)), np.zeros(held // steps_per_tick + 2)
    timing, noise = (tick_s, steps_per_tick, every), (loop_noise, resolution, torque_noise)
    _fill(samples, past, commands, held, record, position, velocity, timing, noise)
    return samples


@kernel
def _fill(samples, past, commands, held, record, position, velocity, timing, noise):
    """See `run`.

    past: float64[n, 3], what the sensors see late, written round and round, an entry per step:
    angle, speed, rod. commands: on their way to the inverter, for `held` steps. timing, noise: the
    other arguments of `run`.
    """
    tick_s, steps_per_tick, every = timing
    loop_noise, resolution, torque_noise = noise
    p = record[0]
    ticks = position.shape[0]
    step = tick_s / steps_per_tick
    late = past.shape[0] - 1
    past[:, 0] = p.rotor_angle
    past[:, 2] = _rod_scale(p.load_angle, p)
    y = (p.rotor_angle, p.rotor_speed, p.load_angle, p.load_speed, 0.0, p.load_angle, p.load_speed)
    bristles = (0.0, 0.0, 0.0)
    memory = (0.0, 0.0)
    position_integral = speed_integral = current_integral = 0.0
    # What the control code keeps for its filters and differences.
    target, target_rate, last_rate = position[0], 0.0, velocity[0]
    last_angle = loop_speed_seen = asked = 0.0
    count = 0
    for tick in range(ticks):
        angle, speed = _encoder(y[0], y[1], p)
        rod = _rod_scale(y[2], p)
        current = (1.0 + p.current_gain) * y[4] + p.current_offset
        if p.law_port >= laws.ROTOR_ANGLE_ERROR:
            now = count * step
            rod += p.rod_per_rotor * _law_in_reading(y, now, memory, laws.ROD_ERROR, p)
            current += _law_in_reading(y, now, memory, laws.CURRENT_ERROR, p)
            off = _law_in_reading(y, now, memory, laws.ROTOR_ANGLE_ERROR, p)
            ahead = (y[0] + 1e-6, y[1], y[2], y[3], y[4], y[5], y[6])
            slope = (_law_in_reading(ahead, now, memory, laws.ROTOR_ANGLE_ERROR, p) - off) / 1e-6
            angle, speed = angle + off, speed + slope * y[1]
        place = count % (late + 1)
        past[place, 0], past[place, 1], past[place, 2] = angle, speed, rod
        place = (count + 1) % (late + 1)  # the oldest entry
        loop_angle, loop_speed, loop_rod = past[place, 0], past[place, 1], past[place, 2]
        if loop_noise.shape[0] > 0:
            drawn = loop_noise[tick]
            angle = _stepped(angle + drawn[0], resolution[0])
            loop_angle = _stepped(loop_angle + drawn[0], resolution[0])
            speed, loop_speed = speed + drawn[1], loop_speed + drawn[1]
            current += drawn[2]
            rod = _stepped(rod + drawn[3], resolution[1])
            loop_rod = _stepped(loop_rod + drawn[3], resolution[1])

        if tick == 0:
            last_angle, loop_speed_seen = loop_angle, loop_speed
        if p.speed_differences > 0.0:
            loop_speed = (loop_angle - last_angle) / tick_s
        last_angle = loop_angle
        loop_speed_seen = _smoothed(loop_speed_seen, loop_speed, tick_s, p.speed_filter_s)
        loop_speed = loop_speed_seen
        target = _smoothed(target, position[tick], tick_s, p.setpoint_filter_s)
        target_rate = _smoothed(target_rate, velocity[tick], tick_s, p.setpoint_filter_s)
        if tick == 0:
            last_rate = target_rate
        forward = p.acceleration_feedforward * (target_rate - last_rate) / tick_s
        forward /= p.nominal_rod_per_rotor
        last_rate = target_rate

        seen = loop_rod / p.nominal_rod_per_rotor if p.feedback_rod > 0.0 else loop_angle
        error = target / p.nominal_rod_per_rotor - seen
        wanted = p.position_kp * error + p.position_ki * position_integral
        wanted += p.position_kd * (target_rate / p.nominal_rod_per_rotor - loop_speed)
        if p.no_speed_loop > 0.0:
            wanted += forward
            if abs(wanted) <= p.current_limit:
                position_integral += tick_s * error
        else:
            wanted += p.velocity_feedforward * target_rate / p.nominal_rod_per_rotor
            if abs(wanted) <= p.speed_limit:
                position_integral += tick_s * error
            error = _limited(wanted, p.speed_limit) - loop_speed
            wanted = p.speed_kp * error + p.speed_ki * speed_integral + forward
            if abs(wanted) <= p.current_limit:
                speed_integral += tick_s * error
        asked = _smoothed(asked, _limited(wanted, p.current_limit), tick_s, p.current_filter_s)
        error = asked - current
        wanted = p.current_kp * error + p.current_ki * current_integral
        if abs(wanted) <= p.voltage_limit:
            current_integral += tick_s * error
        command = _limited(wanted, p.voltage_limit)
        commands[tick % commands.shape[0]] = command

        if tick % every == 0:
            row = samples[tick // every]
            row[ROTOR_ANGLE], row[ROTOR_SPEED], row[LOAD_ANGLE] = angle, speed, y[2]
            row[CURRENT], row[VOLTAGE], row[ROD] = current, command, rod
            if not (math.isfinite(y[0]) and math.isfinite(y[4])):
                row[:] = np.nan
                return
        disturbance = torque_noise[tick] if torque_noise.shape[0] > 0 else 0.0
        for part in range(steps_per_tick):
            sent = count - held
            voltage = 0.0
            if sent >= 0:
                voltage = _stepped(
                    commands[(sent // steps_per_tick) % commands.shape[0]], p.pwm_step_v
                )
            if part > 0 and late > 0:
                place = count % (late + 1)
                past[place, 0], past[place, 1] = _encoder(y[0], y[1], p)
                past[place, 2] = _rod_scale(y[2], p)
            now = count * step
            y, bristles = _advanced(y, bristles, now, voltage, disturbance, memory, step, p)
            if p.law_port > 0.0:
                memory = _remembered(memory, y, step, p)
            count += 1
