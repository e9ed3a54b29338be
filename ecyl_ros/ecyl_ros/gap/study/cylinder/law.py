"""A law that no catalogue holds, as the stand-in plays it: a size times shapes of its variables.

value = size x (offset + shape(first)) x shape(second), each shape with a width and a place in its
variable's unit. Written apart from what a diagnosis fits: formulas, no tables.
"""

from __future__ import annotations

import math

from ....drive.compiled import kernel

# Where it acts; the order is that of the numbers, from 1.
PORTS = (
    "rotor_torque",
    "rotor_friction",
    "load_torque",
    "load_friction",
    "inverter_voltage",
    "rotor_angle_error",
    "current_error",
    "rod_error",
)
(
    ROTOR_TORQUE,
    ROTOR_FRICTION,
    LOAD_TORQUE,
    LOAD_FRICTION,
    INVERTER_VOLTAGE,
    ROTOR_ANGLE_ERROR,
    CURRENT_ERROR,
    ROD_ERROR,
) = range(1, len(PORTS) + 1)

VARIABLES = (
    "position",
    "rotor_angle",
    "screw_angle",
    "speed",
    "direction",
    "current",
    "torque",
    "time",
    "heat",
    "travel",
)
SHAPES = (
    "one",
    "line",  # (x - place) / width
    "sine",  # sin(2 pi (x - place) / width)
    "bump",  # exp(-((x - place) / width)^2)
    "step",  # (1 + tanh((x - place) / width)) / 2
    "square",  # ((x - place) / width)^2
    "odd_square",  # x |x| / width^2
    "cube",  # ((x - place) / width)^3
    "beyond",  # max(x - place, 0) / width
    "saturated",  # tanh(x / width)
    "fading",  # exp(-|x| / width)
)


@kernel
def shape(number, x, width, place):
    """A shape of one variable; see `SHAPES`."""
    if number == 0:
        return 1.0
    off = (x - place) / width
    if number == 1:
        return off
    if number == 2:
        return math.sin(2.0 * math.pi * off)
    if number == 3:
        return math.exp(-off * off)
    if number == 4:
        return 0.5 * (1.0 + math.tanh(off))
    if number == 5:
        return off * off
    if number == 6:
        return off * abs(off)
    if number == 7:
        return off * off * off
    if number == 8:
        return max(off, 0.0)
    if number == 9:
        return math.tanh(off)
    return math.exp(-abs(off))


@kernel
def _variable(p, number, angle, speed, current, torque, time, heat, travel):
    if number == 0.0:
        return angle * p.rod_per_rotor
    if number == 1.0:
        return angle
    if number == 2.0:
        return angle / p.gear_ratio
    if number == 3.0:
        return speed
    if number == 4.0:
        return math.tanh(speed / 0.01)
    if number == 5.0:
        return current
    if number == 6.0:
        return torque
    if number == 7.0:
        return time
    if number == 8.0:
        return heat
    return travel


@kernel
def law_value(p, angle, speed, current, torque, time, heat, travel):
    """What the law gives; angle and speed are those of the side that it acts on."""
    first = _variable(p, p.law_first, angle, speed, current, torque, time, heat, travel)
    found = p.law_offset + shape(p.law_first_shape, first, p.law_first_width, p.law_first_place)
    if p.law_second_shape > 0.0:
        second = _variable(p, p.law_second, angle, speed, current, torque, time, heat, travel)
        found *= shape(p.law_second_shape, second, p.law_second_width, p.law_second_place)
    return p.law_size * found
