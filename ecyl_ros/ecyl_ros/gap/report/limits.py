"""What a recording could have shown, in words and as a table."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ..diagnosis import Diagnosis
from ..limits.limit import Alike, Limit
from ..listed import listed
from . import quantities as q
from . import words

# Faults that machines have in service, the commonest of each place first.
_MATTER = (
    ("rotor_coulomb_friction", "load_coulomb_friction", "direction_dependent_friction"),
    ("backlash_error", "transmission_error", "constant_load"),
    ("load_inertia_error", "load_viscous_friction", "spring_load"),
    ("resistance_error", "torque_constant_error", "torque_ripple"),
    ("measurement_delay", "actuation_delay", "cogging_torque"),
)
_MOST_PAIRS = 5
_MANY = 10.0  # times a constant: from here on no percentage


def chosen(diagnosis: Diagnosis) -> list[Limit]:
    """Five at the most: of each place the first that the recording would have shown."""
    shown = {one.effect: one for one in diagnosis.limits if one.smallest_seen is not None}
    kept = []
    for names in _MATTER:
        found = next((shown[name] for name in names if name in shown), None)
        if found is not None:
            kept.append(found)
    return kept


def size(one: Limit) -> str:
    """The smallest size that is seen: "2.1 mN m", "off by 4.2 %", "below 6.1 V"."""
    if one.smallest_seen is None:
        return "not at any size"
    if one.neutral == 0.0 or not math.isfinite(one.neutral):
        return q.amount(one.smallest_seen, one.unit)
    if _caps(one):
        return f"below {q.amount(one.neutral - one.smallest_seen, one.unit)}"
    share = one.smallest_seen / abs(one.neutral)
    if share >= _MANY:
        return f"off by {q.number(share, 2)} times its value"
    return f"off by {q.number(100.0 * share, 2)} %"


def _caps(one: Limit) -> bool:
    """Whether it is a limit, which acts from somewhere below what the motion asks for."""
    return one.effect in ("voltage_limit", "current_limit", "stiffness_hardening")


def at(one: Limit) -> str:
    """What the size is stated for; empty where it holds whatever else."""
    units = {"hz": "Hz", "m": "m", "rad_s": "rad/s"}
    parts = []
    for name, value in one.at.items():
        label = q.parameter_label(name)
        unit = units.get(name.rsplit("_", 1)[-1], "")
        parts.append(f"{label} {q.joined(q.number(value), unit)}")
    return ", ".join(parts)


def sentence(diagnosis: Diagnosis) -> str:
    """What could not have hidden, in one sentence; empty where nothing is known."""
    found = chosen(diagnosis)
    if not found:
        return ""
    if diagnosis.verdict in ("no_gap", "within_sheet"):
        parts = [f"no {_named(one)} {_of(one, 'above', 'off by more than')}" for one in found]
        return f"With 95 % confidence there is {listed(parts, 'and')}."
    parts = [f"{_named(one)} {_of(one, 'of', 'off by')}" for one in found]
    return f"It would also have shown {listed(parts, 'or')} on 95 of 100 machines."


def _named(one: Limit) -> str:
    """The effect as what it is off by: a wrong backlash is a backlash off by so much."""
    return words.title(one.effect).removeprefix("wrong ")


def _of(one: Limit, above: str, off: str) -> str:
    text = size(one)
    if text.startswith("off by"):
        return f"{off}{text.removeprefix('off by')}"
    return text if text.startswith("below") else f"{above} {text}{_wave(one)}"


def _wave(one: Limit) -> str:
    """How often a wave of that size repeats: what repeats more often may be beyond the band."""
    return "".join(
        f" ({value:.4g} {q.parameter_label(name).removeprefix('periods ')})"
        for name, value in one.at.items()
        if name.startswith("periods_per")
    )


def pairs(diagnosis: Diagnosis) -> list[str]:
    """Effects that look alike in this recording, one line each, closest first."""
    lines = [_pair(one) for one in merged(diagnosis.alike)]
    kept = lines[:_MOST_PAIRS]
    if len(lines) > _MOST_PAIRS:
        kept.append(f"{len(lines) - _MOST_PAIRS} more pairs in the JSON")
    return kept


def merged(alike: Sequence[Alike]) -> list[Alike]:
    """One of each two pairs of the same effects: the one that stands further apart."""
    found: dict[frozenset[str], Alike] = {}
    for one in alike:
        key = frozenset(one.effects)
        if key not in found or one.separation > found[key].separation:
            found[key] = one
    return sorted(found.values(), key=lambda one: one.separation)


def _pair(one: Alike) -> str:
    first, second = (words.title(name) for name in one.effects)
    first = first[:1].upper() + first[1:]
    return (
        f"{first} and {second} look alike here: separated by "
        f"{q.number(one.separation, 2)} noise floors, {q.number(one.needed, 2)} are needed"
    )
