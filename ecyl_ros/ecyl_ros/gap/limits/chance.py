"""How likely a fault of a size is seen: the competition's own tests, on drawn healthy machines.

A recording shows a fault where neither noise nor the sheet accounts for it: the nominal model does
not stand at the floor, and no constants within their tolerances bring it there (`verdict.at_floor`,
`earn.at_noise`). Both are worked out in the linear look of `columns` for machines whose other
constants are drawn from the sheet: what a fit of the sheet would leave, raised by the price of its
pulls, and how far it would strain a constant.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...arrays import BoolArray, FloatArray
from ...effects.catalogue import CATALOGUE
from ..compete.earn import AT_FLOOR, LEAST, WORTH
from ..compete.strain import STRAINED, UNSEEN, effect_of, price_beyond
from ..inverse import inverse_of
from ..replay.hidden import NO_GAP_RATIO
from ..sheet import PULL_PRICE
from .columns import Base
from .loss import weights

DRAWS = 100  # machines: of these, five are not seen at the size that is seen with 95 %
CHANCE = 0.95
_ROUNDS = 4  # of the fit of a drawn machine's sheet
_BISECTIONS = 11
_REACH = 3.0  # decades that a size is looked for in, both ways
_SEED = 14


@dataclass(frozen=True, eq=False)
class Machines:
    """Drawn machines about a base.

    Attributes:
        pulls: float64[draws, k], true ones of the sheet; 0 for causes. phases: float64[draws].
        level: mean square of what the model leaves, by noise or by what is not explained. floor: of
        a perfect one. evidence: see `sheet`. shaken: mean square of each signal's noise.
        tested: bool[k], coordinates that may be found strained. relative: float64[k], tolerances of
        constants as shares of their nominal values.
    """

    base: Base
    pulls: FloatArray
    phases: FloatArray
    level: float
    floor: float
    evidence: float
    shaken: FloatArray
    tested: BoolArray
    relative: FloatArray

    @classmethod
    def drawn(cls, base: Base, draws: int = DRAWS) -> Machines:
        """The same machines for the same sheet."""
        fitter = base.fitter
        rng = np.random.default_rng(_SEED)
        pulls = 0.5 * rng.standard_normal((draws, len(base.precision)))
        pulls[:, base.precision == 0.0] = 0.0
        perfect = fitter.perfect_with(base.fit.values) ** 2
        healthy = fitter.replay.healthy[:, base.rows]
        tested = [row >= 0 and effect_of(row, fitter) is not None for row in base.pulled]
        return cls(
            base,
            pulls,
            rng.uniform(0.0, 2.0 * math.pi, draws),
            base.fit.left,
            perfect,
            fitter.sheet.evidence,
            np.maximum(np.mean(healthy**2, axis=1), 1.0),
            np.array(tested, dtype=bool),
            np.array([fitter.sheet.relative[row] if row >= 0 else 0.0 for row in base.pulled]),
        )

    def without(self, effect: str) -> Machines:
        """The same, the constant that an effect gives its own value not off besides."""
        one = CATALOGUE[effect]
        row = self.base.fitter.sheet.index(one.constant)
        if row is None or one.on_top or row not in self.base.pulled:
            return self
        pulls = self.pulls.copy()
        pulls[:, self.base.pulled.index(row)] = 0.0
        return Machines(**{**self.__dict__, "pulls": pulls})


@dataclass(frozen=True, eq=False)
class _Part:
    """Inner products of the sheet and a response on some of the rows.

    gram: float64[k, k], the sheet first. Along `axes` of the sheet a fit moves in each as if it
    were alone, by `values`; along, own: of the response with these, and with itself.
    """

    gram: FloatArray
    values: FloatArray
    axes: FloatArray
    along: FloatArray
    own: FloatArray

    @classmethod
    def of(cls, rows: FloatArray, weight: FloatArray, kept: Sequence[bool], response: int) -> _Part:
        gram = without_free((rows * weight) @ rows.T / max(rows.shape[1], 1), kept)
        size = len(gram) - response
        values, axes = np.linalg.eigh(gram[:size, :size])
        return cls(
            gram, np.maximum(values, 0.0), axes, axes.T @ gram[:size, size:], gram[size:, size:]
        )


class Visible:
    """Whether a response of float64[1 or 2, m] is seen, at multiples of its size."""

    def __init__(
        self, machines: Machines, response: FloatArray, own: tuple[int, float] | None = None
    ) -> None:
        """own: see `Base.own`; a fit of that constant goes the way of the effect, far as it is."""
        base = machines.base
        self.machines = machines
        free = base.free
        if own is not None:
            free = free.copy()
            free[own[0]] = response[0] / own[1]
        price = base.precision
        rows = np.concatenate([free, response])
        weight = weights(np.sqrt(np.mean(response**2, axis=0)))
        kept = [*(price > 0.0), *[True] * len(response)]
        held = base.held
        self._fitted, self._held = (
            _Part.of(rows[:, part], weight[part], kept, len(response))
            for part in (~held, held if held.any() else ~held)
        )
        priced = np.flatnonzero(price > 0.0)
        self._pulls = machines.pulls[:, priced]
        self._tested, self._relative = machines.tested[priced], machines.relative[priced]
        parts = rows.reshape(len(rows), base.signals, -1).swapaxes(0, 1)
        self._by_signal = parts @ parts.swapaxes(1, 2) / parts.shape[2]
        self._shares = _directions(machines.phases, len(response))
        sound, _ = self._sheet_alone(0.0)
        self._needed = [
            np.maximum(AT_FLOOR**2 * machines.floor * first, one + _worth(one, machines.floor))
            for one, first in zip(sound, (0.0, 1.0), strict=True)
        ]

    def chance(self, size: float) -> float:
        """Share of the machines on which it is seen at `size` times itself."""
        before, strained = self._sheet_alone(size)
        more = np.ones(len(strained), dtype=bool)
        for one, needed in zip(before, self._needed, strict=True):
            more &= one > needed
        return float(np.mean((strained | more) & self._gap(size)))

    def smallest(self) -> float:
        """Multiple of the response from which 95 % see it; inf where none does."""
        low, high = -_REACH, _REACH
        if self.chance(10.0**high) < CHANCE:
            return math.inf
        for _ in range(_BISECTIONS):
            middle = 0.5 * (low + high)
            low, high = (low, middle) if self.chance(10.0**middle) >= CHANCE else (middle, high)
        return 10.0**high

    def _sheet_alone(self, size: float) -> tuple[tuple[FloatArray, FloatArray], BoolArray]:
        """Of the sheet fitted: mean squares with its price, and whether a constant is strained.

        Mean squares are on the rows that are fitted, and on those that are held out.
        """
        machines, fitted = self.machines, self._fitted
        values, axes = fitted.values, fitted.axes
        shares = size * self._shares
        alone = np.einsum("di,ij,dj->d", shares, fitted.own, shares)
        pushed = shares @ fitted.along.T  # [draws, axes]
        drawn = self._pulls @ axes
        cost = machines.level + alone
        left = np.zeros_like(drawn)
        for _ in range(_ROUNDS if len(values) else 0):
            # What is left of a pull after the fit: its price against what it does to the signals.
            scale = (machines.evidence / cost)[:, None]
            left = (PULL_PRICE * drawn - scale * pushed) / (scale * values + PULL_PRICE)
            moved = alone + np.sum(left * (2.0 * pushed + values * left), axis=1)
            cost = machines.level + np.maximum(moved, 0.0)
        off = left @ axes.T
        pulls = self._pulls - off
        dearer = np.exp(
            np.minimum(PULL_PRICE * np.sum(pulls**2, axis=1) / machines.evidence, 100.0)
        )
        scale = (machines.evidence / cost)[:, None]
        seen = 1.0 - PULL_PRICE / (scale * values + PULL_PRICE) @ (axes**2).T
        saved = price_beyond(pulls / np.maximum(seen, UNSEEN), seen, self._relative)
        strained = np.any((saved > STRAINED) & (seen > UNSEEN) & self._tested, axis=1)
        point = np.concatenate([off, shares], axis=1)
        judged = np.sum(point @ self._held.gram * point, axis=1)
        judged = machines.level + np.maximum(judged, 0.0)
        return (cost * dearer, judged * dearer), strained

    def _gap(self, size: float) -> BoolArray:
        """Whether the nominal model is off its floor in any signal, bool[draws]."""
        point = np.concatenate([self.machines.pulls, size * self._shares], axis=1)
        square = np.sum(point @ self._by_signal * point, axis=2).T
        shaken = self.machines.shaken
        allowed = np.where(shaken > 1.21, 1.69 * shaken, shaken) * NO_GAP_RATIO**2
        found: BoolArray = np.any(shaken + square > allowed, axis=1)
        return found


def without_free(gram: FloatArray, kept: Sequence[bool]) -> FloatArray:
    """Inner products of what is kept, less what the others, free to take any size, account for."""
    inside = np.array(kept, dtype=bool)
    if inside.all():
        return gram
    out = gram[np.ix_(~inside, ~inside)]
    across = gram[np.ix_(inside, ~inside)]
    taken = across @ inverse_of(out) @ across.T
    found: FloatArray = gram[np.ix_(inside, inside)] - taken
    return found


def _directions(phases: FloatArray, rows: int) -> FloatArray:
    """Share of each row of a response on each machine, float64[draws, rows]."""
    if rows == 1:
        return np.ones((len(phases), 1))
    return np.column_stack([np.cos(phases), np.sin(phases)])


def _worth(after: FloatArray, floor: float) -> FloatArray:
    """By how much a model without the effect has to be worse for it to earn its place."""
    surplus = after - np.minimum(0.95 * floor, after)
    return np.maximum(LEAST, surplus * (1.0 / WORTH - 1.0))
