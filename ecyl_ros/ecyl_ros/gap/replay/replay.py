"""The recorded run once more, on the nominal drive with a set of effects: what all fits compare."""

from __future__ import annotations

import copy
import dataclasses
import math
import threading
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...arrays import BoolArray, FloatArray
from ...drive.cascade import initial_cascade_state
from ...drive.engine import COLUMNS, MEASUREMENT, VOLTAGE, run_ticks
from ...drive.law import Law
from ...drive.packed import choose_substeps, pack
from ...drive.parameters import DriveParameters
from ...drive.plant import MEASURED, voltage_queue
from ...drive.tolerances import with_constants
from ...effects.catalogue import CATALOGUE
from ...recording.signals import Recording
from ..split import held_out_of
from .d_axis import follows, has_d_loop
from .first_state import first_state, place_unsure, resting
from .grid import Grid
from .held import held_ticks, run_holding
from .injected import injected
from .pushed import pushed_at, run_pushed
from .screen import screen
from .sensor_noise import (
    declared_noise,
    first_floors,
    settled_floors,
    silent,
    with_noise,
    with_steps,
)

Effects = Mapping[str, Mapping[str, float]]
Constants = Mapping[str, float]
NOMINAL: Constants = {}  # no constant off its nominal value


@dataclass(frozen=True)
class Signal:
    """One signal that recording and replay are compared in.

    name: as the diagnosis calls it. unit: SI. recorded: the `Recording` field. column: of the
    engine's samples.
    """

    name: str
    unit: str
    recorded: str
    column: int


def _measured(name: str) -> int:
    return MEASUREMENT + MEASURED.index(name)


SIGNALS = (
    Signal("rotor_position", "rad", "rotor_position_rad", _measured("rotor_position_rad")),
    Signal(
        "rotor_velocity", "rad/s", "rotor_velocity_rad_per_s", _measured("rotor_velocity_rad_per_s")
    ),
    Signal("current_q", "A", "current_q_a", _measured("current_q_a")),
    Signal("voltage_q", "V", "voltage_q_v", VOLTAGE + 1),
    Signal("rod_position", "m", "rod_position_m", _measured("rod_position_m")),
)

# A step of the replay's integrator times the drive's fastest rate: its error stays far below the
# noise floor, and it takes half the time of the emulator's own.
_REPLAY_RATE_STEP = 0.45
# Sub-steps per tick, those of the nominal drive so many times or this many: what a fit wanders to
# beyond is no drive. A law's steepest place may ask for more, and is integrated with these.
_STIFFER, _MOST_SUBSTEPS = 4, 40

_TICK_COST = 1  # of a control tick beside its sub-steps, in such
_STIFF_COST = 4  # of a sub-step in which the current goes ahead, in such as have none
# Share of the stated noise in the loop from which on its way round is reckoned with. What a load
# that sticks creeps by grows with its square: with a tenth it is some floors, with this below one.
_LOUD = 0.03
_NEXT_DRAW = 7919  # from the seed of one draw to the next: unlike those of other drives
_SHAKING_SEED = 0x5EED  # unlike those that drives are emulated with
_SETTLING_S = 0.3  # left out where the run does not begin at rest, or a long gap ends
_LONG_GAP_S = 0.02  # a gap the loop notices when the reference is filled in by a spline


