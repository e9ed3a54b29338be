"""A recording as motion and effort on one even grid, and the band in which the two can be compared.

As in the inverse dynamic identification method (Gautier, "Dynamic identification of robots with
power model", 1997; Janot, Vandanjon, Gautier, 2014): position is low-passed forwards and backwards,
without shift of phase, before central differences give speed and acceleration; effort and every
column that is compared with it then pass one and the same low-pass ("parallel filter") and are
decimated to what that leaves of information.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, sosfiltfilt, welch

from ...drive.rigid.loop import asked_along
from ...drive.rigid.machine import EFFORTS, Machine
from ...errors import InputError
from ...recording.signals import FOREIGN_SIGNALS, SIGNALS, Recording
from ..diagnosis import BoolArray, FloatArray

_ORDER = 4  # of the low-passes, run forwards and backwards
_DERIVATIVE = 2.5  # cutoff before differentiating, over the bandwidth
_SAMPLES_PER_PERIOD = 2.5  # of the bandwidth's frequency, after decimation
_HIGHEST = 0.2  # of the sampling rate: a bandwidth above it is not asked for
_POWER = 0.997  # share of the effort's power that the band holds
_LEAST_SAMPLES = 1500  # to compare, so that steps of friction are seen in smooth motion, too
_NOISE = 0.05  # share of the acceleration's power that may be noise
_HUGE = 1e12  # in SI: larger values are no measurement
_LONGEST_GAP = 5  # missing samples in a row that are bridged
_SETTLE = 1.0  # periods of the bandwidth's frequency left out at gaps
_ENDS = 4.0  # the same at the ends, beyond which the low-passes have to guess how it moved
_MOST_BENT, _JUMP = 0.999, 3.0  # of the second differences; beyond so many times it is a jump
_QUIETER = 0.5  # times the noise of differences: below, the recorded speed is taken
_LAG = 0.02  # of the speed's spread that a recorded speed may be off beyond noise
_FROZEN, _FROZEN_S = 20, 0.25  # samples and seconds for which an effort has to stand still
_RUNS = 10  # runs of equal values, with which they are usual
_LIVELY = 0.5  # share of the other samples at which it changes
_MOVED = 0.01  # of the travel, that the output has to move meanwhile
_EVEN = 0.02  # steps of the stamps may differ by this share and still be called even


@dataclass(frozen=True, eq=False)
class Motion:
    """What a recording holds of a rigid drive, evenly sampled; float64[n] in SI of the output.

    Attributes:
        position, velocity, acceleration: low-passed without phase, cutoff 2.5 x `bandwidth_hz`.
        raw_position: as recorded (bridged over short gaps).
        recorded_velocity, reference_position, reference_velocity: NaN where not recorded.
        effort: in `effort_unit`; NaN throughout where there is none.
        effort_unit: N, N m where the drive file's gain is known or not needed, else that of the
            recorded signal.
        other_effort: what the file's controller asks for where `effort` was recorded, and what was
            recorded where `effort` is what it asks for; NaN throughout where one of them is not
            known.
        mode: NaN where not recorded.
        usable: bool[n], False beside gaps, at the ends and where another mode ruled.
        position_noise: standard deviation of the position's noise. speed_noise: of `velocity`.
        standing: share of the motion over which the effort stood still, as it can not.
        bandwidth_hz: of the comparison. step: samples of the grid per compared sample.
        notes: what was found lacking.
    """

    time_s: FloatArray
    position: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    raw_position: FloatArray
    recorded_velocity: FloatArray
    reference_position: FloatArray
    reference_velocity: FloatArray
    effort: FloatArray
    effort_unit: str
    effort_name: str
    other_effort: FloatArray
    mode: FloatArray
    usable: BoolArray
    rate_hz: float
    position_noise: float
    speed_noise: float
    standing: float
    bandwidth_hz: float
    step: int
    notes: tuple[str, ...] = ()
    _sos: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 6)))
    _smoothing: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 6)))

    @property
    def rows(self) -> NDArray[np.int64]:
        """int64[m], the samples of the grid that are compared."""
        return np.arange(self.step // 2, self.time_s.size, self.step)

    def filtered(self, columns: FloatArray) -> FloatArray:
        """Columns float64[..., n] through the parallel filter, at `rows`: float64[..., m]."""
        made: FloatArray = sosfiltfilt(self._sos, columns, axis=-1, padlen=self._pad)
        return made[..., self.rows]

    def smoothed(self, values: FloatArray) -> FloatArray:
        """float64[n] through the low-pass that `position` and `velocity` have passed."""
        return _low_passed(self._smoothing, values)

    @property
    def _pad(self) -> int:
        return min(self.time_s.size - 1, int(3 * self.rate_hz / self.bandwidth_hz))


def motion_of(
    recording: Recording, machine: Machine, source: str, mode: float | None = None
) -> Motion:
    """The motion and effort that a recording holds of `machine`.

    mode: only where the recorded mode has this value.

    Raises:
        InputError: no position or speed of the output, too few samples, or no sample of the mode.
    """
    grid, rate, notes = _grid(recording, source)
    take = _Taker(recording, grid, rate)
    linear = machine.linear
    position = take("rod_position_m" if linear else "rotor_position_rad")
    if not linear and not np.isfinite(position).any():
        position = take("load_position_rad")
    recorded = take("rod_velocity_m_per_s" if linear else "rotor_velocity_rad_per_s")
    if not linear and not np.isfinite(recorded).any():
        recorded = take("load_velocity_rad_per_s")
    known = np.isfinite(position)
    from_speed = not known.any()
    if from_speed and not np.isfinite(recorded).any():
        wanted = "rod_position_m" if linear else "rotor_position_rad"
        held = ", ".join(name for name in (*SIGNALS, *FOREIGN_SIGNALS) if recording.has(name))
        raise InputError(
            f"{source}: {wanted} is missing; expected the position of the {machine.output} output "
            f"(recorded: {held or 'nothing'})"
        )
    if from_speed:
        known = np.isfinite(recorded)
        speed = _bridged(recorded, known)
        position = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1])) / rate])
        notes.append("no position recorded: it was integrated from speed, its start is unknown")
    effort, unit, name = _effort(take, machine, notes)
    modes = take.held("mode")
    position = _bridged(position, known)
    usable = _wide(known, rate)
    with_effort = np.isfinite(effort)
    if with_effort.any():
        usable &= _wide(with_effort, rate)
        effort = _bridged(effort, with_effort)
    if mode is not None:
        usable &= modes == mode
        if not usable.any():
            found = np.unique(modes[np.isfinite(modes)])
            had = ", ".join(f"{one:g}" for one in found[:8]) or "none"
            raise InputError(f"{source}: mode {mode:g} does not occur; modes recorded: {had}")
    noise = machine.position_noise
    if noise is None:
        noise = position_noise(position, rate, usable)
    stood = 0.0
    if with_effort.any():
        standing = _standing(effort, position, noise, rate) & usable
        if standing.any() and not standing[usable].all():
            steps = np.abs(np.diff(position, prepend=position[0]))
            stood = float(steps[standing].sum() / max(steps[usable].sum(), 1e-300))
            usable &= ~standing
            notes.append(
                f"the effort stands still for {standing.sum() / rate:.3g} s while the output "
                "moves: nothing was measured, or something else drives; left out"
            )
    jumps = _jumps(position, usable)
    if jumps.any():
        usable &= ~jumps
        position = _bridged(position, ~jumps)
        starts = int(np.sum(np.diff(jumps.astype(np.int8)) == 1) + jumps[0])
        notes.append(
            f"{starts} jumps of the position that no motion beside them comes near (a late stamp, "
            "a slipped count) were left out"
        )
    noise = machine.position_noise
    if noise is None:
        noise = position_noise(position, rate, usable)
    noise = max(noise, (machine.position_resolution or 0.0) / math.sqrt(12.0))
    bandwidth = machine.bandwidth_hz
    if bandwidth is None:
        bandwidth = bandwidth_of(position, effort, rate, noise, usable)
    bandwidth = min(bandwidth, 0.4 * rate)
    cutoff = min(_DERIVATIVE * bandwidth, 0.45 * rate)
    sos = butter(_ORDER, cutoff, fs=rate, output="sos")
    if from_speed:
        velocity = _low_passed(sos, _bridged(recorded, known))
        smooth = position
        spread = _in_band(noise, cutoff, rate)
    else:
        smooth = _low_passed(sos, position)
        velocity = np.gradient(smooth, 1.0 / rate)
        spread = _in_band(noise, cutoff, rate)
        told = _told(recorded, velocity, usable, rate, spread, machine, bandwidth, effort, cutoff)
        if told is not None:
            bandwidth, cutoff, spread = told
            sos = butter(_ORDER, cutoff, fs=rate, output="sos")
            smooth = _low_passed(sos, position)
            velocity = _low_passed(sos, recorded)
            notes.append(
                "speed is the recorded one: it says the same as the position, with less noise"
            )
    settle = max(3, round(_SETTLE * rate / bandwidth))
    ends = min(max(settle, round(_ENDS * rate / bandwidth)), grid.size // 20)
    usable[:ends] = usable[grid.size - ends :] = False
    return Motion(
        time_s=grid,
        position=smooth,
        velocity=velocity,
        acceleration=np.gradient(velocity, 1.0 / rate),
        raw_position=position,
        recorded_velocity=recorded,
        reference_position=take(f"reference_position_{'m' if linear else 'rad'}"),
        reference_velocity=take(f"reference_velocity_{'m' if linear else 'rad'}_per_s"),
        effort=effort,
        effort_unit=unit,
        effort_name=name,
        other_effort=_other(take, machine),
        mode=modes,
        usable=_eroded(usable, settle),
        rate_hz=rate,
        position_noise=noise,
        speed_noise=spread,
        standing=stood,
        bandwidth_hz=bandwidth,
        step=max(1, int(rate / (_SAMPLES_PER_PERIOD * bandwidth))),
        notes=tuple(notes),
        _sos=butter(_ORDER, bandwidth, fs=rate, output="sos"),
        _smoothing=sos,
    )


def _in_band(position_noise: float, cutoff: float, rate: float) -> float:
    """Standard deviation of the low-passed speed, from the position's noise.

    White noise of sigma, differentiated, up to the cutoff f_c: 2 pi sigma sqrt(2 f_c^3 / (3 f_s)).
    """
    return math.tau * position_noise * math.sqrt(2.0 * cutoff**3 / (3.0 * rate))


def _told(
    recorded: FloatArray,
    velocity: FloatArray,
    usable: BoolArray,
    rate: float,
    spread: float,
    machine: Machine,
    bandwidth: float,
    effort: FloatArray,
    cutoff: float,
) -> tuple[float, float, float] | None:
    """Bandwidth, cutoff and noise by the recorded speed; None where differences are as good.

    velocity: from differences of the position, with noise of `spread`. The recorded speed has to
    say the same within that noise, and to be clearly quieter.
    """
    if not usable.any() or not np.isfinite(recorded).all():
        return None
    own = position_noise(recorded, rate, usable)  # of any signal
    quiet = own * math.sqrt(min(2.0 * cutoff / rate, 1.0))
    sos = butter(_ORDER, cutoff, fs=rate, output="sos")
    apart = (_low_passed(sos, recorded) - velocity)[usable]
    size = float(np.std(velocity[usable]))
    if quiet > _QUIETER * spread or float(np.sqrt(np.mean(apart**2))) > 3.0 * spread + _LAG * size:
        return None
    if machine.bandwidth_hz is None:
        bandwidth = max(bandwidth, bandwidth_of(recorded, effort, rate, own, usable, order=1))
        bandwidth = min(bandwidth, 0.4 * rate)
        cutoff = min(_DERIVATIVE * bandwidth, 0.45 * rate)
    return bandwidth, cutoff, own * math.sqrt(min(2.0 * cutoff / rate, 1.0))


def _standing(effort: FloatArray, position: FloatArray, noise: float, rate: float) -> BoolArray:
    """Where the effort is the very same for long while the output moves: it was not measured.

    At its largest value it is a limit, and rightly the same. An effort of few levels stands often:
    then long is long beside its other rests.
    """
    size = float(np.max(np.abs(effort), initial=0.0))
    same = np.concatenate([[False], np.abs(np.diff(effort)) <= 1e-12 * max(size, 1e-300), [False]])
    bounds = np.flatnonzero(np.diff(same.astype(np.int8))).reshape(-1, 2)
    found = np.zeros(effort.size, dtype=bool)
    lengths = bounds[:, 1] - bounds[:, 0]
    usual = float(np.quantile(lengths, 0.9)) if lengths.size >= _RUNS else 1.0
    away = max(100.0 * noise, _MOVED * float(np.ptp(position)))
    for begin, end in bounds.tolist():
        part = slice(begin, end)
        long = end - begin >= max(_FROZEN_S * rate, _FROZEN, 3.0 * usual)
        limit = abs(effort[begin]) >= (1.0 - 1e-9) * size and size > 0.0
        if long and not limit and float(np.ptp(position[part])) > away:
            found[part] = True
    # An effort commanded in steps stands all the time: only one that else changes is not measured.
    changes = ~same[:-1][~found]
    return found if changes.size and float(np.mean(changes)) > _LIVELY else np.zeros_like(found)


def _grid(recording: Recording, source: str) -> tuple[FloatArray, float, list[str]]:
    if len(recording) < 64:
        raise InputError(f"{source}: {len(recording)} samples, expected at least 64")
    steps = np.diff(recording.time_s)
    typical = float(np.median(steps))
    # A mean over all but the longest pauses does not round as a median of stamps in ms does.
    rate = 1.0 / float(steps[steps < 3.0 * typical].mean())
    grid = np.arange(math.floor(recording.duration_s * rate + 1e-6) + 1) / rate
    notes = []
    uneven = float(np.mean(np.abs(steps * rate - 1.0) > _EVEN))
    if uneven > 0.0:
        notes.append(
            f"uneven stamps: {100.0 * uneven:.1f} % of the steps are off {1e3 / rate:.3g} ms by "
            f"more than {100.0 * _EVEN:.0f} %; everything was put on an even grid"
        )
    return grid, rate, notes


class _Taker:
    """Signals of a recording on an even grid."""

    def __init__(self, recording: Recording, grid: FloatArray, rate: float) -> None:
        self._recording, self._grid, self.rate_hz = recording, grid, rate

    def __call__(self, name: str) -> FloatArray:
        """Linear between samples; NaN where the nearest one is too far or unknown."""
        values = self._recording.signal(name)
        known = np.isfinite(values)
        known[known] = np.abs(values[known]) < _HUGE
        if known.sum() < 2:
            return np.full(self._grid.size, np.nan)
        times = self._recording.time_s[known]
        made = np.interp(self._grid, times, values[known], left=np.nan, right=np.nan)
        after = np.clip(np.searchsorted(times, self._grid), 1, times.size - 1)
        made[times[after] - times[after - 1] > (_LONGEST_GAP + 1.5) / self.rate_hz] = np.nan
        return made

    def held(self, name: str) -> FloatArray:
        """The last value at or before each instant: for what switches."""
        values = self._recording.signal(name)
        known = np.isfinite(values)
        if not known.any():
            return np.full(self._grid.size, np.nan)
        times = self._recording.time_s[known]
        last = np.searchsorted(times, self._grid + 1e-9, side="right") - 1
        return np.where(last >= 0, values[known][np.maximum(last, 0)], np.nan)


def _effort(take: _Taker, machine: Machine, notes: list[str]) -> tuple[FloatArray, str, str]:
    own = "N" if machine.linear else "N m"
    kind = machine.actuation
    if kind == "loop":
        return loop_effort(take, machine), own if machine.gain else "1", "effort"
    if kind is None:
        order = ("force", "torque", "current", "voltage")
        if not machine.linear:
            order = ("torque", "current", "voltage", "force")
        found = [one for one in order if np.isfinite(take(EFFORTS[one][0])).any()]
        if not found:
            return np.full_like(take("mode"), np.nan), own, "effort"
        kind = found[0]
    field_name, unit = EFFORTS[kind]
    values = take(field_name)
    gain = machine.gain
    if gain is None and unit == own:
        gain = 1.0
    if gain is None:
        return values, unit, kind
    if not np.isfinite(values).any():
        notes.append(f"no {kind} recorded")
    return gain * values, own, "force" if machine.linear else "torque"


def _other(take: _Taker, machine: Machine) -> FloatArray:
    nothing = np.full_like(take("mode"), np.nan)
    if not machine.loop_known:
        return nothing
    if machine.actuation != "loop":
        return loop_effort(take, machine)
    own = "force" if machine.linear else "torque"
    for kind, factor in ((own, 1.0), ("current", machine.gain), ("voltage", machine.gain)):
        values = take(EFFORTS[kind][0])
        if np.isfinite(values).any():
            return (factor or 1.0) * values
    return nothing


def loop_effort(take: _Taker, machine: Machine) -> FloatArray:
    """What the file's controller asks for, from the recorded reference and motion; see `loop`."""
    end = "m" if machine.linear else "rad"
    return asked_along(
        machine,
        take(f"reference_position_{end}"),
        take(f"reference_velocity_{end}_per_s"),
        take("rod_position_m" if machine.linear else "rotor_position_rad"),
        take("rod_velocity_m_per_s" if machine.linear else "rotor_velocity_rad_per_s"),
        take.rate_hz,
    )


