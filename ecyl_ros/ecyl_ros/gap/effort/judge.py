"""`diagnose_effort`: a recording and a rigid drive in; where the gap in effort lies, what causes
it, how far it shrinks out."""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Callable, Collection, Sequence

import numpy as np
from scipy.signal import find_peaks, welch

from ...effects.catalogue import CATALOGUE
from ...errors import InputError
from ...recording.signals import Recording
from ..diagnosis import (
    BoolArray,
    Candidate,
    Cause,
    ConditionShare,
    Diagnosis,
    FittedParameter,
    FloatArray,
    Measured,
    PortCheck,
    Series,
    SignalGap,
)
from ..verdict import EXPLAINED_SHRINK, NAMED, NO_GAP_RATIO, STRUCTURELESS
from .balance import Balance, Interval, Solution
from .compete import Contest, compete
from .floor import repeatability, white_floor
from .machine import Machine
from .motion import Motion, motion_of
from .terms import Catalogue, Term

SHORTEST_S = 3.0
_LINES = 3
_LATE = 1.5  # sampling periods: a delay below is that of sampling and holding
# Share of the gap that must be gone for anything to be named. Less than in replay: the floor of a
# real drive is what its best model could reach at all, and friction alone rarely gets there.
_HELPS = 0.25
_BLOCKS = {"gravity_on_arm": "load"}
_FINER = 0.8  # a floor below this share of the last one has the effects compete anew
_WANDERS = 0.05  # share of the effort that may not repeat where there is to be no gap
_CERTAIN = 0.97  # the most that a cause found by effort is believed
_LEAST = 0.2  # a cause less sure than this is named only if without it (or its like) ...
_MISSED = 0.1  # ... so large a share of the gap comes back
_SMALL = 0.03  # share of the gap that an effect has to take off to be named
_ALIKE = 1.02  # sets that leave so much at the most cannot be told apart
_UNLIKELY = 0.33  # weight of what gives the same columns as what is named, but is less common
_TOO_LITTLE = 24  # compared samples per second of use: fewer stretches say nothing


def diagnose_effort(
    recording: Recording,
    machine: Machine,
    *,
    without: Collection[str] = (),
    mode: float | None = None,
    source: str = "recording",
    drive_name: str = "drive",
    progress: Callable[[float], None] | None = None,
) -> Diagnosis:
    """Diagnose a rigid drive by the effort that its measured motion needs.

    Args:
        recording: of the real drive; position (or speed) of its output, and effort.
        machine: the nominal model, as far as it is known.
        without: effects to do without.
        mode: judge only the samples whose recorded mode has this value.
        source, drive_name: what messages call the two.
        progress: called now and then with the share done, 0 to 1.

    Raises:
        InputError: unusable input: no position, no effort, too short, no motion, no such mode.
    """
    begin = time.perf_counter()
    if len(recording) and recording.duration_s < SHORTEST_S:
        raise InputError(
            f"{source}: {recording.duration_s:.3g} s long, expected at least {SHORTEST_S:g} s to "
            "fit on one part and judge on another"
        )
    motion = motion_of(recording, machine, source, mode)
    _check(motion, machine, source)
    tell = progress or (lambda share: None)
    tell(0.05)
    catalogue = Catalogue(motion, machine)
    balance = Balance(motion, catalogue.nominal())
    if int(balance.usable.sum()) < 8 * _TOO_LITTLE:
        raise InputError(
            f"{source}: {int(balance.usable.sum())} samples can be compared, expected at least "
            f"{8 * _TOO_LITTLE}: more seconds, or fewer gaps"
        )
    floor, floor_is = _floor(balance, catalogue, machine, _broad(balance, catalogue))
    contest = compete(balance, catalogue, floor, without, lambda share: tell(0.1 + 0.4 * share))
    # What depends on time, or varies fast over the position, does not repeat until it is known.
    finer, finer_is = _floor(balance, catalogue, machine, contest.winner)
    if finer < _FINER * floor:
        floor, floor_is = finer, finer_is
        contest = compete(balance, catalogue, floor, without, lambda share: tell(0.5 + 0.4 * share))
    made = _Judgement(balance, catalogue, contest, floor, floor_is, mode)
    result = made.diagnosis(source, drive_name, begin, recording)
    tell(1.0)
    return result


