"""Fits of effects' parameters to a recording, by replaying it in closed loop.

Beside the parameters of the effects the constants of the data sheet are fitted, each at the price
of leaving it (`sheet`): what a candidate has to beat is the sheet, not its nominal point.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from ...arrays import BoolArray, FloatArray
from ...effects.catalogue import CATALOGUE
from ..replay.evidence import ReplayEvidence, gather
from ..replay.hidden import Hidden
from ..replay.replay import Replay
from ..sheet import PULL_PRICE, Sheet
from .coordinate import Coordinate, is_phase, quantities
from .newton import Differences, Objective, descend
from .robust import LOSS_SCALE, cost
from .stages import FINE, Stage
from .torque_scale import TorqueScale

Values = dict[str, dict[str, float]]  # {effect: {parameter: value}}

ALMOST = 1.05  # times a perfect model's misfit: what leaves no more is as good
_NOISIEST = 4.0  # times a perfect model's misfit: no effect excuses more
_WHITE = math.sqrt(0.85)  # robust misfit of white noise at the floor
_REFUTED = 0.5  # of a perfect model's cost: one draw of impacts hardly leaves twice another's
_AMPLIFIED = 1.2  # times a perfect model's misfit: from here on noise counts as amplified
CONVERGED = 0.02  # fall of the objective below which a fit has ended


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
            sheet; `jacobian` float64[k, signals x fitted rows] of the gap by both at the end of the
            fit (None for values not fitted).
        slopes: {stage: float64[pulled, signals x fitted rows]}, derivatives by the sheet that were
            worked out on the way, as each stage sees them.
        ended: whether the fit went as far as it goes.
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
        self._hold_out(held)
        self.perfect = self._perfect()
        self._sound: tuple[Fit, float] | None = None

    def _hold_out(self, held: BoolArray) -> None:
        self.held = held & self.replay.usable
        self.rows = ~held & self.replay.usable

    def divided_by(self, fit: Fit) -> bool:
        """Whether fitted and held-out stretches were cut anew, for what a fit leaves.

        What a wrong sheet leaves is everywhere; a fault of a moment shows only once that is gone,
        and has to be both fitted and judged. Fits from before are not to be compared with any more.
        """
        held = self.replay.held_out_by(fit.gap)
        if np.array_equal(held & self.replay.usable, self.held):
            return False
        self._hold_out(held)
        self.__dict__.pop("nominal", None)
        return True

    def _perfect(self) -> float:
        """Robust misfit of a perfect model: 0.92 for white noise at the floor."""
        return max(math.sqrt(cost(self.replay.healthy, self.replay.usable)), _WHITE)

    def test_floor(self, fit: Fit) -> None:
        """Find the floor again where a fit leaves far less than it: noise is not in the loop then.

        How much of the sensors' noise goes round the loop is told by the command; where that was
        not recorded, all of it is reckoned with until a recording says otherwise.
        """
        if self.replay.noise_in_loop and fit.left < _REFUTED * self.perfect**2:
            self.replay.keep_noise_out_of_the_loop()
            self.perfect = self._perfect()

    @property
    def floor_unsure(self) -> bool:
        """Whether the floor rests on noise in the loop that no recorded command tells of.

        What that noise does round the loop may then be less, down to none of it.
        """
        told = any(one.name == "voltage_q" for one in self.replay.signals)
        return self.replay.noise_in_loop and self.amplified and not told

    @property
    def amplified(self) -> bool:
        """Whether the loop makes clearly more of the sensors' noise: flanks rattle."""
        return self.perfect > _AMPLIFIED * _WHITE

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

    @cached_property
    def hidden(self) -> Hidden:
        """What the nominal replay does not show."""
        return Hidden(self.replay)

    def sound_with(self, fit: Fit) -> float:
        """Robust misfit of a healthy machine with a fit's effects, no less than `perfect_with`.

        Its constants are off by what the nominal replay does not show; looked for only where the
        fit leaves more than a perfect model.
        """
        if self._sound is None or self._sound[0] is not fit:
            self._sound = fit, self._sound_with(fit)
        return self._sound[1]

    def _sound_with(self, fit: Fit) -> float:
        perfect = self.perfect_with(fit.values)
        if not fit.names or math.sqrt(fit.left) <= ALMOST * perfect:
            return perfect
        noise = self.replay.healthy_with(fit.values)
        costs = [cost(one + noise, self.replay.usable) for one in self._unseen(fit)]
        return min(max(perfect, math.sqrt(np.mean(costs))), _NOISIEST * self.perfect)

    def _unseen(self, fit: Fit) -> FloatArray:
        return self.hidden.left_with(fit.values, self.sheet.constants(fit.pulls))

    def noise_with(self, fit: Fit) -> FloatArray:
        """RMS of what a healthy machine leaves of each signal on the held-out stretches, in floors.

        float64[signals]: 1, but where a fit's effects make clearly more of the noise, or of
        differences that the nominal replay does not show.
        """
        if self.sound_with(fit) <= _AMPLIFIED * self.perfect:
            return np.ones(len(self.replay.signals))
        healthy = self.replay.healthy_with(fit.values)[:, self.held]
        square = np.mean(healthy**2, axis=1)
        square += np.mean(self._unseen(fit)[:, :, self.held] ** 2, axis=(0, 2))
        rms: FloatArray = np.maximum(1.0, np.sqrt(square))
        return np.minimum(rms, _NOISIEST)

    def evaluate(
        self, values: Mapping[str, Mapping[str, float]], pulls: FloatArray | None = None
    ) -> Fit:
        """What is left with given parameters, and constants pulled off their nominal values."""
        pulls = self.sheet.at_nominal if pulls is None else pulls
        full = self.replay.complete(values, self.sheet.constants(pulls))
        pulls = np.where(self.sheet.free(full), pulls, 0.0)
        return self._seen(full, pulls, self._gap(full, pulls))

    def _gap(self, values: Mapping[str, Mapping[str, float]], pulls: FloatArray) -> FloatArray:
        return self.replay.gap(values, self.sheet.constants(pulls))

    def _seen(self, values: Values, pulls: FloatArray, gap: FloatArray) -> Fit:
        left = cost(gap, self.held)
        return Fit(
            values,
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

    def fit(
        self,
        start: Fit,
        *,
        steps: int,
        nuisances: bool = False,
        stage: Stage = FINE,
        least: float = CONVERGED,
        known: Fit | None = None,
    ) -> Fit:
        """Fit from `start`, in at most `steps` steps; see `newton`.

        Args:
            start: where to begin.
            steps: at the most.
            nuisances: fit the parameters that only shape an effect (a friction's presliding) too;
                phases always are.
            stage: how it looks at the gap.
            least: fall of the objective below which the fit has ended.
            known: a fit whose derivatives by the sheet are used, where it has any of this stage.
        """
        coordinates = self.coordinates_of(start, nuisances=nuisances)
        pulled = np.flatnonzero(self.sheet.free(start.values))
        count, size = len(coordinates), len(coordinates) + len(pulled)
        if not size:
            return start
        if not len(pulled):
            stage = dataclasses.replace(stage, wide=1.0, blur_s=0.0)
        seen = self.blurred(stage.blur_s)

        def parted(point: FloatArray) -> tuple[Values, FloatArray]:
            values = {name: dict(given) for name, given in start.values.items()}
            for one, coordinate in zip(coordinates, point, strict=False):
                values[one.effect][one.quantity.name] = one.outward(float(coordinate))
            pulls = start.pulls.copy()
            pulls[pulled] = point[count:]
            return values, pulls

        best = start

        def tried(point: FloatArray) -> FloatArray:
            nonlocal best
            values, pulls = parted(point)
            found = self._seen(values, pulls, self._gap(values, pulls))
            best = found if found.fitted < best.fitted else best
            return seen(found.gap)

        # Far from the floor the scale of the loss is that of the gap, so that all of it pulls.
        typical = float(np.median(np.abs(seen(start.gap))))
        lowest, highest = self.sheet.bounds()
        objective = Objective(
            residual=lambda point: seen(self._gap(*parted(point))),
            tried=tried,
            loss_scale=max(LOSS_SCALE * stage.wide, 3.0 * typical),
            evidence=self.sheet.evidence,
            precision=np.array([0.0] * count + [PULL_PRICE] * len(pulled)),
            low=np.concatenate([[one.low for one in coordinates], lowest[pulled]]),
            high=np.concatenate([[one.high for one in coordinates], highest[pulled]]),
        )
        own = [one.inward(start.values[one.effect][one.quantity.name]) for one in coordinates]
        slopes = np.empty((size, len(self.replay.signals) * int(self.rows.sum())))
        wanted = [*range(count), *self._borrow(known, stage, pulled, slopes)]
        by_size = [stage.difference * one.fineness for one in coordinates]
        scale = TorqueScale.of(
            start.names, coordinates, pulled.tolist(), self.sheet, self.replay.nominal
        )
        ended = descend(
            objective,
            np.clip(np.concatenate([own, start.pulls[pulled]]), objective.low, objective.high),
            slopes,
            wanted,
            range(count, size),
            Differences(np.array(by_size + [stage.pulled] * len(pulled)), stage.central),
            most=steps,
            least=least,
            mended=None if scale is None else scale.taken_out,
        )
        return dataclasses.replace(
            best,
            coordinates=coordinates,
            pulled=tuple(pulled.tolist()),
            jacobian=slopes,
            slopes={} if known is not None else {stage: slopes[count:]},
            ended=ended,
        )

    @staticmethod
    def _borrow(
        known: Fit | None, stage: Stage, pulled: NDArray[np.int64], slopes: FloatArray
    ) -> list[int]:
        """Put derivatives by the sheet that `known` has into `slopes`; rows that it has not."""
        first = slopes.shape[0] - len(pulled)
        borrowed = known.slopes.get(stage) if known is not None else None
        missing = []
        for index, row in enumerate(pulled.tolist(), first):
            if known is not None and borrowed is not None and row in known.pulled:
                slopes[index] = borrowed[known.pulled.index(row)]
            else:
                missing.append(index)
        return missing

    def coordinates_of(self, fit: Fit, *, nuisances: bool) -> tuple[Coordinate, ...]:
        """Of all parameters that a fit begins with and that the recording does not show as they
        are; with `nuisances` of those that only shape, too."""
        return tuple(
            Coordinate.around(name, quantity, fit.values[name][quantity.name])
            for name in fit.values
            for quantity in quantities(name, fit.values[name])
            if quantity.name not in self.shown(name)
            and (nuisances or not quantity.nuisance or is_phase(quantity.name))
        )

    def shown(self, name: str) -> Mapping[str, float]:
        """Parameters of an effect that one of the recordings shows as they are."""
        shown = CATALOGUE[name].shown
        if shown is None:
            return {}
        return next((found for one in self._evidence if (found := shown(one))), {})

    @cached_property
    def _evidence(self) -> list[ReplayEvidence]:
        """Of each recording upon the nominal model."""
        return [gather(one, {}) for one in self.replay.parts]

    def blurred(self, width_s: float) -> Callable[[FloatArray], FloatArray]:
        """What a fit looks at of a gap, float64[signals x fitted rows]: itself, or its moving mean.

        Impacts that come early or late are spikes that do not overlap; in a mean over more than the
        time they are apart by, a fit sees which way they have to move. Stretches that are held
        out have no part in it.
        """
        rows = self.rows
        points = round(width_s / self.replay.step_s)
        if points < 2:
            return lambda gap: gap[:, rows].ravel()
        share = np.maximum(uniform_filter1d(rows.astype(float), points), 1e-9)

        def blurred(gap: FloatArray) -> FloatArray:
            mean = uniform_filter1d(np.where(rows, gap, 0.0), points, axis=1) / share
            found: FloatArray = mean[:, rows].ravel()
            return found

        return blurred
