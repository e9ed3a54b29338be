"""A recording as motion and effort on one even grid, and the band in which the two can be compared.

As in the inverse dynamic identification method (Gautier, "Dynamic identification of robots with
power model", 1997; Janot, Vandanjon, Gautier, 2014): position is low-passed forwards and backwards,
without shift of phase, before splines through it give speed and acceleration; effort and every
column that is compared with it then pass one and the same low-pass ("parallel filter") and are
decimated to what that leaves of information.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.signal import butter, sosfiltfilt

from ...arrays import FloatArray
from ...drive.rigid.course import Course
from ...drive.rigid.loop import asked_along
from ...drive.rigid.machine import EFFORTS, Machine
from ...drive.rigid.units import own_effort
from ...errors import InputError
from ...number_of import number_of
from ...recording.map import in_map
from ...recording.runs import runs_of
from ...recording.signals import FOREIGN_SIGNALS, SIGNALS, Recording
from .band import (
    DERIVATIVE,
    ORDER,
    SAMPLES_PER_PERIOD,
    bandwidth_of,
    low_passed,
    position_noise,
    rounding_of,
    slope,
    speed_noise_of,
    told_by_speed,
)
from .decimated import decimated
from .frozen import without_repeats
from .grid import Taker, bridged, carried_on, eroded, even_grid, jumped, standing_effort, wide
from .other_motion import told_beside, unused_motion
from .refreshed import at_new_motion, new_rows

_SETTLE = 1.0  # periods of the bandwidth's frequency left out at gaps
_ENDS = 4.0  # the same at the ends, beyond which the low-passes have to guess how it moved
# Periods of its slowest corner that the parallel filter answers a sample for, and the share of its
# largest answer below which it is left out.
_REMEMBERED, _INAUDIBLE = 10.0, 1e-8
_WHOLE = 1e-6  # of a sample: so near to one, a shift needs nothing between samples


@dataclass(frozen=True, eq=False, kw_only=True)
class Motion(Course):
    """What a recording holds of a rigid drive, evenly sampled; float64[n] in SI of the output.

    Attributes:
        effort_unit: N, N m where the drive file's gain is known or not needed, else that of the
            recorded signal. effort_name: what to call it.
        other_effort: what the file's controller asks for where `effort` was recorded, and what was
            recorded where `effort` is what it asks for; NaN throughout where one of them is not
            known.
        mode: NaN where not recorded.
        position_noise: standard deviation of the position's noise. rounding: of that, what
            rounding to counts makes.
        by_speed: whether speed and acceleration come from the recorded speed.
        standing: share of the motion over which the effort stood still, as it can not.
        bandwidth_hz: of the comparison; `position` is low-passed at 2.5 times that. step: samples
            of the grid per compared sample.
        weight_hz: where noise of the acceleration overtakes all other; what is compared is weighed
            down beyond, so that what is left is white.
        refreshed_s: how often the effort is new, where that is more seldom than it was logged; 0
            else.
        notes: what was found lacking. caution: what has to be put right before anything else.
    """

    effort_unit: str
    effort_name: str
    other_effort: FloatArray
    mode: FloatArray
    position_noise: float
    rounding: float
    by_speed: bool
    standing: float
    bandwidth_hz: float
    step: int
    weight_hz: float = math.inf
    refreshed_s: float = 0.0
    notes: tuple[str, ...] = ()
    caution: str = ""
    _sos: FloatArray = field(default_factory=lambda: np.zeros((0, 6)))
    _smoothing: FloatArray = field(default_factory=lambda: np.zeros((0, 6)))

    @property
    def rows(self) -> NDArray[np.int64]:
        """int64[m], the samples of the grid that are compared."""
        return np.concatenate(
            [np.arange(one.start + self.step // 2, one.stop, self.step) for one in self.parts]
        )

    @property
    def recording(self) -> NDArray[np.int64]:
        """int64[m], the number of the recording that a compared sample is of, from 0."""
        begins = [part.start for part in self.parts]
        return np.searchsorted(begins, self.rows, side="right") - 1

    def quiet(self, values: FloatArray) -> FloatArray:
        """See `Course`: low-passed where noise overtakes."""
        if not self.weight_hz < 0.45 * self.rate_hz:
            return values
        sos = butter(ORDER, self.weight_hz, fs=self.rate_hz, output="sos")
        return np.concatenate([low_passed(sos, values[one]) for one in self.parts])

    @property
    def corner_hz(self) -> float:
        """The lower corner of the parallel filter: of its band, or of its weight."""
        return min(self.bandwidth_hz, self.weight_hz)

    @property
    def counted(self) -> FloatArray | float:
        """By what compared efforts were divided, float64[m] or one for all."""
        return 1.0

    def in_band(self, columns: FloatArray) -> FloatArray:
        """Columns float64[..., n] through the parallel filter, at `rows`: float64[..., m]."""
        every = [decimated(columns[..., one], self._response, self.step) for one in self.parts]
        return np.concatenate(every, axis=-1)

    def filtered(self, columns: FloatArray) -> FloatArray:
        """The same of efforts, as they are compared: each recording's in its own noise."""
        return self.in_band(columns)

    def shifted(self, values: FloatArray, later_s: FloatArray) -> FloatArray:
        """float64[n] through the parallel filter, later by each of float64[k]: float64[k, m].

        Between samples along a cubic spline, beyond the ends the last one.
        """
        made = self._parallel(values)
        at = np.clip(self.rows - np.asarray(later_s)[:, None] * self.rate_hz, 0.0, made.size - 1.0)
        whole = np.rint(at)
        if np.abs(at - whole).max() < _WHOLE:
            found: FloatArray = made[whole.astype(np.int64)]
        else:
            found = CubicSpline(np.arange(made.size), made)(at)
        return found

    def smoothed(self, values: FloatArray) -> FloatArray:
        """float64[n] through the low-pass that `position` and `velocity` have passed."""
        return low_passed(self._smoothing, values)

    def gain(self, frequency_hz: FloatArray) -> FloatArray:
        """Of the parallel filter at frequencies, float64[k]."""
        made: FloatArray = 1.0 / (1.0 + (frequency_hz / self.bandwidth_hz) ** (2 * ORDER))
        return made / (1.0 + (frequency_hz / self.weight_hz) ** 2)

    @cached_property
    def _response(self) -> FloatArray:
        """What the parallel filter makes of one sample of 1, float64[2 m + 1]."""
        side = math.ceil(_REMEMBERED * self.rate_hz / self.corner_hz)
        alone = np.zeros(2 * side + 1)
        alone[side] = 1.0
        made = self._parallel(alone)
        heard = np.flatnonzero(np.abs(made) > _INAUDIBLE * np.abs(made).max())
        most = max(side - int(heard[0]), int(heard[-1]) - side)
        return made[side - most : side + most + 1]

    def _parallel(self, values: FloatArray) -> FloatArray:
        """Samples of one recording, float64[..., n], through the parallel filter."""
        pad = min(values.shape[-1] - 1, int(3 * self.rate_hz / self.bandwidth_hz))
        made: FloatArray = sosfiltfilt(self._sos, values, axis=-1, padlen=pad)
        if self.weight_hz < 0.45 * self.rate_hz:
            weigh = _weight(self.weight_hz, self.rate_hz)
            made = sosfiltfilt(weigh, made, axis=-1, padlen=pad)
        return made


