"""Fits of effects' parameters to a recording, by replaying it in closed loop.

Beside the parameters of the effects the constants of the data sheet are fitted, each at the price
of leaving it (`sheet`): what a candidate has to beat is the sheet, not its nominal point.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgError, cho_factor, cho_solve
from scipy.ndimage import uniform_filter1d
from scipy.optimize import minimize_scalar

from ..effects.catalogue import CATALOGUE
from ..effects.effect import Quantity
from .replay import BoolArray, FloatArray, Replay
from .sheet import Sheet
from .stages import COARSE, EXACT, FINE, MEDIUM, Stage

Values = dict[str, dict[str, float]]  # {effect: {parameter: value}}


Map = Callable[[Callable[[int], FloatArray], Iterable[int]], Iterable[FloatArray]]

LOSS_SCALE = 3.0  # in noise floors: beyond it a difference counts less than its square
_SHAPES = (0.25, 0.5, 2.0, 4.0)  # times a shape parameter at the start of its fit
_MATTERS = 0.1  # share of the cost that a shape must move to be looked at closely
_BRACKET = 0.8  # half width of a search along one parameter, in the fit's coordinates
_NARROW = 0.03  # the same around what it found: the valley of a limit is a thousandth wide
_SWEEPS = 2  # along size and phase of a periodic effect
_NOISIEST = 4.0  # times a perfect model's misfit: no effect excuses more
_AMPLIFIED = 1.2  # times a perfect model's misfit: from here on noise counts as amplified
_NEAR_FLOOR = 1.3  # times a perfect model's cost: no closer look needed
_ALONE = 2  # times the derivatives of a fit that has no constants beside it: they cost less
_PRICE_MATTERS = 3.0  # times a perfect model's cost
_REACH = 60.0  # a fit may change a positive parameter by this factor either way
_CONVERGED, _ON_THE_WAY = 0.02, 2.0  # falls of the objective below which a fit, a search has ended
# Levenberg's damping, tried in turn until a step leaves less; steps that come near need none.
_DAMPING = (0.0, 1e-2, 0.1, 1.0, 10.0)
_GOOD_STEP = 0.25  # share of the promised fall from which the next damping is not tried


def cost(gap: FloatArray, rows: BoolArray) -> float:
    """Robust mean square of a gap (signals, n) over its noise floor on the rows chosen.

    Cauchy's: c^2 log(1 + (z / c)^2) in place of z^2. An impact of the flanks that comes a sample
    early is a spike in speed and voltage, with its mirror image a sample later; squared, such
    spikes hide how near a fit is and cut its valley into pieces. 0.85 for a perfect model.
    """
    return robust_mean_square(gap[:, rows])


def robust_mean_square(values: FloatArray) -> float:
    """Cauchy's mean square of differences in noise floors, see `cost`."""
    return float(np.mean(robust_squares(values)))


def robust_squares(values: FloatArray) -> FloatArray:
    """Cauchy's square of each difference in noise floors, see `cost`."""
    squares: FloatArray = LOSS_SCALE**2 * np.log1p((values / LOSS_SCALE) ** 2)
    return squares


@dataclass(frozen=True)
class Coordinate:
    """One fitted parameter: in logarithms where it cannot change sign, else over a scale."""

    effect: str
    quantity: Quantity
    logarithmic: bool
    scale: float
    low: float
    high: float

    @classmethod
    def around(cls, effect: str, quantity: Quantity, value: float) -> Coordinate:
        """The coordinate for a fit that starts at `value`."""
        if quantity.low >= 0.0 and value > 0.0:
            low = math.log(max(quantity.low, value / _REACH, 1e-300))
            high = math.log(min(quantity.high, value * _REACH))
            return cls(effect, quantity, True, 1.0, low, high)
        scale = 1.0 if quantity.unit == "rad" else max(abs(value), 1e-9)
        return cls(effect, quantity, False, scale, quantity.low / scale, quantity.high / scale)

    @property
    def fineness(self) -> float:
        """Share of the common difference that suits this parameter.

        Over many periods a small change of order or frequency is a large change of phase.
        """
        counted = self.quantity.unit in ("1", "Hz") and not self.quantity.nuisance
        return 0.02 if counted and self.logarithmic else 1.0

    def of(self, value: float) -> float:
        """Coordinate of a value."""
        return math.log(max(value, 1e-300)) if self.logarithmic else value / self.scale

    def inward(self, value: float) -> float:
        """Coordinate of a value, kept a little off the bounds."""
        raw = self.of(value)
        margin = 1e-6 * max(1.0, min(abs(self.low), abs(self.high)))
        return min(max(raw, self.low + margin), self.high - margin)

    def outward(self, coordinate: float) -> float:
        """Value of a coordinate."""
        if self.logarithmic:
            return math.exp(coordinate)
        return coordinate * self.scale


