"""Charts as inline SVG that takes its colours and its typeface from the page.

Drawn small (`WIDTH` units) so that the same picture reads on a phone and, two side by side, on a
desk. Curves carry CSS classes, no colours, so that light, dark and print are the page's affair.
"""

from __future__ import annotations

import html
import math
from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray
from .decimate import envelope

WIDTH = 420
HEIGHT = 206
_LEFT, _RIGHT, _TOP, _BOTTOM = 46, 10, 24, 36
_FAR = 3.0  # curves are cut off this many heights beyond the frame


@dataclass(frozen=True)
class Axis:
    """One axis: its range, its label with unit (plain text), linear or logarithmic."""

    low: float
    high: float
    label: str
    logarithmic: bool = False

    @classmethod
    def around(cls, label: str, *values: FloatArray, margin: float = 0.05) -> Axis:
        """A linear axis with room for all finite values."""
        every = np.concatenate([np.ravel(one) for one in values]) if values else np.empty(0)
        every = every[np.isfinite(every)]
        if every.size == 0:
            return cls(0.0, 1.0, label)
        low, high = float(every.min()), float(every.max())
        room = margin * (high - low) or margin * abs(high) or 1.0
        return cls(low - room, high + room, label)

    def place(self, values: FloatArray) -> FloatArray:
        """float64[n], 0 at the low end and 1 at the high end; NaN where there is no place."""
        if self.logarithmic:
            with np.errstate(divide="ignore", invalid="ignore"):
                raw = np.log(np.where(values > 0.0, values, np.nan))
            low, high = math.log(self.low), math.log(self.high)
        else:
            raw, low, high = np.asarray(values, dtype=float), self.low, self.high
        placed: FloatArray = (raw - low) / (high - low)
        return placed

    def ticks(self, most: int) -> list[tuple[float, str]]:
        """Round values within the range, with their text."""
        return _decades(self.low, self.high, most) if self.logarithmic else self._even(most)

    def _even(self, most: int) -> list[tuple[float, str]]:
        span = self.high - self.low
        raw = span / max(most, 1)
        power = 10.0 ** math.floor(math.log10(raw))
        step = next(power * one for one in (1.0, 2.0, 5.0, 10.0) if power * one >= raw * 0.999)
        places = max(0, -math.floor(math.log10(step) + 1e-9))
        first = math.ceil(self.low / step - 1e-9)
        last = math.floor(self.high / step + 1e-9)
        values = [count * step for count in range(first, last + 1)]
        if max(abs(self.low), abs(self.high)) >= 1e6 or places > 6:
            return [(value, f"{value:.1e}") for value in values]
        return [(value, f"{value:.{places}f}".replace("-", "\N{MINUS SIGN}")) for value in values]


def _decades(low: float, high: float, most: int) -> list[tuple[float, str]]:
    first, last = math.ceil(math.log10(low) - 1e-9), math.floor(math.log10(high) + 1e-9)
    if last - first < 1:
        steps = [f * 10.0**p for p in range(first - 1, last + 2) for f in (1.0, 2.0, 5.0)]
        return [(one, f"{one:g}") for one in steps if low <= one <= high]
    stride = max(1, math.ceil((last - first + 1) / most))
    plain = first >= -2 and last <= 3
    return [(10.0**power, _power(power, plain)) for power in range(first, last + 1, stride)]


def _power(power: int, plain: bool) -> str:
    if plain or power in (0, 1):
        return f"{10.0**power:g}"
    return "10" + str(power).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