def _check(motion: Motion, machine: Machine, source: str) -> None:
    if not np.isfinite(motion.effort).any():
        wanted = machine.actuation or ("force" if machine.linear else "torque")
        raise InputError(
            f"{source}: no effort ({wanted}) recorded; expected one to weigh the motion against, "
            "or a drive file of kind follower, which takes command and position alone"
        )
    moved = motion.velocity[motion.usable]
    if moved.size == 0 or not np.ptp(motion.position[motion.usable]) > 20.0 * motion.position_noise:
        raise InputError(
            f"{source}: the output does not move by more than 20 times its noise of "
            f"{motion.position_noise:.3g}; expected motion"
        )
    if not np.ptp(motion.effort[motion.usable]) > 0.0:
        raise InputError(f"{source}: the effort never changes; expected a recorded effort")


def _broad(balance: Balance, catalogue: Catalogue) -> Solution:
    """A fit that takes most of the smooth dependence on the motion away."""
    terms = [*catalogue.unknown(), catalogue.viscous(), catalogue.constant(), catalogue.spring()]
    if catalogue.both_ways:
        terms.append(catalogue.by_direction())
    return balance.fit(terms)


def _floor(
    balance: Balance, catalogue: Catalogue, machine: Machine, fit: Solution
) -> tuple[float, str]:
    """Standard deviation of what does not repeat once `fit` is taken away, and what it is."""
    turns = not machine.linear and catalogue.turns
    repeats = repeatability(balance, fit, turns)
    noise = machine.effort_noise
    gain = machine.gain if balance.motion.effort_unit in ("N", "N m") else None
    if noise is not None and gain is not None:
        noise *= gain
    white = white_floor(balance, noise)
    if repeats is None or repeats <= white:
        return max(white, 1e-12), "measurement noise"
    return repeats, "what the same motion does not repeat"


