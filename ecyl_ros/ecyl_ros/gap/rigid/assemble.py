"""A judgement of a rigid drive as a `Diagnosis`."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Collection, Sequence

import numpy as np

from ...arrays import FloatArray
from ...drive.rigid.effects_file import as_file, numbered
from ...drive.rigid.machine import Machine
from ...effects.catalogue import CATALOGUE
from ...recording.signals import Recording
from ..diagnosis import Candidate, Cause, Diagnosis, FittedParameter, Series, SignalGap
from ..judge.verdict import ranked
from ..limits.rigid import rigid_limits
from .closest import closest
from .judge import Judgement
from .left_out import costs
from .locate import by_condition, by_frequency, by_port
from .machine_values import ALL_THAT_MOVES
from .measured import measured
from .other_motion import unused_motion
from .replay import Replay, replay
from .ruling import Ruling
from .runaway import ran_away, without_runaways
from .sheet import sheet_values
from .witness import borne_out, heard, refuted


def assembled(
    judgement: Judgement,
    mode: float | None,
    recordings: Sequence[Recording],
    source: str,
    drive_name: str,
    without: Collection[str] = (),
) -> Diagnosis:
    """Rule, replay, and put together what is said. mode: that was judged, None for all."""
    ruled = judgement.rule()
    terms = judgement.contest.order  # without what is not sure enough, once that is ruled
    ruling, light = borne_out(ruled, terms, judgement.balance)
    played = replay(judgement, ruling)
    over_time = any(one.over_time for one in terms)
    runaways = ran_away(played, judgement.judged)
    ruling, far = refuted(ruling, played, silent=over_time or runaways.before)
    if far:
        played = replay(judgement, ruling)
        runaways = ran_away(played, judgement.judged)
    ruling, worse = heard(ruling, played, over_time=over_time)
    played = without_runaways(played, runaways)
    if ruling.undecided:
        judgement.notes.insert(0, ruling.said_undecided)
    judgement.notes += [note for note in (light, far, worse) if note]
    balance, contest, floor = judgement.balance, judgement.contest, judgement.floor
    motion, along, spread = judgement.motion, judgement.catalogue.along, judgement.spread
    no_gap, named = ruling.verdict in ("no_gap", "within_sheet"), ruling.named
    block = ruling.causes[0].block if named else (None if no_gap else _nearest_block(judgement))
    steps = [one.rms(judgement.judged) / spread for one in contest.path]
    merged, reached = _merged(ruling.causes, steps) if named else ((), ())
    if len(merged) == 1:  # alone it removes what is removed
        merged = (dataclasses.replace(merged[0], shrink=ruling.shrink),)
    order = judgement.contest.order
    untold = [one for one in judgement.competed if not any(one is other for other in order)]
    whole = judgement.values.fit if named else judgement.null.fit([], balance.usable)
    told = whole if named else contest.base
    best = None
    if named or ruling.verdict == "within_sheet":
        best = closest(along, whole, untold if named else ())
    gap = SignalGap(motion.effort_name, motion.effort_unit, ruling.before, ruling.after, floor)
    before = contest.nominal.rms(judgement.judged)
    totals = measured(
        balance, along, told, named={one.key for one in order} if named else (), floor=floor
    )
    # What was found comes first, what no such drive can show last.
    said = [*judgement.notes, *motion.notes]
    inertia = any(one.meaning.startswith(ALL_THAT_MOVES) for one in totals)
    lacking = costs(motion, along, mode, inertia=inertia)
    unused = [note for one in recordings for note in unused_motion(one, judgement.machine)]
    return Diagnosis(
        source=source,
        drive=drive_name,
        verdict=ruling.verdict,
        block=block,
        signals=(gap, *played.signals),
        when=() if no_gap else by_condition(balance, along, ruling.base),
        frequency_hz=() if no_gap else by_frequency(balance, ruling.base),
        ports=by_port(balance, along, before, floor, spread),
        causes=merged,
        before=ruling.before / spread,
        after=ruling.after / spread,
        floor=floor / spread,
        shrink=ruling.shrink,
        steps=reached,
        candidates=_candidates(judgement),
        # Of two lines of one effect the same may be said.
        notes=tuple(dict.fromkeys([*said, *unused, *lacking, *played.notes])),
        values=_values(judgement, best) if named and best is not None else {},
        series=_series(judgement, ruling, played, int(recordings[0].stamp_ns[0])),
        replays=contest.fits,
        misfit_before=ruling.before / floor,
        misfit_after=ruling.after / floor,
        misfit_perfect=1.0,
        misfit_best=ruling.best / floor,
        margin=ruling.margin,
        duration_s=sum(one.duration_s for one in recordings),
        rate_hz=min(one.rate_hz for one in recordings),
        measured=(*totals, *played.measured),
        floor_is=judgement.floor_is,
        closest=best,
        judged=closest(along, ruling.final),
        sheet=sheet_values(
            judgement.values.fit.terms, judgement.values.spans, along.machine, along.units
        ),
        within_sheet=ruling.after / spread if ruling.verdict == "within_sheet" else None,
        reason=ruling.reason,
        limits=rigid_limits(judgement, without) if judgement.balance.moves else (),
        caution=motion.caution,
    )


def _values(judgement: Judgement, best: Machine) -> dict[str, dict[str, float]]:
    """Of the named causes, as a drive file takes them; best: the closest machine."""
    names = {one.effect for one in judgement.contest.order}
    written = as_file(best.effects, judgement.units, best.lead)
    return {name: values for name, values in written.items() if name in names}


def _nearest_block(judgement: Judgement) -> str | None:
    for one in judgement.contest.singles:
        names = [name for name in one.effects if name in CATALOGUE]
        if names:
            return CATALOGUE[names[-1]].block
    return None


def _candidates(judgement: Judgement) -> tuple[Candidate, ...]:
    contest, floor, fitted = judgement.contest, judgement.floor, judgement.balance.fitted
    unknown = {one.effect for one in judgement.null.unknown}
    return ranked(
        Candidate(
            tuple(name for name in one.effects if name not in unknown),
            one.rms(fitted) / floor,
            one.rms(judgement.judged) / floor,
        )
        for one in (contest.winner, *contest.rivals, *contest.singles, contest.base)
    )


def _series(judgement: Judgement, ruling: Ruling, played: Replay, start_ns: int) -> Series:
    motion, balance, along = judgement.motion, judgement.balance, judgement.catalogue.along
    rows, end, counted = motion.rows, along.units.end, motion.counted
    known = np.isfinite(motion.reference_position).any()
    reference = motion.reference_position[rows] if known else np.full(rows.size, np.nan)
    position = motion.position[rows]
    if not along.machine.linear and along.turns:  # within one turn where the output goes round
        position = np.mod(position, math.tau)
    return Series(
        time_s=balance.time_s,
        reference_m=reference,
        recorded=_rows(counted * balance.effort, played.recorded),
        before=_rows(counted * (balance.effort - ruling.base.residual), played.before),
        after=_rows(counted * (balance.effort - ruling.final.residual), played.after),
        held_out=balance.held & balance.usable,
        usable=balance.usable,
        start_ns=start_ns,
        position=position,
        position_unit=end,
        speed=motion.velocity[rows],
        speed_unit=f"{end}/s",
    )


def _rows(first: FloatArray, others: FloatArray) -> FloatArray:
    return np.concatenate([first[None], others.reshape(-1, first.size)])


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
        shrink = max(sum(one.shrink for one in group), 0.0)
        made.append(dataclasses.replace(first, parameters=tuple(parameters), shrink=shrink))
        level = min(level, last[effect])
        reached.append(level)
    return tuple(made), tuple(reached)
