"""The last seconds of recorded and simulated signals, judged as a recording is."""

from __future__ import annotations

import copy
import math
from collections import deque
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...arrays import FloatArray, StampArray
from ...drive.parameters import DriveParameters
from ...recording.signals import Recording
from ..diagnosis import ConditionShare, PortCheck
from ..locate.block import possible_blocks
from ..locate.locate import balances, by_condition, by_port
from ..replay.replay import NOMINAL, SIGNALS, Constants, Effects, Replay
from ..replay.sensor_noise import declared_noise, settled_floors, silent

# A gap is what stands this far above what noise leaves.
GAP = 2.0
# What noise does by way of the loop and of impacts is more at one time and less at another.
_CHANCE = 1.5
_QUIET_LOOP = 0.3  # share of the stated noise in the loop below which its way round is left out
# Where neither drive file nor signals show noise: share of a signal's spread that is not judged.
_NOT_JUDGED = 1e-3
_LEAST = 200  # samples that a floor and a place need
_BROKEN = 4.5  # noise floors from which a balance at a port does not hold
_GATHERED = 0.15  # surplus of energy over time from which a condition is named


@dataclass(frozen=True)
class Compared:
    """Samples of one topic beside the twin's.

    recorded: float64[n, signals]. simulated, noise, noise_square: float64[n, COLUMNS], see
    `Twin.at`.
    """

    stamp_ns: StampArray
    signals: tuple[str, ...]
    recorded: FloatArray
    simulated: FloatArray
    noise: FloatArray
    noise_square: FloatArray


@dataclass(frozen=True)
class SignalNow:
    """RMS of recorded less simulated, the noise floor, and what noise alone would leave; SI."""

    name: str
    unit: str
    rms: float
    floor: float
    healthy: float

    @property
    def over_noise(self) -> float:
        """RMS over what noise leaves with a perfect model: about 1, or less, without a gap."""
        by_loop = _CHANCE * math.sqrt(max(self.healthy**2 - self.floor**2, 0.0))
        return self.rms / math.hypot(self.floor, by_loop)


@dataclass(frozen=True)
class GapNow:
    """Where the gap lies at present.

    signals: those that were measured, the largest gap first. conditions: shares of the gap's
    energy, the most crowded first; ports, blocks: what the balances at the ports leave possible,
    empty where they say nothing or there is no gap. duration_s, samples: what was judged.
    """

    signals: tuple[SignalNow, ...]
    conditions: tuple[ConditionShare, ...]
    ports: tuple[PortCheck, ...]
    blocks: tuple[str, ...]
    duration_s: float
    samples: int

    @property
    def is_gap(self) -> bool:
        """Whether any signal stands out of the noise."""
        return bool(self.signals) and self.signals[0].over_noise > GAP

    @property
    def condition(self) -> ConditionShare | None:
        """Where the gap gathers, if it does."""
        if not self.is_gap or not self.conditions:
            return None
        first = self.conditions[0]
        return first if first.share - first.time_share > _GATHERED else None


class Window:
    """Keeps what was compared in the last `length_s` seconds of the drive's time."""

    def __init__(self, drive: DriveParameters, length_s: float) -> None:
        self._drive = drive
        self._length_ns = round(length_s * 1e9)
        self._parts: dict[str, deque[Compared]] = {}

    def clear(self) -> None:
        """Forget all."""
        self._parts.clear()

    def put(self, key: str, part: Compared) -> None:
        """Add what was compared of one topic."""
        if not part.stamp_ns.size:
            return
        parts = self._parts.setdefault(key, deque())
        parts.append(part)
        newest = max(int(p[-1].stamp_ns[-1]) for p in self._parts.values() if p)
        for others in self._parts.values():
            while others and others[0].stamp_ns[-1] < newest - self._length_ns:
                others.popleft()

    def judge(self, place: bool = True) -> GapNow | None:
        """How large the gap is; None while too little has been compared.

        place: also where it lies, which takes some ms.
        """
        whole = {key: _joined(parts) for key, parts in self._parts.items() if parts}
        if not whole:
            return None
        main = max(whole.values(), key=lambda part: len(part.stamp_ns))
        if len(main.stamp_ns) < _LEAST:
            return None
        recorded = {
            name: _on_stamps(main.stamp_ns, part.stamp_ns, part.recorded[:, column])
            for part in whole.values()
            for column, name in enumerate(part.signals)
        }
        replay = _Compared(self._drive, main, recorded)
        if not replay.signals:
            return None
        return replay.now(place)


def _joined(parts: deque[Compared]) -> Compared:
    return Compared(
        np.concatenate([one.stamp_ns for one in parts]),
        parts[0].signals,
        np.concatenate([one.recorded for one in parts]),
        np.concatenate([one.simulated for one in parts]),
        np.concatenate([one.noise for one in parts]),
        np.concatenate([one.noise_square for one in parts]),
    )


