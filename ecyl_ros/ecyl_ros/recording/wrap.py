"""Fields that start again: counters of some bits, angles of one turn; found, and made whole."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d

from ..arrays import BoolArray, FloatArray

TURN = "rev"
_BITS = re.compile(r"(signed\s+)?(\d{1,2})\s*bits?$")
_COUNTERS = (10, 12, 13, 14, 15, 16, 17, 18, 19, 20, 22, 24, 32)  # bits of encoders and registers
# What actuators on CAN send a position in, rad: +-12.5, +-4 pi or +-95.5, two bytes over it all
# (the MIT Mini Cheetah's protocol, and what came of it).
_CAN = (25.0, 8.0 * math.pi, 191.0)
# One turn by the unit that a header tells; without one what only a turn can be.
_TURNS = {
    "": (math.tau, 360.0, 3600.0, 36000.0),
    "rad": (math.tau, *_CAN),
    "mrad": (math.tau * 1e3,),
    "deg": (360.0,),
    "rev": (1.0,),
}
_CLOCKS = (2.0**16, 2.0**24, 2.0**32, 1e3, 1e6, 1e9, 60.0, 3600.0, 86400.0, 6e4, 3.6e6)
_QUIET = 0.25  # of the period: a field that moves further in a sample cannot be made whole
_PASSED = 0.02  # share of the values that stand in the middle half of a turn, at least
_VALUES = 8  # different ones, of a number whose sign was lost
_NEAR = 10  # steps on either side
_FEW = 50  # values, below which nothing is looked for


@dataclass(frozen=True)
class Wrap:
    """How a field starts again.

    Attributes:
        period: after how much, in the field's own unit; NaN for one revolution.
        signed: whether the upper half of the period stands for negative numbers (two's complement
            read without its sign).
        text: as a map writes it: `4096`, `16bit`, `signed 16bit`, `rev`.
    """

    period: float
    signed: bool
    text: str

    @property
    def in_map(self) -> float | int | str:
        """The value of the map's key."""
        if self.text not in (f"{self.period:g}", f"{self.period:.16g}"):
            return self.text
        return int(self.period) if self.period.is_integer() else self.period


def parse_wrap(value: Any) -> Wrap | None:
    """The wrap that a map's key `wrap` says; None for a value that says none."""
    if isinstance(value, bool):
        return None
    if isinstance(value, int | float):
        number = float(value) if abs(value) < 1e300 else math.inf
        good = 0.0 < number < 2.0**64
        return Wrap(number, False, f"{number:g}") if good else None
    if not isinstance(value, str):
        return None
    text = " ".join(value.lower().split())
    if text == TURN:
        return Wrap(math.nan, False, TURN)
    found = _BITS.match(text)
    if found and 2 <= int(found[2]) <= 63:
        return _bits(int(found[2]), signed=bool(found[1]))
    try:
        return parse_wrap(float(text))
    except ValueError:
        return None


def _bits(bits: int, *, signed: bool) -> Wrap:
    return Wrap(2.0**bits, signed, f"{'signed ' if signed else ''}{bits}bit")


def folded(values: NDArray[Any], period: float) -> FloatArray:
    """Numbers of 0 to the period as those of minus half a period to half a period."""
    out: FloatArray = values - period * np.floor(values / period + 0.5)
    return out


def unwrapped(values: NDArray[Any], period: float) -> FloatArray:
    """The values with whole periods added, so that no step is more than half a period.

    The first finite value stays. NaN stays; steps are taken across it.
    """
    out = np.array(values, dtype=np.float64)
    known = np.flatnonzero(np.isfinite(out))
    if known.size > 1:
        turns = np.cumsum(np.round(np.diff(out[known]) / period))
        out[known[1:]] -= period * turns
    return out


def hurried(values: NDArray[Any], period: float) -> bool:
    """Whether a field moves by more than a quarter of its period in one sample somewhere.

    Then which way it went is a guess there.
    """
    steps = np.abs(np.diff(unwrapped(values[np.isfinite(values)], period)))
    return bool((steps > _QUIET * period).any())


@dataclass(frozen=True)
class WrapFound:
    """A field that starts again.

    Attributes:
        wrap: how.
        times: how often.
        low, high: the range that it stays in.
    """

    wrap: Wrap
    times: int
    low: float
    high: float

    @property
    def text(self) -> str:
        """One line that says how."""
        return (
            f"goes from one end of its range ({self.low:.6g} to {self.high:.6g}) to the other "
            f"{self.times} times, as a field that wraps around after {self.wrap.text} does"
        )