@dataclass(frozen=True, eq=False)
class Fit:
    """Effects with fitted parameters, and the sheet beside them.

    Attributes:
        values: {effect: {parameter: value}}.
        pulls: float64[k], of the sheet's constants; 0 where an effect stands for the constant.
        gap: float64[signals, n], what is left over the noise floor.
        fitted, judged: `cost` on the fitted and on the held-out stretches, raised by the price of
            the pulls.
        left: `cost` on the held-out stretches alone.
        coordinates: the fitted parameters; `pulled`: the constants fitted beside them, rows of the
            sheet; `jacobian` float64[signals x fitted rows, k] of the gap by both at the end of the
            fit (None for values not fitted).
        slopes: {stage: float64[signals x fitted rows, pulled]}, derivatives by the sheet that were
            worked out on the way, as each stage sees them.
        ended: whether the fit went as far as it goes.
        replays: how many runs it took.
    """

    values: Values
    pulls: FloatArray
    gap: FloatArray
    fitted: float
    judged: float
    left: float
    coordinates: tuple[Coordinate, ...] = ()
    pulled: tuple[int, ...] = ()
    jacobian: FloatArray | None = None
    slopes: Mapping[Stage, FloatArray] = field(default_factory=dict)
    ended: bool = False
    replays: int = field(default=1)

    @property
    def names(self) -> tuple[str, ...]:
        """The effects, in the order they were given."""
        return tuple(self.values)

    @property
    def bounds_hit(self) -> tuple[str, ...]:
        """Parameters that stand at a bound of the fit, as effect.parameter."""
        found = []
        for one in self.coordinates:
            value = self.values[one.effect][one.quantity.name]
            at = one.inward(value)
            slack = 1e-4 * max(1.0, one.high - one.low)
            if not one.quantity.nuisance and (at - one.low < slack or one.high - at < slack):
                found.append(f"{one.effect}.{one.quantity.name}")
        return tuple(found)