def _bridged(values: FloatArray, known: BoolArray) -> FloatArray:
    index = np.arange(values.size)
    return np.interp(index, index[known], values[known])


def _wide(known: BoolArray, rate: float) -> BoolArray:
    """False only where more than a few samples in a row are missing."""
    return ~_eroded(~known, _LONGEST_GAP // 2 + 1, outside=False) | known


def _eroded(mask: BoolArray, by: int, outside: bool = True) -> BoolArray:
    """True where all samples within `by` are; beyond the ends counts as False if `outside`."""
    padded = np.concatenate([np.full(by, not outside), mask, np.full(by, not outside)])
    summed = np.concatenate([[0], np.cumsum(~padded)])
    width = 2 * by + 1
    clear: BoolArray = summed[width:] - summed[:-width] == 0
    return clear


def _jumps(position: FloatArray, usable: BoolArray) -> BoolArray:
    """Samples beside a second difference far beyond all others of the recording."""
    bend = np.zeros(position.size)
    bend[1:-1] = np.abs(np.diff(position, 2))
    limit = _JUMP * float(np.quantile(bend[usable], _MOST_BENT)) if usable.any() else 0.0
    beyond = bend > (limit if limit > 0.0 else math.inf)
    return ~_eroded(~beyond, 2, outside=False) if beyond.any() else beyond


def _low_passed(sos: NDArray[np.float64], values: FloatArray) -> FloatArray:
    """Zero-phase; the straight line through the ends is set aside, so that turns add no step."""
    line = np.linspace(values[0], values[-1], values.size)
    made: FloatArray = sosfiltfilt(sos, values - line) + line
    return made


def _spectrum(values: FloatArray, rate: float) -> tuple[FloatArray, FloatArray]:
    segment = int(min(values.size, max(256, 4.0 * rate)))
    frequency, density = welch(values, rate, nperseg=segment, detrend="constant")
    return frequency, density


def _second_difference(rate: float, frequency: FloatArray) -> FloatArray:
    """Squared gain of the second difference over time."""
    gain: FloatArray = (2.0 * np.sin(np.pi * frequency / rate)) ** 4 * rate**4
    return gain


def position_noise(position: FloatArray, rate: float, usable: BoolArray) -> float:
    """Standard deviation of the position's white noise, from the top of its spectrum.

    Not below what the smallest step between recorded values makes as rounding.
    """
    second = np.diff(position[usable], 2) * rate**2
    frequency, density = _spectrum(second, rate)
    top = frequency > 0.35 * rate
    white = float(np.median(density[top] / _second_difference(rate, frequency[top])))
    steps = np.abs(np.diff(position[usable]))
    smallest = float(np.min(steps[steps > 1e-12 * max(np.ptp(position), 1e-300)], initial=np.inf))
    crowd = float(np.mean((steps > 0.5 * smallest) & (steps < 1.5 * smallest) | (steps == 0.0)))
    rounding = smallest / math.sqrt(12.0) if crowd > 0.2 and math.isfinite(smallest) else 0.0
    return max(math.sqrt(max(white, 0.0) * rate / 2.0), rounding, 1e-12)


def bandwidth_of(
    position: FloatArray,
    effort: FloatArray,
    rate: float,
    noise: float,
    usable: BoolArray,
    order: int = 2,
) -> float:
    """Hz up to which effort and acceleration both say more than their noise.

    The frequency that holds 99.7 % of the effort's power (of the acceleration's, where there is no
    effort), or that which leaves 1500 samples to compare, if it is higher; unless noise of the
    position would by then be more than a twentieth of the acceleration's power; never above a fifth
    of the sampling rate. order: of the difference that makes `position` an acceleration; 1 where
    it is a speed, and `noise` is of it.
    """
    second = np.diff(position[usable], order) * rate**order
    frequency, density = _spectrum(second, rate)
    shape = _second_difference(rate, frequency) ** (0.5 * order)
    rough = 2.0 * noise**2 / rate * shape
    signal = np.cumsum(np.maximum(density - rough, 0.0))
    quiet = np.cumsum(rough) <= _NOISE * np.maximum(signal, 1e-300)
    quiet[: max(2, int(2.0 / frequency[1]))] = True
    limit = float(frequency[np.flatnonzero(quiet)[-1]])
    if np.isfinite(effort).all() and float(np.ptp(effort)) > 0.0:
        frequency, density = _spectrum(effort[usable] - effort[usable].mean(), rate)
        density = np.maximum(density - np.median(density[frequency > 0.4 * rate]), 0.0)
        held = np.cumsum(density)
    else:
        held = signal
    reach = float(frequency[int(np.searchsorted(held, _POWER * held[-1]))])
    reach = max(reach, _LEAST_SAMPLES / (_SAMPLES_PER_PERIOD * usable.sum() / rate))
    return max(min(reach, limit, _HIGHEST * rate), 4.0 * frequency[1])