def find_wrap(values: NDArray[Any], unit: str = "") -> WrapFound | None:
    """How a field starts again, if it does; `unit`: as `units.plain` spells it, where one is told.

    What goes from one end of its range to the other between two samples, by a period that
    counters and angles have, and otherwise moves in steps far smaller, has started again. Values
    that touch both ends and the steps' gap between small and large tell it from a drive that
    jumps: with the period subtracted, no such step may be larger than the ordinary ones.
    """
    known = np.asarray(values[np.isfinite(values)], dtype=np.float64)
    if known.size < _FEW:
        return None
    low, high = float(known.min()), float(known.max())
    steps = np.diff(known)
    size = np.abs(steps)
    if not high > low or not float(size.max()) > 0.5 * (high - low):
        return None
    whole = bool((known == np.round(known)).all())
    periods = [(2.0**bits, _bits(bits, signed=False)) for bits in _COUNTERS] if whole else []
    # Whole numbers of a turn are degrees or tenths; 0 and 1 are a flag.
    turns = [turn for turn in _TURNS.get(unit, ()) if not whole or turn > 99.0]
    periods += [(turn, Wrap(turn, False, f"{turn:.16g}")) for turn in turns]
    for period, wrap in periods:
        times = _starts_again(steps, size, period, low, high, whole)
        if not times:
            continue
        if whole and _two(period) and _sign_lost(known, period):
            wrap = _bits(round(math.log2(period)), signed=True)
        elif not _middle(known, period, low).mean() > _PASSED:  # a square wave leaps as far
            continue
        if math.isclose(period, math.tau) or unit == TURN:
            wrap = Wrap(math.nan, False, TURN)
        return WrapFound(wrap, times, low, high)
    return None


def _middle(known: FloatArray, period: float, low: float) -> BoolArray:
    first = 0.0 if low >= -1e-3 * period else -0.5 * period
    return (known > first + 0.25 * period) & (known < first + 0.75 * period)


def _starts_again(
    steps: FloatArray, size: FloatArray, period: float, low: float, high: float, whole: bool
) -> int:
    """How often a field starts again after `period`; 0 where it does not."""
    grain = 1.0 if whole else 1e-3 * period
    if high - low > period + grain or high - low < 0.5 * period:
        return 0
    if not any(
        low >= first - grain and high <= first + period + grain for first in (0.0, -period / 2)
    ):
        return 0
    long = size > 0.5 * period
    times = int(long.sum())
    ordinary = float(size[~long].max(initial=0.0))
    if not times or times > 0.2 * size.size or not 0.0 < ordinary <= _QUIET * period:
        return 0
    rest = np.abs(size[long] - period)
    # What is left of a step over the end is a step like those beside it, or a few grains; more only
    # where samples were lost.
    beside = maximum_filter1d(np.where(long, 0.0, size), 2 * _NEAR + 1)[long]
    if float(np.mean(rest <= 1.5 * beside + 2.0 * grain)) < 0.9:
        return 0
    return times if float(rest.max()) <= _QUIET * period else 0


def _two(period: float) -> bool:
    return math.log2(period).is_integer()


def _sign_lost(known: FloatArray, period: float) -> bool:
    """Whether values stand near 0 and near the period but not between: negative ones unsigned."""
    if known.min() < 0.0 or np.unique(known).size < _VALUES:
        return False
    upper = known > 0.75 * period
    return bool((upper | (known < 0.25 * period)).all()) and bool(upper.any())


def find_clock_wrap(values: NDArray[Any]) -> WrapFound | None:
    """How a column of instants starts again, such as a counter of milliseconds of 16 bits.

    Every step back has to be, but for one period, a step forward like the others.
    """
    known = np.asarray(values[np.isfinite(values)], dtype=np.float64)
    if known.size < _FEW:
        return None
    steps = np.diff(known)
    back = steps < 0.0
    ahead = steps[steps > 0.0]
    times = int(back.sum())
    if not times or not ahead.size or times > 0.1 * steps.size:
        return None
    usual = float(np.median(ahead))
    low, high = float(known.min()), float(known.max())
    for period in sorted(_CLOCKS):
        inside = (low >= 0.0 and high < period) or (low >= -period / 2 and high < period / 2)
        rest = steps[back] + period
        if inside and bool(((rest > 0.0) & (rest < 20.0 * usual)).all()):
            bits = math.log2(period)
            wrap = (
                _bits(round(bits), signed=False)
                if bits.is_integer()
                else Wrap(period, False, f"{period:g}")
            )
            return WrapFound(wrap, times, low, high)
    return None
