"""A constant's pull as a picture: the sheet's tolerance, the value found and its interval."""

from __future__ import annotations

from ..diagnosis import SheetValue

_WIDTH, _HEIGHT = 120, 14
_SPAN = 2.0  # tolerances shown either way


def bar(one: SheetValue) -> str:
    """Inline SVG: grey where the sheet is, a line for the interval, a dot for the value."""
    if not (one.told and one.stated):
        return ""
    half = (one.high - one.low) / (2.0 * one.tolerance)

    def at(pull: float) -> float:
        return 0.5 * _WIDTH * (1.0 + min(max(pull / _SPAN, -1.0), 1.0))

    middle = _HEIGHT / 2
    return (
        f'<svg viewBox="0 0 {_WIDTH} {_HEIGHT}" width="{_WIDTH}" height="{_HEIGHT}" '
        f'role="img" aria-label="pull {one.pull:+.2f}">'
        f'<rect class="sheet" x="{at(-1.0):.1f}" y="2" width="{at(1.0) - at(-1.0):.1f}" '
        f'height="{_HEIGHT - 4}"/>'
        f'<path class="span" d="M{at(one.pull - half):.1f} {middle}H{at(one.pull + half):.1f}"/>'
        f'<circle class="found" cx="{at(one.pull):.1f}" cy="{middle}" r="3"/></svg>'
    )
