"""Causes that the contract's catalogue does not hold: a diagnosis has to say that it does not know.

A diagnosis may know some of them under a name of its own, their `twin`; it is not given that name
where the case is to be outside its catalogue.

Each differs in form from every effect of the contract and from their sums, so that something is
left over whatever is fitted; `x_current_sensor_gain` and `x_low_supply` leave least. Those of the
controller at the end are what a drive's set-up may hide: gains, feedforwards, filters.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .imposed import Draw, Imposed, Values
from .physics import Physics


def _jam(draw: Draw) -> Values:
    return {
        "coulomb_nm": draw.torque(0.2, 0.5),
        "place_m": draw.place(),
        "width_m": draw.within(0.05, 0.15) * draw.scale.stroke_m,
    }


def _put_jam(machine: Physics, values: Values, phases: np.ndarray) -> None:
    machine.jam_nm = values["coulomb_nm"]
    machine.jam_place = values["place_m"] / machine.rod_per_rotor
    machine.jam_width = values["width_m"] / machine.rod_per_rotor


def _put_load_dependent(machine: Physics, values: Values, phases: np.ndarray) -> None:
    machine.load_dependent = values["coefficient"]


def _put_one_way(machine: Physics, values: Values, phases: np.ndarray) -> None:
    machine.load_one_way_viscous = values["viscous_nm_s_per_rad"]


def _put_drag(machine: Physics, values: Values, phases: np.ndarray) -> None:
    machine.rotor_drag = values["drag_nm_s2_per_rad2"]


def _put_hysteresis(machine: Physics, values: Values, phases: np.ndarray) -> None:
    machine.hysteresis_nm = values["torque_nm"]
    machine.hysteresis_rad = values["twist_rad"]


def _put_hardening(machine: Physics, values: Values, phases: np.ndarray) -> None:
    # Soft at first contact, as stiff as nominal at the peak torque and stiffer beyond.
    soft = values["soft_share"]
    deflection = values["torque_nm"] / machine.stiffness[0]
    machine.stiffness = tuple(soft * value for value in machine.stiffness)
    machine.hardening = (1.0 / soft - 1.0) / deflection


def _put_current_gain(machine: Physics, values: Values, phases: np.ndarray) -> None:
    machine.current_gain = values["gain_error"]


def _put_low_supply(machine: Physics, values: Values, phases: np.ndarray) -> None:
    machine.inverter_gain = values["gain"]


def _put_presliding(machine: Physics, values: Values, phases: np.ndarray) -> None:
    machine.rotor_coulomb += values["coulomb_nm"]
    machine.rotor_bristle_rad = values["bristle_rad"]


def _put_warming_friction(machine: Physics, values: Values, phases: np.ndarray) -> None:
    machine.rotor_coulomb += values["coulomb_nm"]
    machine.rotor_friction_decay = values["decay_per_s"]


def _put_warming_winding(machine: Physics, values: Values, phases: np.ndarray) -> None:
    machine.resistance_rise = values["rise_per_s"]


def _put_structure(machine: Physics, values: Values, phases: np.ndarray) -> None:
    machine.structure_inertia = values["share"] * machine.load_inertia
    machine.structure_rate = 2.0 * np.pi * values["frequency_hz"]
    machine.structure_damping = values["damping"]


def _put_end_stop(machine: Physics, values: Values, phases: np.ndarray) -> None:
    machine.end_stop_m = values["place_m"]
    machine.end_stop_n_per_m = values["stiffness_n_per_m"]


def _end_stop(draw: Draw) -> Values:
    place = draw.within(0.3, 0.5) * draw.scale.stroke_m
    return {
        "place_m": place,
        "stiffness_n_per_m": draw.force(0.3, 0.8) / (0.3 * draw.scale.stroke_m),
    }


def _put_wear(machine: Physics, values: Values, phases: np.ndarray) -> None:
    machine.wear = values["share"]
    machine.wear_place = values["place_m"] / machine.rod_per_rotor
    machine.wear_width = values["width_m"] / machine.rod_per_rotor


def _put_random(machine: Physics, values: Values, phases: np.ndarray) -> None:
    machine.random_nm = values["torque_nm"]
    machine.random_rate = values["corner_rad_s"]


def _put_cogging_pair(machine: Physics, values: Values, phases: np.ndarray) -> None:
    machine.cogging_nm = values["amplitude_nm"]
    machine.cogging_periods = values["periods_per_rev"]
    machine.cogging_phase = float(phases[0])
    machine.second_cogging_nm = values["second_amplitude_nm"]
    machine.second_cogging_periods = values["second_periods_per_rev"]
    machine.second_cogging_phase = float(phases[1])


def _cogging_pair(draw: Draw) -> Values:
    first, second = draw.rng.choice([4, 6, 8, 12, 18, 24], size=2, replace=False)
    amplitude = draw.torque(0.02, 0.08)
    return {
        "amplitude_nm": amplitude,
        "periods_per_rev": float(first),
        "second_amplitude_nm": amplitude * draw.within(0.7, 1.3),
        "second_periods_per_rev": float(second),
    }


def _put_second_eccentricity(machine: Physics, values: Values, phases: np.ndarray) -> None:
    machine.second_eccentricity = values["amplitude_rad"]
    machine.second_eccentricity_phase = float(phases[0])


def _off(draw: Draw, nominal: float, low: tuple[float, float], high: tuple[float, float]) -> float:
    """A true value whose factor to the nominal one lies in `low` or in `high`, evenly."""
    return nominal * draw.within(*(low if draw.rng.random() < 0.5 else high))


def _integral(draw: Draw, loop: str, scale: float) -> Values:
    """A true integral gain, parallel form; for a loop without one a share of `scale`."""
    gains, series = getattr(draw.drive.controller, loop), draw.drive.controller.form == "series"
    nominal = gains.ki * (gains.kp if series else 1.0)
    if nominal > 0.0:
        return {"ki": _off(draw, nominal, (0.2, 0.6), (1.7, 4.0))}
    return {"ki": scale * draw.within(0.03, 0.3)}


def _share(draw: Draw) -> Values:
    """A share of velocity feedforward, apart from the nominal one."""
    nominal = draw.drive.controller.velocity_feedforward
    share = draw.within(0.2, 1.0)
    return {"share": share if abs(share - nominal) > 0.1 else abs(nominal - 0.5)}


def _push(draw: Draw) -> Values:
    """Current for acceleration, of what would move rotor and load by itself."""
    motor, nominal = draw.drive.motor, draw.drive.controller.acceleration_feedforward
    if nominal > 0.0:
        return {"gain_a_s2_per_rad": _off(draw, nominal, (0.0, 0.7), (1.4, 2.0))}
    inertia = motor.rotor_inertia + draw.drive.load.inertia
    return {"gain_a_s2_per_rad": inertia / motor.torque_constant * draw.within(0.3, 1.2)}


def _gain(name: str, loop: str, low: tuple[float, float], high: tuple[float, float]) -> Imposed:
    """Another proportional gain of a loop; its integral gain stays."""

    def draw(d: Draw) -> Values:
        return {"kp": _off(d, getattr(d.drive.controller, loop).kp, low, high)}

    return Imposed(
        name, "controller", draw, _setting(f"{loop}_kp", "kp"), twin=f"{loop}_gain_error"
    )


def _setting(field: str, parameter: str) -> Callable[[Physics, Values, np.ndarray], None]:
    def impose(machine: Physics, values: Values, phases: np.ndarray) -> None:
        setattr(machine, field, values[parameter])

    return impose


def _filter(name: str, field: str, low: float, high: float) -> Imposed:
    """A low-pass with a time constant between `low` and `high`, s."""

    def draw(d: Draw) -> Values:
        return {"time_constant_s": d.within(low, high)}

    impose = _setting(field, "time_constant_s")
    return Imposed(name, "controller", draw, impose, twin=name.removeprefix("x_"))


def _put_feed_constant(machine: Physics, values: Values, phases: np.ndarray) -> None:
    machine.nominal_rod_per_rotor *= 1.0 + values["error"]


_ROTOR = "motor_mechanical"

_CONTROLLER = [
    _gain("x_position_gain", "position", (0.6, 0.88), (1.12, 1.5)),
    _gain("x_speed_gain", "speed", (0.5, 0.8), (1.25, 1.7)),
    _gain("x_current_gain", "current", (0.4, 0.7), (1.4, 2.0)),
    Imposed(
        "x_position_integral",
        "controller",
        lambda d: _integral(d, "position", d.drive.controller.position.kp**2),
        _setting("position_ki", "ki"),
        twin="position_integral_error",
    ),
    Imposed(
        "x_speed_integral",
        "controller",
        lambda d: _integral(d, "speed", 100.0 * d.drive.controller.speed.kp),
        _setting("speed_ki", "ki"),
        twin="speed_integral_error",
    ),
    Imposed(
        "x_current_integral",
        "controller",
        lambda d: _integral(d, "current", 1000.0 * d.drive.controller.current.kp),
        _setting("current_ki", "ki"),
        twin="current_integral_error",
    ),
    Imposed(
        "x_feed_constant",
        "controller",
        lambda d: {"error": d.side() * d.within(1e-3, 2e-2)},
        _put_feed_constant,
        twin="feed_constant_error",
    ),
    Imposed(
        "x_velocity_feedforward",
        "controller",
        _share,
        _setting("velocity_feedforward", "share"),
        twin="velocity_feedforward_error",
    ),
    Imposed(
        "x_acceleration_feedforward",
        "controller",
        _push,
        _setting("acceleration_feedforward", "gain_a_s2_per_rad"),
        twin="acceleration_feedforward_error",
    ),
    _filter("x_command_filter", "setpoint_filter_s", 1e-3, 2e-2),
    _filter("x_current_command_filter", "current_filter_s", 2e-4, 8e-4),
    _filter("x_feedback_filter", "speed_filter_s", 2e-4, 1e-3),
]

_EFFECTS = [
    Imposed("x_local_jam", "load", _jam, _put_jam, twin="local_jam"),
    Imposed(
        "x_load_dependent_friction",
        "load",
        lambda d: {"coefficient": d.within(0.1, 0.3)},
        _put_load_dependent,
        twin="load_dependent_friction",
    ),
    Imposed(
        "x_direction_dependent_friction",
        "load",
        lambda d: {"viscous_nm_s_per_rad": d.viscous(0.1, 0.3)},
        _put_one_way,
        twin="direction_dependent_friction",
    ),
    Imposed(
        "x_quadratic_drag",
        _ROTOR,
        lambda d: {"drag_nm_s2_per_rad2": d.viscous(0.1, 0.3) / d.scale.speed_rad_s},
        _put_drag,
    ),
    Imposed(
        "x_transmission_hysteresis",
        "transmission",
        lambda d: {
            "torque_nm": d.torque(0.08, 0.25),
            "twist_rad": d.drive.transmission.backlash * d.within(0.15, 0.5),
        },
        _put_hysteresis,
    ),
    Imposed(
        "x_hardening_stiffness",
        "transmission",
        lambda d: {"soft_share": d.within(0.03, 0.12), "torque_nm": d.torque(0.8, 1.2)},
        _put_hardening,
        twin="stiffness_hardening",
    ),
    Imposed(
        "x_current_sensor_gain",
        "sensor",
        lambda d: {"gain_error": d.side() * d.within(0.06, 0.2)},
        _put_current_gain,
        twin="current_sensor_gain",
    ),
    Imposed(
        "x_low_supply",
        "motor_electrical",
        lambda d: {"gain": d.within(0.7, 0.9)},
        _put_low_supply,
        twin="inverter_gain",
    ),
    Imposed(
        "x_presliding_friction",
        _ROTOR,
        lambda d: {"coulomb_nm": d.torque(0.08, 0.25), "bristle_rad": d.within(0.1, 0.4)},
        _put_presliding,
    ),
    Imposed(
        "x_warming_friction",
        _ROTOR,
        lambda d: {"coulomb_nm": d.torque(0.12, 0.3), "decay_per_s": d.within(0.1, 0.3)},
        _put_warming_friction,
        twin="friction_drift",
    ),
    Imposed(
        "x_warming_winding",
        "motor_electrical",
        lambda d: {"rise_per_s": d.within(0.05, 0.12)},
        _put_warming_winding,
    ),
    Imposed(
        "x_structural_resonance",
        "load",
        lambda d: {
            "share": d.within(0.2, 0.5),
            "frequency_hz": d.within(8.0, 35.0),
            "damping": d.within(0.02, 0.06),
        },
        _put_structure,
    ),
    Imposed("x_end_stop_spring", "load", _end_stop, _put_end_stop),
    Imposed(
        "x_worn_place",
        "transmission",
        lambda d: {
            "share": d.within(0.8, 2.0),
            "place_m": d.place(),
            "width_m": d.within(0.1, 0.3) * d.scale.stroke_m,
        },
        _put_wear,
    ),
    Imposed(
        "x_random_torque",
        _ROTOR,
        lambda d: {"torque_nm": d.torque(0.02, 0.08), "corner_rad_s": d.within(30.0, 200.0)},
        _put_random,
    ),
    Imposed(
        "x_cogging_pair", _ROTOR, _cogging_pair, _put_cogging_pair, frozenset({"cogging_torque"})
    ),
    Imposed(
        "x_encoder_second_harmonic",
        "sensor",
        lambda d: {"amplitude_rad": 10.0 ** d.within(-3.0, -2.2)},
        _put_second_eccentricity,
    ),
    *_CONTROLLER,
]

OUTSIDE: dict[str, Imposed] = {effect.name: effect for effect in _EFFECTS}
