"""A drive in the terms that simulators share: joints, contact between them, and a servo.

What a simulator of rigid bodies has no word for is collected in plain sentences as it is met, and
each format adds what it cannot express itself.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import Any

from ..drive.packed import pack
from ..drive.parameters import DriveParameters
from ..drive.rigid.machine import Machine
from ..drive.rigid.packed import model_of
from ..effects.catalogue import CATALOGUE
from ..errors import InputError


@dataclass(frozen=True, kw_only=True)
class Joint:
    """One degree of freedom; SI, of a slide in N and m, of a hinge in N m and rad.

    Attributes:
        name: as in `/ecyl/joint_states`.
        linear: a slide, else a hinge.
        inertia: mass in kg, or inertia in kg m^2.
        damping, friction, stiffness: per speed, level of Coulomb friction, of a spring to zero.
        constant: effort that pushes against positive motion.
        low, high: of its travel; None without a stop.
        speed, effort: largest; None where nothing limits it.
    """

    name: str
    linear: bool
    inertia: float
    damping: float = 0.0
    friction: float = 0.0
    stiffness: float = 0.0
    constant: float = 0.0
    low: float | None = None
    high: float | None = None
    speed: float | None = None
    effort: float | None = None


@dataclass(frozen=True, kw_only=True)
class Contact:
    """Clearance and flank between rotor and rod, counted at the rotor.

    rod_per_rotor: m/rad. backlash: total, rad. stiffness: N m/rad. damping: N m s/rad, in contact
    only, pulls only where there is no backlash.
    """

    rod_per_rotor: float
    backlash: float
    stiffness: float
    damping: float


@dataclass(frozen=True, kw_only=True)
class Servo:
    """A position loop without integral, at the output: effort = kp x error - kv x speed."""

    kp: float
    kv: float


@dataclass(frozen=True, kw_only=True)
class Mechanism:
    """What `of` returns.

    Attributes:
        name: of the drive.
        output: what is moved. rotor, contact: what moves it; None for a rigid drive, whose servo
            and gain act on the output.
        gain: effort of the rotor (of a rigid drive: of the output) per unit of `signal`.
        signal: what the motor is told: A, V, N or N m. signal_limit: its largest value.
        servo: None where the drive file has no gains.
        step_s: a time step that the fastest oscillation bears.
        left_out: what simulators of rigid bodies have no word for, one sentence each.
    """

    name: str
    output: Joint
    rotor: Joint | None = None
    contact: Contact | None = None
    gain: float = 1.0
    signal: str = "A"
    signal_limit: float | None = None
    servo: Servo | None = None
    step_s: float = 1e-3
    left_out: tuple[str, ...] = ()


# Radians of the fastest oscillation in a step. The classical Runge-Kutta method then errs by some
# 0.4^5 / 120 = 1e-4 of a radian a step.
_STEP_RAD = 0.4
_SLOWEST_HZ = 1000.0  # steps are whole fractions of 1 ms

# What is read of the packed record. An effect that changes nothing else is taken over whole.
_READ = frozenset(
    (
        *("rod_per_rotor", "torque_constant", "current_limit", "per_rotor_inertia"),
        *("per_load_inertia", "rotor_viscous", "load_viscous", "half_backlash", "contact_damping"),
        *("stiffness", "segments", "torque_start", "deflection_start"),
        *("position_kp", "position_kd", "speed_kp", "position_to_current"),
    )
)
_STEPPING = frozenset(("substeps", "finer"))  # of the engine's integration
# Effects that joints have a word for, though the record keeps them apart.
_AS_JOINTS = frozenset(
    (
        *("rotor_coulomb_friction", "load_coulomb_friction", "stribeck_friction"),
        *("constant_load", "spring_load"),
    )
)


def of(drive: DriveParameters | Machine, name: str) -> Mechanism:
    """The drive as joints, contact and servo.

    Raises:
        InputError: a rigid drive without an inertia, or a follower, of which no force is known.
    """
    if isinstance(drive, DriveParameters):
        return _cylinder(drive, name)
    return _rigid(drive, name)


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _cylinder(drive: DriveParameters, name: str) -> Mechanism:
    p = pack(drive)[0]  # with all effects that are another value of a constant
    ratio = float(p["rod_per_rotor"])
    torque_constant, current_limit = float(p["torque_constant"]), float(p["current_limit"])
    effects = {key: CATALOGUE[key].complete(values) for key, values in drive.effects.items()}
    rotor_inertia, load_inertia = (
        1.0 / float(p["per_rotor_inertia"]),
        1.0 / float(p["per_load_inertia"]),
    )
    contact, left_out = _contact(p)

    def value(effect: str, key: str) -> float:
        return effects.get(effect, {}).get(key, 0.0)

    rotor = Joint(
        name="rotor",
        linear=False,
        inertia=rotor_inertia,
        damping=float(p["rotor_viscous"]),
        friction=value("rotor_coulomb_friction", "coulomb_nm")
        + value("stribeck_friction", "coulomb_nm"),
        effort=_finite(torque_constant * current_limit),
    )
    rod = Joint(
        name="rod",
        linear=True,
        inertia=load_inertia / ratio**2,
        damping=float(p["load_viscous"]) / ratio**2,
        friction=value("load_coulomb_friction", "coulomb_nm") / ratio,
        stiffness=value("spring_load", "stiffness_n_per_m"),
        constant=value("constant_load", "force_n"),
        low=drive.limits.stroke_min,
        high=drive.limits.stroke_max,
        speed=drive.limits.speed,
        effort=_finite(torque_constant * current_limit / ratio),
    )
    compliance = 1.0 / rotor_inertia + 1.0 / load_inertia
    fastest = max(math.sqrt(contact.stiffness * compliance), contact.damping * compliance)
    return Mechanism(
        name=name,
        output=rod,
        rotor=rotor,
        contact=contact,
        gain=torque_constant,
        signal="A",
        signal_limit=_finite(current_limit),
        servo=_cascade(p, torque_constant / ratio**2),
        step_s=1.0 / (_SLOWEST_HZ * math.ceil(fastest / (_STEP_RAD * _SLOWEST_HZ))),
        left_out=(*left_out, *_loop_left_out(drive), *_effects_left_out(drive)),
    )


def _contact(p: Any) -> tuple[Contact, list[str]]:
    """The flank as one spring; a piecewise one by its chord up to the last break."""
    stiffness = float(p["stiffness"][0])
    told = []
    count = int(p["segments"])
    if count > 1:
        stiffness = float(p["torque_start"][count - 1] / p["deflection_start"][count - 1])
        told.append(
            f"stiffness in {count} segments: one of {stiffness:.6g} N m/rad stands for them, the "
            f"chord up to {float(p['torque_start'][count - 1]):g} N m"
        )
    contact = Contact(
        rod_per_rotor=float(p["rod_per_rotor"]),
        backlash=2.0 * float(p["half_backlash"]),
        stiffness=stiffness,
        damping=float(p["contact_damping"]),
    )
    return contact, told


def _cascade(p: Any, scale: float) -> Servo:
    """Position and speed gains of the cascade as one position loop; scale: effort per current."""
    if p["position_to_current"]:
        return Servo(kp=scale * float(p["position_kp"]), kv=scale * float(p["position_kd"]))
    speed = scale * float(p["speed_kp"])
    return Servo(kp=speed * float(p["position_kp"]), kv=speed * (1.0 + float(p["position_kd"])))


def _loop_left_out(drive: DriveParameters) -> list[str]:
    """What of controller and motor no servo of a simulator has."""
    c, told = drive.controller, []
    told.append(
        "current loop, winding (resistance, inductance) and back EMF: the current is there at once"
    )
    told.append(f"sampling at {c.rate:g} Hz: the servo acts in every step of the simulation")
    for present, what in (
        (
            c.position.ki or c.speed.ki,
            "integral gains: a constant load leaves a position error that the drive does not have",
        ),
        (c.velocity_feedforward, "velocity feedforward: the servo lags as it would without"),
        (c.acceleration_feedforward, "acceleration feedforward"),
        (c.delay_ticks, f"delay of {c.delay_ticks} ticks from sampling to the inverter"),
        (c.feedback == "rod", "feedback from the rod: the servo closes on the rotor"),
        (
            c.setpoint_filter or c.current_command_filter or c.speed_filter,
            "low-pass filters of setpoint, current command or speed",
        ),
        (math.isfinite(c.speed_limit), f"speed limit of {c.speed_limit:g} rad/s inside the loop"),
        (math.isfinite(c.voltage_limit), f"voltage limit of {c.voltage_limit:g} V"),
    ):
        if present:
            told.append(what)
    sensors = dataclasses.asdict(drive.sensors)
    if any(value for key, value in sensors.items() if key != "noise_seed"):
        told.append("noise and resolution of the sensors")
    told.append("largest acceleration and jerk of setpoints")
    return told


def _effects_left_out(drive: DriveParameters) -> list[str]:
    told = []
    for name in drive.effects:
        effect = CATALOGUE[name]
        if name == "stribeck_friction":
            told.append("Stribeck friction: its Coulomb level is there, its peak at rest is not")
        elif name not in _AS_JOINTS and not _in_record(drive, name):
            told.append(f"{effect.title} (effects.{name})")
    return told


def _in_record(drive: DriveParameters, name: str) -> bool:
    """Whether all that the effect changes in the record is read."""
    others = {key: values for key, values in drive.effects.items() if key != name}
    full, less = pack(drive), pack(dataclasses.replace(drive, effects=others))
    fields = full.dtype.names or ()
    changed = {one for one in fields if (full[one] != less[one]).any()}
    return changed - _STEPPING <= _READ


def _rigid(machine: Machine, name: str) -> Mechanism:
    if machine.kind == "follower":
        raise InputError(
            f"{name}: describes a follower, of which no force is known; expected a full cylinder "
            "or a rigid drive"
        )
    if machine.inertia is None:
        key = "load.mass" if machine.linear else "load.inertia"
        raise InputError(
            f"{name}: {key} is missing; expected what moves (ecyl diagnose --write-drive finds it)"
        )
    own = machine.gain is not None or machine.actuation in ("force", "torque")
    model = model_of(machine, own)
    # Effort by the true gain, where an effect tells that the file's is not true.
    ratio = model.ratio or 1.0
    gain = (machine.gain or 1.0) / ratio
    forwards, backwards = (one / ratio for one in model.coulomb)
    viscous = [one / ratio for one in model.viscous]
    told = [f"{one.name} (effects.{one.name})" for one in model.shapes]
    if viscous[0] != viscous[1]:
        told.append(
            f"viscous friction of {viscous[0]:g} forwards and {viscous[1]:g} backwards: their mean"
        )
    servo = None
    if machine.position_kp is not None and machine.speed_kp is not None:
        speed = machine.speed_kp * gain
        servo = Servo(kp=speed * machine.position_kp, kv=speed)
        told.append("sampling of the loop: the servo acts in every step of the simulation")
        for present, what in (
            (machine.speed_ki, "integral gain of the speed loop"),
            (machine.feedforward, "velocity feedforward"),
            (machine.delay_s, "delay of the loop"),
        ):
            if present:
                told.append(what)
    limit = machine.command_limit
    units = {"current": "A", "voltage": "V", "force": "N", "torque": "N m"}
    return Mechanism(
        name=name,
        output=Joint(
            name="rod" if machine.linear else "rotor",
            linear=machine.linear,
            inertia=(model.inertia or 0.0) / ratio,
            damping=0.5 * (viscous[0] + viscous[1]),
            friction=0.5 * (forwards + backwards),
            stiffness=model.stiffness / ratio,
            constant=model.constant / ratio + 0.5 * (forwards - backwards),
            effort=None if limit is None else limit * gain,
        ),
        gain=gain,
        signal=units.get(machine.actuation or "", "unit of the signal"),
        signal_limit=limit,
        servo=servo,
        left_out=tuple(told),
    )
