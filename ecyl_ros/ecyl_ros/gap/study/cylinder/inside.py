"""The 26 effects of the contract as the study imposes them: ranges, and what they change.

Shares are of the peaks that the nominal drive reaches on the case's own reference.
"""

from __future__ import annotations

import numpy as np

from ....drive.parameters import DriveParameters
from .imposed import Draw, Imposed, Values
from .physics import Physics

SUB_STEP_S = 1e-5  # delays are drawn in whole numbers of it


def _setting(**fields: str):
    """An `impose` that sets fields of the machine to parameters: field="parameter"."""

    def impose(machine: Physics, values: Values, phases: np.ndarray) -> None:
        for field, parameter in fields.items():
            setattr(machine, field, values[parameter])

    return impose


def _adding(**fields: str):
    """The same for parameters that come on top of what the machine has."""

    def impose(machine: Physics, values: Values, phases: np.ndarray) -> None:
        for field, parameter in fields.items():
            setattr(machine, field, getattr(machine, field) + values[parameter])

    return impose


def _wave(phase: str, **fields: str):
    """`_setting` with a hidden phase."""
    setting = _setting(**fields)

    def impose(machine: Physics, values: Values, phases: np.ndarray) -> None:
        setting(machine, values, phases)
        setattr(machine, phase, float(phases[0]))

    return impose


def _away(draw: Draw, nominal: float, low: tuple[float, float], high: tuple[float, float]) -> float:
    """A true value off the nominal one: its factor lies in `low` or in `high`, evenly."""
    return nominal * draw.within(*(low if draw.rng.random() < 0.5 else high))


def _delay(draw: Draw, low: float, high: float) -> float:
    return round(draw.within(low, high) / SUB_STEP_S) * SUB_STEP_S


def _stribeck(draw: Draw) -> Values:
    coulomb = draw.torque(0.05, 0.16)
    return {
        "coulomb_nm": coulomb,
        "static_nm": coulomb * draw.within(1.4, 2.2),
        "stribeck_rad_s": draw.scale.speed_rad_s * draw.within(0.02, 0.15),
    }


def _put_stribeck(machine: Physics, values: Values, phases: np.ndarray) -> None:
    machine.rotor_coulomb += values["coulomb_nm"]
    machine.rotor_static = machine.rotor_coulomb + values["static_nm"] - values["coulomb_nm"]
    machine.rotor_stribeck = values["stribeck_rad_s"]


def _put_backlash(machine: Physics, values: Values, phases: np.ndarray) -> None:
    machine.half_backlash = 0.5 * values["backlash_rad"]


def _put_stiffness(machine: Physics, values: Values, phases: np.ndarray) -> None:
    # One value for all segments' sake: the first is the parameter, the others keep their ratio.
    factor = values["stiffness_nm_per_rad"] / machine.stiffness[0]
    machine.stiffness = tuple(factor * value for value in machine.stiffness)


def _put_lead(machine: Physics, values: Values, phases: np.ndarray) -> None:
    machine.rod_per_rotor = values["lead_m"] / (2.0 * np.pi * machine.gear_ratio)


_ELECTRICAL, _ROTOR, _SCREW = "motor_electrical", "motor_mechanical", "transmission"

