"""Loops that swing by themselves: told by the spectrum, for no waveform shows the way.

A delay that brings the loop to the edge of stability makes it ring. A replay with another delay
rings, too, but at another frequency, and after some periods nothing is left of the likeness: in the
waveform the true delay is a valley some thousandths wide on a plain. The spectrum knows no phase:
it leads into the neighbourhood, where a dense row of replays finds the valley.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy.signal import welch

from ...arrays import FloatArray
from ...effects.catalogue import CATALOGUE
from ..fit.fit import Fit, Fitter, Values
from ..replay.replay import Replay
from ..side_by_side import side_by_side

_SIGNALS = ("rotor_velocity", "current_q", "voltage_q", "rotor_position", "rod_position")
_WINDOW_S = 0.25
_LOWEST_HZ = 20.0  # slower lines are those of the motion
_LOUD = 4.0  # mean square of the gap above it, in floors, from which it is worth listening to
_ALIKE = 0.7  # share of the nominal spectrum's unlikeness that a ringing replay leaves at the most
# Delays to begin with, in control ticks; a loop begins to swing within a tenth of one.
_GRID = np.concatenate([np.arange(0.3, 6.0, 0.1), np.geomspace(6.0, 24.0, 16)])
_HELPS = 0.9  # of the cost of the base that is left at the most
_HOLLOWS = 3  # that are looked at more finely
_FINER = 9
_ROW = np.linspace(-0.02, 0.02, 41)  # around the best of them
_CLOSE = np.linspace(-8e-4, 8e-4, 9)

_ENOUGH = 0.25  # share of the power of what is to be heard that is listened to
_SHORTEST_S = 2.0


class Ringing:
    """Looks for the delay with which the replay rings as the recording does."""

    def __init__(self, fitter: Fitter) -> None:
        self._fitter = fitter
        replay = fitter.replay
        names = [one.name for one in replay.signals]
        self._row = next(names.index(name) for name in _SIGNALS if name in names)
        self._heard: dict[str, bool] = {}
        self._rung: tuple[Fit, FloatArray] | None = None  # unlikeness over the grid, of a base

    def _spectrum(self, values: FloatArray) -> FloatArray:
        rate = self._fitter.replay.recording.rate_hz
        points = min(len(values), round(_WINDOW_S * rate))
        frequency, power = welch(np.nan_to_num(values), rate, nperseg=points)
        kept: FloatArray = power[frequency >= _LOWEST_HZ]
        return kept

    @cached_property
    def _part(self) -> Replay:
        """The recording up to where enough has been heard: a spectrum needs no more of it."""
        replay = self._fitter.replay
        power = np.cumsum(np.diff(self._fitter.nominal.gap[self._row]) ** 2)
        enough = float(replay.time_s[1 + int(np.searchsorted(power, _ENOUGH * power[-1]))])
        return replay.until(max(enough, _SHORTEST_S))

    @cached_property
    def _recorded(self) -> FloatArray:
        part = self._part
        return self._spectrum(part.recorded[self._row] / part.floor[self._row])

    def _unlike(self, gap: FloatArray) -> float:
        """Mean square of the spectra's ratio, in decades; a floor's power is added to both.

        gap: of `_part`, float64[signals, m].
        """
        part = self._part
        power = self._spectrum(part.recorded[self._row] / part.floor[self._row] - gap[self._row])
        noise = 2.0 / part.recording.rate_hz
        return float(np.mean(np.log10((self._recorded + noise) / (power + noise)) ** 2))

    @cached_property
    def _loud(self) -> bool:
        """Whether the nominal gap holds more than noise above the motion's frequencies."""
        gap = self._spectrum(self._fitter.nominal.gap[self._row])
        rate = self._fitter.replay.recording.rate_hz
        return gap.size > 1 and float(gap.mean()) * rate / 2.0 > _LOUD

    def starts(self, base: Fit, name: str) -> list[Values]:
        """`base` with a delay `name` that rings as recorded; nothing where none does.

        The first call says for the effect whether it is worth while on other bases, too.
        """
        if CATALOGUE[name].block != "timing" or not self._loud or not self._heard.get(name, True):
            return []
        (quantity,) = CATALOGUE[name].parameters
        constants = self._fitter.sheet.constants(base.pulls)

        def with_delay(delay: float) -> Values:
            return {**base.values, name: {quantity.name: float(delay)}}

        def heard(delay: float) -> float:
            return self._unlike(self._part.gap(with_delay(delay), constants))

        def tried(delay: float) -> Fit:
            return self._fitter.evaluate(with_delay(delay), base.pulls)

        first = name not in self._heard
        grid = _GRID / self._fitter.replay.drive.controller.rate
        if self._rung is None or self._rung[0] is not base:
            self._rung = base, np.array(side_by_side(heard, grid.tolist()))
        unlike = self._rung[1]  # the loop swings alike, wherever on its way round it is late
        if first:
            nominal = self._unlike(self._part.gap({}))
            self._heard[name] = float(unlike.min()) < _ALIKE * nominal
        if not self._heard[name]:
            return []
        around = np.pad(unlike, 1, constant_values=np.inf)
        hollows = np.flatnonzero((unlike <= around[:-2]) & (unlike <= around[2:]))
        hollows = hollows[np.argsort(unlike[hollows])][:_HOLLOWS]
        finer: list[float] = []
        for best in hollows.tolist():
            low, high = grid[max(best - 1, 0)], grid[min(best + 1, len(grid) - 1)]
            finer += np.linspace(low, high, _FINER).tolist()
        centre = finer[int(np.argmin(side_by_side(heard, finer)))]
        for offsets in (_ROW, _CLOSE):
            row = side_by_side(tried, (centre * (1.0 + offsets)).tolist())
            found = min(row, key=lambda one: one.fitted)
            centre = found.values[name][quantity.name]
        if first:  # a likeness that takes nothing off is not worth a look beside other effects
            self._heard[name] = found.fitted < _HELPS * base.fitted
        return [found.values]
