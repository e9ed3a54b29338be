"""Several recordings of one rigid drive: the effort that each motion needs, weighed together.

One set of causes with one value each and one sheet compete for all recordings at once; noise and
the phases of what swings with time are each recording's own. What one recording alone shows is told
by a fit of the same set to it; where a value differs by more than its intervals, the effects
compete again, with a value of that one for each recording. Last, everything is done once more
without the last recording, which then says what the others' causes are worth.
"""

from __future__ import annotations

import copy
import dataclasses
import functools
from collections.abc import Callable, Collection, Sequence

import numpy as np

from ...arrays import BoolArray
from ...drive.rigid.machine import Machine
from ...effects.apart import apart
from ...effects.catalogue import RIGID
from ...effects.term import Term
from ...errors import InputError
from ...recording.signals import Recording
from ..diagnosis import Diagnosis
from ..judge.verdict import shrink_of
from ..rigid.assemble import assembled
from ..rigid.diagnose import check_motion, effort_changes, inertia_of, judged
from ..rigid.joined import Joined, in_own_noise, joined, motions_of
from ..rigid.judge import Judgement
from ..rigid.own_band import looked_at_again
from ..rigid.rest import moving
from ..rigid.ruling import Ruling
from ..rigid.sets import Sets
from ..rigid.sheet import sheet_value
from ..rigid.solution import Solution
from ..rigid.terms import Catalogue
from ..rigid.uncertainty import intervals
from ..rigid.void import why_not
from .checks import check_one_machine, check_signals, marked_alone, with_differences
from .differences import differences
from .of_recording import OfRecording, OwnValue, Unseen, names_of

_BUILT_IN = ("load.mass", "load.inertia", "actuation.gain")  # that neither wear nor warmth changes
_JOINT, _ANEW, _UNSEEN = 0.5, 0.2, 0.3  # shares of the work


def diagnose_rigid_together(
    recordings: Sequence[Recording],
    machine: Machine,
    *,
    without: Collection[str],
    mode: float | None,
    sources: Sequence[str],
    drive_name: str,
    tell: Callable[[float], None],
) -> Diagnosis:
    """See `together.diagnose_together`; tell: called now and then with the share done.

    Raises:
        InputError: see `rigid.diagnose`; signals that one recording lacks, recordings of different
            machines.
    """
    check_signals(recordings, sources)
    motions = motions_of(recordings, machine, sources, mode)
    changes = [effort_changes(one) for one in motions]
    for one, source in zip(motions, sources, strict=True):
        check_motion(one, machine, source, changes=any(changes))
    motion = joined(motions, sources)
    motion = in_own_noise(motion, motions, inertia_of(Catalogue(motion, machine)))
    every = ", ".join(sources)
    judgement = judged(motion, machine, without, every, lambda share: tell(_JOINT * share))
    values = _values(judgement, sources, changes)
    differing = _differing(judgement, values, without)
    if differing:
        judgement = judged(
            motion, machine, without, every, lambda share: tell(_JOINT + _ANEW * share), differing
        )
        values = _values(judgement, sources, changes)
    told = differing | {RIGID[name].constant[not machine.linear] for name in differing}
    values = marked_alone(values, {one for one in told if one})
    found = assembled(judgement, mode, recordings, every, drive_name, without)
    again = functools.partial(
        diagnose_rigid_together,
        recordings,
        without=without,
        mode=mode,
        sources=sources,
        drive_name=drive_name,
        tell=lambda share: tell(_JOINT + _ANEW * share),
    )
    seen = looked_at_again(found, motion, machine, again)
    if seen.verdict != found.verdict:  # it is of the narrower band, with all that is said below
        return seen
    found = seen
    said = {one.effect for one in found.causes} | set(machine.half_widths())
    values = [[one for one in own if one.of in said] for own in values]
    tell(1.0 - _UNSEEN)
    unseen, why = _unseen(
        motion,
        judgement,
        without,
        sources,
        lambda share: tell(1.0 - _UNSEEN * (1.0 - share)),
    )
    notes = [*differences(values, sources), *([why] if why else [])]
    return dataclasses.replace(
        found,
        recordings=tuple(
            _of_recording(
                judgement, found, recordings[number], number, *called, values=values[number]
            )
            for number, called in enumerate(zip(sources, names_of(sources), strict=True))
        ),
        unseen=unseen,
        notes=(*notes, *found.notes),
    )


