"""A drive of which only reference and position are known: how it follows, and no more.

    position(t) = play(reference(t - lag); width) + offset

with the play (backlash) operator of hysteresis theory: the output stays where it is until the
reference has moved away from it by half the width. Lag and width are scanned together; whether the
width is backlash, stiction, or a dead band of the controller, and whether the lag is a delay
or a soft loop, position alone does not say, so that no cause is named.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import lfilter
from scipy.stats import t as student

from ..arrays import BoolArray, FloatArray
from ..drive.compiled import kernel
from ..drive.rigid.machine import Machine
from ..errors import InputError
from ..recording.signals import Recording
from .describe.follower import Followed, with_follower_description
from .diagnosis import ConditionShare, Diagnosis, Measured, Series, SignalGap
from .judge.verdict import verdict_of
from .locate.conditions import shares
from .replay.hidden import NO_GAP_RATIO
from .rigid.balance import HELD_OUT_EVERY, stretch_length
from .rigid.motion import Motion, motion_of, stated_resolution
from .standing import said_of_stops, stops_of

_LONGEST_LAG_S = 0.6
_GRID = 41  # lags and widths of a scan
_ROUNDS = 3  # of finer scans
_BLOCKS = 12  # left out in turn for intervals
_LEAST = 16  # samples
_MOVES = 4.0  # resolutions that the reference has to travel


@dataclass(frozen=True, eq=False)
class _Followed:
    """Lag in s, width and offset in the output's unit, and the position they give."""

    lag_s: float
    width: float
    offset: float
    position: FloatArray


def diagnose_follower(
    recording: Recording,
    machine: Machine,
    *,
    mode: float | None,
    source: str,
    drive_name: str,
    tell: Callable[[float], None],
) -> Diagnosis:
    """Say how the output follows its reference: lag, play or dead band, offset, resolution.

    See `diagnose.diagnose`; what the machine's file says of a load or a loop is not used.

    Raises:
        InputError: no position, no reference, a reference that does not move.
    """
    motion = motion_of(recording, machine, source, mode)
    end = "m" if machine.linear else "rad"
    reference = motion.reference_position
    if not np.isfinite(reference).any():
        raise InputError(
            f"{source}: reference_position in {end} is missing; a follower is judged by reference "
            "and position"
        )
    name = "rod_position_m" if machine.linear else "rotor_position_rad"
    if not recording.has(name):
        name = "load_position_rad"
    known = recording.signal(name)[np.isfinite(recording.signal(name))]
    step = resolution(known, stated_resolution(recording, machine))
    usable = motion.usable & np.isfinite(reference)
    if not usable.any() or not np.ptp(reference[usable]) > _MOVES * max(step, 1e-300):
        raise InputError(
            f"{source}: the reference moves by less than {_MOVES:g} steps of the position "
            f"({step:.3g} {end}); expected motion"
        )
    reference = np.interp(motion.time_s, motion.time_s[usable], reference[usable])
    floor = math.hypot(step / math.sqrt(12.0), machine.position_noise or motion.position_noise)
    judge = _Judge(motion, reference, usable, step)
    if min(int(judge.fitted.sum()), int(judge.judged.sum())) < _LEAST:
        raise InputError(
            f"{source}: {int(usable.sum())} samples of reference and position together, expected "
            f"more: at least {_LEAST} to fit and {_LEAST} to judge"
        )
    tell(0.1)
    best = judge.fit(judge.fitted, lags=True, widths=True)
    tell(0.3)
    whole, spans = judge.with_intervals(lambda share: tell(0.3 + 0.4 * share))
    stops = stops_of(reference, motion.raw_position, usable, max(step, 2.0 * floor))
    only = {
        "lag": judge.fit(judge.fitted, lags=True, widths=False),
        "width": judge.fit(judge.fitted, lags=False, widths=True),
    }
    slow: list[str] = []
    if stops is not None and stops.width + stops.half < spans["width"][0]:
        slow.append(said_of_stops(motion, end))
        best = only["lag"]
        whole, spans = judge.with_intervals(lambda share: tell(0.7 + 0.25 * share), widths=False)
        whole = replace(whole, width=stops.width)
        spans["width"] = (0.0, stops.width + stops.half)
    gap = judge.left(reference, judge.judged)
    left = judge.left(best.position, judge.judged)
    alone = {name: judge.left(one.position, judge.judged) for name, one in only.items()}
    spread = float(np.std(motion.raw_position[usable])) or 1.0
    no_gap = gap <= NO_GAP_RATIO * floor
    stamp = int(recording.stamp_ns[0])
    found = Diagnosis(
        source=source,
        drive=drive_name,
        verdict=verdict_of(no_gap=no_gap),
        block=None,
        signals=(SignalGap("position", end, gap, gap, floor),),
        when=() if no_gap else _when(motion, reference, usable),
        frequency_hz=(),
        ports=(),
        causes=(),
        before=gap / spread,
        after=gap / spread,
        floor=floor / spread,
        shrink=0.0,
        steps=(),
        candidates=(),
        notes=(
            *slow,
            *_notes(motion, machine, step, whole, spans, alone, left, gap),
            *motion.notes,
        ),
        values={},
        series=_series(motion, machine, reference, judge, stamp),
        replays=judge.scans,
        misfit_before=gap / floor,
        misfit_after=gap / floor,
        misfit_perfect=1.0,
        misfit_best=left / floor,
        duration_s=recording.duration_s,
        rate_hz=recording.rate_hz,
        measured=_measured(motion, end, step, whole, spans, gap, left),
        floor_is="the noise and resolution of the position",
    )
    if no_gap:
        return found
    return with_follower_description(found, judge.followed(machine.linear, best, spans, floor))


