"""What a drive file says, as immutable dataclasses in SI units.

Each field carries its unit, the range that is physically possible for an electric cylinder, and
what it means. The ranges are wide: they are there to catch a value in the wrong unit (a lead in
millimetres, an inductance in millihenries), not to judge a design.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any

from ..errors import InputError
from .law import Law

_REQUIRED = object()


def _quantity(
    unit: str, low: float, high: float, meaning: str, default: Any = _REQUIRED, *, open_low=False
) -> Any:
    """A dataclass field with unit and possible range [low, high], or ]low, high] if `open_low`."""
    metadata = {"unit": unit, "low": low, "high": high, "meaning": meaning, "open_low": open_low}
    if default is _REQUIRED:
        return field(metadata=metadata)
    return field(default=default, metadata=metadata)


@dataclass(frozen=True, kw_only=True)
class MotorParameters:
    """PMSM with equal d and q inductance, i_d = 0 control (Table 2)."""

    resistance: float = _quantity("ohm", 1e-4, 1e3, "stator resistance R_s")
    inductance: float = _quantity("H", 1e-7, 1.0, "armature inductance L_a, d and q alike")
    torque_constant: float = _quantity("N m/A", 1e-4, 1e2, "torque coefficient K_t")
    back_emf_constant: float = _quantity("V s/rad", 1e-4, 1e2, "K_e, per mechanical rad/s")
    rotor_inertia: float = _quantity("kg m^2", 1e-9, 10.0, "inertia of the rotor J_Rotor")
    viscous_friction: float = _quantity("N m s/rad", 0.0, 10.0, "on the rotor, B", 0.0)
    pole_pairs: int = _quantity(
        "1", 1, 100, "electrical per mechanical revolution; the paper gives none, 4 is assumed", 4
    )


@dataclass(frozen=True, kw_only=True)
class TransmissionParameters:
    """Gears and roller screw: backlash, segmented stiffness, ratio and lead; at the rotor."""

    lead: float = _quantity("m/rev", 1e-4, 0.5, "rod travel per screw revolution")
    gear_ratio: float = _quantity("1", 1e-2, 1e3, "rotor revolutions per screw revolution")
    # A drive file may leave out these two: the coupling is then rigid, see `coupling`.
    backlash: float = _quantity("rad", 0.0, 1.0, "total backlash at the rotor, alpha")
    stiffness: tuple[float, ...] = _quantity("N m/rad", 1e-3, 1e8, "one value per torque segment")
    stiffness_breaks: tuple[float, ...] = _quantity(
        "N m", 1e-6, 1e6, "torques where one segment gives way to the next", ()
    )
    contact_damping: float = _quantity(
        "N m s/rad", 0.0, 1e4, "in contact only, pulls only without backlash", 0.0
    )

    @property
    def rod_per_rotor(self) -> float:
        """Metres of rod per radian of rotor."""
        return self.lead / (2.0 * math.pi * self.gear_ratio)


@dataclass(frozen=True, kw_only=True)
class LoadParameters:
    """Gears, screw, nut, rod and load, reduced to the rotor shaft."""

    inertia: float = _quantity("kg m^2", 1e-9, 1e2, "equivalent inertia J_eq at the rotor")
    viscous_friction: float = _quantity("N m s/rad", 0.0, 1e2, "at the rotor", 0.0)


@dataclass(frozen=True, kw_only=True)
class Gains:
    """One PI loop. Parallel form: kp + ki / s; series form, equation (6): kp + kp ki / s."""

    kp: float = _quantity("loop unit", 0.0, 1e6, "proportional gain")
    ki: float = _quantity("loop unit/s", 0.0, 1e9, "integral gain", 0.0)

    def parallel_ki(self, form: str) -> float:
        """The integral gain of the parallel form, for gains that are given in `form`."""
        return self.kp * self.ki if form == "series" else self.ki


@dataclass(frozen=True, kw_only=True)
class PositionGains(Gains):
    """The position loop's gains. With kd: ... + kd s, in the series form ... + kp kd s."""

    kd: float = _quantity(
        "loop unit s", 0.0, 1e6, "derivative gain, on reference velocity less speed feedback", 0.0
    )


