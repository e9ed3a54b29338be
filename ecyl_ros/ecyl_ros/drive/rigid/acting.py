"""Effects in the file of a rigid drive: `effects.NAME.PARAMETER`, and what they are inside.

Names are those of the diagnosis. Inside, a value goes by its stem ("coulomb"), whatever the effort
is counted in; a wave over the position by its rate in rad per m or rad of the output.

An effect may act several times (cogging of two orders): the parameters of the second are numbered
behind their stem, `amplitude_2_n`.
"""

from __future__ import annotations

import contextlib
import difflib
import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ...errors import InputError
from .units import EFFORT_UNITS, Units

_HUGE = 1e9
WAVES = ("periods_per_rev", "periods_per_screw_rev", "period_m")


@dataclass(frozen=True)
class Acting:
    """One effect at work: its name, and its values by stem."""

    name: str
    values: Mapping[str, float]


@dataclass(frozen=True)
class Stem:
    """A value of an effect.

    Attributes:
        name: inside. kind: what it counts, see `_NAMES`. low, high: possible. meaning: in the docs.
        default: where a file may leave it out. either: of those of an effect that have it, a file
            gives one.
    """

    name: str
    kind: str
    low: float
    high: float
    meaning: str
    default: float | None = None
    either: bool = False


# kind -> name in a file, and unit, of a value.
_NAMES: dict[str, Callable[[str, Units], tuple[str, str]]] = {
    "level": lambda stem, units: (units.level(stem), units.effort),
    "per_speed": lambda stem, units: (units.per_speed(stem), units.speed_unit),
    "per_position": lambda stem, units: (
        units.per_position(stem),
        f"{units.effort}/{units.end}",
    ),
    "inertia": lambda stem, units: units.inertia,
    "position": lambda stem, units: (f"{stem}_{units.end}", units.end),
    "speed": lambda stem, units: (
        f"{stem}_m_s" if units.linear else f"{stem}_rad_s",
        f"{units.end}/s",
    ),
    "rate": lambda stem, units: (f"{stem}_per_s", "1/s"),
    "time": lambda stem, units: (f"{stem}_s", "s"),
    "frequency": lambda stem, units: (f"{stem}_hz", "Hz"),
    "share": lambda stem, units: (stem, "1"),
    "angle": lambda stem, units: (f"{stem}_rad", "rad"),
    "gain": lambda stem, units: units.gain(stem == "per_volt"),
}
_COUNTED = ("level", "per_speed", "per_position", "inertia")  # names tell the unit of effort


def _friction(name: str, meaning: str) -> Stem:
    return Stem(name, "level", -_HUGE, _HUGE, meaning)


def _slope(name: str, meaning: str) -> Stem:
    return Stem(name, "per_speed", -_HUGE, _HUGE, meaning)


def _wave() -> tuple[Stem, ...]:
    return (
        Stem("wave", "wave", 1e-6, 1e6, "periods per turn, or period of a straight output"),
        Stem("phase", "angle", -10.0, 10.0, "of the sine at position 0", default=0.0),
    )