def resolution(position: FloatArray, stated: float) -> float:
    """Step of the position: stated, or the smallest distance between values that come often.

    0 where no values come often: the position is finer than the recording tells.
    """
    reach = float(np.ptp(position))
    if stated or reach == 0.0:
        return stated
    grain = 1e-7 * reach  # what resampling between equal values leaves of rounding
    values, count = np.unique(np.round(position / grain), return_counts=True)
    often = values[count >= max(3, position.size / 1000)] * grain
    steps = np.diff(often)
    steps = steps[steps > 10.0 * grain]
    return float(np.median(steps[steps < 1.5 * steps.min()])) if steps.size > 3 else 0.0


def behind_a_loop(reference: FloatArray, lag: float) -> FloatArray:
    """float64[n] behind a first-order loop that begins at rest; lag: in samples.

    Exact where the reference runs straight between its samples.
    """
    if lag < 1e-3:
        return reference.copy()
    kept = math.exp(-1.0 / lag)
    first = lag * (1.0 - kept)
    taps = [1.0 - first, first - kept]
    made, _ = lfilter(taps, [1.0, -kept], reference - reference[0], zi=[0.0])
    found: FloatArray = made + reference[0]
    return found


class _Judge:
    def __init__(
        self, motion: Motion, reference: FloatArray, usable: BoolArray, step: float
    ) -> None:
        self.motion, self.reference, self.usable, self.step = motion, reference, usable, step
        self.stretch_s = stretch_length(float(motion.time_s[-1]))
        self.stretch = (motion.time_s / self.stretch_s).astype(np.int64)
        held = self.stretch % HELD_OUT_EVERY == 1
        self.judged: BoolArray = usable & held
        self.fitted: BoolArray = usable & ~held
        self.scans = 0

    def fit(self, rows: BoolArray, *, lags: bool, widths: bool, looped: bool = False) -> _Followed:
        """Best lag, width and offset on `rows`, from coarse to fine.

        looped: the lag is that of a first-order loop, not a delay.
        """
        reach = float(np.ptp(self.reference[self.usable]))
        low = np.array([0.0, 0.0])
        high = np.array([_LONGEST_LAG_S if lags else 0.0, 0.9 * reach if widths else 0.0])
        best = np.zeros(2)
        for _ in range(_ROUNDS):
            lag = np.linspace(low[0], high[0], _GRID if lags else 1)
            width = np.linspace(low[1], high[1], _GRID if widths else 1)
            cost = self._costs(lag, width, rows, looped)
            at = np.unravel_index(int(np.argmin(cost)), cost.shape)
            best = np.array([lag[at[0]], width[at[1]]])
            reach_now = 3.0 * (high - low) / max(_GRID - 1, 1)
            low, high = np.maximum(best - reach_now, 0.0), best + reach_now
            if not lags:
                low[0] = high[0] = 0.0
            if not widths:
                low[1] = high[1] = 0.0
        played = np.empty(self.reference.size)
        _play(self._late(float(best[0]), looped), 0.5 * float(best[1]), played)
        offset = float(np.mean((self.motion.raw_position - played)[rows]))
        return _Followed(float(best[0]), float(best[1]), offset, played + offset)

    def with_intervals(
        self, tell: Callable[[float], None], *, widths: bool = True
    ) -> tuple[_Followed, dict[str, tuple[float, float]]]:
        """The fit to all usable rows, and 95 % intervals by leaving out blocks of time in turn."""
        whole = self.fit(self.usable, lags=True, widths=widths)
        count = min(_BLOCKS, int(self.stretch.max()) + 1)
        edges = np.linspace(0.0, float(self.motion.time_s[-1]) + 1e-9, count + 1)
        block = np.digitize(self.motion.time_s, edges) - 1
        parts = []
        for number in range(count):
            rows = self.usable & (block != number)
            parts.append(self.fit(rows, lags=True, widths=widths))
            tell((number + 1) / count)
        quantile = float(student.ppf(0.975, count - 1))
        spans = {}
        for name in ("lag_s", "width", "offset"):
            values = np.array([getattr(one, name) for one in parts])
            spread = math.sqrt((count - 1) / count * float(np.sum((values - values.mean()) ** 2)))
            value = getattr(whole, name)
            # Blocks that agree to the step of the scan or of the encoder know no better than it.
            finest = _LONGEST_LAG_S * (6.0 / _GRID) ** (_ROUNDS - 1) / _GRID
            half = math.hypot(quantile * spread, finest if name == "lag_s" else 0.5 * self.step)
            spans[name] = (value - half, value + half)
        return whole, spans

    def followed(
        self,
        linear: bool,
        delayed: _Followed,
        spans: dict[str, tuple[float, float]],
        floor: float,
    ) -> Followed:
        """What a law is looked for beside, where the fit to the fitted rows is `delayed`: that, or
        a loop in place of the delay where this is closer."""
        loop = self.fit(self.fitted, lags=True, widths=True, looped=True)
        looped = self.left(loop.position, self.fitted) < self.left(delayed.position, self.fitted)
        found = loop if looped else delayed
        late = self._late(found.lag_s, looped)
        behind = (late - (found.position - found.offset)) / max(0.5 * found.width, 1e-300)
        half = {name: 0.5 * (high - low) for name, (low, high) in spans.items()}
        return Followed(
            motion=self.motion,
            linear=linear,
            late=late,
            predicted=found.position,
            dead_band=np.clip(behind, -1.0, 1.0),
            lag_s=found.lag_s,
            offset_half=half["offset"],
            lag_half_s=half["lag_s"],
            width_half=half["width"],
            fitted=self.fitted,
            judged=self.judged,
            stretch_s=self.stretch_s,
            floor=floor,
        )

    def left(self, position: FloatArray, rows: BoolArray) -> float:
        """RMS of the recorded position less another, float64[n], on `rows`."""
        return float(np.sqrt(np.mean((self.motion.raw_position - position)[rows] ** 2)))

    def _costs(
        self, lags: FloatArray, widths: FloatArray, rows: BoolArray, looped: bool
    ) -> FloatArray:
        self.scans += lags.size * widths.size
        cost = np.empty((lags.size, widths.size))
        for index, lag in enumerate(lags.tolist()):
            late = self._late(lag, looped)
            _play_costs(late, 0.5 * widths, self.motion.raw_position, rows, cost[index])
        return cost

    def _late(self, lag_s: float, looped: bool) -> FloatArray:
        time_s = self.motion.time_s
        if looped:
            return behind_a_loop(self.reference, lag_s * self.motion.rate_hz)
        return np.interp(time_s - lag_s, time_s, self.reference)


