"""Everything the stand-in for a real drive consists of, as plain numbers in SI units.

A nominal drive file gives the first values; nuisances and effects then change them. Angles,
inertias and torques are at the rotor unless a name says otherwise. Zero switches an effect off.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from ....drive.parameters import DriveParameters, Gains

MAX_SEGMENTS = 8
UNLIMITED = 1e300


@dataclass
class Physics:
    """One machine with its drive; mutable while it is being put together."""

    # Motor and inverter
    resistance: float  # ohm
    resistance_rise: float = 0.0  # 1/s, share by which it grows each second
    inductance: float = 0.0  # H
    torque_constant: float = 0.0  # N m/A
    back_emf_constant: float = 0.0  # V s/rad
    rotor_inertia: float = 0.0  # kg m^2
    rotor_viscous: float = 0.0  # N m s/rad
    rotor_drag: float = 0.0  # N m s^2/rad^2, against the motion with the speed squared
    dead_time_v: float = 0.0  # V lost against the current's sign
    dead_time_transition_a: float = 0.02  # A over which that loss turns its sign
    inverter_gain: float = 1.0  # of the commanded voltage
    pwm_step_v: float = 0.0  # V, resolution of the voltage applied
    cogging_nm: float = 0.0
    cogging_periods: float = 1.0  # per revolution
    cogging_phase: float = 0.0  # rad
    second_cogging_nm: float = 0.0
    second_cogging_periods: float = 1.0
    second_cogging_phase: float = 0.0
    ripple: float = 0.0  # share of the torque
    ripple_periods: float = 1.0
    ripple_phase: float = 0.0
    # Friction of the rotor, of the load: bristles (LuGre)
    bristle_ratio: float = 0.3  # damping ratio of a bristle with the inertia it holds
    bristle_fade: float = 0.2  # rad/s, the speed at which half of that damping has faded
    rotor_coulomb: float = 0.0  # N m
    rotor_static: float = 0.0  # N m, at standstill
    rotor_stribeck: float = 1.0  # rad/s
    rotor_bristle_rad: float = 1e-4  # deflection at which sliding begins at coulomb level
    rotor_friction_decay: float = 0.0  # 1/s, friction falls as exp(-decay t)
    load_coulomb: float = 0.0
    load_bristle_rad: float = 1e-4
    load_dependent: float = 0.0  # N m of friction per N m transmitted, on the load
    jam_nm: float = 0.0  # friction on the load at one place of the stroke
    jam_place: float = 0.0  # rad of the load, at the rotor
    jam_width: float = 1.0  # rad
    # Transmission
    rod_per_rotor: float = 0.0  # m/rad
    gear_ratio: float = 1.0
    half_backlash: float = 0.0  # rad
    wear: float = 0.0  # share of clearance added at one place of the stroke
    wear_place: float = 0.0  # rad
    wear_width: float = 1.0  # rad
    contact_damping: float = 0.0  # N m s/rad
    hardening: float = 0.0  # share of stiffness gained per rad of deflection
    hysteresis_nm: float = 0.0  # friction between the two sides of the transmission
    hysteresis_rad: float = 1e-3  # twist over which it builds up
    error_rad: float = 0.0  # kinematic transmission error, load side
    error_periods: float = 1.0  # per screw revolution
    error_phase: float = 0.0
    # Load
    load_inertia: float = 0.0  # kg m^2
    load_viscous: float = 0.0  # N m s/rad
    load_one_way_viscous: float = 0.0  # N m s/rad, acts in positive motion only
    force_n: float = 0.0  # N on the rod, against positive motion
    spring_n_per_m: float = 0.0
    periodic_n: float = 0.0
    periodic_hz: float = 1.0
    periodic_phase: float = 0.0
    end_stop_n_per_m: float = 0.0  # spring that begins at end_stop_m
    end_stop_m: float = 0.0
    structure_inertia: float = 0.0  # kg m^2, swings on the rod's structure
    structure_rate: float = 1.0  # rad/s, its natural frequency, load held
    structure_damping: float = 0.03  # ratio
    random_nm: float = 0.0  # N m, standard deviation of a random torque on the rotor
    random_rate: float = 100.0  # rad/s, its corner frequency
    # Sensors, as the loop and the recording see them
    current_offset: float = 0.0  # A
    current_gain: float = 0.0  # share
    eccentricity: float = 0.0  # rad, once per rotor revolution
    eccentricity_phase: float = 0.0
    second_eccentricity: float = 0.0  # rad, twice per revolution
    second_eccentricity_phase: float = 0.0
    # Controller; limits here are the real drive's
    nominal_rod_per_rotor: float = 0.0  # m/rad, by which the reference becomes a rotor angle
    feedback_rod: float = 0.0
    velocity_feedforward: float = 0.0
    acceleration_feedforward: float = 0.0  # A s^2/rad
    setpoint_filter_s: float = 0.0  # time constants of low-passes
    current_filter_s: float = 0.0  # on the current asked for
    speed_filter_s: float = 0.0  # on the speed the loop sees
    speed_differences: float = 0.0  # that speed is the encoder's step over a tick
    no_speed_loop: float = 0.0  # the position loop asks for the current
    position_kp: float = 0.0
    position_ki: float = 0.0
    position_kd: float = 0.0
    speed_kp: float = 0.0
    speed_ki: float = 0.0
    current_kp: float = 0.0
    current_ki: float = 0.0
    speed_limit: float = UNLIMITED
    current_limit: float = UNLIMITED
    voltage_limit: float = UNLIMITED
    measurement_delay_s: float = 0.0
    actuation_delay_s: float = 0.0
    # A law outside every catalogue, see `law`
    law_port: float = 0.0  # 0: none
    law_size: float = 0.0
    law_offset: float = 0.0
    law_first: float = 0.0
    law_first_shape: float = 0.0
    law_first_width: float = 1.0
    law_first_place: float = 0.0
    law_second: float = 0.0
    law_second_shape: float = 0.0
    law_second_width: float = 1.0
    law_second_place: float = 0.0
    law_heat_s: float = 1.0  # s, time constant of heat
    # State at the start
    rotor_angle: float = 0.0  # rad
    rotor_speed: float = 0.0  # rad/s
    load_angle: float = 0.0
    load_speed: float = 0.0

    # Elastic torque against deflection, one entry per segment
    stiffness: tuple[float, ...] = (1.0,)  # N m/rad
    stiffness_breaks: tuple[float, ...] = ()  # N m

    def packed(self) -> np.ndarray:
        """A record array of one element, the form the compiled equations take."""
        record = np.zeros(1, PACKED)
        for name in _SCALARS:
            record[name] = getattr(self, name)
        torque = np.array([0.0, *self.stiffness_breaks])
        slope = np.array(self.stiffness)
        start = np.concatenate([[0.0], np.cumsum(np.diff(torque) / slope[:-1])])
        record["segments"] = len(slope)
        for name, values in (("slope", slope), ("bend_rad", start), ("bend_nm", torque)):
            record[name][0, : len(slope)] = values
        return record


_SCALARS = [item.name for item in fields(Physics) if item.type == "float"]
PACKED = np.dtype(
    [(name, "f8") for name in _SCALARS]
    + [("segments", "i8")]
    + [(name, "f8", (MAX_SEGMENTS,)) for name in ("slope", "bend_rad", "bend_nm")]
)


def _parallel(gains: Gains, form: str) -> tuple[float, float]:
    return gains.kp, gains.ki * (gains.kp if form == "series" else 1.0)


def nominal_physics(drive: DriveParameters) -> Physics:
    """The machine exactly as its drive file describes it, at rest."""
    motor, transmission, control = drive.motor, drive.transmission, drive.controller
    position, speed, current = (
        _parallel(gains, control.form)
        for gains in (control.position, control.speed, control.current)
    )
    return Physics(
        resistance=motor.resistance,
        inductance=motor.inductance,
        torque_constant=motor.torque_constant,
        back_emf_constant=motor.back_emf_constant,
        rotor_inertia=motor.rotor_inertia,
        rotor_viscous=motor.viscous_friction,
        rod_per_rotor=transmission.rod_per_rotor,
        gear_ratio=transmission.gear_ratio,
        half_backlash=0.5 * transmission.backlash,
        contact_damping=transmission.contact_damping,
        stiffness=transmission.stiffness,
        stiffness_breaks=transmission.stiffness_breaks,
        load_inertia=drive.load.inertia,
        load_viscous=drive.load.viscous_friction,
        nominal_rod_per_rotor=transmission.rod_per_rotor,
        feedback_rod=float(control.feedback == "rod"),
        velocity_feedforward=control.velocity_feedforward,
        acceleration_feedforward=control.acceleration_feedforward,
        setpoint_filter_s=control.setpoint_filter,
        current_filter_s=control.current_command_filter,
        speed_filter_s=control.speed_filter,
        speed_differences=float(control.speed_source == "differences"),
        no_speed_loop=float(control.structure == "position_to_current"),
        position_kp=position[0],
        position_ki=position[1],
        position_kd=control.position.kd * (position[0] if control.form == "series" else 1.0),
        speed_kp=speed[0],
        speed_ki=speed[1],
        current_kp=current[0],
        current_ki=current[1],
        speed_limit=min(control.speed_limit, UNLIMITED),
        current_limit=min(control.current_limit, UNLIMITED),
        voltage_limit=min(control.voltage_limit, UNLIMITED),
        actuation_delay_s=control.delay_ticks / control.rate,
    )