class Replay:
    """Replays a recording's reference through the drive's model and compares.

    Attributes:
        drive: the nominal model, free of noise.
        signals: those that the recording holds, in the order of `SIGNALS`.
        recorded: float64[signals, n], NaN where nothing was measured.
        floor: float64[signals], standard deviation of the measurement noise, in SI units.
        healthy: float64[signals, n], in floors: what a perfect model would leave (one draw): noise,
            and what noise does round the loop, where it moves the instants at which flanks meet.
        source: what messages call the recording.
        loop_share: share of the stated noise that goes round the loop, as the command shows it.
        time_s: float64[n], from the recording's first stamp.
        usable: bool[n], False while the replay settles (not at rest at the start, long gaps).
        notes: what could not be used, one line each.

    Raises:
        InputError: no reference to replay, no signal to compare with, or too little of either.
    """

    _holds_i_d = False  # by a loop of its own, so that the axes do not couple

    def __init__(self, recording: Recording, drive: DriveParameters, source: str) -> None:
        self.source = source
        self._tally, self._counting = [0, 0], threading.Lock()
        recording, notes = screen(recording, drive, source)
        drive = with_steps(drive, recording)
        self.recording = recording
        self.nominal = drive
        self.drive = silent(drive)
        self.notes = notes
        self.time_s = np.asarray(recording.time_s)
        self.signals = tuple(one for one in SIGNALS if recording.has(one.recorded))
        missing = [one.name for one in SIGNALS if one not in self.signals]
        if missing:
            self.notes.append(f"not recorded, so not judged: {', '.join(missing)}")
        self._injected = injected(recording, drive)
        if self._injected is not None:
            self.notes.append("the recorded injected force or torque acts in the replay, too")
        self.recorded = np.array([recording.signal(one.recorded) for one in self.signals])
        # Voltage noise that the cascade makes of noise in what it measures.
        self.proportional_noise_v = max(declared_noise(drive)["voltage_q"], 1e-12)
        self._grid = Grid.under(self.time_s, recording.rate_hz, self.drive.controller.rate)
        self._reference = self._grid.reference(recording)
        self._left_out = held_ticks(recording, self._grid, drive)
        if len(self._left_out):
            self.notes.append(
                f"the controller left out {len(self._left_out)} of {self._grid.ticks} ticks (it "
                "held the voltage, to the last digit): the replay leaves them out, too"
            )
        self.usable = np.ones(len(self.time_s), dtype=bool)
        self._leave_out_gaps()
        names = [one.name for one in self.signals]
        self.floor = first_floors(names, self.recorded, drive)
        # How much of the stated noise goes round the loop; all of it unless the command says less.
        self.loop_share = 1.0
        self._shaking: tuple[DriveParameters, FloatArray] | None = None
        self._find_start()
        self._holds_i_d = self._shows_no_i_d()
        left = self.recorded - self.simulate({})
        self.floor, self.loop_share = settled_floors(names, self.recorded, left, drive)
        self._leave_out_start()
        self.healthy = self.healthy_with({})

    def _leave_out_gaps(self) -> None:
        """Mark as not usable what follows a stretch without samples, until the loops settle."""
        noticed = max(_LONG_GAP_S, 3.0 * self._grid.step_s)
        time = self.time_s[np.isfinite(self.recording.reference_position_m)]
        for end in time[1:][np.diff(time) > noticed]:
            self.usable &= (self.time_s < end - 1e-9) | (self.time_s > end + _SETTLING_S)
        lost = float(np.diff(self.time_s).max())
        if lost > noticed:
            self.notes.append(f"samples missing for up to {lost:.3f} s")

    def _find_start(self) -> None:
        """Plant and cascade state at the first sample: at rest unless the recording says not."""
        names = [one.name for one in self.signals]
        first = dict(zip(names, self.recorded[:, 0].tolist(), strict=True))
        floors = dict(zip(names, self.floor.tolist(), strict=True))
        recorded = dict(zip(names, self.recorded, strict=True))
        rests = resting(self.reference_m, recorded, floors)
        if math.isfinite(first.get("rod_position", math.nan)):
            first["rod_position"] = float(np.mean(recorded["rod_position"][:rests]))
        wanted = float(self._reference[0, 0]), float(self._reference[0, 1])
        self._plant, integrals = first_state(self.nominal, wanted, first, floors, rests)
        told = {name: floor for name, floor in floors.items() if math.isfinite(first[name])}
        self._unsure = 0.0 if integrals is not None else place_unsure(self.nominal, told, rests)
        self._integrals = np.zeros(3) if integrals is None else integrals
        if integrals is not None:
            self.usable &= self.time_s > _SETTLING_S
            self.notes.append(f"does not begin at rest: the first {_SETTLING_S:g} s are not judged")

    def _leave_out_start(self) -> None:
        """Mark as not usable what hangs on where in its clearance the load begins.

        That is known as well as the rod's scale tells it, or not at all; the first impact comes
        earlier or later by it, and shows it by many floors. What two standard deviations of it,
        either way, change by more than the noise is not judged.
        """
        half = 0.5 * self.drive.transmission.backlash
        middle, place = self._plant[0], self._plant[2]
        if min(half, self._unsure) <= 0.0:
            return
        ends = []
        for off in (-self._unsure, self._unsure):
            self._plant[2] = min(max(place + 2.0 * off, middle - half), middle + half)
            ends.append(self.simulate({}))
        self._plant[2] = place
        apart = 0.5 * np.abs(ends[1] - ends[0]) / self.floor[:, None]
        shows = np.flatnonzero((apart > 1.0).any(axis=0))
        if len(shows):
            begin = float(self.time_s[shows[0]])
            last = shows[self.time_s[shows] <= begin + _SETTLING_S][-1]
            self.usable[shows[0] : last + 1] = False

    @property
    def runs(self) -> int:
        """How many times the drive was simulated so far, copies of this replay included."""
        return self._tally[0]

    @property
    def work(self) -> int:
        """What all `runs` cost: their sub-steps, the rest of a tick counted as some more."""
        return self._tally[1]

    def complete(self, effects: Effects, constants: Constants) -> dict[str, dict[str, float]]:
        """Effects with all the parameters that a fit to this recording has.

        constants: beside which they act.
        """
        return {name: CATALOGUE[name].complete(given) for name, given in effects.items()}

    def held_out(self) -> BoolArray:
        """bool[n], stretches that no parameter is to be fitted to."""
        return self.held_out_by(self.gap({}))

    def held_out_by(self, gap: FloatArray) -> BoolArray:
        """The same, for what is left to be explained: a gap, float64[signals, n], in floors."""
        return held_out_of(self.time_s, gap, self.usable)

    @property
    def step_s(self) -> float:
        """Time between two samples of the recording, the median."""
        return float(np.median(np.diff(self.time_s)))

    @property
    def parts(self) -> tuple[Replay, ...]:
        """One replay for each recording: this one."""
        return (self,)

    @property
    def spans(self) -> tuple[slice, ...]:
        """Where the samples of each of `parts` are."""
        return (slice(0, len(self.time_s)),)

    def at(self, constants: Constants) -> Replay:
        """The same recording with other constants taken for nominal, as a fit has found them.

        The controller goes on believing in those of the drive file.
        """
        other = copy.copy(self)
        other.drive = with_constants(self.drive, constants)
        if self._shaking is not None:
            drive, alone = self._shaking
            other._shaking = with_constants(drive, constants), alone
        return other

    def playing(self, law: Law | None) -> Replay:
        """The same recording, replayed with a law in the drive."""
        other = copy.copy(self)
        other.drive = dataclasses.replace(self.drive, learned=law)
        return other

    def until(self, end_s: float) -> Replay:
        """The same recording up to `end_s`, for a look that needs no more: it costs less."""
        kept = int(np.searchsorted(self.time_s, end_s, side="right"))
        other = self._with(np.arange(kept))
        other._grid = other._grid.ended()
        return other

    def thinned(self, rate_hz: float) -> Replay:
        """The same recording, compared at the samples nearest to those of a lower rate."""
        wanted = np.arange(0.0, float(self.time_s[-1]) + 0.5 / rate_hz, 1.0 / rate_hz)
        after = np.clip(np.searchsorted(self.time_s, wanted), 1, len(self.time_s) - 1)
        before = wanted - self.time_s[after - 1] < self.time_s[after] - wanted
        return self._with(np.unique(after - before))

    def _with(self, rows: NDArray[np.int64]) -> Replay:
        """The same recording, compared at some of its samples."""
        other = copy.copy(self)
        for name in ("time_s", "usable"):
            setattr(other, name, getattr(self, name)[rows])
        for name in ("recorded", "healthy"):
            setattr(other, name, getattr(self, name)[:, rows])
        other._grid = self._grid.of(rows)
        if self._shaking is not None:
            drive, alone = self._shaking
            other._shaking = drive, alone[:, rows]
        return other

    @property
    def reference_m(self) -> FloatArray:
        """float64[n], the rod position asked for at the recording's samples."""
        return self._grid.on_stamps(self._reference[:-1, :1])[0]

    def _shows_no_i_d(self) -> bool:
        """Whether the drive holds i_d at 0 by a loop of its own; see `d_axis`."""
        if not np.nan_to_num(self.recording.current_d_a).any():
            return True
        looped = has_d_loop(self.recording, self.nominal)
        if looped is None:
            left = self._grid.on_stamps(self.run({}))[_measured("current_d_a")]
            looped = not follows(self.recording.current_d_a, left, self.usable)
        return looped

    @cached_property
    def _most_substeps(self) -> int:
        return max(_MOST_SUBSTEPS, _STIFFER * choose_substeps(self.nominal, _REPLAY_RATE_STEP))

    def packed(self, effects: Effects, drive: DriveParameters | None = None) -> NDArray[np.void]:
        """The packed record of the drive with `effects` added to those of the drive file.

        drive: in place of the nominal model free of noise; the controller goes on believing in the
        nominal one.
        """
        base = drive or self.drive
        drive = dataclasses.replace(base, effects={**base.effects, **effects})
        record = pack(drive, rate_step=_REPLAY_RATE_STEP, believed=self.nominal)
        if drive.learned is not None:
            record["substeps"] = np.minimum(record["substeps"], self._most_substeps)
        if self._holds_i_d:
            record["pole_pairs"] = 0.0
        return record

    def run(
        self,
        effects: Effects,
        drive: DriveParameters | None = None,
        torque: FloatArray | None = None,
    ) -> FloatArray:
        """All the engine's columns at the grid of the replay, float64[grid, COLUMNS].

        NaN of a drive so stiff that no recording can be of it: it would take forever, and its loop
        mostly runs away. torque: float64[2, n] at the recording's stamps, N m from outside on rotor
        and load, beside what was injected.
        """
        params = self.packed(effects, drive)
        if params[0]["substeps"] > self._most_substeps:
            return np.full((self._grid.samples, COLUMNS), np.nan)
        cascade = initial_cascade_state(params)
        cascade[0][:] = self._integrals
        samples = np.zeros((self._grid.samples, COLUMNS))
        ticks = self._grid.ticks
        with self._counting:
            self._tally[0] += 1
            each = _STIFF_COST if params[0]["current_span"] > 0.0 else 1
            self._tally[1] += ticks * (_TICK_COST + each * int(params[0]["substeps"]))
        pending = voltage_queue(params)
        run: tuple[Any, ...] = (
            self._grid.every,
            self._reference,
            self._plant.copy(),
            cascade,
            pending,
            params,
            samples,
            np.zeros(len(MEASURED)),
        )
        pushes = [] if torque is None else [(self.time_s, torque)]
        pushes += [] if self._injected is None else [self._injected]
        kernel, given = run_ticks, run
        if pushes:
            pushed = pushed_at(self._grid.instants(), pushes)
            slopes = np.array([params[0]["per_rotor_inertia"], params[0]["per_load_inertia"]])
            kernel, given = run_pushed, (*run, pushed, slopes)

        def advance(first: int, count: int) -> None:
            kernel(first, count, *given)

        held = self._left_out[self._left_out < ticks].tolist()
        run_holding(advance, ticks, held, cascade, pending, samples)
        return samples

    def full(self, effects: Effects, torque: FloatArray | None = None) -> FloatArray:
        """All the engine's columns at the recording's stamps, float64[COLUMNS, n]; see `run`."""
        return self._grid.on_stamps(self.run(effects, torque=torque))

    def healthy_with(self, effects: Effects, draw: int = 0) -> FloatArray:
        """One draw of what a model with `effects` would leave, were it perfect, in floors.

        draw: its number; the first is that of `healthy`.

        float64[signals, n]: noise, and what it does round the loop. White noise where the command
        shows that little of it goes round.
        """
        drawn = np.random.default_rng(1 + draw).standard_normal(self.recorded.shape)
        if not self.noise_in_loop:
            return drawn
        seed = self.nominal.sensors.noise_seed + _NEXT_DRAW * draw
        noisy = self._columns(effects, with_noise(self.nominal, self.loop_share, seed))
        left: FloatArray = (noisy - self.simulate(effects)) / self.floor[:, None]
        # The rest of the noise is the recording's alone; a command has none.
        rest = math.sqrt(1.0 - self.loop_share**2)
        alone = np.array([0.0 if one.name == "voltage_q" else rest for one in self.signals])
        return left + alone[:, None] * drawn

    def healthy_signals(self) -> FloatArray:
        """What a sound nominal machine would have recorded, float64[signals, n], SI: one draw."""
        return self.simulate({}) + self.healthy * self.floor[:, None]

    @property
    def noise_in_loop(self) -> bool:
        """Whether enough of the stated noise goes round the recorded loop to be reckoned with."""
        return self.loop_share >= _LOUD and any(declared_noise(self.nominal).values())

    def keep_noise_out_of_the_loop(self) -> None:
        """From now on reckon with noise of the recording alone."""
        self.loop_share = 0.0
        self.calm()
        self.healthy = self.healthy_with({})

    def shake(self) -> None:
        """From now on simulate with noise in the loop.

        A load that sticks is shaken loose by the noise of its own loop, and creeps where a silent
        replay stays. How it creeps on average hardly depends on the draw of the noise; what this
        draw does to the drive without effects is subtracted again.
        """
        drive = with_noise(self.nominal, self.loop_share, _SHAKING_SEED)
        self._shaking = drive, self._columns({}, drive) - self._columns({})

    def calm(self) -> None:
        """From now on simulate without noise, as at first."""
        self._shaking = None

    def _columns(self, effects: Effects, drive: DriveParameters | None = None) -> FloatArray:
        samples = self.run(effects, drive)
        return self._grid.on_stamps(samples[:, [one.column for one in self.signals]])

    def simulate(self, effects: Effects, constants: Constants = NOMINAL) -> FloatArray:
        """What the model gives at the recording's stamps: float64[signals, n].

        constants: {key of the drive file: value} in place of the nominal ones.
        """
        if self._shaking is None:
            return self._columns(effects, with_constants(self.drive, constants))
        drive, alone = self._shaking
        return self._columns(effects, with_constants(drive, constants)) - alone

    def gap(self, effects: Effects, constants: Constants = NOMINAL) -> FloatArray:
        """Recorded less simulated over the noise floor, float64[signals, n]; 0 where not usable."""
        return self.gap_of(self.simulate(effects, constants))

    def gap_of(self, simulated: FloatArray) -> FloatArray:
        """The same of what was simulated, float64[signals, n]."""
        difference = (self.recorded - simulated) / self.floor[:, None]
        difference[:, ~self.usable] = 0.0
        # A loop that runs away must compare as bad, not as unknown.
        blown = np.isfinite(self.recorded) & ~np.isfinite(difference)
        difference[blown] = 1e6
        np.clip(difference, -1e6, 1e6, out=difference)
        difference[~np.isfinite(self.recorded)] = 0.0
        return difference
