"""Drive files of rigid drives (`drive.kind: rigid`) and of followers (`drive.kind: follower`).

They are ROS 2 parameter files like those of a full cylinder, with fewer keys. What is unknown is
left out; the diagnosis then says what that costs.
"""

from __future__ import annotations

import dataclasses
import difflib
import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ...errors import InputError
from ..drive_file import NODE_KEYS, read_parameter_file, resolve_drive
from ..tolerances import RIGID, half_widths, stated_tolerances
from .acting import Acting, effects_table, parse

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

    @property
    def linear(self) -> bool:
        """Whether the output moves in m."""
        return self.output == "linear"

    @property
    def loop_known(self) -> bool:
        """Whether the file holds a controller that effort can be computed with."""
        return self.speed_kp is not None

    def half_widths(self) -> dict[str, float]:
        """Half width that holds 95 % of sound machines, of each constant that the file states.

        By key and in its unit. A force or torque that was measured as such needs no gain.
        """
        nominal = {}
        for key in RIGID:
            item = KEYS[key]
            value = getattr(self, item.field)
            own = item.field == "gain" and self.actuation in ("force", "torque")
            if value and not own and self.output in item.outputs:
                nominal[key] = float(value)
        return half_widths(nominal, self.tolerances, RIGID)


@dataclass(frozen=True)
class _Key:
    """A key of the file: the field it fills, unit (linear, rotary), possible range, meaning."""

    field: str
    units: tuple[str, str]
    low: float
    high: float
    meaning: str
    outputs: tuple[str, ...] = OUTPUTS
    open_low: bool = False
    choices: tuple[str, ...] = ()


KEYS: dict[str, _Key] = {
    "drive.kind": _Key("kind", ("", ""), 0, 0, "what is known of the drive", choices=KINDS),
    "drive.output": _Key("output", ("", ""), 0, 0, "how the output moves", choices=OUTPUTS),
    "actuation.signal": _Key(
        "actuation", ("", ""), 0, 0, "what was recorded as effort", choices=ACTUATIONS
    ),
    "actuation.gain": _Key(
        "gain",
        ("N per unit of the signal", "N m per unit of the signal"),
        1e-9,
        1e9,
        "output effort per unit: torque constant, force per volt",
    ),
    "load.mass": _Key("inertia", ("kg", ""), 1e-6, 1e6, "all that moves", ("linear",)),
    "load.inertia": _Key("inertia", ("", "kg m^2"), 1e-10, 1e6, "all that turns", ("rotary",)),
    "load.viscous_friction": _Key(
        "viscous", ("N s/m", "N m s/rad"), 0.0, 1e7, "friction in proportion to speed"
    ),
    "load.coulomb_friction": _Key("coulomb", ("N", "N m"), 0.0, 1e7, "friction level"),
    "load.constant_load": _Key(
        "constant", ("N", "N m"), -1e7, 1e7, "positive against positive motion"
    ),
    "load.stiffness": _Key("stiffness", ("N/m", "N m/rad"), 0.0, 1e9, "of a spring to position 0"),
    "screw.lead": _Key("lead", ("m/rev", ""), 1e-5, 10.0, "travel per screw turn", ("linear",)),
    "controller.rate": _Key("rate_hz", ("Hz", "Hz"), 1.0, 1e6, "control rate"),
    "controller.position.kp": _Key("position_kp", ("1/s", "1/s"), 0.0, 1e6, "position loop"),
    "controller.speed.kp": _Key(
        "speed_kp", ("signal unit s/m", "signal unit s/rad"), 0.0, 1e9, "speed loop"
    ),
    "controller.speed.ki": _Key(
        "speed_ki", ("signal unit/m", "signal unit/rad"), 0.0, 1e9, "speed loop"
    ),
    "controller.velocity_feedforward": _Key(
        "feedforward", ("1", "1"), 0.0, 2.0, "share of the reference velocity"
    ),
    "controller.command_limit": _Key(
        "command_limit", ("signal unit",) * 2, 0.0, 1e9, "largest effort asked for", open_low=True
    ),
    "controller.delay": _Key("delay_s", ("s", "s"), 0.0, 1.0, "from measured motion to effort"),
    "sensors.position_resolution": _Key(
        "position_resolution", ("m", "rad"), 0.0, 1.0, "encoder step at the output"
    ),
    "sensors.position_noise": _Key("position_noise", ("m", "rad"), 0.0, 1.0, "standard deviation"),
    "sensors.effort_noise": _Key(
        "effort_noise", ("signal unit",) * 2, 0.0, 1e6, "standard deviation"
    ),
    "judge.bandwidth": _Key(
        "bandwidth_hz", ("Hz", "Hz"), 0.01, 1e5, "effort and motion are compared up to here"
    ),
}


def is_machine_file(path: str | os.PathLike[str]) -> bool:
    """Whether a drive file (or profile) says `drive.kind`, hence is read by `load_machine`."""
    return any(key.startswith("drive.") for key in read_parameter_file(resolve_drive(path)))


