"""A learned law: what acts at a port as a table over what it depends on.

Found by a diagnosis where the library of effects has no name for a cause, and played by engine and
nodes as an effect is (`effects.learned`). In a drive file:

    effects:
      learned: {port: load_friction, of: [position], table: {at: [0.0, 0.01], values: [0.1, 0.3]}}

Between the table's places the value follows a cubic (Hermite's, its slopes from the neighbours);
beyond the first and last place it holds.
"""

from __future__ import annotations

import difflib
import itertools
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

from ..errors import InputError
from ..finite import is_finite

# Where a law may act, in the order of their numbers in the packed record (0: nowhere), with the
# unit of what it gives there. What each means: `effects.ports`.
PORTS = {
    "rotor_torque": "N m",
    "rotor_friction": "N m",
    "load_torque": "N m",
    "load_friction": "N m",
    "inverter_voltage": "V",
    "rotor_angle_error": "rad",
    "current_error": "A",
    "rod_error": "rad",
}
# What it may depend on, in the order of their numbers, with units. Angles, speed, torque and travel
# are at the rotor; those of the load at the load's ports, of the rotor elsewhere.
VARIABLES = {
    "position": "m",
    "rotor_angle": "rad",
    "screw_angle": "rad",
    "speed": "rad/s",
    "direction": "1",
    "current": "A",
    "torque": "N m",
    "voltage": "V",
    "time": "s",
    "heat": "A^2",
    "travel": "rad",
}
PERIODS = {"rotor_angle": 2.0 * math.pi, "screw_angle": 2.0 * math.pi}
LEAST_PERIODS = 1.5  # that a motion has to show before it says that something repeats
# At the sensors there is neither a voltage nor a torque to depend on.
SENSORS = ("rotor_angle_error", "current_error", "rod_error")
MOST_PLACES, MOST_VALUES = 128, 512
KEY = "effects.learned"


def order_of(name: str, period: float) -> int:
    """How often a law of a variable repeats itself in a turn; 1 where there is no turn."""
    return round(PERIODS[name] / period) if name in PERIODS and period > 0.0 else 1


@dataclass(frozen=True)
class Law:
    """What acts at a port.

    Attributes:
        port: one of `PORTS`; at those of friction the value is the level, below 0 as 0.
        of: up to two of `VARIABLES`; none for a constant.
        at: the places of each variable, increasing, at least two each.
        values: one per place, in the port's unit; of two variables row by row, the second's places
            running fastest.
        periods: of each variable, 0 for none; a periodic one is folded to begin at its first place.
        time_constant_s: of heat, the current squared behind a first-order low-pass; 0 elsewhere.
        effort_unit, variable_units: of the values and of each variable, where a drive known by its
            effort counts them otherwise than `PORTS` and `VARIABLES` do.
    """

    port: str
    of: tuple[str, ...]
    at: tuple[tuple[float, ...], ...]
    values: tuple[float, ...]
    periods: tuple[float, ...] = ()
    time_constant_s: float = 0.0
    effort_unit: str = ""
    variable_units: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not self.periods:
            object.__setattr__(self, "periods", tuple(PERIODS.get(one, 0.0) for one in self.of))

    @property
    def unit(self) -> str:
        """Of its values."""
        return self.effort_unit or PORTS[self.port]

    @property
    def units(self) -> tuple[str, ...]:
        """Of its variables."""
        return self.variable_units or tuple(VARIABLES[one] for one in self.of)

    @property
    def of_friction(self) -> bool:
        """Whether its value is a friction level."""
        return self.port.endswith("_friction")

    @property
    def on_load(self) -> bool:
        """Whether it goes by the load's angle and speed."""
        return self.port.startswith("load_") or self.port == "rod_error"


def law_to_flat(law: Law) -> dict[str, Any]:
    """The flat dotted keys of a drive file that hold a law."""
    flat: dict[str, Any] = {f"{KEY}.port": law.port}
    if law.of:  # ROS parameters know no empty list
        flat[f"{KEY}.of"] = list(law.of)
    if any(
        period != PERIODS.get(one, 0.0) for one, period in zip(law.of, law.periods, strict=True)
    ):
        flat[f"{KEY}.period"] = list(law.periods)
    if "heat" in law.of:
        flat[f"{KEY}.time_constant"] = law.time_constant_s
    for number, places in enumerate(law.at):
        flat[f"{KEY}.table.at{'' if number == 0 else '_2'}"] = list(places)
    flat[f"{KEY}.table.values"] = list(law.values)
    return flat


def law_to_file(law: Law) -> dict[str, Any]:
    """The law as it stands under `effects.learned` in a drive file."""
    tree: dict[str, Any] = {}
    for key, value in law_to_flat(law).items():
        branch = tree
        *path, last = key.removeprefix(f"{KEY}.").split(".")
        for part in path:
            branch = branch.setdefault(part, {})
        branch[last] = value
    return tree