def _on_stamps(wanted: StampArray, stamps: StampArray, values: FloatArray) -> FloatArray:
    """Values at other stamps: the same samples where stamps agree, else by lines between them."""
    if len(stamps) == len(wanted) and (stamps == wanted).all():
        return values
    known = np.isfinite(values)
    if not known.any():
        return np.full(len(wanted), np.nan)
    zero = int(wanted[0])
    at, given = (wanted - zero) * 1e-9, (stamps[known] - zero) * 1e-9
    found = np.interp(at, given, values[known], left=np.nan, right=np.nan)
    # Nothing across a gap: two of the wanted steps at most.
    after = np.clip(np.searchsorted(given, at), 0, len(given) - 1)
    before = np.clip(after - 1, 0, len(given) - 1)
    reach = 2.0 * float(np.median(np.diff(at)))
    found[np.minimum(np.abs(given[after] - at), np.abs(at - given[before])) > reach] = np.nan
    return found


class _Compared(Replay):
    """A replay that has been made: what the offline location asks of one."""

    def __init__(
        self, drive: DriveParameters, main: Compared, recorded: dict[str, FloatArray]
    ) -> None:
        keep = np.isfinite(main.simulated).all(axis=1)
        self._simulated = main.simulated[keep]
        self._noise = main.noise[keep]
        noise = np.sqrt(main.noise_square[keep])
        kept: dict[str, Any] = {name: values[keep] for name, values in recorded.items()}
        self.recording = Recording(stamp_ns=main.stamp_ns[keep], **kept)
        self.nominal, self.drive = drive, silent(drive)
        self.notes = []
        self.time_s = np.asarray(self.recording.time_s)
        self.signals = tuple(one for one in SIGNALS if self.recording.has(one.recorded))
        columns = [one.column for one in self.signals]
        self.recorded = np.array([self.recording.signal(one.recorded) for one in self.signals])
        self.usable = np.ones(len(self.time_s), dtype=bool)
        stated = declared_noise(drive)
        self.proportional_noise_v = max(stated["voltage_q"], 1e-12)
        self.loop_share = 1.0
        self._shaking = None
        if self.signals:
            names = [one.name for one in self.signals]
            left = self.recorded - self.simulate({})
            self.floor, self.loop_share = settled_floors(names, self.recorded, left, drive)
            for row, one in enumerate(self.signals):
                if stated[one.name] == 0.0:
                    spread = float(np.nanstd(self.recorded[row]))
                    self.floor[row] = max(self.floor[row], _NOT_JUDGED * spread, 1e-30)
            if self.loop_share < _QUIET_LOOP:
                # The command shows that the noise of the recording is not in the loop.
                self._noise, noise = np.zeros_like(noise), np.zeros_like(noise)
            self.healthy = noise[:, columns].T / self.floor[:, None]

    def simulate(self, effects: Effects, constants: Constants = NOMINAL) -> FloatArray:
        """What the twin gave; no other constants can be put on what has run."""
        if constants:
            raise ValueError(f"the twin has run with its nominal {', '.join(constants)}")
        return self._simulated[:, [one.column for one in self.signals]].T

    def full(self, effects: Effects, torque: FloatArray | None = None) -> FloatArray:
        """The same, all columns; nothing can be put on what has run."""
        return self._simulated.T

    def healthy_signals(self) -> FloatArray:
        """What the noisy twin gave; white noise on the silent one where the loop is quiet."""
        columns = [one.column for one in self.signals]
        if self._noise.any():
            return (self._simulated + self._noise)[:, columns].T
        drawn = np.random.default_rng(1).standard_normal(self.recorded.shape)
        return self._simulated[:, columns].T + drawn * self.floor[:, None]

    @property
    def reference_m(self) -> FloatArray:
        """The rod position asked for."""
        return self._simulated[:, 0]

    def _ports(self) -> tuple[PortCheck, ...]:
        """The balances at the ports, each over what noise alone leaves of it.

        The offline floors leave out what noise does round the loop; here the noisy twin shows it.
        """
        healthy = copy.copy(self)
        healthy.recorded = self.healthy_signals()
        # The controller's floor is such already.
        alone = {one.block: one for one in balances(healthy)}
        found = []
        for one in by_port(self):
            noise = alone.get(one.block)
            scale = 1.0 if noise is None else max(1.0, noise.typical_ratio)
            quiet = replace(one, floor=one.floor * scale)
            # What is broken for certain keeps the floor by which balances are compared.
            found.append(one if quiet.typical_ratio > _BROKEN else quiet)
        return tuple(found)

    def now(self, place: bool) -> GapNow:
        """The judgement."""
        gap = self.gap({})
        signals = []
        for row, one in enumerate(self.signals):
            known = np.isfinite(self.recorded[row])
            floor = float(self.floor[row])
            rms = float(np.sqrt(np.mean(gap[row, known] ** 2))) * floor
            healthy = float(np.sqrt(np.mean(self.healthy[row, known] ** 2))) * floor
            signals.append(SignalNow(one.name, one.unit, rms, floor, healthy))
        signals.sort(key=lambda one: -one.over_noise)
        conditions: tuple[ConditionShare, ...] = ()
        ports: tuple[PortCheck, ...] = ()
        blocks: tuple[str, ...] = ()
        if place and signals[0].over_noise > GAP:
            conditions = by_condition(self, gap)
            ports = self._ports()
            needed = {"motor_electrical", "motor_mechanical", "transmission"}
            if needed <= {one.block for one in ports}:
                blocks = tuple(possible_blocks(ports))
        return GapNow(
            tuple(signals),
            conditions,
            ports,
            blocks,
            float(self.time_s[-1]),
            len(self.time_s),
        )
