"""A drive as far as its file knows it: rigid (`drive.kind: rigid`) or a follower."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ..law import Law
from ..tolerances import RIGID, half_widths
from .model import Acting

KINDS = ("rigid", "follower")
OUTPUTS = ("linear", "rotary")
# What the effort is counted in -> (field of `Recording`, unit, unit of the gain up to the output's
# own force or torque). `loop` is what the controller of the file asks for, from the recorded
# reference and motion.
EFFORTS: dict[str, tuple[str, str]] = {
    "force": ("rod_force_n", "N"),
    "torque": ("rotor_torque_nm", "N m"),
    "current": ("current_q_a", "A"),
    "voltage": ("voltage_q_v", "V"),
}
ACTUATIONS = (*EFFORTS, "loop")


@dataclass(frozen=True, kw_only=True)
class Machine:
    """A drive as far as its file knows it; SI, of the output: N, m where linear, N m, rad where
    rotary. None where the file leaves a value out.

    Attributes:
        kind, output: one of `KINDS`, `OUTPUTS`.
        actuation: what was recorded as effort, one of `ACTUATIONS`; None: whatever the recording
            holds.
        gain: output force or torque per unit of that; None where unknown, 1 for force and torque.
        inertia: moving mass in kg or inertia in kg m^2.
        viscous, coulomb, constant, stiffness: nominal friction per speed, friction level, constant
            load (positive against positive motion) and spring rate, 0 unless given.
        lead: m per turn of a linear drive's screw.
        rate_hz: of the controller. position_kp: 1/s. speed_kp, speed_ki: effort unit per speed, and
            per travel. feedforward: share of the reference velocity. command_limit: of the effort,
            in its unit. delay_s: from the measured motion to the effort.
        position_resolution, position_noise, effort_noise: of the recorded signals; effort in the
            unit it was recorded in.
        bandwidth_hz: up to where effort and motion are compared; None: found from the recording.
        tolerances: as the file states them, by key; see `drive.tolerances`.
        effects: what acts beyond these. effects_unit: of the effort their values are counted in;
            None where no value tells.
        learned: a law that a diagnosis learned, counted in `effects_unit`.
    """

    kind: str
    output: str
    actuation: str | None = None
    gain: float | None = None
    inertia: float | None = None
    viscous: float = 0.0
    coulomb: float = 0.0
    constant: float = 0.0
    stiffness: float = 0.0
    lead: float | None = None
    rate_hz: float | None = None
    position_kp: float | None = None
    speed_kp: float | None = None
    speed_ki: float = 0.0
    feedforward: float = 0.0
    command_limit: float | None = None
    delay_s: float = 0.0
    position_resolution: float | None = None
    position_noise: float | None = None
    effort_noise: float | None = None
    bandwidth_hz: float | None = None
    tolerances: Mapping[str, float | str] = dataclasses.field(default_factory=dict)
    effects: tuple[Acting, ...] = ()
    effects_unit: str | None = None
    learned: Law | None = None

    @property
    def linear(self) -> bool:
        """Whether the output moves in m."""
        return self.output == "linear"

    @property
    def loop_known(self) -> bool:
        """Whether the file holds a controller that effort can be computed with."""
        return self.speed_kp is not None

    def half_widths(self) -> dict[str, float]:
        """Half width that holds 95 % of healthy machines, of each constant that the file states.

        By key and in its unit. A force or torque that was measured as such is as sure as that,
        unless the file says by name how unsure its gain is.
        """
        nominal = {}
        for key in RIGID:
            item = KEYS[key]
            value = getattr(self, item.field)
            sure = item.field == "gain" and self.actuation in ("force", "torque")
            sure = sure and key not in self.tolerances
            if value and not sure and self.output in item.outputs:
                nominal[key] = float(value)
        return half_widths(nominal, self.tolerances, RIGID)


@dataclass(frozen=True)
class Key:
    """A key of the file: the field it fills, unit (linear, rotary), possible range, meaning."""

    field: str
    units: tuple[str, str]
    low: float
    high: float
    meaning: str
    outputs: tuple[str, ...] = OUTPUTS
    open_low: bool = False
    choices: tuple[str, ...] = ()


KEYS: dict[str, Key] = {
    "drive.kind": Key("kind", ("", ""), 0, 0, "what is known of the drive", choices=KINDS),
    "drive.output": Key("output", ("", ""), 0, 0, "how the output moves", choices=OUTPUTS),
    "actuation.signal": Key(
        "actuation", ("", ""), 0, 0, "what was recorded as effort", choices=ACTUATIONS
    ),
    "actuation.gain": Key(
        "gain",
        ("N per unit of the signal", "N m per unit of the signal"),
        1e-9,
        1e9,
        "output effort per unit: torque constant, force per volt",
    ),
    "load.mass": Key("inertia", ("kg", ""), 1e-6, 1e6, "all that moves", ("linear",)),
    "load.inertia": Key("inertia", ("", "kg m^2"), 1e-10, 1e6, "all that turns", ("rotary",)),
    "load.viscous_friction": Key(
        "viscous", ("N s/m", "N m s/rad"), 0.0, 1e7, "friction in proportion to speed"
    ),
    "load.coulomb_friction": Key("coulomb", ("N", "N m"), 0.0, 1e7, "friction level"),
    "load.constant_load": Key(
        "constant", ("N", "N m"), -1e7, 1e7, "positive against positive motion"
    ),
    "load.stiffness": Key("stiffness", ("N/m", "N m/rad"), 0.0, 1e9, "of a spring to position 0"),
    "screw.lead": Key("lead", ("m/rev", ""), 1e-5, 10.0, "travel per screw turn", ("linear",)),
    "controller.rate": Key("rate_hz", ("Hz", "Hz"), 1.0, 1e6, "control rate"),
    "controller.position.kp": Key("position_kp", ("1/s", "1/s"), 0.0, 1e6, "position loop"),
    "controller.speed.kp": Key(
        "speed_kp", ("signal unit s/m", "signal unit s/rad"), 0.0, 1e9, "speed loop"
    ),
    "controller.speed.ki": Key(
        "speed_ki", ("signal unit/m", "signal unit/rad"), 0.0, 1e9, "speed loop"
    ),
    "controller.velocity_feedforward": Key(
        "feedforward", ("1", "1"), 0.0, 2.0, "share of the reference velocity"
    ),
    "controller.command_limit": Key(
        "command_limit", ("signal unit",) * 2, 0.0, 1e9, "largest effort command", open_low=True
    ),
    "controller.delay": Key("delay_s", ("s", "s"), 0.0, 1.0, "from measured motion to effort"),
    "sensors.position_resolution": Key(
        "position_resolution", ("m", "rad"), 0.0, 1.0, "encoder step at the output"
    ),
    "sensors.position_noise": Key("position_noise", ("m", "rad"), 0.0, 1.0, "standard deviation"),
    "sensors.effort_noise": Key(
        "effort_noise", ("signal unit",) * 2, 0.0, 1e6, "standard deviation"
    ),
    "judge.bandwidth": Key(
        "bandwidth_hz", ("Hz", "Hz"), 0.01, 1e5, "effort and motion are compared up to here"
    ),
}


_NEAR = 1e-6  # relative: rounding to the digits of a file, over sums of two


def same_machine(one: Machine, other: Machine) -> bool:
    """Whether two machines are the same but for the rounding of what stands in a file.

    In any order of their effects.
    """
    constants = ("inertia", "viscous", "coulomb", "constant")
    plain: dict[str, Any] = {"effects": (), "effects_unit": None, **dict.fromkeys(constants)}
    if dataclasses.replace(one, **plain) != dataclasses.replace(other, **plain):
        return False
    pairs = zip(_values(one), _values(other), strict=False)
    return len(_values(one)) == len(_values(other)) and all(
        name == name_too and math.isclose(value, value_too, rel_tol=_NEAR, abs_tol=1e-300)
        for (name, value), (name_too, value_too) in pairs
    )


def _values(machine: Machine) -> list[tuple[str, float]]:
    effects = sorted(machine.effects, key=lambda one: one.name)
    found = [
        (f"{one.name}.{key}", one.values[key]) for one in effects for key in sorted(one.values)
    ]
    constants = ("inertia", "viscous", "coulomb", "constant")
    return [*((name, getattr(machine, name) or 0.0) for name in constants), *found]