_EFFECTS = [
    Imposed(
        "rotor_coulomb_friction",
        _ROTOR,
        lambda d: {"coulomb_nm": d.torque(0.04, 0.2)},
        _adding(rotor_coulomb="coulomb_nm"),
    ),
    Imposed(
        "rotor_viscous_friction",
        _ROTOR,
        lambda d: {"viscous_nm_s_per_rad": d.viscous(0.03, 0.25)},
        _adding(rotor_viscous="viscous_nm_s_per_rad"),
    ),
    Imposed("stribeck_friction", _ROTOR, _stribeck, _put_stribeck),
    Imposed(
        "cogging_torque",
        _ROTOR,
        lambda d: {
            "amplitude_nm": d.torque(0.015, 0.08),
            "periods_per_rev": d.one_of(6, 8, 12, 18, 24, 36),
        },
        _wave("cogging_phase", cogging_nm="amplitude_nm", cogging_periods="periods_per_rev"),
    ),
    Imposed(
        "torque_ripple",
        _ROTOR,
        lambda d: {"fraction": d.within(0.03, 0.12), "periods_per_rev": d.one_of(6, 12, 24, 36)},
        _wave("ripple_phase", ripple="fraction", ripple_periods="periods_per_rev"),
    ),
    Imposed(
        "rotor_inertia_error",
        _ROTOR,
        lambda d: {"inertia_kg_m2": _away(d, d.drive.motor.rotor_inertia, (0.6, 0.85), (1.2, 1.9))},
        _setting(rotor_inertia="inertia_kg_m2"),
    ),
    Imposed(
        "torque_constant_error",
        _ELECTRICAL,
        lambda d: {
            "torque_constant_nm_per_a": _away(
                d, d.drive.motor.torque_constant, (0.82, 0.95), (1.05, 1.18)
            )
        },
        _setting(torque_constant="torque_constant_nm_per_a"),
    ),
    Imposed(
        "back_emf_error",
        _ELECTRICAL,
        lambda d: {
            "back_emf_v_s_per_rad": _away(
                d, d.drive.motor.back_emf_constant, (0.65, 0.88), (1.12, 1.4)
            )
        },
        _setting(back_emf_constant="back_emf_v_s_per_rad"),
    ),
    Imposed(
        "resistance_error",
        _ELECTRICAL,
        lambda d: {"resistance_ohm": _away(d, d.drive.motor.resistance, (0.5, 0.75), (1.3, 2.0))},
        _setting(resistance="resistance_ohm"),
    ),
    Imposed(
        "inverter_dead_time",
        _ELECTRICAL,
        lambda d: {"voltage_v": d.within(0.06, 0.35) * d.scale.voltage_v},
        _setting(dead_time_v="voltage_v"),
    ),
    Imposed(
        "voltage_limit",
        "controller",
        lambda d: {"voltage_v": d.within(0.55, 0.85) * d.scale.voltage_v},
        _setting(voltage_limit="voltage_v"),
    ),
    Imposed(
        "current_limit",
        "controller",
        lambda d: {"current_a": d.within(0.5, 0.85) * d.scale.current_a},
        _setting(current_limit="current_a"),
    ),
    Imposed(
        "backlash_error",
        _SCREW,
        lambda d: {
            "backlash_rad": _away(d, d.drive.transmission.backlash, (0.35, 0.75), (1.3, 2.2))
        },
        _put_backlash,
    ),
    Imposed(
        "stiffness_error",
        _SCREW,
        lambda d: {"stiffness_nm_per_rad": d.drive.transmission.stiffness[0] * d.within(0.08, 0.4)},
        _put_stiffness,
    ),
    Imposed(
        "transmission_error",
        _SCREW,
        lambda d: {
            "amplitude_rad": d.within(0.005, 0.03),
            "periods_per_screw_rev": d.one_of(1, 2, 3, 4),
        },
        _wave("error_phase", error_rad="amplitude_rad", error_periods="periods_per_screw_rev"),
    ),
    Imposed(
        "lead_error",
        _SCREW,
        lambda d: {"lead_m": d.drive.transmission.lead * (1.0 + d.side() * d.within(0.0015, 0.01))},
        _put_lead,
    ),
    Imposed(
        "load_inertia_error",
        "load",
        lambda d: {"inertia_kg_m2": _away(d, d.drive.load.inertia, (0.5, 0.85), (1.2, 2.2))},
        _setting(load_inertia="inertia_kg_m2"),
    ),
    Imposed(
        "load_coulomb_friction",
        "load",
        lambda d: {"coulomb_nm": d.torque(0.04, 0.2)},
        _adding(load_coulomb="coulomb_nm"),
    ),
    Imposed(
        "load_viscous_friction",
        "load",
        lambda d: {"viscous_nm_s_per_rad": d.viscous(0.03, 0.25)},
        _adding(load_viscous="viscous_nm_s_per_rad"),
    ),
    Imposed(
        "constant_load",
        "load",
        lambda d: {"force_n": d.side() * d.force(0.05, 0.3)},
        _adding(force_n="force_n"),
    ),
    Imposed(
        "spring_load",
        "load",
        lambda d: {"stiffness_n_per_m": d.force(0.1, 0.5) / d.scale.stroke_m},
        _setting(spring_n_per_m="stiffness_n_per_m"),
    ),
    Imposed(
        "periodic_disturbance",
        "load",
        lambda d: {"amplitude_n": d.force(0.03, 0.15), "frequency_hz": d.within(1.5, 30.0)},
        _wave("periodic_phase", periodic_n="amplitude_n", periodic_hz="frequency_hz"),
    ),
    Imposed(
        "current_sensor_offset",
        "sensor",
        lambda d: {"offset_a": d.side() * d.within(0.02, 0.12) * d.scale.current_a},
        _setting(current_offset="offset_a"),
    ),
    Imposed(
        "encoder_eccentricity",
        "sensor",
        lambda d: {"amplitude_rad": 10.0 ** d.within(-3.0, -2.0)},
        _wave("eccentricity_phase", eccentricity="amplitude_rad"),
    ),
    Imposed(
        "measurement_delay",
        "timing",
        lambda d: {"delay_s": _delay(d, 5e-5, 5e-4)},
        _setting(measurement_delay_s="delay_s"),
    ),
    Imposed(
        "actuation_delay",
        "timing",
        lambda d: {"delay_s": _delay(d, 4e-5, 2e-4)},
        _adding(actuation_delay_s="delay_s"),
    ),
]


def nominal_values(drive: DriveParameters) -> dict[tuple[str, str], float]:
    """What the nominal model holds for (effect, parameter) where it holds anything, SI."""
    motor, transmission, control = drive.motor, drive.transmission, drive.controller
    return {
        ("rotor_inertia_error", "inertia_kg_m2"): motor.rotor_inertia,
        ("torque_constant_error", "torque_constant_nm_per_a"): motor.torque_constant,
        ("back_emf_error", "back_emf_v_s_per_rad"): motor.back_emf_constant,
        ("resistance_error", "resistance_ohm"): motor.resistance,
        ("voltage_limit", "voltage_v"): control.voltage_limit,
        ("current_limit", "current_a"): control.current_limit,
        ("backlash_error", "backlash_rad"): transmission.backlash,
        ("stiffness_error", "stiffness_nm_per_rad"): transmission.stiffness[0],
        ("lead_error", "lead_m"): transmission.lead,
        ("load_inertia_error", "inertia_kg_m2"): drive.load.inertia,
    }


INSIDE: dict[str, Imposed] = {effect.name: effect for effect in _EFFECTS}
