"""Where an effect upon a base may begin: what the recording suggests, where the sheet strains."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial

import numpy as np

from ...effects.catalogue import CATALOGUE
from ..fit.coordinate import PHASE, is_phase, later
from ..fit.fit import Fit, Fitter
from ..replay.evidence import gather
from ..side_by_side import side_by_side
from .promise import Promises
from .ringing import Ringing
from .strain import effect_of, strains

# The square of a normal variable by chance: 1 of 20 sound constants saves more than this.
_PULLED_OUT = 4.0
# Where a load rattles, only what is this small of a start answers in proportion.
_SMALL = 0.1
_HELPS = 0.5  # share of the cost below which a start counts as on the way


class Beginnings:
    """Starts of effects, replayed once each."""

    def __init__(self, fitter: Fitter, promises: Promises) -> None:
        self.fitter, self.promises = fitter, promises
        self._ringing = Ringing(fitter)

    def upon(self, base: Fit, names: Sequence[str], most: int) -> list[Fit]:
        """`base` with one more effect, at up to `most` starts that the recording suggests."""
        sheet = self.fitter.sheet
        evidence = gather(self.fitter.replay.at(sheet.constants(base.pulls)), base.values)
        jobs: list[tuple[str, dict[str, float], bool]] = []
        for name in names:
            if name in base.values:
                continue
            for rank, start in enumerate(CATALOGUE[name].starts(evidence)[:most]):
                if possible(name, start):
                    jobs.append((name, dict(start), rank == 0))
                    if rank == 0 and PHASE not in start:
                        small = CATALOGUE[name].scaled(start, _SMALL, self.fitter.replay.drive)
                        jobs.append((name, small, False))

        for name in names:
            if name not in base.values:
                jobs += [(name, values[name], False) for values in self._ringing.starts(base, name)]

        def begin(job: tuple[str, dict[str, float], bool]) -> Fit:
            name, start, first = job
            fit = self.fitter.evaluate({**base.values, name: start}, base.pulls)
            if PHASE in fit.values[name]:
                return self._in_phase(base, name, fit, all_round=first)
            return fit

        self.promises.upon(base)  # worked out before threads ask for it
        return self._out_of_sheet(base, names) + side_by_side(begin, jobs)

    def _out_of_sheet(self, base: Fit, names: Sequence[str]) -> list[Fit]:
        """`base` with the effect of a strained constant, where all go once that one is free."""
        sheet, drive = self.fitter.sheet, self.fitter.replay.drive
        found = []
        for one in strains(base, self.fitter):
            name = effect_of(one.row, self.fitter)
            if one.saved < _PULLED_OUT or name is None or name not in names or name in base.values:
                continue
            effect = CATALOGUE[name]
            away = sheet.at_nominal
            away[one.row] = one.pull
            off = float(sheet.values(away)[one.row] - sheet.nominal[one.row])
            value = {effect.parameters[0].name: effect.neutral(drive) + off}
            if possible(name, value):
                found.append(self.fitter.evaluate({**one.values, name: value}, one.pulls))
        return found

    def _in_phase(self, base: Fit, name: str, fit: Fit, *, all_round: bool) -> Fit:
        """A periodic effect with the size and phase that its response in quadrature suggests."""
        given = fit.values[name]
        size = CATALOGUE[name].parameters[0]
        shifted = later(given, 0.5 * math.pi)
        other = self.fitter.evaluate({**base.values, name: shifted}, base.pulls)
        upon = self.promises.upon(base)
        pair = np.column_stack([upon.response(one) for one in (fit, other)])
        sine, cosine = np.linalg.lstsq(pair, upon.free, rcond=None)[0]
        turned = later(given, math.atan2(cosine, sine))
        turned = {
            key: math.remainder(value, 2.0 * math.pi) if is_phase(key) else value
            for key, value in turned.items()
        }
        turned[size.name] = min(given[size.name] * math.hypot(sine, cosine), size.high)
        third = self.fitter.evaluate({**base.values, name: turned}, base.pulls)
        tried = [fit, other, third]
        # Less what the sheet could do as well: over a short way a line looks like a wrong lead.
        if all_round and min(upon.promise(one).score for one in tried) > _HELPS * base.fitted:
            # Not a linear matter (a load that rattles in its clearance): the phases all round.
            others = [
                {**base.values, name: later(given, 0.5 * math.pi * quarters)}
                for quarters in (0.5, 1.5, 2.0, 2.5, 3.0, 3.5)
            ]
            tried += side_by_side(partial(self.fitter.evaluate, pulls=base.pulls), others)
        return min(tried, key=lambda one: upon.promise(one).score)


def possible(name: str, start: object) -> bool:
    """Whether a start lies within what an effect's parameters may be."""
    values = dict(start)  # type: ignore[call-overload]
    for quantity in CATALOGUE[name].parameters:
        value = values.get(quantity.name, quantity.default)
        if value is None or not np.isfinite(value):
            return False
        if not quantity.low <= value <= quantity.high:
            return False
    return True
