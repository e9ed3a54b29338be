"""A full cylinder judged by replay in closed loop: from a competition to a diagnosis."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import BoolArray
from ..drive.parameters import DriveParameters
from ..drive.stability import check_stability
from ..effects.catalogue import CATALOGUE
from ..recording.signals import Recording
from .compete.compete import compete
from .compete.competition import Competition
from .compete.earn import at_noise, gone
from .describe.apply import with_description
from .diagnosis import Candidate, Cause, Diagnosis, FittedParameter, Series, SheetValue
from .fit.fit import Fit, Fitter
from .fit.left_out import costs, not_to_be_judged, with_coupling
from .fit.robust import misfit
from .judge.clear import without_strained, without_unclear
from .judge.coincidence import Coincidence, without_coincidence
from .judge.constancy import Inconstancy, without_effects, without_stand_ins
from .judge.hidden import without_hidden
from .judge.intervals import intervals
from .judge.own_frequency import without_own_frequency
from .judge.place import without_open_ended
from .judge.pressed import pressed
from .judge.strained import without_causes
from .judge.tolerance import without_traces
from .judge.verdict import (
    NAMED,
    SEEN,
    Standing,
    alternatives,
    at_floor,
    confidence,
    helped,
    named_cause,
    ranked,
    ratios,
    settings,
    settings_alone,
    share_of,
    shrink_of,
    standing,
    undecided,
    verdict_of,
)
from .limits.cylinder import limits_of
from .locate.block import unnamed_block
from .locate.locate import (
    beside_the_loop,
    by_condition,
    by_frequency,
    by_port,
    by_signal,
    pooled,
    pooled_ports,
)
from .replay.replay import Replay


@dataclass(frozen=True, eq=False)
class Judged:
    """A full cylinder's competition, judged.

    Attributes:
        fitter: of the recordings. competition: with what does not hold taken out of its winner.
        closest: the winner before that.
        remarks: on what was taken out, one line each. no_gap: whether the nominal model is at the
            floor. barred: effects that did not compete.
    """

    fitter: Fitter
    competition: Competition
    closest: Fit
    remarks: tuple[str, ...]
    no_gap: bool
    barred: frozenset[str]

    @property
    def to_go_on(self) -> Competition:
        """The competition as it was before anything was taken out of its winner."""
        return dataclasses.replace(self.competition, winner=self.closest)


def diagnose_cylinder(
    recording: Recording,
    drive: DriveParameters,
    *,
    without: Collection[str],
    source: str,
    drive_name: str,
    tell: Callable[[float], None],
) -> Diagnosis:
    """See `diagnose.diagnose`; tell: called now and then with the share done.

    Raises:
        InputError: nothing to replay or compare, an unstable loop.
    """
    check_stability(drive, drive_name)

    def replayed(drive: DriveParameters) -> Replay:
        return Replay(recording, drive, source)

    found = judged(replayed, drive, without, lambda share: tell(0.82 * share))
    fitter = found.fitter
    diagnosis, final = assembled(found, source, drive_name)
    diagnosis = with_description(
        diagnosis, fitter, found.competition, lambda share: tell(0.82 + 0.13 * share)
    )
    tell(0.95)
    limits, not_told = limits_of(fitter, final, found.barred)
    return dataclasses.replace(diagnosis, limits=limits, alike=not_told, replays=fitter.replay.runs)


def judged(
    replayed: Callable[[DriveParameters], Replay],
    drive: DriveParameters,
    without: Collection[str],
    tell: Callable[[float], None],
    known: Competition | None = None,
) -> Judged:
    """Let the effects but those of `without` compete for what a drive's replay leaves.

    replayed: the replay of what was recorded, with a nominal model. tell: takes the share done.
    known: what came of it on some of the recordings, see `Judged.to_go_on`.
    """
    replay = replayed(drive)
    begun = with_coupling(replay)
    if begun is not drive:
        drive, replay = begun, replayed(begun)
    fitter = Fitter(replay, replay.held_out())
    nominal = fitter.nominal
    tell(0.02)
    fitter.test_floor(nominal)
    barred = frozenset({*without, *not_to_be_judged(drive)})
    if at_floor(nominal, replay):
        nothing = Competition(nominal, nominal, (), nominal, (), {})
        return Judged(fitter, nothing, nominal, (), True, barred)
    names = [name for name in CATALOGUE if name not in barred]
    competition = compete(fitter, names, lambda stage, share: tell(0.02 + 0.98 * share), known)
    closest = competition.winner
    competition, odd = without_stand_ins(competition, fitter)
    competition, alike = without_coincidence(competition, fitter)
    remarks = [_stand_in(one) for one in odd] + ([_coincide(alike)] if alike else [])
    if competition.unsearched:
        remarks.append(
            f"sets of {competition.unsearched} causes were not searched: replays of this drive "
            "cost too much"
        )
    hold = (
        without_own_frequency,
        without_hidden,
        without_strained,
        without_unclear,
        without_open_ended,
        without_traces,
        _without_unsure,
    )
    for holding in hold:
        competition, said = holding(competition, fitter)
        remarks += said
    return Judged(fitter, competition, closest, tuple(remarks), False, barred)


def _without_unsure(competition: Competition, fitter: Fitter) -> tuple[Competition, list[str]]:
    """The competition without causes that others fit as well as, beside causes that are sure."""
    names = competition.winner.names
    others = {name: alternatives(competition, name) for name in names}
    unsure = [name for name in names if others[name]]
    if not 0 < len(unsure) < len(names):
        return competition, []
    notes = []
    for name in unsure:
        titles = " or ".join(CATALOGUE[one].title for one in (name, *others[name]))
        notes.append(f"{titles} would improve the fit further, each equally well")
    return without_effects(competition, fitter, unsure), notes


def _steps(fitter: Fitter, competition: Competition) -> list[Fit]:
    """Fits as the causes are added in the order they earn their place, from the last back."""
    chain = [competition.winner]
    while len(chain[0].names) > 1:
        full = chain[0]
        options = []
        for name in full.names:
            known = competition.leave_one_out.get(name) if full is competition.winner else None
            options.append(known or fitter.fit(fitter.without(full, [name]), steps=4))
        chain.insert(0, min(options, key=lambda one: one.judged))
    return chain


def assembled(found: Judged, source: str, drive_name: str) -> tuple[Diagnosis, Fit]:
    """What is said, and the model that it is said of."""
    fitter, competition, no_gap = found.fitter, found.competition, found.no_gap
    replay = fitter.replay
    nominal, winner, alone = competition.nominal, competition.winner, competition.sheet
    held: BoolArray = fitter.held

    def in_all(fit: Fit) -> float:
        return pooled(replay, np.array(ratios(fit, held)))

    white = pooled(replay, np.ones(len(replay.signals)))
    before = in_all(nominal)
    perfect = fitter.sound_with(winner)
    place = standing(competition, perfect)
    notes = [*replay.notes, *found.remarks]
    chain = _steps(fitter, competition) if winner.names else []
    noise = fitter.noise_with(winner)
    floor = pooled(replay, noise)
    surplus = before - floor
    against = in_all(without_causes(competition, fitter))
    causes, at_bounds = _causes(found, chain, place, in_all, against, surplus)
    notes += at_bounds
    named = bool(causes) and min(one.confidence for one in causes) >= NAMED
    helps = helped(against, in_all(winner), white, place, gone(fitter, winner))
    reason = undecided(causes) if helps and not named else ""
    named = named and helps
    within_sheet = not (no_gap or named) and alone is not nominal and at_noise(fitter, alone)
    if not named:
        notes += [] if reason else _too_unlike(causes, winner)
        noise, floor = np.ones(len(replay.signals)), white
        surplus = before - floor
    elif floor > white:
        notes.append(
            f"with {' and '.join(one.title for one in causes)} the loop amplifies sensor noise "
            "and differences that are otherwise too small to show: even a perfect model may "
            f"leave up to {floor / white:.1f} times the sensor noise"
        )
    final = winner if named else alone
    after = in_all(final)
    shrink = shrink_of(before, after, surplus) if named or within_sheet else 0.0
    as_found = replay.at(fitter.sheet.constants(final.pulls))
    ports = pooled_ports([by_port(one) for one in as_found.parts])
    ports = beside_the_loop(ports, as_found.parts[0])
    verdict = verdict_of(
        no_gap=no_gap,
        within_sheet=within_sheet,
        named=named,
        shrink=shrink,
        left=misfit(winner.left) / perfect,
        undecided=bool(reason),
    )
    block: str | None = None
    if verdict in ("unexplained", "not_judgeable"):
        block = unnamed_block(competition, ports, as_found)
    elif named and not (no_gap or within_sheet):
        block = causes[0].block
    sheet = sheet_of(fitter, final)
    notes += costs(replay.drive, sheet)
    pool = [competition.winner, *competition.rivals, *competition.singles, competition.sheet]
    diagnosis = Diagnosis(
        source=source,
        drive=drive_name,
        verdict=verdict,
        block=block,
        signals=by_signal(replay, nominal, final, noise, held),
        when=by_condition(replay, nominal.gap) if not no_gap else (),
        frequency_hz=by_frequency(replay, nominal.gap) if not no_gap else (),
        ports=ports,
        causes=tuple(causes) if named else (),
        before=before,
        after=after,
        floor=floor,
        shrink=shrink,
        steps=tuple(in_all(fit) for fit in chain) if named else (),
        candidates=ranked(
            Candidate(one.names, misfit(one.fitted), misfit(one.judged)) for one in pool
        ),
        notes=tuple(notes),
        values={name: dict(given) for name, given in final.values.items()},
        series=_series(fitter, nominal, final),
        replays=fitter.replay.runs,
        misfit_before=misfit(nominal.left),
        misfit_after=misfit(final.left),
        misfit_perfect=perfect if named else fitter.perfect,
        misfit_best=misfit(winner.left),
        margin=place.margin,
        duration_s=float(replay.time_s[-1]),
        rate_hz=replay.recording.rate_hz,
        sheet=sheet,
        within_sheet=in_all(alone),
        reason=reason if verdict == "not_judgeable" else "",
    )
    return diagnosis, final


def _causes(
    found: Judged,
    chain: Sequence[Fit],
    place: Standing,
    in_all: Callable[[Fit], float],
    against: float,
    surplus: float,
) -> tuple[list[Cause], list[str]]:
    """The winner's effects as causes, in the order that they earn their place, and remarks.

    chain: fits as they are added, one a cause. in_all: what a fit leaves on held-out stretches.
    against: the same without causes. surplus: what stands above the floor.
    """
    fitter, competition = found.fitter, found.competition
    winner = competition.winner
    if not chain:
        return [], []
    order: list[str] = []
    for fit in chain:
        order += [name for name in fit.names if name not in order]
    spans, _ = intervals(winner, fitter)
    held_by_bound = pressed(winner, fitter)
    tuned = settings(winner.names)
    own = settings_alone(tuned)
    causes, notes = [], []
    previous = against
    for name, fit in zip(order, chain, strict=True):
        now = in_all(fit)
        others = alternatives(competition, name)
        sure = confidence(place, len(others)) * (own if name in tuned else 1.0)
        rest = against if len(chain) == 1 else in_all(competition.leave_one_out[name])
        parameters = []
        for quantity in CATALOGUE[name].reported:
            value = winner.values[name][quantity.name]
            low, high = spans.get((name, quantity.name), (value, value))
            bound = f"{name}.{quantity.name}" in held_by_bound
            parameters.append(
                FittedParameter(quantity.name, quantity.unit, value, low, high, bound)
            )
            if bound:
                notes.append(f"{name}: {quantity.name} is at the bound of its fit")
        off = share_of(previous - now, surplus)
        lost = share_of(rest - in_all(winner), surplus)
        needed = CATALOGUE[name].needed
        causes.append(named_cause(name, parameters, sure, others, off, lost, needed=needed))
        previous = now
    return causes, notes


def _too_unlike(causes: Sequence[Cause], winner: Fit) -> list[str]:
    """What is said of causes that come nearest, but are not named."""
    if not causes:
        return []
    tried = ", ".join(one.title for one in causes)
    notes = [f"closest in the catalogue, not named: {tried}"]
    if settings_alone(winner.names) < 1.0:
        notes.append(
            "together, settings of one controller give nearly any change of its response: one "
            "that the catalogue lacks may be the cause"
        )
    return notes


def _series(fitter: Fitter, nominal: Fit, final: Fit) -> Series:
    """What was recorded, and what both models play."""
    replay = fitter.replay
    return Series(
        replay.time_s,
        replay.reference_m,
        replay.recorded,
        replay.simulate(nominal.values),
        replay.simulate(final.values, fitter.sheet.constants(final.pulls)),
        fitter.held,
        replay.usable,
        int(replay.recording.stamp_ns[0]),
    )


def sheet_of(fitter: Fitter, final: Fit) -> tuple[SheetValue, ...]:
    """The data sheet as it was found beside the causes; what they stand for is left out."""
    sheet = fitter.sheet
    if not len(sheet) or final is fitter.nominal:
        return ()
    _, halves = intervals(final, fitter)
    found, low, high = (sheet.values(final.pulls + off) for off in (0.0, -halves, halves))
    return tuple(
        SheetValue(
            sheet.keys[row],
            sheet.units[row],
            float(sheet.nominal[row]),
            float(sheet.tolerance[row]),
            float(found[row]),
            float(low[row]),
            float(high[row]),
            seen=bool(halves[row] < SEEN),
            stated=sheet.keys[row] not in fitter.replay.drive.left_out,
        )
        for row in np.flatnonzero(sheet.free(final.values)).tolist()
    )


def _stand_in(one: Inconstancy) -> str:
    sizes = ", ".join(f"{size:g}" for size in one.sizes)
    return (
        f"{CATALOGUE[one.effect].title} comes near, but its size would have to change with "
        f"{one.condition} (times {sizes}): the true cause behaves differently"
    )


def _coincide(one: Coincidence) -> str:
    *first, last = (CATALOGUE[name].title for name in one.effects)
    return (
        f"{', '.join(first)} and {last} come near, but all are off by one factor "
        f"({one.factor:.3f}): one fault of another kind, such as a wrong unit or scale"
    )