def rounded(law: Law, digits: Callable[[float], float]) -> Law:
    """The law with numbers as they are written."""
    return replace(
        law,
        at=tuple(tuple(digits(one) for one in places) for places in law.at),
        values=tuple(digits(one) for one in law.values),
        periods=tuple(
            PERIODS.get(name, digits(one)) for name, one in zip(law.of, law.periods, strict=True)
        ),
        time_constant_s=digits(law.time_constant_s),
    )


# Below `KEY`, with what they mean.
KEYS = {
    "port": "where it acts",
    "of": "what it depends on, up to two variables; a constant without",
    "period": "of each variable in its unit, 0 for none",
    "time_constant": "of heat, s",
    "table.at": "places of the first variable, in its unit",
    "table.at_2": "places of the second variable, in its unit",
    "table.values": "in the port's unit; of two variables the second runs fastest",
}


def law_from_flat(
    flat: Mapping[str, Any],
    source: str,
    ports: Mapping[str, str] = MappingProxyType(PORTS),
    variables: Mapping[str, str] = MappingProxyType(VARIABLES),
) -> Law | None:
    """The law in flat dotted keys; None where they hold none.

    ports, variables: that the drive has.

    Raises:
        InputError: an unknown or missing key, or a value that a law cannot have.
    """
    given = {
        key.removeprefix(f"{KEY}."): value
        for key, value in flat.items()
        if key == KEY or key.startswith(f"{KEY}.")
    }
    if not given:
        return None
    for key in given:
        if key not in KEYS:
            raise InputError(f"{source}: unknown key {KEY}.{key}; learned has {', '.join(KEYS)}")
    for key in ("port", "table.values"):
        if key not in given:
            raise InputError(f"{source}: {KEY}.{key} is missing; a learned law needs it")
    port = _one_of(given["port"], ports, "port", source)
    names = given.get("of", ())
    if isinstance(names, str) or not hasattr(names, "__iter__"):
        names = [names]
    of = tuple(_one_of(one, variables, "of", source) for one in names)
    if len(of) > 2 or len(set(of)) < len(of):
        raise InputError(f"{source}: {KEY}.of = {list(of)}, expected up to two different variables")
    lost = [one for one in of if one in ("voltage", "torque") and port in SENSORS]
    if lost:
        raise InputError(f"{source}: {KEY}.of = {lost[0]}, expected none of it at {port}")
    at = []
    for key in ("table.at", "table.at_2")[: len(of)]:
        if key not in given:
            raise InputError(f"{source}: {KEY}.{key} is missing; expected the places of the table")
        places = _numbers(given[key], key, source, 2, MOST_PLACES)
        if any(b <= a for a, b in itertools.pairwise(places)):
            raise InputError(f"{source}: {KEY}.{key}, expected increasing places")
        at.append(places)
    if len(of) < 2 and "table.at_2" in given:
        raise InputError(f"{source}: {KEY}.table.at_2, expected none for a law of {len(of)}")
    wanted = math.prod(len(places) for places in at)
    if wanted > MOST_VALUES:
        raise InputError(f"{source}: {KEY}.table, expected no more than {MOST_VALUES} values")
    values = _numbers(given["table.values"], "table.values", source, wanted, wanted)
    periods = tuple(PERIODS.get(one, 0.0) for one in of)
    if "period" in given:
        periods = _numbers(given["period"], "period", source, len(of), len(of))
    for places, period in zip(at, periods, strict=True):
        if period < 0.0 or (period > 0.0 and places[-1] - places[0] >= period):
            raise InputError(
                f"{source}: {KEY}.period = {period:g}, expected 0, or more than the "
                f"{places[-1] - places[0]:g} that the table reaches over"
            )
    constant = 0.0
    if "heat" in of:
        if "time_constant" not in given:
            raise InputError(f"{source}: {KEY}.time_constant is missing; heat needs it, s")
        (constant,) = _numbers(given["time_constant"], "time_constant", source, 1, 1)
        if not constant > 0.0:
            raise InputError(f"{source}: {KEY}.time_constant = {constant:g}, expected above 0 s")
    elif "time_constant" in given:
        raise InputError(f"{source}: {KEY}.time_constant, expected only for a law of heat")
    return Law(port, of, tuple(at), values, periods, constant)


def _one_of(value: Any, known: Mapping[str, str], key: str, source: str) -> str:
    if isinstance(value, str) and value in known:
        return value
    near = difflib.get_close_matches(str(value), known, n=1)
    hint = f"did you mean {near[0]}?" if near else f"expected one of {', '.join(known)}"
    raise InputError(f"{source}: {KEY}.{key} = {value!r}; {hint}")


def _numbers(value: Any, key: str, source: str, least: int, most: int) -> tuple[float, ...]:
    if isinstance(value, int | float | str) or not hasattr(value, "__iter__"):
        value = [value]
    values = list(value)
    count = f"{least}" if least == most else f"{least} to {most}"
    if not least <= len(values) <= most:
        raise InputError(f"{source}: {KEY}.{key} has {len(values)} values, expected {count}")
    for one in values:
        if not is_finite(one):
            raise InputError(f"{source}: {KEY}.{key} = {one!r}, expected finite numbers")
    return tuple(float(one) for one in values)
