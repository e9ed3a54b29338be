"""A ruling as a `Diagnosis`: where the gap lies, what was measured, what could not be judged."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence

import numpy as np
from scipy.signal import find_peaks, welch

from ...effects.catalogue import CATALOGUE
from ...recording.signals import Recording
from ..diagnosis import (
    Candidate,
    Cause,
    ConditionShare,
    FittedParameter,
    FloatArray,
    Measured,
    PortCheck,
    Series,
    SignalGap,
)
from .acting import as_file, numbered
from .balance import Interval, Solution
from .closest import closest
from .floor import white_floor
from .replay import replay
from .ruling import Judgement
from .sheet import sheet_values
from .terms import Term
from .twin import EffortDiagnosis

_LINES = 3


class Assembly:
    """From a judgement to a diagnosis."""

    def __init__(self, judgement: Judgement, mode: float | None) -> None:
        self.mode = mode
        self.ruling = judgement.rule()
        self.judgement = judgement
        self.balance, self.catalogue = judgement.balance, judgement.catalogue
        self.contest, self.floor = judgement.contest, judgement.floor
        self.machine, self.motion = judgement.machine, judgement.motion
        self.units, self.spread, self.rms = judgement.units, judgement.spread, judgement.rms
        self.whole, self.spans = judgement.whole, judgement.spans
        self.replay = replay(judgement, self.ruling)

    def diagnosis(
        self, source: str, drive_name: str, begin: float, recording: Recording
    ) -> EffortDiagnosis:
        """The result; `begin`: when the work began, by `time.perf_counter`."""
        ruling, motion = self.ruling, self.motion
        no_gap, named = ruling.verdict in ("no_gap", "within_sheet"), ruling.named
        block = ruling.causes[0].block if named else (None if no_gap else self._nearest_block())
        steps = [self.rms(one) / self.spread for one in self.contest.path]
        merged, reached = _merged(ruling.causes, steps) if named else ((), ())
        gap = SignalGap(
            motion.effort_name, motion.effort_unit, ruling.before, ruling.after, self.floor
        )
        return EffortDiagnosis(
            source=source,
            drive=drive_name,
            verdict=ruling.verdict,
            block=block,
            signals=(gap, *self.replay.signals),
            when=() if no_gap else self._when(ruling.base),
            frequency_hz=() if no_gap else self._lines(ruling.base),
            ports=self._ports(),
            causes=merged,
            before=ruling.before / self.spread,
            after=ruling.after / self.spread,
            floor=self.floor / self.spread,
            shrink=ruling.shrink,
            steps=reached,
            candidates=self._candidates(),
            notes=(*self._costs(), *self.replay.notes, *motion.notes, *self.judgement.notes),
            values=self._values() if named else {},
            series=self._series(ruling.base, ruling.final, int(recording.stamp_ns[0])),
            seconds=time.perf_counter() - begin,
            replays=self.contest.fits,
            misfit_before=ruling.before / self.floor,
            misfit_after=ruling.after / self.floor,
            misfit_perfect=1.0,
            misfit_best=ruling.best / self.floor,
            margin=ruling.margin,
            duration_s=recording.duration_s,
            rate_hz=recording.rate_hz,
            measured=(*self._measured(named), *self.replay.measured),
            floor_is=self.judgement.floor_is,
            closest=closest(self.catalogue, self.whole) if named else None,
            judged=closest(self.catalogue, ruling.final),
            sheet=sheet_values(self.whole.terms, self.spans, self.machine, self.units),
            within_sheet=ruling.after / self.spread if ruling.verdict == "within_sheet" else None,
            reason=ruling.reason,
        )

    def _values(self) -> dict[str, dict[str, float]]:
        """Of the named causes, as a drive file takes them."""
        machine = closest(self.catalogue, self.whole)
        names = {one.effect for one in self.contest.order}
        written = as_file(machine.effects, self.units, machine.lead)
        return {name: values for name, values in written.items() if name in names}

    def _nearest_block(self) -> str | None:
        for one in self.contest.singles:
            names = [name for name in one.effects if name in CATALOGUE]
            if names:
                return CATALOGUE[names[-1]].block
        return None

    def _candidates(self) -> tuple[Candidate, ...]:
        contest = self.contest
        pool = [contest.winner, *contest.rivals, *contest.singles, contest.base]
        unknown = {one.effect for one in self.catalogue.unknown()}
        best: dict[tuple[str, ...], Candidate] = {}
        for one in pool:
            names = tuple(dict.fromkeys(t.effect for t in one.terms if t.effect not in unknown))
            fitted = self.rms(one, self.balance.fitted) / self.floor
            judged = self.rms(one) / self.floor
            if names not in best or judged < best[names].judged:
                best[names] = Candidate(names, fitted, judged)
        return tuple(sorted(best.values(), key=lambda one: one.judged)[:12])

    # Where.

    def _when(self, solution: Solution) -> tuple[ConditionShare, ...]:
        motion, balance = self.motion, self.balance
        rows = balance.usable
        energy = solution.residual[rows] ** 2
        total = float(energy.sum())
        if total <= 0.0:
            return ()
        at = motion.rows
        speed, rate = motion.velocity[at], balance.time_s
        step = float(np.median(np.diff(rate)))
        top = self.catalogue.top_speed
        crossing = np.zeros(speed.size, dtype=bool)
        crossing[1:] = np.signbit(speed[1:]) != np.signbit(speed[:-1])
        width = max(1, round(0.06 / step))
        near = np.convolve(crossing, np.ones(2 * width + 1), mode="same") > 0.0
        hard = np.abs(motion.acceleration[at])
        level = np.abs(balance.effort)
        masks = {
            "reversal": near,
            "rest": np.abs(speed) < 0.01 * top,
            "low_speed": (np.abs(speed) < 0.05 * top) & ~near,
            "high_speed": np.abs(speed) > 0.5 * top,
            "acceleration": hard > 0.5 * float(np.quantile(hard[rows], 0.995)),
            "high_torque": level > 0.5 * float(np.quantile(level[rows], 0.995)),
            "forwards": speed > self.catalogue.soft,
            "backwards": speed < -self.catalogue.soft,
        }
        mode = motion.mode[at]
        values = np.unique(mode[rows & np.isfinite(mode)])
        if 1 < values.size <= 8:
            masks |= {f"mode_{value:g}": mode == value for value in values.tolist()}
        found = [
            ConditionShare(name, float(energy[mask[rows]].sum()) / total, float(mask[rows].mean()))
            for name, mask in masks.items()
        ]
        found = [one for one in found if one.time_share > 0.0]
        found.append(_gathered("position", motion.position[at][rows], energy))
        found.append(_gathered("time", balance.time_s[rows], energy))
        found.sort(key=lambda one: one.time_share - one.share)
        return tuple(found)

    def _lines(self, solution: Solution) -> tuple[float, ...]:
        balance = self.balance
        rate = self.motion.rate_hz / self.motion.step
        values = np.where(balance.usable, solution.residual, 0.0)
        frequency, density = welch(values, rate, nperseg=min(values.size, int(4.0 * rate)))
        peaks, _ = find_peaks(
            np.concatenate([[0.0], density]), height=4.0 * float(np.median(density))
        )
        peaks = peaks - 1
        peaks = peaks[frequency[peaks] > 0.0]
        order = peaks[np.argsort(-density[peaks])][:_LINES]
        return tuple(float(frequency[row]) for row in order)

    def _ports(self) -> tuple[PortCheck, ...]:
        motion, balance = self.motion, self.balance
        unit = motion.effort_unit
        side = "load" if self.machine.linear else "motor_mechanical"
        before = self.rms(self.contest.base)
        found = [PortCheck(side, "effort less what the motion needs", unit, before, self.floor)]
        both = np.isfinite(motion.other_effort)
        if both.any():
            other = np.interp(motion.time_s, motion.time_s[both], motion.other_effort[both])
            left = motion.filtered(motion.effort - other)[balance.usable]
            white = max(white_floor(balance, None), 1e-3 * self.spread)
            what = "recorded effort against what the loop asks for"
            rms = float(np.sqrt(np.mean(left**2)))
            found.insert(0, PortCheck("controller", what, unit, rms, white))
        return tuple(found)

    def _series(self, base: Solution, final: Solution, start_ns: int) -> Series:
        motion, balance = self.motion, self.balance
        rows = motion.rows
        nothing = np.full(rows.size, np.nan)
        known = np.isfinite(motion.reference_position).any()
        reference = motion.reference_position[rows] if known else nothing
        end = "m" if self.machine.linear else "rad"
        return Series(
            time_s=balance.time_s,
            reference_m=reference,
            recorded=_rows(balance.effort, self.replay.recorded),
            before=_rows(balance.effort - base.residual, self.replay.before),
            after=_rows(balance.effort - final.residual, self.replay.after),
            held_out=balance.held & balance.usable,
            usable=balance.usable,
            start_ns=start_ns,
            position=self._shown_position(rows),
            position_unit=end,
            speed=motion.velocity[rows],
            speed_unit=f"{end}/s",
        )

    def _shown_position(self, rows: np.ndarray) -> FloatArray:
        """Within one turn where the output goes round."""
        position: FloatArray = self.motion.position[rows]
        turns = not self.machine.linear and self.catalogue.turns
        return np.mod(position, math.tau) if turns else position

    # What was measured, and what could not be.

    def _measured(self, named: bool) -> tuple[Measured, ...]:
        """The closest model as a whole: nominal and found values together."""
        catalogue = self.catalogue
        model = catalogue.model
        terms = list(self.contest.winner.terms) if named else list(self.contest.base.terms)
        keys = {one.key for one in terms}
        extra = []
        refined = {name for one in terms for name in one.refines} | {one.effect for one in terms}
        known = [catalogue.inertia()]
        friction = any(model.coulomb) and catalogue.both_ways
        if friction and model.coulomb + model.viscous != model.coulomb[::-1] + model.viscous[::-1]:
            known.append(catalogue.by_direction())
        else:
            known += [catalogue.viscous()] if any(model.viscous) else []
            known += [catalogue.coulomb()] if friction else []
        for one in known:
            inside = refined.intersection(one.refines)
            if one.key not in keys and one.effect not in refined and not inside:
                extra.append(one)
        fit = self.balance.fit([*terms, *extra], self.balance.usable)
        spans = self.balance.intervals(fit, self.balance.usable)
        found = []
        for one in fit.terms:
            for span in spans[one.key]:
                made = self._total(one, span)
                if made is not None:
                    found.append(made)
        rows = self.balance.usable
        left = fit.residual[rows] if not extra else self._whole_residual(named)[rows]
        size = float(np.sqrt(np.mean(self.balance.effort[rows] ** 2)))
        share = float(np.sqrt(np.mean(left**2))) / size
        name = self.motion.effort_name
        found.append(
            Measured(
                f"relative_{name}_error",
                "1",
                share,
                share,
                share,
                f"RMS of what is left over RMS of the {name}, over the whole run",
            )
        )
        return tuple(found)

    def _whole_residual(self, named: bool) -> FloatArray:
        if named:
            return self.whole.residual
        return self.balance.fit(self.contest.base.terms, self.balance.usable).residual

    def _total(self, term: Term, span: Interval) -> Measured | None:
        model, units = self.catalogue.model, self.units
        if term.key == "inertia":
            return Measured(*span, "all that moves", model.inertia)
        constant = model.constant if "constant" not in self._keys else 0.0
        totals = {
            units.per_speed("viscous"): (model.viscous[0], "friction in proportion to speed"),
            units.per_speed("viscous_positive"): (model.viscous[0], "the same, forwards"),
            units.per_speed("viscous_negative"): (model.viscous[1], "the same, backwards"),
            units.level("coulomb"): (model.coulomb[0], "friction level"),
            units.level("coulomb_positive"): (
                model.coulomb[0] + constant,
                "friction level forwards, constant load included",
            ),
            units.level("coulomb_negative"): (
                model.coulomb[1] - constant,
                "friction level backwards, constant load included",
            ),
        }
        if span.name in totals and term.effect != "friction_drift":
            base, meaning = totals[span.name]
            value, low, high = (one + base for one in span[2:])
            return Measured(span.name, span.unit, value, low, high, meaning, base or None)
        if term.effect == "constant_load":
            value, low, high = (one + model.constant for one in span[2:])
            nominal = model.constant or None
            return Measured(span.name, span.unit, value, low, high, "constant load", nominal)
        return None

    @property
    def _keys(self) -> set[str]:
        return {one.key for one in self.contest.winner.terms}

    def _costs(self) -> list[str]:
        """What the drive file leaves out, and what that costs."""
        machine, motion, catalogue = self.machine, self.motion, self.catalogue
        side = "load" if machine.linear else "rotor"
        notes: list[str] = []
        general = [
            f"a rigid drive has one inertia: motor and load cannot be told apart, friction is "
            f"named on the {side}; clearance, stiffness and electrical effects are not judged",
            f"compared up to {motion.bandwidth_hz:.3g} Hz (zero-phase), "
            f"{motion.rate_hz / motion.step:.3g} samples per second; faster effects are not seen",
        ]
        if motion.effort_unit not in ("N", "N m"):
            notes.append(
                f"actuation.gain is left out: effort is counted in {motion.effort_unit}, inertia "
                "and friction are known as multiples of it, and a wrong gain cannot be seen"
            )
        if catalogue.model.inertia is None:
            key = "load.mass" if machine.linear else "load.inertia"
            notes.append(
                f"{key} is left out: it was found from the recording, so that a wrong one, or a "
                "wrong gain of the effort, cannot be seen"
            )
        if not machine.loop_known:
            notes.append(
                "no controller in the drive file: delays and limits of the loop are not judged"
            )
        if not catalogue.both_ways:
            notes.append(
                "the output moves one way only: Coulomb friction and a constant load are one"
            )
        if machine.linear and machine.lead is None:
            notes.append("screw.lead is left out: what repeats over the stroke has a period in m")
        if self.mode is not None:
            notes.append(f"judged where the mode is {self.mode:g}")
        else:
            values = np.unique(motion.mode[np.isfinite(motion.mode)])
            if values.size > 1:
                listed = ", ".join(f"{one:g}" for one in values[:8].tolist())
                notes.append(
                    f"the mode changes within the run ({listed}): all were judged together; "
                    "--mode picks one"
                )
        return [*notes, *general]


def _merged(
    causes: Sequence[Cause], steps: Sequence[float]
) -> tuple[tuple[Cause, ...], tuple[float, ...]]:
    """Several orders or frequencies of one effect as one cause, the strongest first.

    Steps are kept where the last of its orders was added.
    """
    groups: dict[str, list[Cause]] = {}
    last: dict[str, float] = {}
    for one, step in zip(causes, steps, strict=True):
        groups.setdefault(one.effect, []).append(one)
        last[one.effect] = step
    made, reached = [], []
    level = math.inf
    for effect, group in groups.items():
        first = group[0]
        parameters = list(first.parameters)
        for number, other in enumerate(group[1:], start=2):
            parameters += [
                FittedParameter(numbered(p.name, number), p.unit, p.value, p.low, p.high)
                for p in other.parameters
            ]
        made.append(
            Cause(
                effect,
                first.block,
                first.title,
                min(one.confidence for one in group[:1]),
                tuple(parameters),
                sum(one.shrink for one in group),
                first.shrink_alone_lost,
                first.alternatives,
                first.excitation,
            )
        )
        level = min(level, last[effect])
        reached.append(level)
    return tuple(made), tuple(reached)


def _gathered(name: str, over: FloatArray, energy: FloatArray) -> ConditionShare:
    """How much of the energy falls into the tenth of `over`'s range that holds most of it."""
    low, high = float(over.min()), float(over.max())
    if not high > low:
        return ConditionShare(name, 1.0, 1.0)
    bins = np.clip(((over - low) / (high - low) * 10.0).astype(np.int64), 0, 9)
    shares = np.bincount(bins, weights=energy, minlength=10) / energy.sum()
    best = int(np.argmax(shares))
    return ConditionShare(name, float(shares[best]), float(np.mean(bins == best)))


def _rows(first: FloatArray, others: FloatArray) -> FloatArray:
    return np.concatenate([first[None], others.reshape(-1, first.size)])