# The class behind each loop's gains.
LOOPS: dict[str, type[Gains]] = {"position": PositionGains, "speed": Gains, "current": Gains}


@dataclass(frozen=True, kw_only=True)
class ControllerParameters:
    """The cascade and how it is sampled."""

    rate: float = _quantity("Hz", 1.0, 1e6, "control rate")
    position: PositionGains
    speed: Gains
    current: Gains
    structure: str = field(
        default="cascade",
        metadata={
            "choices": ("cascade", "position_to_current"),
            "meaning": "with position_to_current there is no speed loop (its gains must be 0): the "
            "position loop commands the current, kp in A/rad, ki in A/(rad s), kd in A s/rad",
        },
    )
    feedback: str = field(
        default="rotor",
        metadata={"choices": ("rotor", "rod"), "meaning": "where the position loop closes"},
    )
    form: str = field(
        default="parallel",
        metadata={"choices": ("parallel", "series"), "meaning": "of the PI gains"},
    )
    delay_ticks: int = _quantity("ticks", 0, 64, "from sampling to the inverter", 0)
    feed_scale: float = _quantity(
        "1", 1e-2, 1e2, "feed constant that the controller is set to, over the lead", 1.0
    )
    velocity_feedforward: float = _quantity("1", 0.0, 2.0, "share of the reference velocity", 0.0)
    acceleration_feedforward: float = _quantity(
        "A s^2/rad", 0.0, 1e3, "current command per rad/s^2 of the reference, at the rotor", 0.0
    )
    setpoint_filter: float = _quantity(
        "s", 0.0, 10.0, "low-pass on the reference before the position loop; 0: none", 0.0
    )
    current_command_filter: float = _quantity(
        "s", 0.0, 1.0, "low-pass on the current command; 0: none", 0.0
    )
    speed_source: str = field(
        default="measured",
        metadata={
            "choices": ("measured", "differences"),
            "meaning": "speed feedback: the speed reading, or the encoder's steps over a tick",
        },
    )
    speed_filter: float = _quantity(
        "s", 0.0, 1.0, "low-pass on the speed feedback, whatever its source; 0: none", 0.0
    )
    speed_limit: float = _quantity(
        "rad/s", 0.0, math.inf, "largest rotor speed command", math.inf, open_low=True
    )
    current_limit: float = _quantity(
        "A", 0.0, math.inf, "the speed integral holds while it acts", math.inf, open_low=True
    )
    voltage_limit: float = _quantity(
        "V", 0.0, math.inf, "the current integral holds while it acts", math.inf, open_low=True
    )


@dataclass(frozen=True, kw_only=True)
class SensorParameters:
    """Standard deviations and resolutions of the measured signals; the loop sees them too."""

    rotor_position_noise: float = _quantity("rad", 0.0, 1.0, "standard deviation", 0.0)
    rotor_velocity_noise: float = _quantity("rad/s", 0.0, 100.0, "standard deviation", 0.0)
    current_noise: float = _quantity("A", 0.0, 100.0, "standard deviation", 0.0)
    rod_position_noise: float = _quantity("m", 0.0, 0.1, "standard deviation", 0.0)
    rotor_position_resolution: float = _quantity("rad", 0.0, 1.0, "encoder step; 0: none", 0.0)
    rod_position_resolution: float = _quantity("m", 0.0, 0.1, "scale step; 0: none", 0.0)
    noise_seed: int = _quantity("1", 0, 2**31 - 1, "the same seed gives the same noise", 1)


@dataclass(frozen=True, kw_only=True)
class LimitParameters:
    """What setpoints may ask of the rod; live setpoints and moves stay within them."""

    stroke_min: float = _quantity("m", -100.0, 100.0, "lowest rod position", -0.25)
    stroke_max: float = _quantity("m", -100.0, 100.0, "highest rod position", 0.25)
    speed: float = _quantity("m/s", 1e-6, 100.0, "rod speed", 0.5)
    acceleration: float = _quantity("m/s^2", 1e-6, 1e5, "rod acceleration", 5.0)
    jerk: float = _quantity("m/s^3", 1e-6, 1e8, "rod jerk", 200.0)