@kernel
def _play(reference, half, out):
    """The play operator: `out` stays until `reference` is `half` away from it."""
    state = reference[0]
    for index in range(reference.shape[0]):
        state = min(max(state, reference[index] - half), reference[index] + half)
        out[index] = state


@kernel
def _play_costs(reference, halves, position, rows, out):
    """Variance over `rows` of position less played reference, for each half width, into `out`."""
    for number in range(halves.shape[0]):
        half = halves[number]
        state = reference[0]
        count, first, second = 0, 0.0, 0.0
        for index in range(reference.shape[0]):
            state = min(max(state, reference[index] - half), reference[index] + half)
            if rows[index]:
                left = position[index] - state
                count += 1
                first += left
                second += left * left
        out[number] = second / count - (first / count) ** 2


def _measured(
    motion: Motion,
    end: str,
    step: float,
    whole: _Followed,
    spans: dict[str, tuple[float, float]],
    gap: float,
    left: float,
) -> tuple[Measured, ...]:
    share = max(0.0, 1.0 - left / gap) if gap > 0.0 else 0.0
    lag = (max(spans["lag_s"][0], 0.0), spans["lag_s"][1])
    width = (max(spans["width"][0], 0.0), spans["width"][1])
    return (
        Measured("lag_s", "s", whole.lag_s, *lag, "of the position behind the reference"),
        Measured(
            f"dead_band_{end}",
            end,
            whole.width,
            *width,
            "backlash, stiction and dead band of the controller together, full width",
        ),
        Measured(
            f"offset_{end}", end, whole.offset, *spans["offset"], "position minus reference, mean"
        ),
        Measured(f"resolution_{end}", end, step, step, step, "step of the recorded position"),
        Measured(
            "highest_frequency_hz",
            "Hz",
            *(0.5 * motion.rate_hz,) * 3,
            "half the sampling rate: nothing faster is seen",
        ),
        Measured(
            "relative_gap_taken_off", "1", share, share, share, "by these, on held-out stretches"
        ),
    )