class Fitter:
    """Evaluates and fits sets of effects on one replay.

    Attributes:
        replay: of the recording. sheet: of its drive. held, rows: bool[n], stretches that are
            judged and those that are fitted. perfect: robust misfit of a perfect model.
    """

    def __init__(self, replay: Replay, held: BoolArray) -> None:
        self.replay = replay
        self.sheet = Sheet.of(replay.nominal, float(replay.time_s[-1]))
        self.held = held & replay.usable
        self.rows = ~held & replay.usable
        # With constants beside the effects, a stage but the last only leads on to the next.
        self._least = _ON_THE_WAY if len(self.sheet) else _CONVERGED
        # Robust misfit of a perfect model: 0.92 for white noise at the floor.
        self.perfect = math.sqrt(max(cost(replay.healthy, replay.usable), 0.85))

    @cached_property
    def nominal(self) -> Fit:
        """The model without effects, its constants as the sheet has them."""
        return self.evaluate({})

    def perfect_with(self, values: Values) -> float:
        """Robust misfit that a perfect model leaves with these effects, no less than without.

        Some let noise through that the nominal drive keeps small: a load that sticks creeps as the
        noise shakes it, a delay at the edge of stability rings.
        """
        if not values or not self.replay.noise_in_loop:
            return self.perfect
        left = cost(self.replay.healthy_with(values), self.replay.usable)
        most = _NOISIEST * self.perfect
        return min(max(self.perfect, math.sqrt(left)), most) if math.isfinite(left) else most

    def noise_with(self, values: Values) -> FloatArray:
        """RMS of what noise alone leaves of each signal on the held-out stretches, in floors.

        float64[signals]: 1, but where it is clearly more on its way round the loop.
        """
        if self.perfect_with(values) <= _AMPLIFIED * self.perfect:
            return np.ones(len(self.replay.signals))
        healthy = self.replay.healthy_with(values)[:, self.held]
        rms: FloatArray = np.maximum(1.0, np.sqrt(np.mean(healthy**2, axis=1)))
        return np.minimum(rms, _NOISIEST)

    def evaluate(
        self, values: Mapping[str, Mapping[str, float]], pulls: FloatArray | None = None
    ) -> Fit:
        """What is left with given parameters, and constants pulled off their nominal values."""
        full = {name: CATALOGUE[name].complete(given) for name, given in values.items()}
        pulls = self.sheet.at_nominal if pulls is None else pulls
        pulls = np.where(self.sheet.free(full), pulls, 0.0)
        gap = self.replay.gap(full, self.sheet.constants(pulls))
        left = cost(gap, self.held)
        return Fit(
            full,
            pulls,
            gap,
            self.sheet.priced(cost(gap, self.rows), pulls),
            self.sheet.priced(left, pulls),
            left,
        )

    def without(self, fit: Fit, effects: Collection[str]) -> Fit:
        """What a fit leaves without some of its effects, the others as they are.

        A constant that no effect stands for any more goes on from where it was.
        """
        pulls = fit.pulls
        for name in fit.names:
            if name in effects:
                pulls = pulls + self.sheet.pulled_to(name, fit.values[name], self.replay.nominal)
        rest = {name: given for name, given in fit.values.items() if name not in effects}
        return self.evaluate(rest, pulls)

    def search(self, start: Fit, known: Fit | None = None) -> Fit:
        """Fit from afar, without the parameters that only shape an effect.

        known: a fit whose derivatives by the sheet are near enough to be used.

        One parameter: golden sections and parabolas along its valley, which no spike can mislead.
        Several: the same along each effect that has but one, and along size and phase of those
        that have a phase, then least squares of all, with coarse derivatives first and finer ones
        after.
        """
        coordinates = self._coordinates(start, nuisances=False)
        if len(coordinates) == 1:
            return self._search_one(start, coordinates[0], known)
        replays, best = 0, start
        # One parameter at a time first, the latest addition to a set before the others.
        for name in reversed(start.names):
            own = [one for one in coordinates if one.effect == name]
            periodic = any(one.quantity.name == "phase_rad" for one in own)
            for one in _SWEEPS * [own[0], own[-1]] if periodic else own[: len(own) == 1]:
                if best.fitted > _NEAR_FLOOR * self.perfect**2:
                    best = self._search_along(best, one, closely=not periodic)
                    replays += best.replays
        turned = self._turn(best)
        found = self.fit(turned, steps=6, stage=COARSE, known=known, least=self._least)
        again = self._turn(found)
        finer = self.fit(again, steps=4, stage=MEDIUM, known=known, least=self._least)
        replays += turned.replays + found.replays + again.replays + finer.replays
        return dataclasses.replace(finer, replays=replays)

    def _search_one(self, start: Fit, one: Coordinate, known: Fit | None) -> Fit:
        """Along the valley of a single parameter, and then with the sheet beside it, in turn."""
        best = self._search_along(start, one)
        replays = best.replays
        if not self.sheet.free(start.values).any():
            return best
        for stage in (COARSE, MEDIUM):
            best = self.fit(best, steps=5, stage=stage, known=known, least=self._least)
            replays += best.replays
        if best.fitted > _NEAR_FLOOR * self.perfect**2:
            again = self._search_along(best, one)
            best = self.fit(again, steps=4, stage=MEDIUM, known=known, least=self._least)
            replays += again.replays + best.replays
        return dataclasses.replace(best, replays=replays)

    def polish(self, start: Fit, steps: int) -> Fit:
        """Fit to the end, with the parameters that only shape an effect.

        steps: derivatives at the most in each stage.
        """
        shaped = self._shape(start)
        replays, best = shaped.replays, shaped
        free = bool(self.sheet.free(start.values).any())
        far = free and shaped.fitted > _NEAR_FLOOR * self.perfect**2
        steps = steps if free else _ALONE * steps
        for stage in (COARSE, MEDIUM, FINE) if far else (MEDIUM, FINE):
            best = self.fit(best, steps=steps, nuisances=True, stage=stage, least=self._least)
            replays += best.replays
        # Far from the floor the price of the sheet decides nothing.
        if free and best.fitted < _PRICE_MATTERS * self.perfect**2:
            best = self.fit(best, steps=steps, nuisances=True, stage=EXACT)
            replays += best.replays
        return dataclasses.replace(best, replays=replays)

    def alone(self, steps: int, side_by_side: Map) -> Fit:
        """The sheet alone: the nominal model with its constants fitted, from coarse to fine."""
        best = self.nominal
        slopes: dict[Stage, FloatArray] = {}
        for stage in (COARSE, MEDIUM, FINE, EXACT):
            best = self.fit(best, steps=steps, stage=stage, side_by_side=side_by_side)
            slopes |= best.slopes
        return dataclasses.replace(best, slopes=slopes) if slopes else best

    def _shape(self, start: Fit) -> Fit:
        """Better values of the parameters that only shape an effect (no phase).

        The best of several; where that matters and something is left, the bottom of its valley.
        """
        best, replays = start, 0
        for name in start.values:
            for one in CATALOGUE[name].parameters:
                if not one.nuisance or one.name == "phase_rad":
                    continue
                middle = best.values[name][one.name]
                costs = [best.fitted]
                for factor in _SHAPES:
                    value = min(max(middle * factor, one.low), one.high)
                    values = {**best.values, name: {**best.values[name], one.name: value}}
                    tried = self.evaluate(values, best.pulls)
                    costs.append(tried.fitted)
                    if tried.fitted < best.fitted:
                        best = tried
                replays += len(_SHAPES)
                matters = max(costs) - min(costs) > _MATTERS * min(costs)
                if matters and best.fitted > _NEAR_FLOOR * self.perfect**2:
                    value = best.values[name][one.name]
                    best = self._search_along(best, Coordinate.around(name, one, value))
                    replays += best.replays
        return dataclasses.replace(best, replays=replays)

    def _turn(self, start: Fit) -> Fit:
        """Other frequencies with the phase in the middle of the recording held.

        Frequency and phase make a narrow valley that runs across the axes of the fit.
        """
        best, replays = start, 0
        time = self.replay.time_s
        for name, given in start.values.items():
            periodic = [one.name for one in CATALOGUE[name].parameters if one.unit == "Hz"]
            for frequency in periodic:
                centre = best.values[name]
                for offset in np.linspace(-0.3, 0.3, 13) / float(time[-1]):
                    turned = {
                        **given,
                        **centre,
                        frequency: centre[frequency] + offset,
                        "phase_rad": centre["phase_rad"] - np.pi * offset * float(time[-1]),
                    }
                    replays += 1
                    tried = self.evaluate({**best.values, name: turned}, best.pulls)
                    if tried.fitted < best.fitted:
                        best = tried
        return dataclasses.replace(best, replays=replays)

    def _search_along(self, start: Fit, one: Coordinate, *, closely: bool = True) -> Fit:
        best, replays = start, 0

        def at(point: float) -> float:
            nonlocal best, replays
            values = {name: dict(given) for name, given in start.values.items()}
            values[one.effect][one.quantity.name] = one.outward(float(point))
            found = self.evaluate(values, start.pulls)
            replays += 1
            if found.fitted < best.fitted:
                best = found
            return found.fitted

        middle = one.inward(start.values[one.effect][one.quantity.name])
        width = _BRACKET
        for _ in range(2):
            low, high = max(one.low, middle - width), min(one.high, middle + width)
            found = minimize_scalar(
                at, bounds=(low, high), method="bounded", options={"xatol": 1e-3, "maxiter": 13}
            )
            edge = 0.08 * (high - low)
            if low + edge < found.x < high - edge:
                break
            middle = float(found.x)  # the valley lies beyond: once more around its rim
        if closely and best.fitted > _NEAR_FLOOR * self.perfect**2:
            middle = one.inward(best.values[one.effect][one.quantity.name])
            low, high = max(one.low, middle - _NARROW), min(one.high, middle + _NARROW)
            minimize_scalar(
                at, bounds=(low, high), method="bounded", options={"xatol": 1e-5, "maxiter": 15}
            )
        return dataclasses.replace(best, replays=replays)

    @staticmethod
    def _coordinates(start: Fit, *, nuisances: bool) -> tuple[Coordinate, ...]:
        return tuple(
            Coordinate.around(name, quantity, start.values[name][quantity.name])
            for name in start.values
            for quantity in CATALOGUE[name].parameters
            if nuisances or not quantity.nuisance or quantity.name == "phase_rad"
        )

    def fit(
        self,
        start: Fit,
        *,
        steps: int,
        nuisances: bool = False,
        stage: Stage = FINE,
        least: float = _CONVERGED,
        known: Fit | None = None,
        side_by_side: Map = map,
    ) -> Fit:
        """Fit from `start`, with at most `steps` derivatives.

        Gauss-Newton with Cauchy's weights, damped where a step leaves more (Levenberg): the
        logarithm of the cost, times the evidence, plus the price of the sheet.

        Args:
            start: where to begin.
            steps: derivatives at the most.
            nuisances: fit the parameters that only shape an effect (a friction's presliding) too;
                phases always are.
            stage: how it looks at the gap.
            least: fall of the objective below which the fit has ended.
            known: a fit whose derivatives by the sheet are used, where it has any of this stage.
            side_by_side: does the replays of one derivative.
        """
        coordinates = self._coordinates(start, nuisances=nuisances)
        pulled = np.flatnonzero(self.sheet.free(start.values))
        size = len(coordinates) + len(pulled)
        if not size:
            return start
        if not len(pulled):
            stage = dataclasses.replace(stage, wide=1.0, blur_s=0.0)
        low, high = self._bounds(coordinates, pulled)
        seen = self._blurred(stage.blur_s)
        # Far from the floor the scale of the loss is that of the gap, so that all of it pulls.
        loss_scale = max(LOSS_SCALE * stage.wide, 3.0 * float(np.median(np.abs(seen(start)))))
        steps_of = np.array(
            [stage.difference * one.fineness for one in coordinates] + [stage.pulled] * len(pulled)
        )
        precision = np.array([0.0] * len(coordinates) + [4.0] * len(pulled))
        replays, ended = 0, False

        def at(point: FloatArray) -> Fit:
            values = {name: dict(given) for name, given in start.values.items()}
            for one, coordinate in zip(coordinates, point, strict=False):
                values[one.effect][one.quantity.name] = one.outward(float(coordinate))
            pulls = start.pulls.copy()
            pulls[pulled] = point[len(coordinates) :]
            return self.evaluate(values, pulls)

        def objective(fit: Fit) -> float:
            scaled = _cauchy(seen(fit), loss_scale)
            return self.sheet.evidence * math.log(scaled) + self.sheet.price(fit.pulls)

        point = np.clip(
            np.concatenate(
                [
                    [
                        one.inward(start.values[one.effect][one.quantity.name])
                        for one in coordinates
                    ],
                    start.pulls[pulled],
                ]
            ),
            low,
            high,
        )
        now = at(point)
        best = now if now.fitted < start.fitted else start
        value = objective(now)
        columns = np.empty((seen(now).size, size))
        wanted = list(range(size))
        borrowed = known.slopes.get(stage) if known is not None else None
        if known is not None and borrowed is not None:
            wanted = wanted[: len(coordinates)]
            for index, row in enumerate(pulled.tolist(), len(coordinates)):
                if row in known.pulled:
                    columns[:, index] = borrowed[:, known.pulled.index(row)]
                else:
                    wanted.append(index)
        for _ in range(steps):
            base = seen(now)
            turns = np.where(point + steps_of > high, -steps_of, steps_of)

            def slope(
                index: int, point: FloatArray = point, turns: FloatArray = turns, base=base
            ) -> FloatArray:
                moved = point.copy()
                moved[index] += turns[index]
                ahead = seen(at(moved))
                if not stage.central:
                    found: FloatArray = (ahead - base) / turns[index]
                    return found
                moved[index] -= 2.0 * turns[index]
                found = (ahead - seen(at(moved))) / (2.0 * turns[index])
                return found

            for index, column in zip(wanted, side_by_side(slope, wanted), strict=True):
                columns[:, index] = column
            replays += (2 if stage.central else 1) * len(wanted)
            weights = 1.0 / (1.0 + (base / loss_scale) ** 2)
            scale = self.sheet.evidence / (_cauchy(base, loss_scale) * base.size)
            weighted = columns * weights[:, None]
            hessian = scale * (weighted.T @ columns)
            slope_of = scale * (weighted.T @ base) + precision * point
            gained, promised = 0.0, 0.0
            for damping in _DAMPING:
                moved, fall = _step(hessian, slope_of, precision, point, damping, low, high)
                tried = at(moved)
                replays += 1
                if tried.fitted < best.fitted:
                    best = tried
                gain = value - objective(tried)
                if gain > gained:
                    gained, promised, after, reached = gain, fall, tried, moved
                if gained > 0.0 and gained >= _GOOD_STEP * promised:
                    break
            if gained <= least:
                ended = True
                break
            now, point, value = after, reached, value - gained
        return dataclasses.replace(
            best,
            coordinates=coordinates,
            pulled=tuple(pulled.tolist()),
            jacobian=columns,
            slopes={} if borrowed is not None else {stage: columns[:, len(coordinates) :]},
            ended=ended,
            replays=replays,
        )

    def _blurred(self, width_s: float) -> Callable[[Fit], FloatArray]:
        """What a fit looks at, float64[signals x fitted rows]: the gap, or its moving mean.

        Impacts that come early or late are spikes that do not overlap; in a mean over more than the
        time they are apart by, a fit sees which way they have to move. Stretches that are held
        out have no part in it.
        """
        rows = self.rows
        points = round(width_s / self.replay.step_s)
        if points < 2:
            return lambda fit: fit.gap[:, rows].ravel()
        share = np.maximum(uniform_filter1d(rows.astype(float), points), 1e-9)

        def blurred(fit: Fit) -> FloatArray:
            mean = uniform_filter1d(np.where(rows, fit.gap, 0.0), points, axis=1) / share
            found: FloatArray = mean[:, rows].ravel()
            return found

        return blurred

    def _bounds(
        self, coordinates: Sequence[Coordinate], pulled: NDArray[np.int64]
    ) -> tuple[FloatArray, FloatArray]:
        """Lowest and highest values of the coordinates and of the pulls, float64[k] each."""
        lowest, highest = self.sheet.bounds()
        low = np.concatenate([[one.low for one in coordinates], lowest[pulled]])
        return low, np.concatenate([[one.high for one in coordinates], highest[pulled]])


