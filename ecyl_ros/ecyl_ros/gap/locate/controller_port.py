"""The controller's own equation: the voltage that the nominal cascade commands on measured signals.

Whatever the loop does, a healthy controller commands what its equation makes of what it measures.
Integrals fed with noise drift; they are therefore held to what was commanded, by an observer whose
innovation is the residual: what is slower than `_HELD_S` is taken up, the rest is left. What noise
alone leaves is worked out the same way, on a healthy draw of the nominal machine; what happens
between samples (a load that rattles), by leaving out every other one. Of the data sheet the
equation knows the feed constant alone, which is free within its tolerance.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize_scalar

from ...arrays import FloatArray
from ...drive.cascade import cascade_step, initial_cascade_state
from ...drive.compiled import allocating
from ...typical import typical_rms
from ..compete.strain import SOUND
from ..diagnosis import PortCheck
from ..fit.robust import robust_weights
from ..replay.evidence import Smoother
from ..replay.replay import Effects, Replay
from ..sheet import Sheet

# Above the motion of a drive, below its loops: a shorter one takes up what a wrong setting leaves,
# a longer one lets noise that is integrated twice grow over it.
_HELD_S = 0.05
_SETTLED = 5.0  # times that: what the integrals were at the first sample is forgotten
_FEED = "controller.feed_scale"
_ROUNDS = 10  # of reweighted least squares
_LONGEST_DELAY_S = 0.02
_DELAYS = 13  # that are tried before the best is looked for between its neighbours

Signals = Mapping[str, FloatArray]


def controller_check(replay: Replay) -> PortCheck | None:
    """What the controller's equation leaves; None where a signal that it needs was not recorded."""
    recorded = _complete(replay)
    if recorded is None:
        return None
    equation = _Equation(replay)
    rms = equation.typical(equation.with_feed_free(equation.fed(recorded)))
    what = "voltage commanded on measured signals"
    return PortCheck("controller", what, "V", rms, equation.floor(recorded))


def delay_restores(replay: Replay, ratio: float) -> bool:
    """Whether the balance holds, below `ratio`, once measured signals reach the loop later."""
    return all(_late(one, ratio) for one in replay.parts)


def _late(replay: Replay, ratio: float) -> bool:
    recorded = _complete(replay)
    if recorded is None:
        return False
    equation = _Equation(replay)
    allowed = ratio * equation.floor(recorded)
    fed = equation.fed(recorded)

    def off(delay_s: float) -> float:
        late = {"measurement_delay": {"delay_s": delay_s}}
        return equation.typical(equation.with_feed_free(fed, late)) / allowed

    tried = np.geomspace(0.1 / replay.drive.controller.rate, _LONGEST_DELAY_S, _DELAYS)
    best = int(np.argmin([off(float(one)) for one in tried]))
    around = tried[max(best - 1, 0)], tried[min(best + 1, _DELAYS - 1)]
    found = minimize_scalar(off, bounds=around, method="bounded", options={"maxiter": 20})
    return float(found.fun) < 1.0


def _complete(replay: Replay) -> dict[str, FloatArray] | None:
    """{signal: float64[n]} of those recorded whole; None if the controller needs another."""
    names = [one.name for one in replay.signals]
    rows = zip(names, replay.recorded, strict=True)
    found = {name: row for name, row in rows if np.isfinite(row).all()}
    needed = {"rotor_position", "rotor_velocity", "current_q", "voltage_q"}
    if replay.drive.controller.feedback == "rod":
        needed.add("rod_position")
    return found if needed <= found.keys() else None