@dataclass(frozen=True, kw_only=True)
class DriveParameters:
    """Everything a drive file holds. SI units; angles, inertias and torques at the rotor."""

    motor: MotorParameters
    transmission: TransmissionParameters
    load: LoadParameters
    controller: ControllerParameters
    sensors: SensorParameters = field(default_factory=SensorParameters)
    limits: LimitParameters = field(default_factory=LimitParameters)
    telemetry_rate: float = _quantity("Hz", 0.1, 1e6, "samples a second on the topics", 1000.0)
    # What the machine has beyond its nominal model: {effect: {parameter: value}}, see `effects`.
    effects: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    # What a diagnosis found beyond all effects that have a name, see `law`.
    learned: Law | None = None
    # How far its constants may lie from these, as the file states it; see `tolerances`.
    tolerances: Mapping[str, float | str] = field(default_factory=dict)
    # Keys of the coupling that its file leaves out, filled in as `coupling` has them.
    left_out: tuple[str, ...] = ()

    @property
    def telemetry_every(self) -> int:
        """Control ticks per telemetry sample: the whole number nearest to the rates' ratio."""
        return max(1, round(self.controller.rate / self.telemetry_rate))

    @property
    def sample_rate(self) -> float:
        """Telemetry samples per second as they come, the control rate over a whole number, Hz."""
        return self.controller.rate / self.telemetry_every


# The dataclass behind each key that holds a group, in the order a drive file is written.
GROUPS: dict[str, type] = {
    "motor": MotorParameters,
    "transmission": TransmissionParameters,
    "load": LoadParameters,
    "controller": ControllerParameters,
    "sensors": SensorParameters,
    "limits": LimitParameters,
}


def check_relations(drive: DriveParameters, source: str) -> None:
    """Refuse values that are possible one by one but not together; raises InputError."""
    transmission, limits = drive.transmission, drive.limits
    expected = len(transmission.stiffness) - 1
    if len(transmission.stiffness_breaks) != expected:
        raise InputError(
            f"{source}: transmission.stiffness_breaks has {len(transmission.stiffness_breaks)} "
            f"values, expected {expected}: one fewer than transmission.stiffness"
        )
    pairs = zip(transmission.stiffness_breaks, transmission.stiffness_breaks[1:], strict=False)
    if any(later <= earlier for earlier, later in pairs):
        raise InputError(
            f"{source}: transmission.stiffness_breaks = {list(transmission.stiffness_breaks)}, "
            "expected increasing torques in N m"
        )
    if limits.stroke_min >= limits.stroke_max:
        raise InputError(
            f"{source}: limits.stroke_min = {limits.stroke_min:g} m, expected less than "
            f"limits.stroke_max = {limits.stroke_max:g} m"
        )
    _check_structure(drive.controller, source)


def _check_structure(controller: ControllerParameters, source: str) -> None:
    """Refuse values of a speed loop that is not there."""
    if controller.structure == "cascade":
        return
    for key, value, wanted in (
        ("speed.kp", controller.speed.kp, 0.0),
        ("speed.ki", controller.speed.ki, 0.0),
        ("velocity_feedforward", controller.velocity_feedforward, 0.0),
        ("speed_limit", controller.speed_limit, math.inf),
    ):
        if value != wanted:
            expected = "none" if wanted else "0"
            raise InputError(
                f"{source}: controller.{key} = {value:g}, expected {expected}: with "
                f"controller.structure {controller.structure} there is no speed loop"
            )


def leaf_fields() -> dict[str, Any]:
    """Every dotted key of a drive file with its dataclass field, in file order."""
    leaves: dict[str, Any] = {}
    for group, kind in GROUPS.items():
        for item in fields(kind):
            if item.metadata:
                leaves[f"{group}.{item.name}"] = item
            else:  # a PI loop
                gains = fields(LOOPS[item.name])
                leaves |= {f"{group}.{item.name}.{gain.name}": gain for gain in gains}
    leaves |= {item.name: item for item in fields(DriveParameters) if item.metadata}
    return leaves
