"""The law that a diagnosis learned, as it acts in the compiled drive (see `drive.law`).

No effect of the catalogue: it has no name to compete under, and its parameters are a table.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from ..drive.compiled import called, kernel
from ..drive.law import MOST_PLACES, MOST_VALUES, PORTS, VARIABLES, Law
from ..drive.parameters import DriveParameters

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
_NUMBER = {name: number for number, name in enumerate(PORTS, 1)}
_PLACE = {name: number for number, name in enumerate(VARIABLES)}
_IN_PLANT = LOAD_FRICTION + 1  # ports up to here act within a step of the plant
SEGMENT = 14  # numbers that hold one segment of a table's axis, see `segments`

# What the packed record holds of it.
FIELDS = [
    ("learned_port", "i8"),  # 0: none
    ("learned_on_load", "i8"),
    ("learned_variables", "i8", (2,)),
    ("learned_count", "i8", (2,)),  # 0: fewer variables
    ("learned_period", "f8", (2,)),
    ("learned_heat_kept", "f8"),  # share that heat keeps over a tick
    ("learned_segments", "f8", (2, MOST_PLACES, SEGMENT)),
    ("learned_value", "f8", (MOST_VALUES,)),
]


def put_table(record: np.ndarray, law: Law) -> None:
    """Put a law's table into a record that has `FIELDS`."""
    for row, (name, places) in enumerate(zip(law.of, law.at, strict=True)):
        record["learned_variables"][0, row] = _PLACE[name]
        record["learned_count"][0, row] = len(places)
        record["learned_period"][0, row] = law.periods[row]
        record["learned_segments"][0, row, : len(places)] = segments(places, law.periods[row])
    record["learned_value"][0, : len(law.values)] = law.values


def put(record: np.ndarray, law: Law, drive: DriveParameters) -> None:
    """Put a law into the packed record of a drive."""
    put_table(record, law)
    record["learned_port"] = _NUMBER[law.port]
    record["learned_on_load"] = law.on_load
    if law.time_constant_s > 0.0:
        record["learned_heat_kept"] = math.exp(-1.0 / (law.time_constant_s * drive.controller.rate))
    if law.of_friction:
        record[f"acts_at_{law.port}"] = 1
    if _NUMBER[law.port] <= _IN_PLANT:
        record["acts_in_plant"] = 1


def rate(law: Law, drive: DriveParameters) -> float:
    """Largest rate constant that a law brings into the plant, 1/s: the spring that its slope is."""
    inertia = drive.load.inertia if law.on_load else drive.motor.rotor_inertia
    values = np.array(law.values)
    per_rad = {"position": drive.transmission.rod_per_rotor, "rotor_angle": 1.0, "travel": 1.0}
    per_rad["screw_angle"] = 1.0 / drive.transmission.gear_ratio
    fastest = 0.0
    if law.unit != "N m":
        return fastest
    table = values.reshape([len(places) for places in law.at])
    for axis, (name, places) in enumerate(zip(law.of, law.at, strict=True)):
        slopes = np.diff(table, axis=axis)
        steps = np.diff(places).reshape([-1 if row == axis else 1 for row in range(len(law.at))])
        steepest = float(np.max(np.abs(slopes / steps)))
        if name in per_rad:
            fastest = max(fastest, math.sqrt(steepest * per_rad[name] / inertia))
        elif name == "speed":
            fastest = max(fastest, steepest / inertia)
    return fastest


def segments(at: ArrayLike, period: float) -> FloatArray:
    """The cubics between the places of a table's axis, as `places` takes them.

    Args:
        at: float64[k], increasing. period: of the axis, 0 for none.

    Returns:
        float64[k, SEGMENT], of the segment that begins at each place: the place, 1 over the
        segment's width, and of each of the four weights (of the value before it, at its beginning,
        at its end, beyond it) the factors of t, t^2 and t^3, t being the share of the width that
        has been passed. At t = 0 the second weight is 1 and the others are 0. Without a period the
        last place begins no segment.
    """
    here = np.asarray(at, dtype=float)
    wraps = period > 0.0
    width = np.append(np.diff(here), here[0] + period - here[-1] if wraps else 1.0)
    # Of the slope at each place: what it takes of the values before, at and after it.
    left = np.roll(width, 1)
    slope = np.column_stack([-width / left, width / left - left / width, left / width])
    slope /= (left + width)[:, None]
    if not wraps:
        slope[0] = 0.0, -1.0 / width[0], 1.0 / width[0]
        slope[-1] = -1.0 / left[-1], 1.0 / left[-1], 0.0
    # Hermite's: value and slope at the beginning, value and slope at the end.
    ends = np.array([[[0.0, -3.0, 2.0], [0.0, 3.0, -2.0]]])
    begins = width[:, None, None] * slope[:, :, None] * np.array([1.0, -2.0, 1.0])
    stops = width[:, None, None] * np.roll(slope, -1, axis=0)[:, :, None] * np.array([0, -1, 1])
    weights = np.zeros((len(here), 4, 3))
    weights[:, 1:3] = ends
    weights[:, :3] += begins
    weights[:, 1:] += stops
    return np.column_stack([here, 1.0 / width, weights.reshape(len(here), -1)])


