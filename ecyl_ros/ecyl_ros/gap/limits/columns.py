"""What the sheet, found causes and further effects do to the compared signals, as columns.

Each is a difference of two replays about one base, in noise floors, on rows spread over the whole
recording: what a linear look needs, however many effects are asked for.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...arrays import BoolArray, FloatArray
from ...effects.catalogue import CATALOGUE
from ..fit.coordinate import Coordinate, is_phase, quantities
from ..fit.fit import Fit, Fitter
from ..sheet import PULL_PRICE
from ..side_by_side import side_by_side
from .probes import Probe, Values, rows_of

_ROWS = 3000  # of each signal at the most: more say no more of a ratio
_PULL = 0.5  # tolerances: as far as a healthy machine's constant usually lies off
_STEP = 0.05  # of a found parameter, in its coordinate


@dataclass(frozen=True, eq=False)
class Base:
    """About what point responses are taken.

    Attributes:
        fitter: of the recording. fit: the model so far. rows: int[n] of the signals.
        free: float64[k, m], what the model can still do, by unit of each coordinate; m: all signals
            at `rows`, one after the other. precision: float64[k], of the price of its square.
        pulled: rows of the sheet among these, -1 for parameters of causes.
    """

    fitter: Fitter
    fit: Fit
    rows: NDArray[np.int64]
    free: FloatArray
    precision: FloatArray
    pulled: tuple[int, ...]

    @classmethod
    def of(cls, fitter: Fitter, fit: Fit, most: int | None = None) -> Base:
        """About a fit; most: rows of each signal."""
        sheet = fitter.sheet
        rows = rows_of(fitter.replay, most or _ROWS)
        pulled = np.flatnonzero(sheet.free(fit.values)).tolist()
        jobs: list[tuple[dict[str, Values], FloatArray, float]] = []
        for row in pulled:
            pulls = fit.pulls.copy()
            step = -_PULL if pulls[row] > 0.0 else _PULL
            pulls[row] += step
            jobs.append((fit.values, pulls, step))
        causes = [
            Coordinate.around(name, one, fit.values[name][one.name])
            for name in fit.values
            for one in quantities(name, fit.values[name])
            if not one.nuisance or is_phase(one.name)
        ]
        for cause in causes:
            values = {name: dict(given) for name, given in fit.values.items()}
            old = values[cause.effect][cause.quantity.name]
            step = _STEP * cause.fineness
            new = min(
                max(cause.outward(cause.of(old) + step), cause.quantity.low), cause.quantity.high
            )
            values[cause.effect][cause.quantity.name] = new
            jobs.append((values, fit.pulls, step))
        before = fit.gap[:, rows]

        def column(job: tuple[dict[str, Values], FloatArray, float]) -> FloatArray:
            values, pulls, step = job
            gap = fitter.replay.gap(values, sheet.constants(pulls))
            made: FloatArray = ((before - gap[:, rows]) / step).ravel()
            return made

        free = np.array(side_by_side(column, jobs)).reshape(len(jobs), before.size)
        precision = np.array([PULL_PRICE] * len(pulled) + [0.0] * len(causes))
        return cls(fitter, fit, rows, free, precision, (*pulled, *[-1] * len(causes)))

    @property
    def held(self) -> BoolArray:
        """bool[m], which of the rows no parameter is fitted to."""
        return np.tile(self.fitter.held[self.rows], self.signals)

    @property
    def signals(self) -> int:
        """How many are compared."""
        return len(self.fit.gap)

    def own(self, probe: Probe, size: float) -> tuple[int, float] | None:
        """Coordinate that gives a constant what an effect of this size gives it, and how far.

        None where the sheet has no such constant.
        """
        row = self.fitter.sheet.index(CATALOGUE[probe.effect].constant)
        if row is None or row not in self.pulled:
            return None
        drive = self.fitter.replay.nominal
        pulls = self.fitter.sheet.pulled_to(probe.effect, probe.made(size), drive)
        return (self.pulled.index(row), float(pulls[row])) if pulls[row] else None

    def response(self, probe: Probe, size: float) -> FloatArray:
        """What an effect of this size does to the signals: float64[1 or 2, m], in floors."""
        made = [probe.made(size), *([probe.turned(size)] if probe.turned is not None else [])]
        return self.response_to(probe.effect, made, probe.made(0.0))

    def response_to(
        self, effect: str, forms: Iterable[Mapping[str, float]], neutral: Values | None = None
    ) -> FloatArray:
        """The same of an effect in each of its forms: float64[forms, m].

        neutral: its parameters where it vanishes, of one that takes the place of a constant, which
        the fit may have moved.
        """
        row = self.fitter.sheet.index(CATALOGUE[effect].constant)
        without = self.fit.gap[:, self.rows]
        if neutral is not None and row is not None and self.fit.pulls[row] != 0.0:
            without = self._gap({effect: neutral})
        return np.array([(without - self._gap({effect: one})).ravel() for one in forms])

    def _gap(self, more: Mapping[str, Mapping[str, float]]) -> FloatArray:
        constants = self.fitter.sheet.constants(self.fit.pulls)
        gap = self.fitter.replay.gap({**self.fit.values, **more}, constants)
        found: FloatArray = gap[:, self.rows]
        return found
