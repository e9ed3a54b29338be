"""The drive's constants as one NumPy record, the form that compiled functions take them in.

`DriveParameters` is what people and files see; `pack` turns it into a record of float64 with the
derived quantities (deflections where stiffness segments meet, metres of rod per rotor radian)
worked out once. A record keeps its field names inside compiled code and costs no more to pass than
an array.
"""

from __future__ import annotations

import math

import numpy as np

from ..effects import learned
from ..effects.catalogue import CATALOGUE, MODULES
from ..effects.ports import ARGUMENTS, AT_PORTS, IN_PLANT
from .filters import kept_share
from .friction import BREAKAWAY_RAD, BRISTLE_DAMPING_S
from .parameters import DriveParameters

MAX_SEGMENTS = 8

PACKED = np.dtype(
    [
        ("resistance", "f8"),
        ("inductance", "f8"),
        ("per_inductance", "f8"),  # reciprocals: a product costs less than a division
        ("per_rotor_inertia", "f8"),
        ("per_load_inertia", "f8"),
        ("torque_constant", "f8"),
        ("back_emf_constant", "f8"),
        ("pole_pairs", "f8"),
        ("rotor_viscous", "f8"),
        ("rod_per_rotor", "f8"),  # m of rod per rad of rotor-side angle, in truth
        ("gear_ratio", "f8"),
        ("half_backlash", "f8"),
        ("segments", "i8"),
        ("stiffness", "f8", (MAX_SEGMENTS,)),
        ("deflection_start", "f8", (MAX_SEGMENTS,)),  # rad, where each segment begins
        ("torque_start", "f8", (MAX_SEGMENTS,)),  # N m, elastic torque there
        ("contact_damping", "f8"),
        ("load_viscous", "f8"),
        ("tick", "f8"),  # s, control period
        ("substeps", "i8"),
        ("current_span", "f8"),  # A, over which an effect bends the winding's equation; 0: none
        ("actuation_delay", "f8"),  # ticks, broken ones too
        ("measurement_delay", "f8"),  # ticks, broken ones too
        ("feedback_rod", "i8"),
        ("believed_rotor_per_rod", "f8"),  # rad/m, what the controller reckons with
        ("velocity_feedforward", "f8"),
        ("acceleration_feedforward", "f8"),
        ("position_to_current", "i8"),  # no speed loop
        ("speed_by_differences", "i8"),
        ("setpoint_kept", "f8"),  # shares that filters keep each tick, see filters
        ("current_command_kept", "f8"),
        ("speed_kept", "f8"),
        ("position_kp", "f8"),
        ("position_ki", "f8"),
        ("position_kd", "f8"),
        ("speed_kp", "f8"),
        ("speed_ki", "f8"),
        ("current_kp", "f8"),
        ("current_ki", "f8"),
        ("speed_limit", "f8"),
        ("current_limit", "f8"),
        ("voltage_limit", "f8"),
        ("rotor_position_noise", "f8"),
        ("rotor_velocity_noise", "f8"),
        ("current_noise", "f8"),
        ("rod_position_noise", "f8"),
        ("rotor_position_resolution", "f8"),
        ("rod_position_resolution", "f8"),
        ("noise_seed", "u8"),
        ("rotor_breakaway", "f8"),  # rad, see friction
        ("load_breakaway", "f8"),
        ("rotor_bristle_damping", "f8"),  # s
        ("load_bristle_damping", "f8"),
        # Whether any effect acts at a port: the others cost nothing.
        *((f"acts_at_{port}", "i8") for port in ARGUMENTS),
        ("acts_in_plant", "i8"),  # at any of IN_PLANT
        *learned.FIELDS,
        *(
            (effect.field_name(parameter.name), "f8")
            for effect in CATALOGUE.values()
            if effect.name in AT_PORTS
            for parameter in effect.parameters
        ),
    ]
)