def _rows(judgement: Judgement, number: int) -> BoolArray:
    """Compared samples of one recording, bool[m]."""
    rows: BoolArray = judgement.balance.usable & (judgement.motion.recording == number)
    return rows


def _moving(judgement: Judgement, number: int) -> BoolArray:
    """Those of them that gap figures are of."""
    return moving(_rows(judgement, number), judgement.motion, judgement.catalogue.along)


def _common(terms: Sequence[Term]) -> list[Term]:
    """Terms with one value for all recordings."""
    return [one.common or one for one in terms]


def _values(
    judgement: Judgement, sources: Sequence[str], changes: Sequence[bool]
) -> list[list[OwnValue]]:
    """What each recording alone shows of the closest set and of the sheet.

    changes: whether the effort of each does. Alone, one that never changes says nothing: any
    friction of its level is in balance.

    Raises InputError where they are of different machines.
    """
    common, machine, units = judgement.null.common(), judgement.machine, judgement.units
    terms = _common(judgement.competed)
    found: list[list[OwnValue]] = []
    constants: list[dict[str, OwnValue]] = []
    for number in range(len(sources)):
        balance = copy.copy(judgement.balance)
        balance.usable = _rows(judgement, number)
        if not balance.usable.any():
            raise InputError(
                f"{sources[number]}: nothing of it can be compared beside the others; expected "
                "motion as long and as fast, or a diagnosis without it"
            )
        fit = common.fit(terms, balance.usable)
        spans = intervals(balance, fit, balance.usable)
        own, held, at = [], {}, 0
        for term in fit.terms:
            span = spans[term.key]
            told = sheet_value(term, span, machine, units)
            if told is not None:
                key, values = told.parameter, (told.value, told.low, told.high)
                held[key] = OwnValue(
                    key, key, told.unit, *values, seen=told.seen and changes[number]
                )
            if any(term is one for one in terms):
                along = judgement.catalogue.along
                seen = changes[number] and not why_not(balance, along, fit, term, span, at)
                fitted = [one for one in span if one.name not in term.fixed]
                own += [OwnValue(term.effect, *one, seen=seen) for one in fitted]
            elif told is not None and held[told.parameter].seen:
                own.append(held[told.parameter])
            at += term.columns.shape[0]
        found.append(own)
        constants.append(held if changes[number] else {})
    widths = machine.half_widths()
    check_one_machine(
        constants, {key: widths[key] for key in _BUILT_IN if widths.get(key, 0.0) > 0.0}, sources
    )
    return with_differences(found)


def _differing(
    judgement: Judgement, values: Sequence[Sequence[OwnValue]], without: Collection[str]
) -> set[str]:
    """Effects of which the recordings show different values, so that one of each is worth it.

    Their intervals lie beside one another, and values of their own earn their place as an effect
    does: on stretches that no fit saw.
    """
    keys = {one.of for own in values for one in own if one.differs}
    if not keys:
        return set()
    linear, order = judgement.machine.linear, judgement.competed
    effects = {one.effect for one in order if one.effect in keys}
    effects |= {
        one.term.effect
        for one in judgement.null.uncertain
        if RIGID[one.term.effect].constant[not linear] in keys
    }
    sets = Sets(judgement.null, judgement.floor, without)
    current = sets.fit(order)
    standing = sets.standing(current, order)
    found, parts = set(), judgement.motion.parts
    for name in sorted(effects):
        own = copy.copy(sets)
        own.null = judgement.null.with_own(name)
        then = [apart(one, parts) if one.effect == name else one for one in order]
        (term,) = [one for one in own.fit(then).terms if one.effect == name][:1]
        gain = own.gained(standing, then, term)
        if gain is not None and gain.earned and own.holds(current, own.fit(then), term):
            found.add(name)
    return found


