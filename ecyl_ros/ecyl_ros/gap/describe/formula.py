"""The simplest formula that does as well as a law's table.

Sparse regression over the forms that the field writes laws in: powers, magnitudes and signs, waves
of a place, products of these for two variables. Terms are added one by one, the one that removes
most first, until what is left lies within the table's band, or is a twentieth of it. Where the band
is wide, a place counts for less.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable

import numpy as np

from ...arrays import FloatArray
from ...drive.law import PERIODS, Law, order_of

_MOST_TERMS = 4
_AS_WELL = 0.05  # of the table's RMS
_HARMONICS = 12
_MOST_TURNS = 12.1
_PLACES = 4.0  # of the table in a period: fewer could as well be of another one
_SYMBOLS = {
    "position": "x",
    "rotor_angle": "a",
    "screw_angle": "a",
    "speed": "w",
    "direction": "sgn",
    "current": "i",
    "torque": "T",
    "voltage": "u",
    "time": "t",
    "heat": "h",
    "travel": "s",
}
Form = tuple[str, str, FloatArray]  # text, unit of its coefficient's denominator, values
Term = list[Form]  # what is added at once


def formula(law: Law, half: FloatArray) -> str | None:
    """A formula of the law in SI units; None where none of few terms does as well.

    half: float64[values], half the width of the band.
    """
    values = np.array(law.values)
    if not law.of:
        return f"{values[0]:.4g} {law.unit}"
    grids = np.meshgrid(*(np.array(one) for one in law.at), indexing="ij")
    forms = [
        _forms(name, unit, grid.ravel(), order_of(name, period))
        for name, unit, grid, period in zip(law.of, law.units, grids, law.periods, strict=True)
    ]
    if len(forms) == 1:
        pool = forms[0]
    else:
        pool = [*forms[0], *forms[1]] + [
            [(f"{x[0]} {y[0]}", _times(x[1], y[1]), x[2] * y[2]) for x in one for y in other]
            for one, other in itertools.product(*forms)
        ]
    pool = [[("", "", np.ones(len(values)))], *pool]
    least = max(_AS_WELL * float(np.sqrt(np.mean(values**2))), 1e-300)
    enough = np.maximum(least, half / 1.96)
    chosen: list[Term] = []
    while True:
        found, left = _fitted(chosen, values, enough)
        if float(np.mean((left / enough) ** 2)) <= 1.0:
            break
        if len(chosen) == _MOST_TERMS:
            return None
        rest = [one for one in pool if all(one is not other for other in chosen)]

        def leaves(term: Term, before: list[Term] = chosen) -> float:
            return float(np.sum((_fitted([*before, term], values, enough)[1] / enough) ** 2))

        chosen = [*chosen, min(rest, key=leaves)]
    return _text(chosen, found, law.unit)


def _fitted(
    terms: list[Term], values: FloatArray, enough: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """(coefficients, what is left), each place weighed by what would be near enough there."""
    if not terms:
        return np.zeros(0), values
    design = np.stack([one[2] for term in terms for one in term], axis=1)
    scale = np.maximum(np.abs(design).max(axis=0), 1e-300)
    weighed = design / scale / enough[:, None]
    found = np.linalg.lstsq(weighed, values / enough, rcond=1e-9)[0] / scale
    return found, values - design @ found


def _forms(name: str, unit: str, x: FloatArray, base: int) -> list[Term]:
    """base: how often the law repeats itself in a turn."""
    symbol = _SYMBOLS[name]
    if name == "direction":
        return [[("sgn(w)", "", x)]]
    if name in PERIODS:
        return [
            _wave(f"{order * base if order * base > 1 else ''}{symbol}", order * base * x)
            for order in range(1, min(_HARMONICS, int(len(np.unique(x)) / _PLACES)) + 1)
        ]
    powers: list[tuple[str, int, Callable[[FloatArray], FloatArray]]] = [
        (symbol, 1, lambda v: v),
        (f"{symbol}^2", 2, np.square),
        (f"{symbol}^3", 3, lambda v: v**3),
    ]
    if x.min() < 0.0 < x.max():
        powers += [
            (f"|{symbol}|", 1, np.abs),
            (f"{symbol}|{symbol}|", 2, lambda v: v * np.abs(v)),
        ]
    found = [[(text, _power(unit, order), made(x))] for text, order, made in powers]
    if name == "speed" and x.min() < 0.0 < x.max():
        found.append([(f"sgn({symbol})", "", np.sign(x))])
    if name in ("position", "time"):
        reach = float(np.ptp(x))
        most = min(_MOST_TURNS, (len(np.unique(x)) - 1) / _PLACES)
        for turns in np.arange(0.75, most + 0.01, 0.05):
            rate = 2.0 * math.pi * turns / reach
            length = f"{reach / turns:.3g} {unit}"
            found.append(_wave(f"2 pi {symbol} / {length}", rate * x))
    return found


def _wave(text: str, angle: FloatArray) -> Term:
    """A wave of any phase."""
    return [(f"sin({text})", "", np.sin(angle)), (f"cos({text})", "", np.cos(angle))]


def _power(unit: str, order: int) -> str:
    if unit == "1" or order == 0:
        return ""
    base = f"({unit})" if order > 1 and ("/" in unit or "^" in unit or " " in unit) else unit
    return base if order == 1 else f"{base}^{order}"


def _times(one: str, other: str) -> str:
    return " ".join(part for part in (one, other) if part)


_NEGLIGIBLE = 0.02  # of a formula's largest part


def _text(terms: list[Term], found: FloatArray, unit: str) -> str:
    forms = [one for term in terms for one in term]
    if not forms:
        return f"0 {unit}"
    sizes = [
        abs(value) * float(np.abs(one[2]).max()) for one, value in zip(forms, found, strict=True)
    ]
    parts = []
    for (text, per, _), value, size in zip(forms, found, sizes, strict=True):
        if size < _NEGLIGIBLE * max(sizes):
            continue
        shown = (
            f"{unit}/({per})"
            if " " in per or (per.count("/") and not per.startswith("("))
            else f"{unit}/{per}"
            if per
            else unit
        )
        sign = "-" if value < 0.0 else "+"
        body = f"{abs(value):.4g} {shown}" + (f" {text}" if text else "")
        parts.append((sign, body))
    first = ("-" if parts[0][0] == "-" else "") + parts[0][1]
    return " ".join([first, *(f"{sign} {body}" for sign, body in parts[1:])])