def load_machine(path: str | os.PathLike[str]) -> Machine:
    """Read and check the drive file of a rigid drive or a follower.

    Raises:
        InputError: unreadable, a key of another name, a value of another kind or range, or keys
            that do not go together.
    """
    source = resolve_drive(path)
    return machine_from_flat(read_parameter_file(source), str(source))


def machine_from_flat(flat: Mapping[str, Any], source: str) -> Machine:
    """`Machine` from dotted parameters; see `load_machine`."""
    acting = {}
    known = ", ".join((*KEYS, "effects", "tolerances"))
    for key in flat:
        if key in KEYS or key.split(".")[0] in ("tolerances", *NODE_KEYS):
            continue
        if key.startswith("effects.") and key.count(".") == 2:
            acting[key.removeprefix("effects.")] = flat[key]
            continue
        near = difflib.get_close_matches(key, KEYS, n=1)
        hint = f"did you mean {near[0]}?" if near else f"a rigid drive has {known}"
        raise InputError(f"{source}: unknown key {key}; {hint}")
    values: dict[str, Any] = {}
    for key in ("drive.kind", "drive.output"):
        if key not in flat:
            raise InputError(
                f"{source}: {key} is missing; expected {' or '.join(KEYS[key].choices)}"
            )
    for key, one in KEYS.items():
        if key in flat:
            values[one.field] = _value(flat[key], one, key, str(flat["drive.output"]), source)
    linear = values["output"] == "linear"
    units = {key: KEYS[key].units[not linear] for key in RIGID}
    stated = stated_tolerances(flat, units, source, RIGID)
    effects, unit = parse(acting, linear, values.get("lead"), source)
    machine = Machine(
        **values,
        tolerances=stated,
        effects=effects,
        effects_unit=unit,
    )
    _check_relations(machine, source)
    return _with_own_gain(machine)


def _value(value: Any, key: _Key, name: str, output: str, source: str) -> Any:
    if key.choices:
        if value not in key.choices:
            raise InputError(f"{source}: {name} = {value!r}, expected {' or '.join(key.choices)}")
        return value
    if output in OUTPUTS and output not in key.outputs:
        other = "load.inertia" if name == "load.mass" else "load.mass"
        hint = f"; expected {other}" if name.startswith("load") else ""
        raise InputError(f"{source}: {name} does not go with drive.output {output}{hint}")
    unit = key.units[output == "rotary"]
    above = "above" if key.open_low else "from"
    wanted = f"expected a number {above} {key.low:g} to {key.high:g} {unit}"
    if isinstance(value, str):  # YAML 1.1 reads 1e3 (no dot) as text; ROS reads a number
        try:
            value = float(value)
        except ValueError:
            raise InputError(f"{source}: {name} = {value!r}, {wanted}") from None
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise InputError(f"{source}: {name} = {value!r}, {wanted}")
    if not key.low <= value <= key.high or (key.open_low and value == key.low):
        raise InputError(f"{source}: {name} = {value:g}, {wanted} (SI units throughout)")
    return float(value)


def _check_relations(machine: Machine, source: str) -> None:
    if machine.actuation == "force" and not machine.linear:
        raise InputError(
            f"{source}: actuation.signal = 'force' does not go with drive.output rotary; expected "
            "torque, current, voltage or loop"
        )
    if machine.effects and machine.kind == "follower":
        raise InputError(f"{source}: effects do not go with drive.kind follower; expected rigid")
    if any(one.name == "torque_constant_error" for one in machine.effects) and machine.gain is None:
        raise InputError(
            f"{source}: actuation.gain is missing; effects.torque_constant_error is told from it"
        )
    if machine.actuation == "loop" and not machine.loop_known:
        raise InputError(
            f"{source}: controller.speed.kp is missing; actuation.signal = 'loop' computes the "
            "effort with it"
        )
    for name, given in (
        ("controller.position.kp", machine.position_kp),
        ("controller.speed.ki", machine.speed_ki or None),
    ):
        if given is not None and not machine.loop_known:
            raise InputError(f"{source}: controller.speed.kp is missing; {name} needs it")


def _with_own_gain(machine: Machine) -> Machine:
    """Force of a linear and torque of a rotary output are effort as they are."""
    own = "force" if machine.linear else "torque"
    if machine.actuation == own and machine.gain is None:
        return dataclasses.replace(machine, gain=1.0)
    return machine


def key_table() -> str:
    """Every key as a table of Markdown, for docs/drive-file.md."""
    rows = [
        "| key | unit (linear, rotary) | possible | meaning |",
        "|---|---|---|---|",
    ]
    for name, one in KEYS.items():
        unit = ", ".join(dict.fromkeys(unit for unit in one.units if unit))
        possible = " or ".join(one.choices)
        if not possible:
            possible = f"above {one.low:g}" if one.open_low else f"{one.low:g} to {one.high:g}"
        rows.append(f"| `{name}` | {unit} | {possible} | {one.meaning} |")
    return "\n".join(rows)


if __name__ == "__main__":
    print(key_table(), effects_table(), sep="\n\n")