def _of_recording(
    judgement: Judgement,
    found: Diagnosis,
    recording: Recording,
    number: int,
    source: str,
    name: str,
    values: Sequence[OwnValue],
) -> OfRecording:
    balance, motion = judgement.balance, judgement.motion
    own = _rows(judgement, number)
    held = own & judgement.judged if (own & judgement.judged).any() else own
    noise = float(motion.noise[number]) if isinstance(motion, Joined) else 1.0
    base, final = judgement.contest.nominal, judgement.contest.nominal
    unseen = None
    if found.causes:
        final = judgement.contest.winner
        order = [one if one.over_time else one.common or one for one in judgement.contest.order]
        others = balance.fitted & (motion.recording != number)
        fit = judgement.null.common().fit(order, others)
        whole = _moving(judgement, number)
        unseen = _shrink(base, _in_own_phase(judgement, fit, own), whole, judgement.floor)
    elif found.verdict == "within_sheet":
        final = judgement.contest.base
    before, after = base.rms(held), final.rms(held)
    first, behind = np.searchsorted(motion.recording, [number, number + 1]).tolist()
    return OfRecording(
        source=source,
        name=name,
        duration_s=recording.duration_s,
        rate_hz=recording.rate_hz,
        unit=motion.effort_unit,
        before=noise * before,
        after=noise * after,
        floor=noise * judgement.floor,
        shrink=_shrink(base, final, held, judgement.floor) if final is not base else 0.0,
        unseen=unseen,
        values=tuple(values),
        rows=(first, behind),
    )


def _shrink(base: Solution, final: Solution, rows: BoolArray, floor: float) -> float:
    before, after = base.rms(rows), final.rms(rows)
    return shrink_of(before, after, max(before - floor, 1e-12 * before, 1e-300))


def _in_own_phase(judgement: Judgement, fit: Solution, rows: BoolArray) -> Solution:
    """A fit that did not see `rows`, with what swings with time in the phase that it has there."""
    swings = [one for one in fit.terms if one.over_time]
    if not swings:
        return fit
    columns = judgement.balance.columns(swings)
    values = np.concatenate([fit.of(one) for one in swings])
    left = fit.residual + columns @ values
    seen = rows & ~judgement.balance.held
    found = np.linalg.lstsq(columns[seen], left[seen], rcond=1e-10)[0]
    return dataclasses.replace(fit, residual=np.where(rows, left - columns @ found, fit.residual))


def _unseen(
    motion: Joined,
    of_all: Judgement,
    without: Collection[str],
    sources: Sequence[str],
    tell: Callable[[float], None],
) -> tuple[Unseen | None, str]:
    """What the others name alone, held against the last recording; or why nothing can be said.

    of_all: of all recordings. Nothing of it is used but how large its noise is.
    """
    last = len(sources) - 1
    rows, noise = _moving(of_all, last), (of_all.floor, of_all.floor_is)
    usable = motion.usable.copy()
    usable[motion.parts[last]] = False
    others = dataclasses.replace(motion, usable=usable)
    try:
        judgement = judged(
            others, of_all.machine, without, ", ".join(sources[:-1]), tell, known=noise
        )
    except InputError as problem:
        return None, f"the last recording is not tested with the others alone: {problem}"
    ruling: Ruling = judgement.rule()
    unit = float(motion.noise[last])
    final = _in_own_phase(judgement, ruling.final, rows)
    shrink = 0.0
    if ruling.named or ruling.verdict == "within_sheet":
        shrink = _shrink(ruling.base, final, rows, judgement.floor)
    return (
        Unseen(
            source=sources[last],
            named_on=tuple(sources[:-1]),
            verdict=ruling.verdict,
            causes=tuple(dict.fromkeys(one.effect for one in ruling.causes)),
            before=unit * ruling.base.rms(rows),
            after=unit * final.rms(rows),
            floor=unit * judgement.floor,
            shrink=shrink,
        ),
        "",
    )
