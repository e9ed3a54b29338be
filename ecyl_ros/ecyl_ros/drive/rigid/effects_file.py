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
from typing import Any

from ...effects.catalogue import RIGID, rigid_forms
from ...effects.rigid_form import EFFORT_KINDS, Stem
from ...errors import InputError
from ...finite import is_finite
from .model import Acting
from .units import EFFORT_UNITS, Units, own_effort

WAVES = ("periods_per_rev", "periods_per_screw_rev", "period_m")

# kind -> name in a file, and unit, of a value.
_NAMES: dict[str, Callable[[str, Units], tuple[str, str]]] = {
    "level": lambda stem, units: (units.level(stem), units.effort),
    "load": lambda stem, units: (units.load, units.effort),
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


def _name(stem: Stem, units: Units) -> tuple[str, str]:
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
    known = rigid_forms(linear)
    wanted: dict[str, dict[str, Any]] = {}
    for key, value in flat.items():
        effect, _, parameter = key.partition(".")
        if effect not in known:
            near = difflib.get_close_matches(effect, known, n=1)
            hint = f"did you mean {near[0]}?" if near else f"a rigid drive has {', '.join(known)}"
            raise InputError(f"{source}: unknown effect effects.{effect}; {hint}")
        wanted.setdefault(effect, {})[parameter] = value
    own = own_effort(linear)
    choices = [own, *(one for one in EFFORT_UNITS if one != own)]
    for unit in choices:
        units = Units(unit, linear)
        names = {effect: _named(known[effect].stems, units) for effect in wanted}
        if all(
            _plain(parameter)[0] in names[effect]
            for effect, values in wanted.items()
            for parameter in values
        ):
            break
    else:
        units = Units(own, linear)
        names = {effect: _named(known[effect].stems, units) for effect in wanted}
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
            counted = counted or stem.kind in EFFORT_KINDS
            where = f"{source}: effects.{effect}.{parameter}"
            inside = _checked(value, stem, plain, lead, where)
            if stem.name in numbered.setdefault(number, {}):
                raise InputError(f"{where}: given beside {' or '.join(WAVES[1:])}; expected one")
            numbered[number][stem.name] = inside
        for number in sorted(numbered):
            place = f"{source}: effects.{effect}"
            found.append(
                Acting(
                    effect, _complete(numbered[number], known[effect].stems, units, place, number)
                )
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
    if not is_finite(value):
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
    count: dict[str, int] = {}
    found: dict[str, dict[str, float]] = {}
    for one in effects:
        number = count[one.name] = count.get(one.name, 0) + 1
        target = found.setdefault(one.name, {})
        for stem in RIGID[one.name].stems:
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
    for name, form in RIGID.items():
        if form.outputs == ("rotary",):  # stands beside its like on a straight output
            continue
        title = f"`{name}`"
        if form.outputs == ("linear",):
            title += f"; `{name.replace('load_', 'rotor_')}`"
        parts = []
        for stem in form.stems:
            if stem.kind == "wave":
                names = f"`{WAVES[1]}` or `{WAVES[2]}`; `{WAVES[0]}`"
            else:
                pair = (_name(stem, Units("N", True))[0], _name(stem, Units("N m", False))[0])
                names = "; ".join(f"`{one}`" for one in dict.fromkeys(pair))
            parts.append(f"{names}: {stem.meaning}")
        rows.append(f"| {title} | {'<br>'.join(parts)} |")
    return "\n".join(rows)
