"""Loops that swing by themselves: told by the spectrum, for no waveform shows the way.

A delay that brings the loop to the edge of stability makes it ring. A replay with another delay
rings, too, but at another frequency, and after some periods nothing is left of the likeness: in the
waveform the true delay is a valley some thousandths wide on a plain. The spectrum knows no phase:
it leads into the neighbourhood, where a dense row of replays finds the valley.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cached_property

import numpy as np
from scipy.signal import welch

from ..effects.catalogue import CATALOGUE
from .fit import Fit, Fitter, Values
from .replay import FloatArray

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

Map = Callable[[Callable[[float], Fit], Iterable[float]], list[Fit]]


class Ringing:
    """Looks for the delay with which the replay rings as the recording does."""

    def __init__(self, fitter: Fitter, side_by_side: Map) -> None:
        self._fitter = fitter
        self._map = side_by_side
        replay = fitter.replay
        names = [one.name for one in replay.signals]
        self._row = next(names.index(name) for name in _SIGNALS if name in names)
        self._heard: dict[str, bool] = {}

    def _spectrum(self, values: FloatArray) -> FloatArray:
        rate = self._fitter.replay.recording.rate_hz
        points = min(len(values), round(_WINDOW_S * rate))
        frequency, power = welch(np.nan_to_num(values), rate, nperseg=points)
        kept: FloatArray = power[frequency >= _LOWEST_HZ]
        return kept

    @cached_property
    def _recorded(self) -> FloatArray:
        replay = self._fitter.replay
        return self._spectrum(replay.recorded[self._row] / replay.floor[self._row])

    def _unlike(self, fit: Fit) -> float:
        """Mean square of the spectra's ratio, in decades; a floor's power is added to both."""
        replay = self._fitter.replay
        power = self._spectrum(
            replay.recorded[self._row] / replay.floor[self._row] - fit.gap[self._row]
        )
        noise = 2.0 / replay.recording.rate_hz
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
        tick = 1.0 / self._fitter.replay.drive.controller.rate
        (quantity,) = CATALOGUE[name].parameters

        def tried(delay: float) -> Fit:
            values = {**base.values, name: {quantity.name: float(delay)}}
            return self._fitter.evaluate(values, base.pulls)

        grid = _GRID * tick
        unlike = np.array([self._unlike(one) for one in self._map(tried, grid)])
        first = name not in self._heard
        if first:
            nominal = self._unlike(self._fitter.nominal)
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
        centre = finer[int(np.argmin([self._unlike(one) for one in self._map(tried, finer)]))]
        for offsets in (_ROW, _CLOSE):
            row = self._map(tried, centre * (1.0 + offsets))
            found = min(row, key=lambda one: one.fitted)
            centre = found.values[name][quantity.name]
        if first:  # a likeness that takes nothing off is not worth a look beside other effects
            self._heard[name] = found.fitted < _HELPS * base.fitted
        return [found.values]
