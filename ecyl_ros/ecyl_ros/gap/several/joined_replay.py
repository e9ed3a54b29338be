"""Several recordings of one full cylinder as one replay: each from its own start, in its own noise.

The recordings stand behind one another on one axis of time; each is replayed by itself, so that
state and time restart with each. A cause has one value in all of them, but for the phase of what
swings with time, which no clock ties to the recordings, and for what `own` gives another size in
each.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Mapping, Sequence

import numpy as np
from scipy.optimize import minimize_scalar

from ...arrays import BoolArray, FloatArray
from ...drive.law import Law
from ...drive.tolerances import constants_of
from ...effects.catalogue import CATALOGUE
from ..fit.coordinate import PHASE, phase_in
from ..fit.robust import cost
from ..replay.replay import NOMINAL, Constants, Effects, Replay

_SAME_RATE = 1.01  # rates nearer to each other than this count as one
_PHASES = 8  # that are tried all round
_JUNCTION_S = 0.025  # by which filters reach from one recording into the next

Own = Mapping[str, Sequence[float]]


class JoinedReplay(Replay):
    """Replays of several recordings of one machine, compared together.

    Attributes:
        own: factors float[recordings] of the size of an effect, or of the value of a constant of
            the sheet, in each of the recordings.
        others: those of `Replay`.
    """

    def __init__(
        self, parts: Sequence[Replay], own: Own | None = None, held: Sequence[BoolArray] = ()
    ) -> None:
        """parts: replays of the recordings, which have the same signals.

        held: stretches of each that no parameter is fitted to, found unless given.
        """
        rates = [1.0 / one.step_s for one in parts]
        slowest = min(rates)
        self._parts = tuple(
            one.thinned(slowest) if rate > _SAME_RATE * slowest else one
            for one, rate in zip(parts, rates, strict=True)
        )
        self.own: Own = dict(own or {})
        self.drive, self.nominal = self._parts[0].drive, self._parts[0].nominal
        self.signals = self._parts[0].signals
        self.recording = self._parts[rates.index(slowest)].recording
        self.proportional_noise_v = self._parts[0].proportional_noise_v
        several = len(parts) > 1
        self.notes = [
            f"{one.source}: {note}" if several else note for one in parts for note in one.notes
        ]
        self._lay_side_by_side()
        self._held = tuple(held) or tuple(one.held_out() for one in self._parts)

    def _lay_side_by_side(self) -> None:
        """What is known of each recording, one behind the other."""
        times: list[FloatArray] = []
        usable: list[BoolArray] = []
        begin = 0.0
        for number, one in enumerate(self._parts):
            times.append(begin + one.time_s)
            near = np.zeros(len(one.time_s), dtype=bool)
            if number:
                near |= one.time_s < _JUNCTION_S
            if number < len(self._parts) - 1:
                near |= one.time_s > float(one.time_s[-1]) - _JUNCTION_S
            usable.append(one.usable & ~near)
            begin = float(times[-1][-1]) + one.step_s
        self.time_s = np.concatenate(times)
        self.usable: BoolArray = np.concatenate(usable)
        self.recorded = np.concatenate([one.recorded for one in self._parts], axis=1)
        ends = np.cumsum([len(one.time_s) for one in self._parts]).tolist()
        self._spans = tuple(
            slice(end - len(one.time_s), end) for end, one in zip(ends, self._parts, strict=True)
        )
        shares = np.array([len(one.time_s) for one in self._parts]) / len(self.time_s)
        floors = np.array([one.floor for one in self._parts])
        self.floor = np.sqrt(shares @ floors**2)
        self.healthy = self._joined([one.healthy for one in self._parts])

    def _joined(self, parts: Sequence[FloatArray]) -> FloatArray:
        return np.concatenate(parts, axis=1)

    @property
    def parts(self) -> tuple[Replay, ...]:
        """See `Replay`."""
        return self._parts

    @property
    def spans(self) -> tuple[slice, ...]:
        """See `Replay`."""
        return self._spans

    def subset(self, numbers: Sequence[int]) -> JoinedReplay:
        """Some of the recordings; sizes of their own are over that of the last of these."""
        own = {}
        for name, factors in self.own.items():
            last = factors[numbers[-1]]
            own[name] = [factors[number] / last for number in numbers]
        return JoinedReplay(
            [self._parts[number] for number in numbers],
            own,
            [self._held[number] for number in numbers],
        )

    def with_own(self, own: Own) -> JoinedReplay:
        """The same recordings with other sizes of their own."""
        return JoinedReplay(self._parts, own, self._held)

    def _each(self, parts: Sequence[Replay]) -> JoinedReplay:
        """The same with other replays of the same recordings."""
        other = copy.copy(self)
        other._parts = tuple(parts)
        other.drive = parts[0].drive
        return other

    @property
    def runs(self) -> int:
        """See `Replay`."""
        return sum(one.runs for one in self._parts)

    @property
    def work(self) -> int:
        """See `Replay`."""
        return sum(one.work for one in self._parts)

    def at(self, constants: Constants) -> JoinedReplay:
        """See `Replay`."""
        return self._each(
            [one.at(self.constants_in(number, constants)) for number, one in enumerate(self._parts)]
        )

    def playing(self, law: Law | None) -> JoinedReplay:
        """See `Replay`."""
        return self._each([one.playing(law) for one in self._parts])

    def until(self, end_s: float) -> JoinedReplay:
        """See `Replay`."""
        parts: list[Replay] = []
        for one, span in zip(self._parts, self.spans, strict=True):
            begin = float(self.time_s[span.start])
            if begin >= end_s:
                break
            parts.append(
                one if begin + float(one.time_s[-1]) <= end_s else one.until(end_s - begin)
            )
        factors = {name: values[: len(parts)] for name, values in self.own.items()}
        return JoinedReplay(parts, factors)

    @property
    def reference_m(self) -> FloatArray:
        """See `Replay`."""
        return np.concatenate([one.reference_m for one in self._parts])

    def constants_in(self, number: int, constants: Constants) -> Constants:
        """The constants of one recording."""
        own = {key: factors[number] for key, factors in self.own.items() if key not in CATALOGUE}
        if not own:
            return constants
        nominal = constants_of(self.drive)
        return {
            **constants,
            **{key: by * constants.get(key, nominal[key]) for key, by in own.items()},
        }

    def complete(self, effects: Effects, constants: Constants) -> dict[str, dict[str, float]]:
        """See `Replay`: with a phase of each recording for what swings with time.

        A phase that is not given yet is the one that fits best.
        """
        full = {}
        for name, given in effects.items():
            phases = {key: value for key, value in given.items() if "@" in key}
            first = {key: value for key, value in given.items() if "@" not in key}
            full[name] = {**CATALOGUE[name].complete(first), **phases}
        for name in filter(swings, list(full)):
            for number in range(1, len(self._parts)):
                key = phase_in(number)
                if key not in full[name]:
                    full[name][key] = self._phase(number, full, name, constants)
        return full

    def effects_in(self, number: int, effects: Effects) -> dict[str, dict[str, float]]:
        """The effects with the sizes and phases that they have in one recording.

        Its phase is that of the first where none is given.
        """
        found = {}
        for name, given in effects.items():
            own = {key: value for key, value in given.items() if "@" not in key}
            if phase_in(number) in given:
                own[PHASE] = given[phase_in(number)]
            if name in self.own:
                own = CATALOGUE[name].scaled(own, self.own[name][number], self.drive)
            found[name] = own
        return found

    def effects_among(
        self, numbers: Sequence[int], effects: Effects
    ) -> dict[str, dict[str, float]]:
        """The effects for `subset`: in the size of the last of these, in the phases of each."""
        found = self.effects_in(numbers[-1], effects)
        for name in filter(swings, list(found)):
            for place, number in enumerate(numbers):
                phase = self.effects_in(number, effects)[name][PHASE]
                found[name][phase_in(place)] = phase
        return found

    def in_own_phase(
        self, number: int, effects: Effects, constants: Constants
    ) -> dict[str, dict[str, float]]:
        """The same with the phases that fit the recording best: of values that others gave."""
        found = self.effects_in(number, effects)
        for name in filter(swings, list(found)):
            found[name][PHASE] = self._phase(number, found, name, constants)
        return found

    def _phase(self, number: int, effects: Effects, name: str, constants: Constants) -> float:
        """The phase of an effect that fits a recording best, of all round.

        Stretches that are held out have no part in it.
        """
        part = self._parts[number]
        own = self.constants_in(number, constants)
        rows = part.usable & ~self._held[number]
        given = self.effects_in(number, effects)

        def left(phase: float) -> float:
            return cost(part.gap({**given, name: {**given[name], PHASE: phase}}, own), rows)

        tried = np.arange(_PHASES) * (math.tau / _PHASES)
        best = float(tried[int(np.argmin([left(phase) for phase in tried]))])
        step = math.tau / _PHASES
        found = minimize_scalar(
            left, bounds=(best - step, best + step), method="bounded", options={"xatol": 0.02}
        )
        return math.remainder(float(found.x), math.tau)

    def held_out(self) -> BoolArray:
        """See `Replay`."""
        return np.concatenate(self._held)

    def held_out_by(self, gap: FloatArray) -> BoolArray:
        """See `Replay`; from now on these stretches are held out."""
        self._held = tuple(
            one.held_out_by(gap[:, span]) for one, span in zip(self._parts, self.spans, strict=True)
        )
        return self.held_out()

    def full(self, effects: Effects, torque: FloatArray | None = None) -> FloatArray:
        """See `Replay`."""
        return self._joined(
            [
                one.full(
                    self.effects_in(number, effects),
                    None if torque is None else torque[:, self.spans[number]],
                )
                for number, one in enumerate(self._parts)
            ]
        )

    def healthy_with(self, effects: Effects, draw: int = 0) -> FloatArray:
        """See `Replay`."""
        return self._joined(
            [
                one.healthy_with(self.effects_in(number, effects), draw)
                for number, one in enumerate(self._parts)
            ]
        )

    @property
    def noise_in_loop(self) -> bool:
        """See `Replay`."""
        return any(one.noise_in_loop for one in self._parts)

    def keep_noise_out_of_the_loop(self) -> None:
        """See `Replay`."""
        for one in self._parts:
            one.keep_noise_out_of_the_loop()
        self.healthy = self._joined([one.healthy for one in self._parts])

    def shake(self) -> None:
        """See `Replay`."""
        for one in self._parts:
            one.shake()

    def calm(self) -> None:
        """See `Replay`."""
        for one in self._parts:
            one.calm()

    def simulate(self, effects: Effects, constants: Constants = NOMINAL) -> FloatArray:
        """See `Replay`."""
        return self._joined(
            [
                one.simulate(
                    self.effects_in(number, effects),
                    self.constants_in(number, constants),
                )
                for number, one in enumerate(self._parts)
            ]
        )

    def gap_of(self, simulated: FloatArray) -> FloatArray:
        """See `Replay`."""
        parts = zip(self._parts, self.spans, strict=True)
        found = self._joined([one.gap_of(simulated[:, span]) for one, span in parts])
        found[:, ~self.usable] = 0.0
        return found


def swings(effect: str) -> bool:
    """Whether an effect repeats in time, with a phase that begins with the recording."""
    units = {one.unit for one in CATALOGUE[effect].parameters}
    names = {one.name for one in CATALOGUE[effect].parameters}
    return "Hz" in units and PHASE in names