# Rate x step that sub-steps keep to. A fourth-order step then errs by some 1e-6 of the fastest
# oscillation per radian of it; `python benchmarks/convergence.py` prints what halving it changes.
RATE_STEP = 0.1


def fastest_rate(drive: DriveParameters) -> float:
    """Largest rate constant of the plant, 1/s: contact resonance, contact damping, R/L, bristles.

    By the drive's constants, or those that its effects put in their place where these are faster.
    What an effect makes of the winding's is not in it: `stiff_current` has pieces of its own.
    """
    return _fastest_rate(_records(drive, drive), drive)


def _fastest_rate(records: tuple[np.ndarray, ...], drive: DriveParameters) -> float:
    """See `fastest_rate`; records: of the drive without its effects, and with them."""
    return max(_rate(record[0], drive) for record in records)


def _rate(record: np.void, drive: DriveParameters) -> float:
    """The same by the constants of one record."""
    per_inertia = {side: float(record[f"per_{side}_inertia"]) for side in ("rotor", "load")}
    compliance = sum(per_inertia.values())
    resonance = math.sqrt(float(np.max(record["stiffness"])) * compliance)
    damping = float(record["contact_damping"]) * compliance
    electrical = float(record["resistance"] * record["per_inductance"])
    bristle = 0.0
    for name, values in drive.effects.items():
        for side, per_kg_m2 in per_inertia.items():
            if hasattr(MODULES[name], f"{side}_friction"):
                level = max((v for k, v in values.items() if k.endswith("_nm")), default=0.0)
                breakaway = values.get("breakaway_rad", BREAKAWAY_RAD)
                bristle = max(bristle, math.sqrt(abs(level) * per_kg_m2 / breakaway))
    law = drive.learned
    if law is not None:
        bristle = max(bristle, learned.rate(law, drive))
        if law.of_friction:
            level = max(0.0, *law.values)
            per_kg_m2 = per_inertia["load" if law.on_load else "rotor"]
            bristle = max(bristle, math.sqrt(level * per_kg_m2 / BREAKAWAY_RAD))
    return max(resonance, damping, electrical, bristle)


def current_span(drive: DriveParameters) -> float:
    """The least current over which an effect bends the winding's equation, A; 0 where none does."""
    spans = (CATALOGUE[n].current_span(CATALOGUE[n].complete(v)) for n, v in drive.effects.items())
    return min((one for one in spans if one > 0.0), default=0.0)


def choose_substeps(drive: DriveParameters, rate_step: float = RATE_STEP) -> int:
    """Sub-steps per control tick that keep rate x step <= `rate_step`."""
    return _substeps(fastest_rate(drive), drive, rate_step)


def _substeps(rate: float, drive: DriveParameters, rate_step: float) -> int:
    return max(1, math.ceil(rate / (rate_step * drive.controller.rate) - 1e-9))


def pack(
    drive: DriveParameters,
    *,
    substeps: int | None = None,
    rate_step: float = RATE_STEP,
    believed: DriveParameters | None = None,
) -> np.ndarray:
    """Pack `drive` into a one-element record array of dtype `PACKED`.

    substeps: overrides the automatic choice (for convergence studies). rate_step: of that choice.
    believed: the drive that the controller was set up for, where its constants are not those of
    `drive`.
    """
    records = _records(drive, believed or drive)
    if substeps is None:
        substeps = _substeps(_fastest_rate(records, drive), drive, rate_step)
    _, record = records
    record["substeps"] = substeps
    return record


