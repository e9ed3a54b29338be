"""How the gap closes: before, what each cause removes, after, and the floor, as bars."""

from __future__ import annotations

import html

from ..diagnosis import Diagnosis
from . import quantities as q
from . import words
from .markup import typeset
from .svg import WIDTH

_ROW = 40
_BAR = 14
_SMALLEST = 1.5  # a bar shorter than this is not seen


def waterfall(diagnosis: Diagnosis) -> str:
    """Inline SVG; bars from left to right on one linear scale, the floor as a line through all."""
    rows = _rows(diagnosis)
    top = max([*(max(start, end) for _, _, start, end, _ in rows), 1e-300])
    scale = (WIDTH - 2) / top
    height = _ROW * len(rows) + 6
    floor = diagnosis.floor * scale
    parts = [
        f'<svg class="chart" viewBox="0 0 {WIDTH} {height}" role="img" '
        f'aria-label="{html.escape(_text(diagnosis))}">',
    ]
    for number, (name, kind, start, end, figure) in enumerate(rows):
        y = number * _ROW
        left, right = sorted((start * scale, end * scale))
        width = max(right - left, _SMALLEST)
        parts.append(f'<text x="0" y="{y + 14}">{typeset(name)}</text>')
        parts.append(f'<text class="end" x="{WIDTH}" y="{y + 14}">{typeset(figure)}</text>')
        parts.append(
            f'<rect class="bar {kind}" x="{left:.1f}" y="{y + 20}" width="{width:.1f}" '
            f'height="{_BAR}"/>'
        )
        if kind != "floor":
            parts.append(f'<path class="curve floor" d="M{floor:.1f} {y + 19}v{_BAR + 3}"/>')
    return "".join(parts) + "</svg>"


def _rows(diagnosis: Diagnosis) -> list[tuple[str, str, float, float, str]]:
    floor = diagnosis.floor

    def size(value: float) -> str:
        return f"{_share(value)}, {q.times(value, floor)} x floor"

    rows = [("nominal model", "before", 0.0, diagnosis.before, size(diagnosis.before))]
    level = diagnosis.before
    if diagnosis.sheet and diagnosis.within_sheet is not None and diagnosis.causes:
        level = diagnosis.within_sheet
        sign = "-" if level <= diagnosis.before else "+"
        change = f"{sign}{_share(abs(diagnosis.before - level))}"
        rows.append(("the sheet's constants", "taken", level, diagnosis.before, change))
    for cause, reached in zip(diagnosis.causes, diagnosis.steps, strict=False):
        sign = "-" if reached <= level else "+"
        change = f"{sign}{_share(abs(level - reached))}"
        rows.append((words.heading(cause.effect), "taken", reached, level, change))
        level = reached
    if diagnosis.closes:
        name = "with it added" if len(diagnosis.causes) == 1 else "with them added"
        name = name if diagnosis.causes else "with the constants found"
        name = "with the law" if diagnosis.law is not None else name
        rows.append((name, "after", 0.0, diagnosis.after, size(diagnosis.after)))
    rows.append((f"{diagnosis.floor_is} (floor)", "floor", 0.0, floor, _share(floor)))
    return rows


def _share(value: float) -> str:
    return f"{q.number(100.0 * value)} %"


def _text(diagnosis: Diagnosis) -> str:
    return "Bars: " + "; ".join(f"{name}, {figure}" for name, _, _, _, figure in _rows(diagnosis))
