"""A rigid drive's effort that nothing in the catalogue explains, as a law along its motion.

The balance of efforts is linear in a law's table, so that what a cylinder needs replays for is one
regression: the law is fitted beside the data sheet on some stretches, and must hold on the others.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Sequence

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...drive.law import Law
from ...drive.rigid.law import counted_in, scaled
from ...drive.rigid.machine import KEYS, Machine
from ...effects.catalogue import EFFECTS, RIGID
from ...effects.term import Term
from ..compete.strain import SOUND
from ..diagnosis import Diagnosis, Measured, SheetValue
from ..judge.verdict import shrink_of
from ..rigid.closest import closest, per_effort
from ..rigid.judge import Judgement
from ..rigid.measured import relative_error
from ..rigid.replay import Replay, replay_with
from ..rigid.runaway import ran_away, without_runaways
from ..rigid.sets import Sets
from ..rigid.solution import Solution
from . import words
from .balance import Balance
from .choose import Choice, choose
from .description import Course, Description, Resembled
from .guess import Guess
from .measured_motion import MeasuredMotion
from .missing import TORQUE, Missing
from .nearest import curve
from .regressed import FREE, LEAST_STRETCHES, Held, described, held

_LAG = 4.0  # times half a sample


def with_rigid_description(
    diagnosis: Diagnosis, judgement: Judgement, without: Collection[str] = ()
) -> Diagnosis:
    """The diagnosis; where it is `unexplained` and a law holds on unseen data, `described`.

    without: effects that it is not said to resemble.
    """
    if diagnosis.verdict != "unexplained":
        return diagnosis
    found = _described(diagnosis, judgement, without)
    return diagnosis if found is None else found


def _missing(judgement: Judgement, motion: MeasuredMotion) -> Missing:
    """The effort that is missing, positive where it drives; the sheet beside it."""
    balance = judgement.balance
    terms = _sheet_terms(judgement)
    sheet = _per_pull(judgement)[:, None] * balance.columns(terms).T
    rows = np.flatnonzero(motion.known)
    pulled = tuple(range(len(sheet)))
    unit = judgement.motion.effort_unit
    same = np.zeros(len(pulled))  # the effort is what is measured, whatever the drive
    return Missing(
        TORQUE, unit, -balance.target, judgement.floor, motion.known, rows, -sheet, pulled, same
    )


def _sheet_terms(judgement: Judgement) -> tuple[Term, ...]:
    """What the file leaves out, and what it is not sure of."""
    null = judgement.null
    return (*null.unknown, *(one.term for one in null.uncertain))


def _per_pull(judgement: Judgement) -> FloatArray:
    """What the coefficients of these come to for a pull of one, float64[k]."""
    balance, null = judgement.balance, judgement.null
    found = []
    size = float(np.std(balance.target[balance.usable])) or 1.0
    for term in null.unknown:
        spread = np.std(balance.columns([term])[balance.usable], axis=0)
        found += (FREE * size / np.where(spread > 0.0, spread, 1.0)).tolist()
    for one in null.uncertain:
        # The lag was found beside what is missing, and may be off by as much as any lag may be.
        wide = 1.0 if _states(one.term) else _LAG
        found += [wide * one.width] * one.term.columns.shape[0]
    return np.array(found)


def _with_law(judgement: Judgement, choice: Choice, law: Law, left: FloatArray) -> Machine | None:
    """The drive with the constants that were found beside the law, and the law; None where its
    file holds one already."""
    along, terms = judgement.catalogue.along, _sheet_terms(judgement)
    if along.machine.learned is not None:
        return None
    unknown = sum(one.columns.shape[0] for one in judgement.null.unknown)
    pulls, per_pull = choice.best.found.pulls, _per_pull(judgement)
    prior = np.where(np.arange(pulls.size) < unknown, 0.0, 2.0 / per_pull)
    ones = np.ones(left.size)
    floor = judgement.floor
    beside = Solution(terms, pulls * per_pull, left, ones, floor, prior, 0.0, 1.0)
    machine = closest(along, beside)
    counted = scaled(law, per_effort(along, beside))
    return dataclasses.replace(machine, learned=counted, effects_unit=judgement.motion.effort_unit)


def _described(
    diagnosis: Diagnosis, judgement: Judgement, without: Collection[str]
) -> Diagnosis | None:
    balance, contest, floor = judgement.balance, judgement.contest, judgement.floor
    motion = MeasuredMotion.of(balance, judgement.catalogue)
    missing = _missing(judgement, motion)
    if len(np.unique(balance.stretch[motion.known & balance.fitted])) < LEAST_STRETCHES:
        return None
    looked = Balance([(missing, 1.0)], motion, balance.fitted)
    choice = choose(("torque", "friction"), {"torque": looked, "friction": looked}, motion)
    judged = balance.judged & motion.known
    if choice is None or not judged.any():
        return None
    holds = held(looked, choice, missing, judged, floor)
    named = min((one.rms(judged) for one in (contest.winner, *contest.rivals)), default=np.inf)
    if holds is None or named <= holds.left or _strained(choice, judgement):
        return None
    if not holds.whole:
        return dataclasses.replace(
            diagnosis, notes=(_short_of(judgement, choice, holds), *diagnosis.notes)
        )
    law, sheet = holds.law, holds.sheet
    found = _description(judgement, motion, looked, choice, missing, law, sheet)
    left = balance.target + law + sheet
    near = _resembled(judgement, motion, found, missing.rows, left, without)
    # Whether there is a law is decided where it is known; what it closes, wherever gaps are judged.
    nominal = contest.nominal.rms(judgement.judged)
    after = float(np.sqrt(np.mean(left[judgement.judged] ** 2)))
    if after >= nominal:
        return None
    shrink = shrink_of(nominal, after, max(nominal - floor, 1e-12))
    spread = judgement.spread
    series = diagnosis.series
    shown = judgement.motion.counted * (balance.effort - left)
    gap = dataclasses.replace(diagnosis.signals[0], after=after)
    machine = _with_law(judgement, choice, found.law, left)
    # Where no drive can hold the law, position and speed have no part in what it closes.
    played = Replay() if machine is None else replay_with(judgement, machine, left)
    played = without_runaways(played, ran_away(played, judged))
    rows = len(shown)
    error = relative_error(balance, left[balance.usable], balance.usable)
    return dataclasses.replace(
        diagnosis,
        verdict="described",
        block=words.BLOCKS[found.law.port],
        law=dataclasses.replace(found, shrink=shrink, resembles=near),
        signals=(gap, *played.signals),
        after=after / spread,
        shrink=shrink,
        series=dataclasses.replace(
            series,
            recorded=np.concatenate([series.recorded[:1], played.recorded.reshape(-1, rows)]),
            before=np.concatenate([series.before[:1], played.before.reshape(-1, rows)]),
            after=np.concatenate([shown[None], played.after.reshape(-1, rows)]),
        ),
        measured=_replaced(diagnosis.measured, (error, *played.measured)),
        closest=machine,
        judged=machine or diagnosis.judged,
        sheet=diagnosis.sheet if machine is None else _beside(machine, diagnosis.sheet),
        misfit_after=after / floor,
    )


def _beside(machine: Machine, sheet: Sequence[SheetValue]) -> tuple[SheetValue, ...]:
    """The constants as they are beside the law, which takes a part of what they had."""
    found = []
    for one in sheet:
        value = float(getattr(machine, KEYS[one.parameter].field))
        moved = value - one.value
        found.append(
            dataclasses.replace(one, value=value, low=one.low + moved, high=one.high + moved)
        )
    return tuple(found)


def _short_of(judgement: Judgement, choice: Choice, holds: Held) -> str:
    """What is said of a law that predicts a part of what is missing."""
    law = _at_port(judgement, choice.best)
    missing = f"the {judgement.motion.effort_name} that the sheet cannot account for,"
    told = words.closest(f"{words.place(law)} {words.depends(law)}", holds.share, missing)
    return f"{told}; something else acts beside it"


def _at_port(judgement: Judgement, best: Guess) -> Law:
    """A law where it acts, in the unit of the effort."""
    along = judgement.catalogue.along
    port = f"{along.side}_{'friction' if best.kind == 'friction' else 'torque'}"
    return counted_in(best.law(port), judgement.motion.effort_unit, along.machine.linear)


def _replaced(measured: Sequence[Measured], others: Sequence[Measured]) -> tuple[Measured, ...]:
    """What was measured, with others in the place of those of their name."""
    names = {one.name for one in others}
    return (*(one for one in measured if one.name not in names), *others)


def _strained(choice: Choice, judgement: Judgement) -> bool:
    """Whether a constant would lie further off its sheet than a sound one does."""
    stated = [False for one in judgement.null.unknown for _ in one.columns]
    stated += [_states(one.term) for one in judgement.null.uncertain for _ in one.term.columns]
    pulls = choice.best.found.pulls[np.array(stated, dtype=bool)]
    return bool(np.any(np.abs(pulls) > SOUND))


def _states(term: Term) -> bool:
    """Whether a data sheet states what a term stands for."""
    return any(RIGID[term.effect].constant)


def _description(
    judgement: Judgement,
    motion: MeasuredMotion,
    looked: Balance,
    choice: Choice,
    missing: Missing,
    law: FloatArray,
    sheet: FloatArray,
) -> Description:
    best = choice.best
    played = _at_port(judgement, best)
    against = -np.sign(motion.speed) if best.kind == "friction" else np.ones(len(motion.speed))
    rows = missing.rows
    values = missing.values - sheet
    band = 1.96 * judgement.white
    course = Course(motion.time_s, values, band, motion.known, law, played.unit)
    return described(
        looked,
        choice,
        played,
        f"{words.place(played)} {words.depends(played)}",
        course,
        (values * against)[rows],
        rows,
    )


def _resembled(
    judgement: Judgement,
    motion: MeasuredMotion,
    found: Description,
    rows: NDArray[np.int64],
    left: FloatArray,
    without: Collection[str],
) -> Resembled | None:
    """The nearest of the named effects, alone, whether it earned a place or not.

    rows: of the points of the description. left: float64[n], what the law leaves.
    """
    balance, floor = judgement.balance, judgement.floor
    judged = judgement.judged & motion.known
    unknown = {one.effect for one in judgement.null.unknown}
    sets = Sets(judgement.null, floor, without)
    alone = [
        (fit.rms(judged), name, fit)
        for fit in (sets.fit([one]) for one in sets.candidates(judgement.contest.base, ()))
        for name in fit.effects
        if name in EFFECTS and name not in unknown
    ]
    if not alone:
        return None
    misfit, name, nearest = min(alone, key=lambda one: one[0])
    own = float(np.sqrt(np.mean(left[judged] ** 2)))
    terms = [one for one in nearest.free if one.effect == name]
    asks = balance.columns(terms) @ np.concatenate([nearest.of(one) for one in terms])
    level = np.sign(motion.speed) * asks if found.law.of_friction else -asks
    near = curve(found.law, np.array([*found.points[:-1], level[rows]]))
    return Resembled(name, misfit / floor, own / floor, near)