def effects_of(linear: bool) -> dict[str, tuple[Stem, ...]]:
    """Effects that the file of a rigid drive may hold, with their values."""
    side = "load" if linear else "rotor"
    return {
        f"{side}_inertia_error": (
            Stem("inertia", "inertia", 1e-12, _HUGE, "all that moves, in place of the nominal one"),
        ),
        f"{side}_viscous_friction": (_slope("viscous", "friction in proportion to speed"),),
        f"{side}_coulomb_friction": (_friction("coulomb", "friction level"),),
        "direction_dependent_friction": (
            _friction("coulomb_positive", "level, forwards"),
            _friction("coulomb_negative", "level, backwards"),
            _slope("viscous_positive", "rise with speed, forwards"),
            _slope("viscous_negative", "rise with speed, backwards"),
        ),
        "stribeck_friction": (
            _friction("coulomb", "level at speed"),
            _friction("static", "level at rest"),
            Stem("stribeck", "speed", 1e-9, 1e6, "at which the surplus has fallen to 1/e"),
        ),
        "friction_drift": (
            _friction("coulomb", "level at the first sample"),
            Stem("rate", "rate", -_HUGE, _HUGE, "change of the level over it"),
        ),
        "load_dependent_friction": (
            Stem("share", "share", 0.0, 10.0, "level over the nominal load carried", either=True),
            Stem("inertia", "inertia", 0.0, _HUGE, "level over the acceleration", either=True),
        ),
        "local_jam": (
            _friction("coulomb", "drag against the motion"),
            Stem("position", "position", -1e6, 1e6, "middle of the part"),
            Stem("width", "position", 1e-9, 1e6, "length of the part"),
        ),
        "constant_load": (
            _friction("force" if linear else "torque", "positive against positive motion"),
        ),
        "spring_load": (
            Stem("stiffness", "per_position", -_HUGE, _HUGE, "spring rate"),
            Stem("rest", "position", -1e9, 1e9, "where it is slack", default=0.0),
        ),
        "gravity_on_arm": (
            Stem("amplitude", "level", 0.0, _HUGE, "weight of an arm"),
            Stem("phase", "angle", -10.0, 10.0, "of the sine at angle 0", default=0.0),
        ),
        "cogging_torque": (Stem("amplitude", "level", 0.0, _HUGE, "peak"), *_wave()),
        "torque_ripple": (Stem("fraction", "share", 0.0, 1.0, "peak share of effort"), *_wave()),
        "periodic_disturbance": (
            Stem("amplitude", "level", 0.0, _HUGE, "peak"),
            Stem("frequency", "frequency", 1e-4, 1e6, "its frequency"),
            Stem("phase", "angle", -10.0, 10.0, "of the sine at the first sample", default=0.0),
        ),
        "actuation_delay": (Stem("delay", "time", -1.0, 1.0, "from effort to motion"),),
        "torque_constant_error": (
            Stem("per_ampere", "gain", 1e-9, _HUGE, "true one", either=True),
            Stem("per_volt", "gain", 1e-9, _HUGE, "true one", either=True),
        ),
    }


def _name(stem: Stem, units: Units) -> tuple[str, str]:
    if stem.name == "share":
        return "coefficient", "1"
    return _NAMES[stem.kind](stem.name, units)


def _named(stems: Sequence[Stem], units: Units) -> dict[str, Stem]:
    """Parameter of a file -> stem; a wave has several names."""
    found: dict[str, Stem] = {}
    for stem in stems:
        if stem.kind == "wave":
            found |= dict.fromkeys(WAVES[1:] if units.linear else WAVES[:1], stem)
        else:
            found[_name(stem, units)[0]] = stem
    return found


def parse(
    flat: Mapping[str, Any], linear: bool, lead: float | None, source: str
) -> tuple[tuple[Acting, ...], str | None]:
    """The effects of a file, and the unit of effort that their names say (None: they do not).

    flat: "NAME.PARAMETER" -> value.

    Raises:
        InputError: an effect or parameter of another name, a value missing or out of its range.
    """
    if not flat:
        return (), None
    known = effects_of(linear)
    wanted: dict[str, dict[str, Any]] = {}
    for key, value in flat.items():
        effect, _, parameter = key.partition(".")
        if effect not in known:
            near = difflib.get_close_matches(effect, known, n=1)
            hint = f"did you mean {near[0]}?" if near else f"a rigid drive has {', '.join(known)}"
            raise InputError(f"{source}: unknown effect effects.{effect}; {hint}")
        wanted.setdefault(effect, {})[parameter] = value
    own = "N" if linear else "N m"
    choices = [own, *(one for one in EFFORT_UNITS if one != own)]
    for unit in choices:
        units = Units(unit, linear)
        names = {effect: _named(known[effect], units) for effect in wanted}
        if all(
            _plain(parameter)[0] in names[effect]
            for effect, values in wanted.items()
            for parameter in values
        ):
            break
    else:
        units = Units(own, linear)
        names = {effect: _named(known[effect], units) for effect in wanted}
        effect, parameter = next(
            (effect, parameter)
            for effect, values in wanted.items()
            for parameter in values
            if _plain(parameter)[0] not in names[effect]
        )
        raise InputError(
            f"{source}: unknown key effects.{effect}.{parameter}; expected "
            f"{', '.join(names[effect])}, all effects counted in one unit"
        )
    found: list[Acting] = []
    counted = False
    for effect, values in wanted.items():
        numbered: dict[int, dict[str, float]] = {}
        for parameter, value in values.items():
            plain, number = _plain(parameter)
            stem = names[effect][plain]
            counted = counted or stem.kind in _COUNTED
            where = f"{source}: effects.{effect}.{parameter}"
            inside = _checked(value, stem, plain, lead, where)
            if stem.name in numbered.setdefault(number, {}):
                raise InputError(f"{where}: given beside {' or '.join(WAVES[1:])}; expected one")
            numbered[number][stem.name] = inside
        for number in sorted(numbered):
            place = f"{source}: effects.{effect}"
            found.append(
                Acting(effect, _complete(numbered[number], known[effect], units, place, number))
            )
    return tuple(found), units.effort if counted else None