def _records(drive: DriveParameters, believed: DriveParameters) -> tuple[np.ndarray, np.ndarray]:
    """The record of `pack` without its effects, and with them; sub-steps are in neither."""
    record = np.zeros(1, PACKED)
    motor, transmission, load = drive.motor, drive.transmission, drive.load
    controller, sensors = drive.controller, drive.sensors
    values: dict[str, float] = {
        "resistance": motor.resistance,
        "inductance": motor.inductance,
        "per_inductance": 1.0 / motor.inductance,
        "per_rotor_inertia": 1.0 / motor.rotor_inertia,
        "per_load_inertia": 1.0 / load.inertia,
        "torque_constant": motor.torque_constant,
        "back_emf_constant": motor.back_emf_constant,
        "pole_pairs": motor.pole_pairs,
        "rotor_viscous": motor.viscous_friction,
        "rod_per_rotor": transmission.rod_per_rotor,
        "gear_ratio": transmission.gear_ratio,
        "half_backlash": 0.5 * transmission.backlash,
        "contact_damping": transmission.contact_damping,
        "load_viscous": load.viscous_friction,
        "tick": 1.0 / controller.rate,
        "current_span": current_span(drive),
        "actuation_delay": controller.delay_ticks,
        "feedback_rod": controller.feedback == "rod",
        "believed_rotor_per_rod": 1.0
        / (believed.transmission.rod_per_rotor * controller.feed_scale),
        "velocity_feedforward": controller.velocity_feedforward,
        "acceleration_feedforward": controller.acceleration_feedforward,
        "position_to_current": controller.structure == "position_to_current",
        "speed_by_differences": controller.speed_source == "differences",
        "setpoint_kept": kept_share(controller.setpoint_filter, controller.rate),
        "current_command_kept": kept_share(controller.current_command_filter, controller.rate),
        "speed_kept": kept_share(controller.speed_filter, controller.rate),
        "speed_limit": controller.speed_limit,
        "current_limit": controller.current_limit,
        "voltage_limit": controller.voltage_limit,
        "rotor_position_noise": sensors.rotor_position_noise,
        "rotor_velocity_noise": sensors.rotor_velocity_noise,
        "current_noise": sensors.current_noise,
        "rod_position_noise": sensors.rod_position_noise,
        "rotor_position_resolution": sensors.rotor_position_resolution,
        "rod_position_resolution": sensors.rod_position_resolution,
        "noise_seed": sensors.noise_seed,
        "rotor_breakaway": BREAKAWAY_RAD,
        "load_breakaway": BREAKAWAY_RAD,
        "rotor_bristle_damping": BRISTLE_DAMPING_S,
        "load_bristle_damping": BRISTLE_DAMPING_S,
    }
    for loop in ("position", "speed", "current"):
        gains = getattr(controller, loop)
        values[f"{loop}_kp"] = gains.kp
        # Equation (6) is the series form Kp Ki / s + Kp; the parallel form is kp + ki / s.
        values[f"{loop}_ki"] = gains.parallel_ki(controller.form)
    position = controller.position
    values["position_kd"] = position.kd * (position.kp if controller.form == "series" else 1.0)
    for name, value in values.items():
        record[name] = value

    count = len(transmission.stiffness)
    record["segments"] = count
    deflection = torque = 0.0
    for index, stiffness in enumerate(transmission.stiffness):
        record["stiffness"][0, index] = stiffness
        record["deflection_start"][0, index] = deflection
        record["torque_start"][0, index] = torque
        if index < count - 1:
            deflection += (transmission.stiffness_breaks[index] - torque) / stiffness
            torque = transmission.stiffness_breaks[index]
    stated = record.copy()
    _put_effects(record, drive)
    return stated, record


def _put_effects(record: np.ndarray, drive: DriveParameters) -> None:
    if drive.learned is not None:
        learned.put(record, drive.learned, drive)
    for name, given in drive.effects.items():
        effect, module = CATALOGUE[name], MODULES[name]
        values = effect.complete(given)
        if effect.modify is not None:
            effect.modify(record, values, drive)
        if name not in AT_PORTS:
            continue
        for parameter, value in values.items():
            record[effect.field_name(parameter)] = value
        for port in ARGUMENTS:
            if hasattr(module, port):
                record[f"acts_at_{port}"] = 1
                if port in IN_PLANT:
                    record["acts_in_plant"] = 1