class Chart:
    """A frame with two axes that curves, bands, levels and shades are drawn into.

    text: what the picture shows, for those who do not see it.
    """

    def __init__(self, x: Axis, y: Axis, text: str, height: int = HEIGHT) -> None:
        self.x, self.y, self.text, self.height = x, y, text, height
        self._wide = WIDTH - _LEFT - _RIGHT
        self._tall = height - _TOP - _BOTTOM
        self._marks: list[str] = []

    def shade(self, start: float, stop: float) -> None:
        """A quiet background between two x."""
        left, right = self.x.place(np.array([start, stop])) * self._wide
        left, right = max(float(left), 0.0), min(float(right), float(self._wide))
        if right > left:
            self._marks.append(
                f'<rect class="shade" x="{left:.1f}" y="0" width="{right - left:.1f}" '
                f'height="{self._tall}"/>'
            )

    def curve(self, x: FloatArray, y: FloatArray, kind: str) -> None:
        """A line of CSS class `kind`; NaN breaks it."""
        x, y = envelope(np.asarray(x, dtype=float), np.asarray(y, dtype=float), self._wide)
        path = self._path(x, y)
        if path:
            self._marks.append(f'<path class="curve {kind}" d="{path}"/>')

    def dots(self, x: FloatArray, y: FloatArray) -> None:
        """A point at each place that is within the axes."""
        across, down = self.x.place(x) * self._wide, self._down(y)
        marks = [
            f"M{left:.1f} {top:.1f}h0"
            for left, top in zip(across.tolist(), down.tolist(), strict=True)
            if 0.0 <= left <= self._wide and 0.0 <= top <= self._tall
        ]
        if marks:
            self._marks.append(f'<path class="dots" d="{"".join(marks)}"/>')

    def band(self, x: FloatArray, low: FloatArray, high: FloatArray, kind: str) -> None:
        """The area between two lines."""
        if x.size < 2:
            return
        path = self._path(np.concatenate([x, x[::-1]]), np.concatenate([low, high[::-1]]))
        self._marks.append(f'<path class="band {kind}" d="{path}Z"/>')

    def level(self, y: float, kind: str) -> None:
        """A horizontal line across the frame."""
        place = self._down(np.array([y]))[0]
        if math.isfinite(place) and 0.0 <= place <= self._tall:
            self._marks.append(f'<path class="curve {kind}" d="M0 {place:.1f}H{self._wide}"/>')

    def _down(self, y: FloatArray) -> FloatArray:
        placed = (1.0 - self.y.place(y)) * self._tall
        cut: FloatArray = np.clip(placed, -_FAR * self._tall, (1.0 + _FAR) * self._tall)
        return cut

    def _path(self, x: FloatArray, y: FloatArray) -> str:
        across, down = self.x.place(x) * self._wide, self._down(y)
        parts, pen_down = [], False
        for left, top in zip(across.tolist(), down.tolist(), strict=True):
            if not (math.isfinite(left) and math.isfinite(top)):
                pen_down = False
                continue
            parts.append(f"{'L' if pen_down else 'M'}{left:.1f} {top:.1f}")
            pen_down = True
        return "".join(parts)

    def __str__(self) -> str:
        wide, tall = self._wide, self._tall
        parts = [
            f'<svg class="chart" viewBox="0 0 {WIDTH} {self.height}" role="img" '
            f'aria-label="{html.escape(self.text)}">',
            f'<text x="0" y="13">{html.escape(self.y.label)}</text>',
        ]
        grid, marks = [], []
        for value, text in self.y.ticks(max(3, tall // 26)):
            top = _TOP + self._down(np.array([value]))[0]
            grid.append(f"M{_LEFT} {top:.1f}h{wide}")
            marks.append(f'<text class="end" x="{_LEFT - 6}" y="{top + 4:.1f}">{text}</text>')
        for value, text in self.x.ticks(6):
            left = _LEFT + float(self.x.place(np.array([value]))[0]) * wide
            grid.append(f"M{left:.1f} {_TOP + tall}v4")
            marks.append(f'<text class="mid" x="{left:.1f}" y="{_TOP + tall + 16}">{text}</text>')
        parts.append(f'<path class="grid" d="{"".join(grid)}"/>')
        parts += marks
        parts.append(
            f'<text class="end" x="{WIDTH - _RIGHT}" y="{self.height - 4}">'
            f"{html.escape(self.x.label)}</text>"
        )
        parts.append(
            f'<svg x="{_LEFT}" y="{_TOP}" width="{wide}" height="{tall}" overflow="hidden">'
            f"{''.join(self._marks)}</svg></svg>"
        )
        return "".join(parts)