@kernel
def _cubic(segment, first, t):
    return t * (segment[first] + t * (segment[first + 1] + t * segment[first + 2]))


@kernel
def places(axis, count, period, x):
    """Where `x` lies on a table's axis: (four rows, four weights), as a flat tuple of eight.

    axis: float64[count ..., SEGMENT], as `segments` makes them. period: of the axis, 0 for none.
    """
    first, last = axis[0, 0], axis[count - 1, 0]
    if period > 0.0:
        x -= period * math.floor((x - first) / period)
    elif x <= first:
        return 0, 0, 0, 0, 0.0, 1.0, 0.0, 0.0
    elif x >= last:
        return 0, count - 1, 0, 0, 0.0, 1.0, 0.0, 0.0
    # Even places are found at once; others are searched for.
    here = min(max(int((x - first) * axis[0, 1]), 0), count - 1)
    low, high = 0, count
    if axis[here, 0] <= x:
        low = here
        if here + 1 == count or x < axis[here + 1, 0]:
            high = here + 1
    else:
        high = here
    while high - low > 1:
        middle = (low + high) // 2
        if axis[middle, 0] <= x:
            low = middle
        else:
            high = middle
    segment = axis[low]
    before, after, beyond = low - 1, low + 1, low + 2
    if period > 0.0:
        before += count if before < 0 else 0
        after -= count if after >= count else 0
        beyond -= count if beyond >= count else 0
    else:
        before, beyond = max(before, 0), min(beyond, count - 1)
    t = (x - segment[0]) * segment[1]
    return (
        before,
        low,
        after,
        beyond,
        _cubic(segment, 2, t),
        1.0 + _cubic(segment, 5, t),
        _cubic(segment, 8, t),
        _cubic(segment, 11, t),
    )


@kernel
def _row(p, first, found):
    """Value along the second axis of the table's row that begins at `first`."""
    value = p.learned_value
    return (
        found[4] * value[first + found[0]]
        + found[5] * value[first + found[1]]
        + found[6] * value[first + found[2]]
        + found[7] * value[first + found[3]]
    )


@kernel
def _variable(p, number, angle, speed, current, torque, voltage, time, heat, travel):
    if number == 0:
        return angle * p.rod_per_rotor
    if number == 1:
        return angle
    if number == 2:
        return angle / p.gear_ratio
    if number == 3:
        return speed
    if number == 4:
        return 1.0 if speed > 0.0 else (-1.0 if speed < 0.0 else 0.0)
    if number == 5:
        return current
    if number == 6:
        return torque
    if number == 7:
        return voltage
    if number == 8:
        return time
    if number == 9:
        return heat
    return travel


@called
def law_value(p, angle, speed, current, torque, voltage, time, heat, travel):
    """What the law gives; angle, speed: of the side that it is on."""
    if p.learned_count[0] == 0:
        return p.learned_value[0]
    x = _variable(
        p, p.learned_variables[0], angle, speed, current, torque, voltage, time, heat, travel
    )
    found = places(p.learned_segments[0], p.learned_count[0], p.learned_period[0], x)
    width = p.learned_count[1]
    if width == 0:
        return _row(p, 0, found)
    x = _variable(
        p, p.learned_variables[1], angle, speed, current, torque, voltage, time, heat, travel
    )
    across = places(p.learned_segments[1], width, p.learned_period[1], x)
    return (
        found[4] * _row(p, found[0] * width, across)
        + found[5] * _row(p, found[1] * width, across)
        + found[6] * _row(p, found[2] * width, across)
        + found[7] * _row(p, found[3] * width, across)
    )


_STEP_RAD = 1e-5  # over which the rate of an angle's error is taken


@kernel
def reading_error(p, angle, speed, current, time, heat, travel):
    """(error of a reading, its change per rad of angle) at the sensors' ports."""
    here = law_value(p, angle, speed, current, 0.0, 0.0, time, heat, travel)
    there = law_value(p, angle + _STEP_RAD, speed, current, 0.0, 0.0, time, heat, travel)
    return here, (there - here) / _STEP_RAD


@kernel
def remember(p, speed, current, heat, travel, time_s, share):
    """(heat, travel) after `share` of a tick that took `time_s`; speed: of the side it is on.

    heat: current squared behind a low-pass, A^2. travel: rad since the speed last changed sign.
    """
    kept = p.learned_heat_kept**share if share != 1.0 else p.learned_heat_kept
    squared = current * current
    heat = squared + (heat - squared) * kept
    if travel * speed < 0.0:
        travel = 0.0
    return heat, travel + speed * time_s