# By whether the output is straight: fields of its position, and kinds of effort, the first recorded
# of which counts where the file names none.
PLACES = {True: ("rod_position_m",), False: ("rotor_position_rad", "load_position_rad")}
BY_DEFAULT = {
    True: ("force", "torque", "current", "voltage"),
    False: ("torque", "current", "voltage", "force"),
}


@lru_cache(maxsize=32)
def _weight(cutoff_hz: float, rate_hz: float) -> FloatArray:
    """The low-pass that compared efforts are weighed with; it is asked for at every column."""
    sos: FloatArray = butter(1, cutoff_hz, fs=rate_hz, output="sos")
    return sos


def motion_of(
    recording: Recording,
    machine: Machine,
    source: str,
    mode: float | None = None,
    rate_hz: float | None = None,
    times: float = 1.0,
) -> Motion:
    """The motion and effort that a recording holds of `machine`.

    mode: only where the recorded mode has this value. rate_hz: of the grid, for a recording that is
    to go with slower ones; its own unless given. times: as long as this are all that go together.

    Raises:
        InputError: no position or speed of the output, too few samples, or no sample of the mode.
    """
    said: list[str] = []
    if not machine.loop_known:
        recording, said = at_new_motion(recording)
    recording, refreshed_s = _at_new_efforts(recording, machine)
    grid, rate, notes = even_grid(recording, source, rate_hz)
    notes += said
    if refreshed_s:
        notes.append(
            f"the effort is new only every {1e3 * refreshed_s:.3g} ms, and old in the rows "
            "between: these are left out; log it as often as the position"
        )
    recording, frozen = without_repeats(recording)
    if frozen:
        shown = ", ".join(f"{begin:.3f} to {end:.3f} s" for begin, end in frozen[:4])
        more = f" and {len(frozen) - 4} more times" if len(frozen) > 4 else ""
        notes.append(f"the logger repeats one sample from {shown}{more}: left out")
    notes += unused_motion(recording, machine)
    take = Taker(recording, grid, rate)
    linear = machine.linear
    places = [take(one) for one in PLACES[linear]]
    position = next((one for one in places if np.isfinite(one).any()), places[-1])
    recorded = take("rod_velocity_m_per_s" if linear else "rotor_velocity_rad_per_s")
    if not linear and not np.isfinite(recorded).any():
        recorded = take("load_velocity_rad_per_s")
    known = np.isfinite(position)
    from_speed = not known.any()
    if from_speed and not np.isfinite(recorded).any():
        wanted = "rod_position_m" if linear else "rotor_position_rad"
        names = (name for name in (*SIGNALS, *FOREIGN_SIGNALS) if recording.has(name))
        held = ", ".join(in_map(name) for name in names)
        raise InputError(
            f"{source}: {in_map(wanted)} is missing; expected the position of the "
            f"{machine.output} output (recorded: {held or 'nothing'})"
        )
    if from_speed:
        known = np.isfinite(recorded)
        speed = bridged(recorded, known)
        position = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1])) / rate])
        notes.append("no position recorded: it was integrated from speed, its start is unknown")
    effort, unit, name = _effort(take, machine, notes)
    injected = _injected(take, unit, linear, notes)
    effort = effort + injected
    modes = take.held("mode")
    position = bridged(position, known)
    usable = wide(known, rate)
    with_effort = np.isfinite(effort)
    if with_effort.any():
        usable &= wide(with_effort, rate)
        effort = bridged(effort, with_effort)
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
        standing = standing_effort(effort, position, noise, rate) & usable
        if standing.any() and not standing[usable].all():
            steps = np.abs(np.diff(position, prepend=position[0]))
            stood = float(steps[standing].sum() / max(steps[usable].sum(), 1e-300))
            usable &= ~standing
            notes.append(
                f"the effort is constant for {standing.sum() / rate:.3g} s while the output "
                "moves: nothing was measured, or something else drives it; left out"
            )
    jumps = jumped(position, usable)
    if jumps.any():
        usable &= ~jumps
        position = bridged(position, ~jumps)
        notes.append(
            f"left out: {number_of(len(runs_of(jumps)), 'jump')} of the position, far larger than "
            "any motion around (a late stamp, a slipped count)"
        )
    noise = machine.position_noise
    if noise is None:
        noise = position_noise(position, rate, usable)
    rounding = stated_resolution(recording, machine) / math.sqrt(12.0)
    noise = max(noise, rounding)
    bandwidth = machine.bandwidth_hz
    if bandwidth is None:
        bandwidth = bandwidth_of(position, effort, rate, noise, usable, times=times)
    bandwidth = min(bandwidth, 0.4 * rate)
    cutoff = min(DERIVATIVE * bandwidth, 0.45 * rate)
    sos = butter(ORDER, cutoff, fs=rate, output="sos")
    by_speed, caution = from_speed, ""
    if from_speed:
        velocity = low_passed(sos, bridged(recorded, known))
        smooth = position
        spread = speed_noise_of(noise, cutoff, rate)
    else:
        position = carried_on(position, known & ~jumps, settling(rate, bandwidth))
        smooth = low_passed(sos, position)
        velocity = slope(smooth, rate)
        spread = speed_noise_of(noise, cutoff, rate)
        measured = np.isfinite(recorded)
        seen = usable & wide(measured, rate)
        complete = bool(measured.any()) and np.array_equal(seen, usable)
        filled = bridged(recorded, measured) if measured.any() else recorded
        told = None
        beside = told_beside(filled, position, seen, rate)
        caution = beside.caution
        if beside.note:
            notes.append(beside.note)
        if complete and beside.agrees:
            # Where filters have forgotten what was bridged.
            calm = eroded(usable, settling(rate, bandwidth))
            told = told_by_speed(
                filled, velocity, calm, rate, spread, machine, bandwidth, effort, cutoff, times
            )
        by_speed = told is not None
        if told is not None:
            bandwidth, cutoff, spread = told
            sos = butter(ORDER, cutoff, fs=rate, output="sos")
            smooth = low_passed(sos, position)
            velocity = low_passed(sos, filled)
            notes.append(
                "the recorded speed is used: it agrees with the position and has less noise"
            )
    settle = settling(rate, bandwidth)
    ends = min(max(settle, round(_ENDS * rate / bandwidth)), grid.size // 20)
    usable[:ends] = usable[grid.size - ends :] = False
    return Motion(
        time_s=grid,
        position=smooth,
        velocity=velocity,
        acceleration=slope(velocity, rate),
        raw_position=position,
        recorded_velocity=recorded,
        reference_position=take(f"reference_position_{'m' if linear else 'rad'}"),
        reference_velocity=take(f"reference_velocity_{'m' if linear else 'rad'}_per_s"),
        effort=effort,
        injected=injected,
        effort_unit=unit,
        effort_name=name,
        other_effort=_other(take, machine),
        mode=modes,
        usable=eroded(usable, settle),
        rate_hz=rate,
        position_noise=noise,
        rounding=rounding or rounding_of(position, usable),
        by_speed=by_speed,
        speed_noise=spread,
        standing=stood,
        bandwidth_hz=bandwidth,
        step=max(1, int(rate / (SAMPLES_PER_PERIOD * bandwidth))),
        refreshed_s=refreshed_s,
        notes=tuple(notes),
        caution=caution,
        _sos=butter(ORDER, bandwidth, fs=rate, output="sos"),
        _smoothing=sos,
    )


def _at_new_efforts(recording: Recording, machine: Machine) -> tuple[Recording, float]:
    """The recording at the rows where its effort is new, and how often that is, s; 0: always."""
    if machine.actuation == "loop":  # worked out at each sample
        return recording, 0.0
    place = _place(recording, machine)
    kinds = (machine.actuation,) if machine.actuation else BY_DEFAULT[machine.linear]
    name = next((EFFORTS[one][0] for one in kinds if recording.has(EFFORTS[one][0])), None)
    if place is None or name is None:
        return recording, 0.0
    rows = new_rows(recording.signal(name), recording.signal(place))
    if rows is None:
        return recording, 0.0
    return recording.at(rows), float(np.median(np.diff(recording.time_s[rows])))


def stated_resolution(recording: Recording, machine: Machine) -> float:
    """Step of the position as the drive file or else the map has it; 0 where neither says."""
    place = _place(recording, machine)
    return machine.position_resolution or recording.resolution.get(place or "", 0.0)


def _place(recording: Recording, machine: Machine) -> str | None:
    """The position of the output by the name that was recorded."""
    return next((one for one in PLACES[machine.linear] if recording.has(one)), None)


def settling(rate_hz: float, bandwidth_hz: float) -> int:
    """Samples on either side of a gap that are left out, for the filter reaches as far."""
    return max(3, round(_SETTLE * rate_hz / bandwidth_hz))


def _effort(take: Taker, machine: Machine, notes: list[str]) -> tuple[FloatArray, str, str]:
    own = own_effort(machine.linear)
    kind = machine.actuation
    if kind == "loop":
        return loop_effort(take, machine), own if machine.gain else "1", "effort"
    if kind is None:
        found = [
            one for one in BY_DEFAULT[machine.linear] if np.isfinite(take(EFFORTS[one][0])).any()
        ]
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


def _injected(take: Taker, unit: str, linear: bool, notes: list[str]) -> FloatArray:
    """What was put on the output from outside and is known, float64[n]; it drives it, too."""
    values = take(f"injected_{'force_n' if linear else 'torque_nm'}")
    known = np.isfinite(values)
    if known.any() and unit != own_effort(linear):
        notes.append(
            f"an injected {'force' if linear else 'torque'} was recorded, but without "
            f"actuation.gain it cannot be added to an effort in {unit}: left out"
        )
        known[:] = False
    return np.where(known, values, 0.0)


def _other(take: Taker, machine: Machine) -> FloatArray:
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


def loop_effort(take: Taker, machine: Machine) -> FloatArray:
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