def _cauchy(values: FloatArray, scale: float) -> float:
    """Cauchy's mean square of differences, linear beyond `scale`."""
    return float(np.mean(scale**2 * np.log1p((values / scale) ** 2)))


def _step(
    hessian: FloatArray,
    slope: FloatArray,
    precision: FloatArray,
    point: FloatArray,
    damping: float,
    low: FloatArray,
    high: FloatArray,
) -> tuple[FloatArray, float]:
    """Where a damped step from `point` leads within the bounds, and the fall that it promises.

    hessian, slope: of half the objective, the price's slope included; precision: of the price.
    """
    size = np.diag(hessian) + precision
    size = np.where(size > 0.0, size, 1.0)
    # Scaled by its own curvature; what nothing depends on stays where it is.
    root = 1.0 / np.sqrt(size)
    full = (hessian + np.diag(precision)) * np.outer(root, root)
    full[np.diag_indices_from(full)] += damping + 1e-9
    try:
        step = -root * cho_solve(cho_factor(full), root * slope)
    except LinAlgError:
        return point, 0.0
    reached = np.clip(point + step, low, high)
    step = reached - point
    fall = -2.0 * float(slope @ step) - float(step @ (hessian + np.diag(precision)) @ step)
    return reached, max(fall, 0.0)