class _Equation:
    """The equation of a replay's controller, to be fed with signals at its ticks."""

    def __init__(self, replay: Replay) -> None:
        self._replay = replay
        self._sheet = Sheet.of(replay.nominal, float(replay.time_s[-1]))
        self._row = self._sheet.index(_FEED)
        tick = 1.0 / replay.drive.controller.rate
        self._ticks = np.arange(int(replay.time_s[-1] / tick)) * tick
        # Smooth, as the drive's own controller follows it: corners at the samples would come out
        # of a feedforward as spikes.
        spline = CubicSpline(replay.time_s, replay.reference_m)
        self._reference, self._velocity = spline(self._ticks), spline(self._ticks, 1)
        settled = replay.usable & (replay.time_s >= replay.time_s[0] + _SETTLED * _HELD_S)
        self._settled = settled if settled.any() else replay.usable

    def fed(self, signals: Signals, every: int = 1) -> Signals:
        """Signals at the ticks, what is measured out of every so many samples alone."""
        time_s = self._replay.time_s
        kept = time_s[::every]
        found = {
            name: np.interp(self._ticks, kept, values[::every]) for name, values in signals.items()
        }
        if every > 1:
            found["voltage_q"] = np.interp(self._ticks, time_s, signals["voltage_q"])
        return found

    def typical(self, left: FloatArray) -> float:
        """RMS that the median suggests; impacts between samples are not in what is fed."""
        return typical_rms(Smoother(self._replay.time_s)(left)[self._settled])

    def floor(self, recorded: Signals) -> float:
        """What a healthy controller leaves, V.

        As much as on a healthy draw of the nominal machine, and what more happens between the
        samples than there.
        """
        names = [one.name for one in self._replay.signals]
        drawn = dict(zip(names, self._replay.healthy_signals(), strict=True))
        noise = self.typical(self.with_feed_free(self.fed(drawn)))
        missed, usual = (self._missed(signals) for signals in (recorded, drawn))
        return max(math.sqrt(noise**2 + max(missed**2 - usual**2, 0.0)), 1e-12)

    def _missed(self, signals: Signals) -> float:
        """What the samples miss between them, V.

        Interpolation errs with the square of their distance: by a third of what half of them
        change.
        """
        params = _unlimited(self._replay.packed({}))
        whole, half = (self._left(self.fed(signals, every), params) for every in (1, 2))
        return self.typical(half - whole) / 3.0

    def with_feed_free(self, fed: Signals, effects: Effects | None = None) -> FloatArray:
        """What is left with the feed constant that leaves least, as far off as in a sound sheet."""
        effects = effects or {}
        if self._row is None:
            return self._left(fed, self._replay.packed(effects))
        # In proportion without limits: a reference that is off winds the integrals up to them.
        left, other = (
            self._left(fed, _unlimited(self._feeding(pull).packed(effects))) for pull in (0.0, 1.0)
        )
        rows = self._replay.usable
        left, slope = left[rows], (other - left)[rows]
        found = 0.0
        for _ in range(_ROUNDS):
            rest = left + found * slope
            weight = robust_weights(rest / max(typical_rms(rest), 1e-12))
            found = -float(weight @ (slope * left)) / max(float(weight @ slope**2), 1e-300)
        feeding = self._feeding(min(max(found, -SOUND), SOUND))
        return self._left(fed, feeding.packed(effects))

    def _feeding(self, pull: float) -> Replay:
        """The replay with a feed constant so many tolerances off its nominal value."""
        pulls = self._sheet.at_nominal
        pulls[self._row] = pull
        return self._replay.at({_FEED: float(self._sheet.values(pulls)[self._row])})

    def _left(self, fed: Signals, params: NDArray[np.void]) -> FloatArray:
        """Recorded less commanded voltage at the recording's stamps, V."""
        left = np.empty(len(self._ticks))
        _innovation(
            self._reference,
            self._velocity,
            fed["rotor_position"],
            fed["rotor_velocity"],
            fed["current_q"],
            fed.get("rod_position", np.zeros(len(self._ticks))),
            fed["voltage_q"],
            _observer(params),
            params,
            initial_cascade_state(params),
            left,
        )
        return np.interp(self._replay.time_s, self._ticks, left)


def _unlimited(params: NDArray[np.void]) -> NDArray[np.void]:
    for limit in ("speed_limit", "current_limit", "voltage_limit"):
        params[limit] = math.inf
    return params


def _observer(params: NDArray[np.void]) -> FloatArray:
    """What each integral is corrected by in a tick for a volt of innovation: float64[3].

    An error a of the current loop's integral part (V) and b of the current asked for (A) make an
    innovation of a + kp b, and a grows by ki b: both poles are put at -1 / `_HELD_S`.
    """
    p = {name: float(params[name][0]) for name in ("tick", "current_kp", "current_ki")}
    outer = 0 if float(params["position_to_current"][0]) else 1
    slope = float(params["position_ki" if outer == 0 else "speed_ki"][0])
    kp, ki, per = p["current_kp"], p["current_ki"], 1.0 / _HELD_S
    found = np.zeros(3)
    if slope > 0.0 and ki > 0.0:
        found[outer] = per**2 / ki / slope
        found[2] = max(2.0 * per - kp * per**2 / ki, 0.0) / ki
    elif ki > 0.0:
        found[2] = per / ki
    elif slope > 0.0 and kp > 0.0:
        found[outer] = per / kp / slope
    return p["tick"] * found


@allocating
def _innovation(
    reference, velocity, angle, speed, current, rod, commanded, observer, params, state, left
):
    """The cascade fed with measured signals, tick by tick; fills `left` (float64[n]), V."""
    measured = np.zeros(7)
    voltage = np.zeros(2)
    for tick in range(left.shape[0]):
        measured[0] = angle[tick]
        measured[1] = speed[tick]
        measured[2] = rod[tick]
        measured[5] = current[tick]
        cascade_step(state, reference[tick], velocity[tick], measured, params, voltage)
        left[tick] = commanded[tick] - voltage[1]
        for one in range(3):
            state[0][one] += observer[one] * left[tick]
