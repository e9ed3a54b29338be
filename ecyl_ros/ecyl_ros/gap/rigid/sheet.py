"""Constants of a rigid drive's data sheet among the terms of a fit: no cause within tolerance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ...drive.rigid.machine import KEYS, Machine
from ...drive.rigid.units import Units
from ...effects.catalogue import RIGID
from ...effects.term import Interval, Term
from ..diagnosis import SheetValue
from ..judge.verdict import SEEN


def sheet_value(
    term: Term, spans: Sequence[Interval], machine: Machine, units: Units
) -> SheetValue | None:
    """The constant that a fitted term tells of; None where it tells of none that is uncertain.

    spans: the term's parameters with their 95 % intervals, in the unit that effort is counted in,
    which must be the output's own for nominal and found values to be compared.
    """
    form = RIGID[term.effect]
    key = form.constant[not machine.linear]
    width = machine.half_widths().get(key, 0.0)
    if width <= 0.0 or not units.own:
        return None
    nominal = float(getattr(machine, KEYS[key].field))
    on_top = nominal if form.on_top else 0.0
    value, low, high = (on_top + one for one in spans[0][2:])
    beyond = low > nominal + width or high < nominal - width
    return SheetValue(
        parameter=key,
        unit=_unit(key, machine, units),
        nominal=nominal,
        tolerance=width,
        value=value,
        low=low,
        high=high,
        # As wide as the sheet's an interval says nothing new, unless it lies beyond.
        seen=bool(beyond or high - low < 2.0 * SEEN * width),
    )


def _unit(key: str, machine: Machine, units: Units) -> str:
    """Of a constant; of a gain by the signal that it counts."""
    if key == "actuation.gain" and machine.actuation in ("current", "voltage"):
        return units.gain(machine.actuation == "voltage")[1]
    return KEYS[key].units[not machine.linear]


def within(value: SheetValue) -> bool:
    """Whether a constant's interval reaches into its tolerance: what the sheet allows."""
    reach = value.tolerance
    return value.low <= value.nominal + reach and value.high >= value.nominal - reach


def sheet_values(
    terms: Sequence[Term],
    spans: Mapping[str, Sequence[Interval]],
    machine: Machine,
    units: Units,
) -> tuple[SheetValue, ...]:
    """Of all terms of a fit."""
    found = (sheet_value(one, spans[one.key], machine, units) for one in terms)
    return tuple(one for one in found if one is not None)