def _plain(parameter: str) -> tuple[str, int]:
    """Name and number of a parameter: "amplitude_2_nm" is ("amplitude_nm", 2)."""
    match = re.fullmatch(r"([a-z]+)_([2-9]|[1-9]\d)(_.*)?", parameter)
    if match is None:
        return parameter, 1
    return f"{match[1]}{match[3] or ''}", int(match[2])


def numbered(name: str, number: int) -> str:
    """The name of a further one: "amplitude_nm" is "amplitude_2_nm"; the first has no number."""
    first, mark, rest = name.partition("_")
    return f"{first}_{number}{mark}{rest}" if number > 1 else name


def _checked(value: Any, stem: Stem, name: str, lead: float | None, where: str) -> float:
    if isinstance(value, str):  # YAML 1.1 reads 1e3 (no dot) as text; ROS reads a number
        with contextlib.suppress(ValueError):
            value = float(value)
    wanted = f"expected a number from {stem.low:g} to {stem.high:g}"
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise InputError(f"{where} = {value!r}, {wanted}")
    if not stem.low <= value <= stem.high:
        raise InputError(f"{where} = {value:g}, {wanted} (SI units throughout)")
    if stem.kind != "wave" or name == "periods_per_rev":
        return float(value)
    if name == "period_m":
        return math.tau / float(value)
    if lead is None:
        raise InputError(f"{where}: screw.lead is missing; periods per screw turn need it")
    return float(value) * math.tau / lead


def _complete(
    values: dict[str, float], stems: Sequence[Stem], units: Units, place: str, number: int
) -> dict[str, float]:
    either = [one for one in stems if one.either]
    if either and sum(one.name in values for one in either) != 1:
        names = " or ".join(_name(one, units)[0] for one in either)
        raise InputError(f"{place}: expected one of {names}")
    for stem in stems:
        if stem.name in values or stem.either:
            continue
        if stem.default is None:
            choices = [name for name, one in _named(stems, units).items() if one is stem]
            missing = " or ".join(numbered(name, number) for name in choices)
            raise InputError(f"{place}.{missing} is missing")
        values[stem.name] = stem.default
    return values


def as_file(
    effects: Iterable[Acting], units: Units, lead: float | None
) -> dict[str, dict[str, float]]:
    """{effect: {parameter: value}} as `parse` reads them."""
    known = effects_of(units.linear)
    count: dict[str, int] = {}
    found: dict[str, dict[str, float]] = {}
    for one in effects:
        number = count[one.name] = count.get(one.name, 0) + 1
        target = found.setdefault(one.name, {})
        for stem in known[one.name]:
            if stem.name not in one.values:
                continue
            value = one.values[stem.name]
            if stem.kind == "wave":
                name, value = wave_as_file(value, units.linear, lead)
            else:
                name = _name(stem, units)[0]
            target[numbered(name, number)] = value
    return found


def wave_as_file(rate: float, linear: bool, lead: float | None) -> tuple[str, float]:
    """Name and value of a wave of `rate` rad per m or rad of the output."""
    if not linear:
        return WAVES[0], rate
    if lead is not None:
        return WAVES[1], rate * lead / math.tau
    return WAVES[2], math.tau / rate


def effects_table() -> str:
    """Every effect as a table of Markdown, for docs/drive-file.md."""
    rows = ["| effect | parameters (linear; rotary) |", "|---|---|"]
    straight, round_ = effects_of(True), effects_of(False)
    for (name, stems), (other, turned) in zip(straight.items(), round_.items(), strict=True):
        title = f"`{name}`" if name == other else f"`{name}`; `{other}`"
        parts = []
        for stem, turning in zip(stems, turned, strict=True):
            if stem.kind == "wave":
                names = f"`{WAVES[1]}` or `{WAVES[2]}`; `{WAVES[0]}`"
            else:
                pair = (_name(stem, Units("N", True))[0], _name(turning, Units("N m", False))[0])
                names = "; ".join(f"`{one}`" for one in dict.fromkeys(pair))
            parts.append(f"{names}: {stem.meaning}")
        rows.append(f"| {title} | {'<br>'.join(parts)} |")
    return "\n".join(rows)