class _Judgement:
    """From a contest to a diagnosis."""

    def __init__(
        self,
        balance: Balance,
        catalogue: Catalogue,
        contest: Contest,
        floor: float,
        floor_is: str,
        mode: float | None,
    ) -> None:
        self.balance, self.catalogue, self.contest = balance, catalogue, contest
        self.floor, self.floor_is, self.mode = floor, floor_is, mode
        self.white = white_floor(balance, None)
        self.machine, self.motion = catalogue.machine, balance.motion
        self.units = catalogue.units
        judged = balance.judged if balance.judged.any() else balance.usable
        self.judged = judged
        self.spread = float(np.std(balance.effort[judged])) or 1.0
        # Gap figures are those of fits that saw a part; values are fitted anew to all of it.
        self.whole = balance.fit(contest.winner.terms, balance.usable)
        self.spans = balance.intervals(self.whole, balance.usable)
        self.notes: list[str] = []
        self._sure: dict[str, tuple[float, float, float]] = {}
        self._alike: dict[str, tuple[str, ...]] = {}
        self._shares: dict[str, float] = {}

    def rms(self, solution: Solution, rows: BoolArray | None = None) -> float:
        """Of what a solution leaves on `rows`, held-out ones unless told."""
        values = solution.residual[self.judged if rows is None else rows]
        return float(np.sqrt(np.mean(values**2)))

    def diagnosis(
        self, source: str, drive_name: str, begin: float, recording: Recording
    ) -> Diagnosis:
        """The result."""
        contest = self.contest
        before, best = self.rms(contest.base), self.rms(contest.winner)
        surplus = max(before - self.floor, 1e-12 * before, 1e-300)
        causes = self._causes(before, surplus)
        # An effort that wanders by itself does not repeat either: that is no floor, but a gap.
        wanders = self.floor > _WANDERS * self.spread and self.floor > 3.0 * self.white
        no_gap = before <= NO_GAP_RATIO * self.floor and not wanders
        if wanders:
            self.notes.append(
                f"{100.0 * self.floor / self.spread:.0f} % of the {self.motion.effort_name} does "
                "not repeat with the motion: it depends on something that was not recorded"
            )
        helps = before - best >= _HELPS * surplus
        named = bool(causes) and helps and not no_gap
        if named and any(self._unsure(one) for one in self.contest.order):
            causes = self._sure_ones(causes, before, surplus)
            contest, best = self.contest, self.rms(self.contest.winner)
            named = bool(causes) and before - best >= _HELPS * surplus
        if causes and not named and not no_gap:
            tried = ", ".join(one.title for one in causes)
            self.notes.append(f"closest in the catalogue, but too unsure to be named: {tried}")
        final = contest.winner if named else contest.base
        after = self.rms(final)
        shrink = max(0.0, min(1.0, (before - after) / surplus)) if named else 0.0
        if no_gap:
            verdict = "no_gap"
        elif not named:
            verdict = "unexplained"
        elif shrink >= EXPLAINED_SHRINK and after <= STRUCTURELESS * self.floor:
            verdict = "explained"
        else:
            verdict = "partly_explained"
        name = self.motion.effort_name
        block = causes[0].block if named else (None if no_gap else self._nearest_block())
        steps = [self.rms(one) / self.spread for one in contest.path]
        merged, reached = _merged(causes, steps)
        rivals = [one for one in contest.rivals if self._rival(one)]
        margin = self.rms(rivals[0]) / best if rivals and best > 0.0 else 1.0
        return Diagnosis(
            source=source,
            drive=drive_name,
            verdict=verdict,
            block=block,
            signals=(SignalGap(name, self.motion.effort_unit, before, after, self.floor),),
            when=() if no_gap else self._when(contest.base),
            frequency_hz=() if no_gap else self._lines(contest.base),
            ports=self._ports(),
            causes=merged if named else (),
            before=before / self.spread,
            after=after / self.spread,
            floor=self.floor / self.spread,
            shrink=shrink,
            steps=reached if named else (),
            candidates=self._candidates(),
            notes=(*self._costs(), *self.motion.notes, *self.notes),
            values=self._values() if named else {},
            series=self._series(contest.base, final, int(recording.stamp_ns[0])),
            seconds=time.perf_counter() - begin,
            replays=contest.fits,
            misfit_before=before / self.floor,
            misfit_after=after / self.floor,
            misfit_perfect=1.0,
            misfit_best=best / self.floor,
            margin=margin,
            duration_s=recording.duration_s,
            rate_hz=recording.rate_hz,
            measured=self._measured(named),
            floor_is=self.floor_is,
        )

    # Causes.

    def _causes(self, before: float, surplus: float) -> list[Cause]:
        contest = self.contest
        found = []
        shares: dict[str, float] = {}
        previous = before
        for term, fit in zip(contest.order, contest.path, strict=True):
            now = self.rms(fit)
            lost = self.rms(contest.without[term.effect]) - self.rms(contest.winner)
            known = CATALOGUE.get(term.effect)
            if term.key not in self._sure:  # judged once, beside its rivals and with all others
                acts, sure, alternatives = self._certainty(term, lost)
                self._sure[term.key] = (acts, sure, lost / surplus)
                self._alike[term.key] = alternatives
            shares[term.effect] = shares.get(term.effect, 0.0) + (previous - now) / surplus
            found.append(
                Cause(
                    effect=term.effect,
                    block=known.block if known else _BLOCKS.get(term.effect, "load"),
                    title=known.title if known else term.effect.replace("_", " "),
                    confidence=self._sure[term.key][1],
                    parameters=_fitted(self.spans[term.key]),
                    shrink=min(1.0, (previous - now) / surplus),
                    shrink_alone_lost=min(1.0, lost / surplus),
                    alternatives=self._alike[term.key],
                    excitation=known.excitation if known else "",
                )
            )
            previous = now
        self._shares = shares
        return found

    def _unsure(self, term: Term) -> bool:
        """Not to be named: unsure, small, or hardly missed while much could take its place."""
        acts, sure, missed = self._sure[term.key]
        exchangeable = sure < _LEAST and missed < _MISSED
        return acts < NAMED or exchangeable or self._shares[term.effect] < _SMALL

    def _certainty(self, term: Term, lost: float) -> tuple[float, float, tuple[str, ...]]:
        """That it, or what looks the same here, acts; that it does itself; what looks the same.

        The first grows with how much it is missed and how far behind the best set without it
        comes; the second is its share of the first among what this recording cannot tell from it.
        """
        best = max(self.rms(self.contest.winner), 1e-300)
        held = {one.effect for one in self.contest.order}
        weights = dict.fromkeys(term.alternatives, _UNLIKELY)
        behind = best + max(lost, 0.0)
        for rival in self.contest.rivals:
            finer = {name for one in rival.terms for name in one.refines}
            if term.effect in rival.effects or term.effect in finer:
                continue
            level = self.rms(rival)
            others = [
                one.effect for one in rival.terms if one.effect not in held and one.key != "inertia"
            ]
            if level <= _ALIKE * best and len(others) == 1:
                weights.setdefault(others[0], 1.0)
            else:
                behind = min(behind, level)
        sure = 1.0 - math.exp(-max(behind / best - 1.0, 0.0) / 0.03)
        acts = min(0.5 + 0.5 * sure, _CERTAIN)
        return acts, acts / (1.0 + sum(weights.values())), tuple(weights)

    def _rival(self, one: Solution) -> bool:
        """Whether a set could take the winner's place: it does not contain it."""
        refined = {name for term in one.terms for name in term.refines}
        named = {term.effect for term in self.contest.order}
        return not all(name in one.effects or name in refined for name in named)

    def _sure_ones(self, causes: Sequence[Cause], before: float, surplus: float) -> list[Cause]:
        """The causes that are sure enough, the others only noted and taken out of the model."""
        balance, contest = self.balance, self.contest
        kept = []
        for one, term in zip(causes, contest.order, strict=True):
            if not self._unsure(term):
                kept.append(term)
            else:
                why = f"confidence {one.confidence:.2f}, too unsure"
                if self._shares[term.effect] < _SMALL:
                    why = f"takes off {100.0 * one.shrink:.1f} % of the gap, too little"
                self.notes.append(f"{one.title}: {why} to be named")
        unknown = self.catalogue.unknown()
        path = [balance.fit([*unknown, *kept[: end + 1]]) for end in range(len(kept))]
        self.contest = dataclasses.replace(
            contest, winner=path[-1] if path else contest.base, order=tuple(kept), path=tuple(path)
        )
        self.whole = balance.fit(self.contest.winner.terms, balance.usable)
        self.spans = balance.intervals(self.whole, balance.usable)
        return self._causes(before, surplus)

    def _values(self) -> dict[str, dict[str, float]]:
        found: dict[str, dict[str, float]] = {}
        for at, one in enumerate(self.contest.order):
            values = {span.name: span.value for span in self.spans[one.key]}
            number = 1 + sum(other.effect == one.effect for other in self.contest.order[:at])
            if number > 1:
                values = {_numbered(name, number): value for name, value in values.items()}
            found.setdefault(one.effect, {}).update(values)
        return found

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
            recorded=balance.effort[None],
            before=(balance.effort - base.residual)[None],
            after=(balance.effort - final.residual)[None],
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
        machine, catalogue, units = self.machine, self.catalogue, self.units
        terms = list(self.contest.winner.terms) if named else list(self.contest.base.terms)
        keys = {one.key for one in terms}
        extra = []
        refined = {name for one in terms for name in one.refines} | {one.effect for one in terms}
        for one in (catalogue.inertia(), catalogue.viscous(), catalogue.coulomb()):
            free = one.key not in keys and one.effect not in refined
            if one.key == "viscous" and not machine.viscous:
                free = False
            if one.key == "coulomb" and not (catalogue.both_ways and machine.coulomb):
                free = False
            if free:
                extra.append(one)
        fit = self.balance.fit([*terms, *extra], self.balance.usable)
        spans = self.balance.intervals(fit, self.balance.usable)
        found = []
        known_inertia = machine.inertia if units.effort in ("N", "N m") else None
        for one in fit.terms:
            for span in spans[one.key]:
                made = self._total(one, span, known_inertia)
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

    def _total(self, term: Term, span: Interval, inertia: float | None) -> Measured | None:
        machine, units = self.machine, self.units
        if term.key == "inertia":
            return Measured(*span, "all that moves", inertia)
        constant = machine.constant if "constant" not in self._keys else 0.0
        totals = {
            units.per_speed("viscous"): (machine.viscous, "friction in proportion to speed"),
            units.per_speed("viscous_positive"): (machine.viscous, "the same, forwards"),
            units.per_speed("viscous_negative"): (machine.viscous, "the same, backwards"),
            units.level("coulomb"): (machine.coulomb, "friction level"),
            units.level("coulomb_positive"): (
                machine.coulomb + constant,
                "friction level forwards, constant load included",
            ),
            units.level("coulomb_negative"): (
                machine.coulomb - constant,
                "friction level backwards, constant load included",
            ),
        }
        if span.name in totals and term.effect != "friction_drift":
            base, meaning = totals[span.name]
            value, low, high = (one + base for one in span[2:])
            return Measured(span.name, span.unit, value, low, high, meaning, base or None)
        if term.effect == "constant_load":
            value, low, high = (one + machine.constant for one in span[2:])
            nominal = machine.constant or None
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
        if machine.inertia is None:
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


def _fitted(spans: Sequence[Interval]) -> tuple[FittedParameter, ...]:
    return tuple(FittedParameter(*one) for one in spans)


def _numbered(name: str, number: int) -> str:
    """The name of a further order's parameter: "amplitude_nm" is "amplitude_2_nm"."""
    first, mark, rest = name.partition("_")
    return f"{first}_{number}{mark}{rest}"


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
                FittedParameter(_numbered(p.name, number), p.unit, p.value, p.low, p.high)
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
