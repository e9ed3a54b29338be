"""Causes that no catalogue names, each a law of one or two variables, or with memory.

What a study of described causes draws from. Sizes are drawn against the healthy machine's peaks, as
those of every other effect are; `law` holds how the stand-in plays them.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...describe.words import BLOCKS
from .imposed import Draw, Imposed, Values
from .law import PORTS, SHAPES, VARIABLES
from .physics import Physics


@dataclass(frozen=True)
class Unnamed:
    """A kind of cause.

    Attributes:
        name: begins with ``x_law_``. port: where it acts. of: what it depends on, memory included.
        memory: whether it depends on what was (heat, travel since a reversal).
        akin: catalogue effects that name the same in a form of theirs; naming them is no error.
        draw: values of a law's fields, without `law_`: size, offset, and per variable shape
            (a number), width and place.
    """

    name: str
    port: str
    of: tuple[str, ...]
    draw: Callable[[Draw], Values]
    memory: bool = False
    akin: frozenset[str] = frozenset()

    @property
    def imposed(self) -> Imposed:
        """As the study imposes it."""

        def impose(machine: Physics, values: Values, phases: np.ndarray) -> None:
            machine.law_port = 1.0 + PORTS.index(self.port)
            for key, value in values.items():
                setattr(machine, f"law_{key}", value)

        return Imposed(self.name, BLOCKS[self.port], self.draw, impose, akin=self.akin)


def _first(variable: str, shape: str, width: float, place: float = 0.0) -> Values:
    return {
        "first": float(VARIABLES.index(variable)),
        "first_shape": float(SHAPES.index(shape)),
        "first_width": width,
        "first_place": place,
    }


def _second(variable: str, shape: str, width: float, place: float = 0.0) -> Values:
    return {
        "second": float(VARIABLES.index(variable)),
        "second_shape": float(SHAPES.index(shape)),
        "second_width": width,
        "second_place": place,
    }


def _turn(draw: Draw, times: int) -> tuple[float, float]:
    """(width, place) of a sine so many times a turn, in rad."""
    width = 2.0 * math.pi / times
    return width, draw.within(0.0, width)


def _wave(draw: Draw) -> tuple[float, float]:
    """(width, place) of a sine along the stroke, two to six periods on it, m."""
    width = draw.scale.stroke_m / draw.within(1.0, 3.0)
    return width, draw.within(0.0, width)


def _kind(
    name: str,
    port: str,
    of: tuple[str, ...],
    draw: Callable[[Draw], Values],
    **more: object,
) -> Unnamed:
    return Unnamed(f"x_law_{name}", port, of, draw, **more)  # type: ignore[arg-type]


_KINDS = [
    _kind(
        "drag_wave",
        "load_friction",
        ("position",),
        lambda d: (
            {"size": d.torque(0.1, 0.2), "offset": 1.2} | _first("position", "sine", *_wave(d))
        ),
    ),
    _kind(
        "drag_slope",
        "load_friction",
        ("position",),
        lambda d: (
            {"size": d.torque(0.15, 0.3), "offset": 0.0}
            | _first("position", "step", 0.3 * d.scale.stroke_m, d.place())
        ),
    ),
    _kind(
        "drag_of_speed_squared",
        "load_friction",
        ("speed",),
        lambda d: {"size": d.torque(0.2, 0.4)} | _first("speed", "square", d.scale.speed_rad_s),
    ),
    _kind(
        "drag_at_one_speed",
        "rotor_friction",
        ("speed",),
        lambda d: (
            {"size": d.torque(0.15, 0.3)}
            | _first(
                "speed", "bump", 0.2 * d.scale.speed_rad_s, d.side() * 0.4 * d.scale.speed_rad_s
            )
        ),
    ),
    _kind(
        "drag_of_current",
        "rotor_friction",
        ("current",),
        lambda d: {"size": d.torque(0.15, 0.3)} | _first("current", "square", d.scale.current_a),
    ),
    _kind(
        "drag_from_then_on",
        "load_friction",
        ("time",),
        lambda d: {"size": d.torque(0.15, 0.3)} | _first("time", "step", 0.5, d.within(3.0, 8.0)),
    ),
    _kind(
        "drag_comes_and_goes",
        "rotor_friction",
        ("time",),
        lambda d: (
            {"size": d.torque(0.1, 0.25)}
            | _first("time", "bump", d.within(1.5, 3.0), d.within(4.0, 7.0))
        ),
    ),
    _kind(
        "drag_of_rotor_angle",
        "rotor_friction",
        ("rotor_angle",),
        lambda d: (
            {"size": d.torque(0.08, 0.15), "offset": 1.1}
            | _first("rotor_angle", "sine", *_turn(d, 1))
        ),
    ),
    _kind(
        "drag_of_screw_angle",
        "load_friction",
        ("screw_angle",),
        lambda d: (
            {"size": d.torque(0.08, 0.15), "offset": 1.1}
            | _first("screw_angle", "sine", *_turn(d, int(d.one_of(1, 2))))
        ),
    ),
    _kind(
        "stiffening_spring",
        "load_torque",
        ("position",),
        lambda d: {"size": -d.torque(0.3, 0.6)} | _first("position", "cube", d.scale.stroke_m),
    ),
    _kind(
        "one_sided_spring",
        "load_torque",
        ("position",),
        lambda d: (
            {"size": -d.torque(0.3, 0.6)}
            | _first("position", "beyond", 0.5 * d.scale.stroke_m, 0.1 * d.scale.stroke_m)
        ),
    ),
    _kind(
        "detents",
        "load_torque",
        ("position",),
        lambda d: {"size": d.torque(0.1, 0.2)} | _first("position", "sine", *_wave(d)),
    ),
    _kind(
        "load_that_grows",
        "load_torque",
        ("time",),
        lambda d: {"size": d.side() * d.torque(0.15, 0.3)} | _first("time", "step", 2.0, 6.0),
    ),
    _kind(
        "cubic_drag",
        "rotor_torque",
        ("speed",),
        lambda d: {"size": -d.torque(0.2, 0.4)} | _first("speed", "cube", d.scale.speed_rad_s),
    ),
    _kind(
        "square_drag",
        "load_torque",
        ("speed",),
        lambda d: (
            {"size": -d.torque(0.2, 0.4)} | _first("speed", "odd_square", d.scale.speed_rad_s)
        ),
    ),
    _kind(
        "third_harmonic",
        "rotor_torque",
        ("rotor_angle",),
        lambda d: (
            {"size": d.torque(0.04, 0.1), "offset": 0.6}
            | _first("rotor_angle", "sine", *_turn(d, int(d.one_of(3, 4, 6))))
        ),
        akin=frozenset({"cogging_torque", "constant_load"}),
    ),
    _kind(
        "saturation",
        "rotor_torque",
        ("current",),
        lambda d: {"size": -d.torque(0.08, 0.15)} | _first("current", "cube", d.scale.current_a),
    ),
    _kind(
        "one_sided_torque",
        "rotor_torque",
        ("current",),
        lambda d: (
            {"size": -d.torque(0.1, 0.2)}
            | _first("current", "beyond", 0.5 * d.scale.current_a, 0.05 * d.scale.current_a)
        ),
    ),
    _kind(
        "drag_place_and_way",
        "load_friction",
        ("direction", "position"),
        lambda d: (
            {"size": d.torque(0.15, 0.3), "offset": 1.0}
            | _first("direction", "line", 1.0)
            | _second("position", "step", 0.2 * d.scale.stroke_m, d.place())
        ),
    ),
    _kind(
        "damper_with_place",
        "load_torque",
        ("position", "speed"),
        lambda d: (
            {"size": -d.torque(0.2, 0.4), "offset": 0.0}
            | _first("position", "step", 0.3 * d.scale.stroke_m, d.place())
            | _second("speed", "line", d.scale.speed_rad_s)
        ),
    ),
    _kind(
        "damper_with_time",
        "load_torque",
        ("speed", "time"),
        lambda d: (
            {"size": -d.torque(0.2, 0.4)}
            | _first("speed", "line", d.scale.speed_rad_s)
            | _second("time", "step", 1.0, d.within(4.0, 8.0))
        ),
    ),
    _kind(
        "ripple_of_harmonics",
        "rotor_torque",
        ("current", "rotor_angle"),
        lambda d: (
            {"size": d.torque(0.1, 0.25)}
            | _first("current", "line", d.scale.current_a)
            | _second("rotor_angle", "sine", *_turn(d, int(d.one_of(1, 2))))
        ),
        akin=frozenset({"torque_ripple"}),
    ),
    _kind(
        "lossy_inverter",
        "inverter_voltage",
        ("current",),
        lambda d: (
            {"size": -d.within(0.1, 0.3) * d.scale.voltage_v}
            | _first("current", "cube", d.scale.current_a)
        ),
    ),
    _kind(
        "back_emf_of_harmonics",
        "inverter_voltage",
        ("rotor_angle", "speed"),
        lambda d: (
            {"size": d.within(0.05, 0.15) * d.scale.voltage_v}
            | _first("rotor_angle", "sine", *_turn(d, 1))
            | _second("speed", "line", d.scale.speed_rad_s)
        ),
    ),
    _kind(
        "back_emf_that_bends",
        "inverter_voltage",
        ("speed",),
        lambda d: (
            {"size": d.within(0.1, 0.3) * d.scale.voltage_v}
            | _first("speed", "cube", d.scale.speed_rad_s)
        ),
    ),
    _kind(
        "supply_sags",
        "inverter_voltage",
        ("time",),
        lambda d: (
            {"size": d.within(0.05, 0.15) * d.scale.voltage_v}
            | _first("time", "step", 0.5, d.within(3.0, 8.0))
        ),
    ),
    _kind(
        "bent_scale",
        "rod_error",
        ("position",),
        lambda d: (
            {"size": 10.0 ** d.within(-2.5, -2.0)}
            | _first("position", "square", 0.7 * d.scale.stroke_m)
        ),
    ),
    _kind(
        "scale_wave",
        "rod_error",
        ("position",),
        lambda d: {"size": 10.0 ** d.within(-2.7, -2.2)} | _first("position", "sine", *_wave(d)),
        akin=frozenset({"transmission_error"}),
    ),
    _kind(
        "current_reading_bends",
        "current_error",
        ("current",),
        lambda d: (
            {"size": d.within(0.05, 0.15) * d.scale.current_a}
            | _first("current", "odd_square", d.scale.current_a)
        ),
    ),
    _kind(
        "current_reading_drifts",
        "current_error",
        ("time",),
        lambda d: (
            {"size": d.side() * d.within(0.05, 0.12) * d.scale.current_a}
            | _first("time", "step", 1.0, d.within(3.0, 8.0))
        ),
    ),
    _kind(
        "drag_of_heat",
        "rotor_friction",
        ("heat",),
        lambda d: (
            {
                "size": d.torque(0.2, 0.4),
                "heat_s": d.within(1.0, 3.0),
            }
            | _first("heat", "fading", (0.15 * d.scale.current_a) ** 2)
        ),
        memory=True,
    ),
    _kind(
        "winding_of_heat",
        "inverter_voltage",
        ("current", "heat"),
        lambda d: (
            {
                "size": -d.within(0.15, 0.4) * d.scale.voltage_v,
                "heat_s": d.within(1.0, 3.0),
            }
            | _first("current", "line", d.scale.current_a)
            | _second("heat", "line", (0.3 * d.scale.current_a) ** 2)
        ),
        memory=True,
    ),
    _kind(
        "wind_up",
        "load_torque",
        ("travel",),
        lambda d: (
            {"size": -d.torque(0.15, 0.3)} | _first("travel", "saturated", d.within(0.3, 1.0))
        ),
        memory=True,
    ),
]

UNNAMED: dict[str, Unnamed] = {one.name: one for one in _KINDS}
