"""Where effects act in the compiled drive: each port is the sum of all effects that define it.

An effect's file defines a kernel under the name of its port. The kernel takes the packed record
first and gives zero while its own parameters are zero. Angles, speeds and torques are at the rotor.

| port | arguments after the record | gives |
|---|---|---|
| `rotor_torque` | rotor angle rad, speed rad/s, i_q A | N m on the rotor |
| `rotor_friction` | speed rad/s, transmitted torque N m, time s | friction level >= 0, N m |
| `load_torque` | time s, load angle rad, speed rad/s | N m on the load |
| `load_friction` | speed rad/s, transmitted torque N m, load angle rad, time s | level >= 0, N m |
| `inverter_voltage` | i_q A, u_q V | V added to u_q at the motor |
| `rotor_angle_error` | rotor angle rad | rad added to the encoder's reading |
| `rotor_speed_error` | rotor angle rad, speed rad/s | rad/s added to the speed reading |
| `current_error` | i_q A | A added to the current reading |
| `rod_error` | load angle rad | rad added to the rod's reading |
| `inverter_resistance` | i_q A, u_q V | ohm, what `inverter_voltage` falls by per A there |

A friction level is what the contact could resist; `drive.friction` makes a torque of it.
"""

from __future__ import annotations

from collections.abc import Callable

from ..drive.compiled import kernel
from .catalogue import MODULES

ARGUMENTS = {
    "rotor_torque": 3,
    "rotor_friction": 3,
    "load_torque": 3,
    "load_friction": 4,
    "inverter_voltage": 2,
    "rotor_angle_error": 1,
    "rotor_speed_error": 2,
    "current_error": 1,
    "rod_error": 1,
    "inverter_resistance": 2,
}

# Those that act within a step of the plant, not where it is measured.
IN_PLANT = ("rotor_torque", "rotor_friction", "load_torque", "load_friction", "inverter_voltage")


def effects_at(port: str) -> list[str]:
    """Names of the effects that act at a port."""
    return [name for name, module in MODULES.items() if hasattr(module, port)]


# Effects with a port of their own; their parameters stand in the packed record.
AT_PORTS = frozenset(name for port in ARGUMENTS for name in effects_at(port))


def _sum(kernels: list[Callable], arguments: int) -> Callable:
    """One kernel that adds up `kernels`; zero for none.

    Compiled as a chain of calls, which the compiler inlines; a loop over a tuple of functions
    would go through pointers.
    """
    if not kernels:
        return _NOTHING[arguments]
    if len(kernels) == 1:
        return kernels[0]
    return _BOTH[arguments](kernels[0], _sum(kernels[1:], arguments))


def _both_1(f: Callable, g: Callable) -> Callable:
    return kernel(lambda p, a: f(p, a) + g(p, a), cache=False)


def _both_2(f: Callable, g: Callable) -> Callable:
    return kernel(lambda p, a, b: f(p, a, b) + g(p, a, b), cache=False)


def _both_3(f: Callable, g: Callable) -> Callable:
    return kernel(lambda p, a, b, c: f(p, a, b, c) + g(p, a, b, c), cache=False)


def _both_4(f: Callable, g: Callable) -> Callable:
    return kernel(lambda p, a, b, c, d: f(p, a, b, c, d) + g(p, a, b, c, d), cache=False)


_BOTH = {1: _both_1, 2: _both_2, 3: _both_3, 4: _both_4}
_NOTHING = {
    1: kernel(lambda p, a: 0.0, cache=False),
    2: kernel(lambda p, a, b: 0.0, cache=False),
    3: kernel(lambda p, a, b, c: 0.0, cache=False),
    4: kernel(lambda p, a, b, c, d: 0.0, cache=False),
}


def _port(name: str) -> Callable:
    return _sum([getattr(MODULES[effect], name) for effect in effects_at(name)], ARGUMENTS[name])


rotor_torque = _port("rotor_torque")
rotor_friction = _port("rotor_friction")
load_torque = _port("load_torque")
load_friction = _port("load_friction")
inverter_voltage = _port("inverter_voltage")
rotor_angle_error = _port("rotor_angle_error")
rotor_speed_error = _port("rotor_speed_error")
current_error = _port("current_error")
rod_error = _port("rod_error")
inverter_resistance = _port("inverter_resistance")