def _notes(
    motion: Motion,
    machine: Machine,
    step: float,
    whole: _Followed,
    spans: dict[str, tuple[float, float]],
    alone: dict[str, float],
    left: float,
    gap: float,
) -> list[str]:
    unit = "m" if machine.linear else "rad"
    notes = [
        "reference and position alone, controller unknown: a lag may be a delay or a soft loop, a "
        "dead band may be backlash, stiction or the controller's own; no cause is named",
    ]
    if left > 0.0 and min(alone.values()) <= 1.05 * left:
        name = min(alone, key=lambda one: alone[one])
        other = "dead band" if name == "lag" else "lag"
        what = "lag" if name == "lag" else "dead band"
        notes.append(
            f"a {what} alone fits nearly as well as both together: the {other} is uncertain; "
            "moves at several speeds would decide"
        )
    if whole.lag_s < 1.0 / motion.rate_hz:
        notes.append(f"the lag is below one sample of {1e3 / motion.rate_hz:.3g} ms")
    if whole.width < 2.0 * step or spans["width"][0] <= step:
        notes.append(
            f"no dead band is proven: what was found is not clearly above the step of "
            f"{step:.3g} {unit}"
        )
    if left > 2.0 * step and left > 0.3 * gap:
        notes.append(
            f"lag and dead band leave {100.0 * left / gap:.0f} % of the gap: the output departs "
            "from the reference in other ways, too (load, friction, stick-slip)"
        )
    notes.append(
        f"not judged at {motion.rate_hz:.3g} Hz from an encoder at the output: inertia, friction "
        "in N m, cogging, stiffness, torque constant, gains, and backlash between motor and "
        "encoder apart from the rest"
    )
    if np.isfinite(motion.effort).any():
        notes.append(
            "an effort was recorded and not used: a drive file of kind rigid compares the motion "
            "with it"
        )
    return notes


def _when(motion: Motion, reference: FloatArray, usable: BoolArray) -> tuple[ConditionShare, ...]:
    energy = (motion.raw_position - reference)[usable] ** 2
    speed = np.gradient(reference, motion.time_s)[usable]
    top = float(np.max(np.abs(np.gradient(reference, motion.time_s))))
    masks = {
        "rest": np.abs(speed) < 0.01 * top,
        "low_speed": (np.abs(speed) >= 0.01 * top) & (np.abs(speed) < 0.2 * top),
        "high_speed": np.abs(speed) > 0.5 * top,
        "forwards": speed > 0.01 * top,
        "backwards": speed < -0.01 * top,
    }
    return shares(energy, {name: mask for name, mask in masks.items() if mask.any()}, {})


def _series(
    motion: Motion, machine: Machine, reference: FloatArray, judge: _Judge, start_ns: int
) -> Series:
    end = "m" if machine.linear else "rad"
    return Series(
        time_s=motion.time_s,
        reference_m=reference,
        recorded=motion.raw_position[None],
        before=reference[None],
        after=reference[None],
        held_out=judge.judged,
        usable=judge.usable,
        start_ns=start_ns,
        position=motion.raw_position,
        position_unit=end,
        speed=np.gradient(reference, motion.time_s),
        speed_unit=f"{end}/s",
    )
