"""A rigid drive replayed, nominal and as found: how far speed, position and tracking error are off.

With the loop known, the recorded reference is all that goes in. A position loop holds the machine
to its reference, so that one replay runs through; a speed loop lets the position drift, so that the
replay is restarted from the measured state with every stretch. With the loop unknown, the measured
effort goes in; a position from effort alone drifts with the square of time, so that this, too,
restarts with every stretch, and what is judged builds up within it. Where something acts over
the position (cogging), a position that has drifted by a good part of its period makes it push where
it should pull: stretches are then halved until the position stays.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray
from ...drive.law import Law
from ...drive.rigid.driven import Driven, Pieces, by_effort, by_loop, pieces
from ...drive.rigid.machine import Machine
from ...drive.rigid.packed import model_of
from ..diagnosis import Measured, SignalGap
from ..report import quantities as q
from .balance import Balance
from .closest import closest
from .judge import Judgement
from .noise import effort_noise
from .ruling import Ruling

_SHORTEST_S = 0.1  # of a piece that runs through
_FEWEST = 16  # samples of a piece that is restarted, at the least
_PHASE = 0.125  # of the shortest period over the position: drift up to here leaves it in step
_PLACES, _PER_WAVE = ("position", "rotor_angle"), 4.0  # places of a table within a wave
_AWAY = 1e3  # times the travel or the largest speed: what is beyond has run away


@dataclass(frozen=True, eq=False)
class Replay:
    """Signals of a replay as rows of a series; the arrays are float64[k, m].

    signals: gaps on held-out stretches. measured, notes: what goes into the diagnosis beside them.
    """

    signals: tuple[SignalGap, ...] = ()
    recorded: FloatArray = dataclasses.field(default_factory=lambda: np.zeros((0, 0)))
    before: FloatArray = dataclasses.field(default_factory=lambda: np.zeros((0, 0)))
    after: FloatArray = dataclasses.field(default_factory=lambda: np.zeros((0, 0)))
    measured: tuple[Measured, ...] = ()
    notes: tuple[str, ...] = ()


def replay(judgement: Judgement, ruling: Ruling) -> Replay:
    """Replay the machine of the file, and with what is named, or as the sheet allows it, beside the
    recording."""
    along = judgement.catalogue.along
    base = closest(along, ruling.base)
    found = ruling.named or ruling.verdict == "within_sheet"
    final = closest(along, ruling.final) if found else base
    return _Replayer(judgement, base, final, ruling.final.residual).run()


def replay_with(judgement: Judgement, found: Machine, left: FloatArray) -> Replay:
    """The same with `found` in place of what is named; left: float64[m], of the effort with it."""
    base = closest(judgement.catalogue.along, judgement.contest.nominal)
    return _Replayer(judgement, base, found, left).run()


class _Replayer:
    """base, final: the nominal machine, and the one that was found. left: float64[m], of the effort
    with the latter."""

    def __init__(
        self, judgement: Judgement, base: Machine, final: Machine, left: FloatArray
    ) -> None:
        self.judgement, self.base, self.final, self.left = judgement, base, final, left
        self.balance: Balance = judgement.balance
        self.motion, self.machine = judgement.motion, judgement.machine
        self.catalogue = judgement.catalogue
        self.end = "m" if self.machine.linear else "rad"
        self.mode = self._mode()
        self.anew_s = self.balance.stretch_s
        self.parts = self._pieces()

    def _mode(self) -> str:
        motion, machine = self.motion, self.machine
        if machine.loop_known:
            if machine.position_kp and np.isfinite(motion.reference_position).any():
                return "position"
            if not machine.position_kp and np.isfinite(motion.reference_velocity).any():
                return "speed"
        return "effort"

    def _pieces(self) -> Pieces:
        motion, balance = self.motion, self.balance
        least = max(8, math.ceil(_SHORTEST_S * motion.rate_hz))
        if self.mode == "position":
            return pieces(motion.usable & np.isfinite(motion.reference_position), None, least)
        begin = float(balance.time_s[balance.usable][0])
        stretch = np.floor((motion.time_s - begin) / self.anew_s).astype(np.int64)
        least = max(8, int(0.5 * self.anew_s * motion.rate_hz))
        where = motion.usable
        if self.mode == "speed":
            where = where & np.isfinite(motion.reference_velocity)
        return pieces(where, stretch, least)

    def run(self) -> Replay:
        """Both replays, and a third that tells what an effort below its floor does."""
        still = np.zeros(self.motion.time_s.size)
        self._shorten(still)
        if not self.parts.first.size:
            return Replay(
                notes=("not replayed: nowhere is the reference recorded for long enough",)
            )
        before = self._driven(self.base, still)
        after = before if self.final is self.base else self._driven(self.final, still)
        shaken = self._driven(self.final, self._push()) if after is not None else None
        if before is None or after is None or shaken is None:
            looks = "the sign and gain of the effort, and at the loop in the drive file"
            why = f"the machine as modelled runs away from the recording; look at {looks}"
            if self.mode == "effort":
                why = "no loop holds the machine as modelled, and it drifts away from the recording"
            return Replay(notes=(f"not replayed: {why}",))
        rows = [self._rows(one) for one in (None, before, after, shaken)]
        recorded, nominal, found, noisy = (np.stack(list(one.values())) for one in rows)
        judged = self.judgement.judged & np.isfinite(nominal[0]) & np.isfinite(recorded).all(axis=0)
        if not judged.any():
            return Replay(notes=("not replayed: no held-out stretch could be",))
        noise = {
            "speed": self.motion.speed_noise,
            "tracking_error": self.motion.position_noise,
            "position": self.motion.position_noise,
        }
        signals = []
        for index, name in enumerate(rows[0]):
            gap, left, moved = (
                float(np.sqrt(np.mean((one[index] - other[index])[judged] ** 2)))
                for one, other in ((recorded, nominal), (recorded, found), (found, noisy))
            )
            floor = math.hypot(moved, noise.get(name, effort_noise(self.motion)))
            floor = max(floor, 1e-300)
            signals.append(SignalGap(name, self._unit(name), gap, left, floor, judged=False))
        return Replay(
            signals=tuple(signals),
            recorded=recorded,
            before=nominal,
            after=found,
            measured=self._tracking(recorded[0][judged], signals[0]),
            notes=self._notes(),
        )

    def _shorten(self, still: FloatArray) -> None:
        """Halve the stretches until what acts over the position stays in step with it."""
        waves = [one.values["wave"] for one in self.final.effects if "wave" in one.values]
        waves += _bends(self.final.learned)
        if self.mode == "position" or not waves:
            return
        most = _PHASE * math.tau / max(waves)
        while self.parts.first.size and self.anew_s * self.motion.rate_hz >= 2 * _FEWEST:
            made = self._driven(self.final, still)
            if made is not None:
                drift = made.position - self.motion.position
                if float(np.sqrt(np.nanmean(drift**2))) <= most:
                    break
            self.anew_s *= 0.5
            self.parts = self._pieces()

    def _driven(self, machine: Machine, push: FloatArray) -> Driven | None:
        """One replay; None where it cannot be or runs away."""
        own = self.catalogue.units.own
        if not (model_of(machine, own).inertia or 0.0) > 0.0:
            return None
        run = by_effort if self.mode == "effort" else by_loop
        with np.errstate(all="ignore"):
            made = run(self.motion, machine, own, self.parts, push)
        inside = np.concatenate([np.arange(a, b) for a, b in self.parts])
        motion = self.motion
        for values, usual in ((made.position, motion.position), (made.velocity, motion.velocity)):
            reach = _AWAY * float(np.ptp(usual))
            off = np.abs(values[inside] - usual[inside])
            if not np.all(off < reach):
                return None
        return made

    def _push(self) -> FloatArray:
        """A load of the floor's size, shaped like what is left: it cannot be told from noise."""
        balance = self.balance
        left = np.where(balance.usable, self.left, 0.0)
        size = float(np.sqrt(np.mean(left[balance.usable] ** 2))) or 1.0
        scaled = left * (self.judgement.floor / size)
        return np.interp(self.motion.time_s, balance.time_s, scaled)

    def _rows(self, made: Driven | None) -> dict[str, FloatArray]:
        """Signals at the compared samples, of a replay or (None) as recorded."""
        motion, rows = self.motion, self.motion.rows
        if made is None:
            found = {"position": motion.raw_position[rows], "speed": motion.velocity[rows]}
        else:
            known = np.isfinite(made.position)
            speed = motion.smoothed(np.where(known, made.velocity, motion.velocity))
            found = {
                "position": made.position[rows],
                "speed": np.where(known, speed, np.nan)[rows],
            }
        if self.mode == "position":
            error = motion.reference_position[rows] - found.pop("position")
            found = {"tracking_error": error, **found}
        if self.mode == "speed":
            del found["position"]
        if self.mode != "effort":
            name = f"{motion.effort_name}_in_the_loop"
            if made is None:
                found[name] = self.balance.effort
            else:
                asked = np.where(np.isfinite(made.effort), made.effort, motion.effort)
                found[name] = np.where(known[rows], motion.filtered(asked), np.nan)
        return found

    def _unit(self, name: str) -> str:
        if name == "speed":
            return f"{self.end}/s"
        return self.end if name in ("position", "tracking_error") else self.motion.effort_unit

    def _tracking(self, error: FloatArray, gap: SignalGap) -> tuple[Measured, ...]:
        if self.mode != "position":
            return ()
        size = float(np.sqrt(np.mean(error**2)))
        text = f"RMS; replayed it is off by {q.amount(gap.gap, self.end)} with the nominal model"
        if self.final is not self.base:
            text += f", by {q.amount(gap.after, self.end)} with the twin"
        return (Measured(f"tracking_error_{self.end}", self.end, size, size, size, text),)

    def _notes(self) -> tuple[str, ...]:
        effort = self.motion.effort_name
        judged = f"gap, shrink and misfit are those of the {effort} that the motion needs"
        if self.mode == "position":
            return (f"{judged}; the other signals are of a replay of the reference in closed loop",)
        anew = f"restarted every {self.anew_s:.3g} s from the measured state"
        if self.anew_s < self.balance.stretch_s:
            anew += " (so often that what acts over the position stays in step with it)"
        if self.mode == "speed":
            return (
                f"{judged}; the other signals are of a replay of the reference speed in closed "
                f"loop, {anew}, because a speed loop lets the position drift",
            )
        why = "no controller in the drive file"
        if self.machine.loop_known:
            why = "no reference was recorded that the loop could follow"
        return (
            f"{judged}; {why}: position and speed are of a replay from the measured {effort}, "
            f"{anew}, because a position from {effort} alone drifts; they show what builds up "
            "within",
        )


def _bends(law: Law | None) -> list[float]:
    """Rad per m or rad of the finest wave that a law over the position can follow; [] without."""
    if law is None:
        return []
    places = [at for at, name in zip(law.at, law.of, strict=True) if name in _PLACES]
    return [math.tau / (_PER_WAVE * float(np.min(np.diff(at)))) for at in places]
