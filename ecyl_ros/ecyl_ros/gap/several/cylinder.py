"""Several recordings of one full cylinder: replayed each from its own start, weighed together.

One set of causes with one value each and one sheet compete for all recordings at once. What one
recording alone shows is told by a fit of the same set to it; where a value differs by more than its
intervals, and another size in each recording earns its place, the effects compete again with such
sizes. Last, everything is done once more without the last recording, which then says what the
others' causes are worth.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Collection, Mapping, Sequence

import numpy as np

from ...drive.parameters import DriveParameters
from ...drive.stability import check_stability
from ...effects.catalogue import CATALOGUE
from ...recording.signals import Recording
from ..compete.earn import at_noise, earns
from ..cylinder import Judged, assembled, judged, sheet_of
from ..describe.apply import with_description
from ..diagnosis import Diagnosis
from ..fit.fit import Fit, Fitter
from ..fit.stages import COARSE, FINE, MEDIUM
from ..judge.clear import unclear
from ..judge.intervals import intervals
from ..judge.verdict import NO_GAP_RATIO, shrink_of
from ..limits.cylinder import limits_of
from ..locate.locate import pooled
from ..replay.replay import SIGNALS, BoolArray, FloatArray, Replay
from ..sheet import Sheet
from .checks import check_one_machine, check_signals, marked_alone, with_differences
from .differences import differences
from .joined_replay import JoinedReplay
from .of_recording import OfRecording, OwnValue, Unseen, names_of

# What neither wear, warmth nor another load changes.
_BUILT_IN = ("motor.rotor_inertia", "motor.torque_constant", "transmission.lead")
_STEPS = 6  # of a fit to one recording, in each stage
_JOINT, _ANEW, _UNSEEN = 0.5, 0.2, 0.3  # shares of the work
_SINGLES = 3  # effects alone that may differ, of the closest
_SMALLEST = 0.05  # of a size over another, so that factors mean something


def diagnose_cylinders(
    recordings: Sequence[Recording],
    drive: DriveParameters,
    *,
    without: Collection[str],
    sources: Sequence[str],
    drive_name: str,
    tell: Callable[[float], None],
) -> Diagnosis:
    """See `together.diagnose_together`; tell: called now and then with the share done.

    Raises:
        InputError: see `cylinder.diagnose_cylinder`; signals that one recording lacks, recordings
            of different machines.
    """
    check_stability(drive, drive_name)
    check_signals(recordings, sources, [one.recorded for one in SIGNALS])
    every = ", ".join(sources)

    def of_all(share: float) -> None:
        tell(_JOINT * share)

    found = judged(_replays(recordings, sources), drive, without, of_all)
    sizes = _differing(found, sources)
    if sizes:
        found = judged(
            _replays(recordings, sources, sizes),
            drive,
            without,
            lambda share: tell(_JOINT + _ANEW * share),
        )
    tell(_JOINT + _ANEW)
    winner = found.competition.winner
    fit = winner if winner.names else found.competition.sheet
    values = marked_alone(_values(found, fit, sources), set(sizes))
    diagnosis, final = assembled(found, every, drive_name)
    diagnosis = with_description(diagnosis, found.fitter, found.competition)
    told = {*(one.effect for one in diagnosis.causes), *(one.parameter for one in diagnosis.sheet)}
    values = [[one for one in each if one.of in told] for each in values]
    unseen = _unseen(
        recordings,
        drive,
        without,
        sources,
        drive_name,
        lambda share: tell(1.0 - _UNSEEN * (1.0 - share)),
    )
    limits, not_told = limits_of(found.fitter, final, found.barred)
    names = names_of(sources)
    return dataclasses.replace(
        diagnosis,
        values=_joined(found).effects_in(len(recordings) - 1, diagnosis.values),
        limits=limits,
        alike=not_told,
        replays=found.fitter.replay.runs,
        duration_s=sum(one.duration_s for one in recordings),
        recordings=tuple(
            _of_recording(found, diagnosis, final, recordings[number], number, *called, values)
            for number, called in enumerate(zip(sources, names, strict=True))
        ),
        unseen=unseen,
        notes=(*differences(values, sources), *diagnosis.notes),
    )


def _replays(
    recordings: Sequence[Recording],
    sources: Sequence[str],
    sizes: Mapping[str, Sequence[float]] | None = None,
) -> Callable[[DriveParameters], JoinedReplay]:
    """What replays the recordings on a nominal model."""
    every = list(zip(recordings, sources, strict=True))
    return lambda drive: JoinedReplay([Replay(one, drive, source) for one, source in every], sizes)


def _joined(found: Judged) -> JoinedReplay:
    replay = found.fitter.replay
    assert isinstance(replay, JoinedReplay)  # which `_replays` makes
    return replay


def _values(found: Judged, fit: Fit, sources: Sequence[str]) -> list[list[OwnValue]]:
    """What each recording alone shows of a set of effects and of the sheet.

    Raises InputError where they are of different machines.
    """
    replay, sheet = _joined(found), found.fitter.sheet
    built_in = {
        key: float(width)
        for key, width in zip(sheet.keys, sheet.tolerance, strict=True)
        if key in _BUILT_IN
    }
    values: list[list[OwnValue]] = []
    constants: list[dict[str, OwnValue]] = []
    for number, part in enumerate(replay.parts):
        fitter = Fitter(part, part.held_out())
        alone = _fitted(fitter, replay, number, fit)
        held = _of_sheet(alone, fitter)
        values.append([*_of_causes(alone, fitter), *(one for one in held if one.seen)])
        if not _sound(alone, fitter):
            held = _another_machine(alone, fitter, built_in)
        constants.append({one.of: one for one in held})
    if any(constants):
        check_one_machine(constants, built_in, sources)
    return with_differences(values)


def _sound(fit: Fit, fitter: Fitter) -> bool:
    """Whether noise accounts for what a fit leaves."""
    return fit.left <= (NO_GAP_RATIO * fitter.perfect_with(fit.values)) ** 2


def _another_machine(fit: Fit, fitter: Fitter, keys: Collection[str]) -> list[OwnValue]:
    """The constant that another value of, as good as free, accounts for all that a fit leaves."""
    nominal = fitter.replay.nominal
    for name, effect in CATALOGUE.items():
        if effect.constant not in keys or effect.on_top or name in fit.values:
            continue
        size = effect.parameters[0]
        start = fitter.evaluate(
            {**fit.values, name: {size.name: effect.neutral(nominal)}}, fit.pulls
        )
        for stage in (COARSE, MEDIUM, FINE):
            start = fitter.fit(start, steps=_STEPS, stage=stage)
        if _sound(start, fitter):
            (value,) = (one for one in _of_causes(start, fitter) if one.of == name)
            key = str(effect.constant)
            return [dataclasses.replace(value, of=key, name=key)]
    return []


def _fitted(fitter: Fitter, replay: JoinedReplay, number: int, fit: Fit) -> Fit:
    """A fit of the same effects and sheet to one recording alone."""
    start = fitter.evaluate(replay.effects_in(number, fit.values), fit.pulls)
    for stage in (MEDIUM, FINE):
        start = fitter.fit(start, steps=_STEPS, stage=stage)
    return start


def _of_causes(fit: Fit, fitter: Fitter) -> list[OwnValue]:
    spans, _ = intervals(fit, fitter.rows, fitter.replay.time_s, fitter.sheet)
    hidden = unclear(fit, fitter)
    return [
        OwnValue(
            name,
            one.name,
            one.unit,
            given[one.name],
            *spans.get((name, one.name), (given[one.name], given[one.name])),
            seen=name not in hidden,
        )
        for name, given in fit.values.items()
        for one in CATALOGUE[name].reported
    ]


def _of_sheet(fit: Fit, fitter: Fitter) -> list[OwnValue]:
    return [
        OwnValue(
            one.parameter, one.parameter, one.unit, one.value, one.low, one.high, seen=one.seen
        )
        for one in sheet_of(fitter, fit)
    ]


def _differing(found: Judged, sources: Sequence[str]) -> dict[str, list[float]]:
    """Sizes over that of the last recording, of what has to have another one in each.

    The intervals lie beside one another, and sizes of their own earn their place as an effect
    does: on stretches that no fit saw. Where no set comes to the floor with common sizes, one
    effect alone with sizes of its own may.
    """
    closest = found.closest
    tried = [closest] if not found.no_gap else []
    if tried and not at_noise(found.fitter, closest):
        tried += [one for one in found.competition.singles[:_SINGLES] if one.names]
    best, sizes = closest, dict[str, list[float]]()
    for fit in tried:
        own, after = _with_own_sizes(found, fit, sources)
        if own and after.judged < best.judged:
            best, sizes = after, own
            if at_noise(found.fitter, after):
                break
    return sizes


def _with_own_sizes(
    found: Judged, fit: Fit, sources: Sequence[str]
) -> tuple[dict[str, list[float]], Fit]:
    """Sizes of its own of what differs in a set of effects, where they earn their place."""
    values = _values(found, fit, sources)
    taken: dict[str, list[float]] = {}
    for key in sorted({one.of for each in values for one in each if one.differs}):
        factors = _factors(key, found, values)
        if factors is None:
            continue
        replay = _joined(found).with_own({**taken, key: factors})
        fitter = Fitter(replay, replay.held_out())
        after = fitter.evaluate(fit.values, fit.pulls)
        for stage in (MEDIUM, FINE):
            after = fitter.fit(after, steps=_STEPS, stage=stage)
        if earns(fitter, after, fit):
            taken[key] = factors
            fit = after
    return taken, fit


def _factors(key: str, found: Judged, values: Sequence[Sequence[OwnValue]]) -> list[float] | None:
    """How large a cause or constant is in each recording, over the last; None without a size."""
    sizes = []
    for each in values:
        value = next((one.value for one in each if one.of == key), None)
        if value is None:
            return None
        sizes.append(value - _neutral(key, found))
    if key in CATALOGUE and CATALOGUE[key].sized == ():
        return None
    most = max(abs(one) for one in sizes)
    if abs(sizes[-1]) < _SMALLEST * most:
        return None
    return [one / sizes[-1] for one in sizes]


def _neutral(key: str, found: Judged) -> float:
    return CATALOGUE[key].neutral(found.fitter.replay.nominal) if key in CATALOGUE else 0.0


def _pooled(replay: Replay, gap: FloatArray, rows: BoolArray) -> float:
    """RMS of a gap on `rows`, pooled over the signals as shares of them."""
    return pooled(replay, np.sqrt(np.mean(gap[:, rows] ** 2, axis=1)))


def _shrink(before: float, after: float, floor: float) -> float:
    """Share of what stands above the floor that is gone."""
    return shrink_of(before, after, max(before - floor, 1e-12))


def _of_recording(
    found: Judged,
    diagnosis: Diagnosis,
    final: Fit,
    recording: Recording,
    number: int,
    source: str,
    name: str,
    values: Sequence[Sequence[OwnValue]],
) -> OfRecording:
    replay, fitter = _joined(found), found.fitter
    part, span = replay.parts[number], replay.spans[number]
    held = fitter.held[span]
    if not held.any():
        held = part.usable
    nominal, left = fitter.nominal.gap, replay.gap_of(diagnosis.series.after)
    white = pooled(part, np.ones(len(part.signals)))
    before, after = (_pooled(part, gap[:, span], held) for gap in (nominal, left))
    unseen = None
    if diagnosis.causes:
        others = [one for one in range(len(replay.parts)) if one != number]
        whole = part.usable
        base = _pooled(part, nominal[:, span], whole)
        rest = _pooled(part, _by_others(replay, others, number, final), whole)
        unseen = _shrink(base, rest, white)
    return OfRecording(
        source=source,
        name=name,
        duration_s=recording.duration_s,
        rate_hz=recording.rate_hz,
        unit="",
        before=before,
        after=after,
        floor=white,
        shrink=_shrink(before, after, white) if diagnosis.closes else 0.0,
        unseen=unseen,
        values=tuple(values[number]),
        rows=(span.start, span.stop),
    )


def _by_others(replay: JoinedReplay, others: Sequence[int], number: int, final: Fit) -> FloatArray:
    """What a recording leaves with the same causes fitted to the others alone, in floors."""
    subset = replay.subset(others)
    fitter = Fitter(subset, subset.held_out())
    values = replay.effects_among(others, final.values)
    fit = fitter.fit(fitter.evaluate(values, final.pulls), steps=_STEPS, stage=FINE)
    return _played(replay.with_own({}), number, fit, fitter.sheet)


def _played(replay: JoinedReplay, number: int, fit: Fit, sheet: Sheet) -> FloatArray:
    """What a recording leaves with causes and constants that others gave, in floors."""
    constants = sheet.constants(fit.pulls)
    effects = replay.in_own_phase(number, fit.values, constants)
    return replay.parts[number].gap(effects, constants)


def _unseen(
    recordings: Sequence[Recording],
    drive: DriveParameters,
    without: Collection[str],
    sources: Sequence[str],
    drive_name: str,
    tell: Callable[[float], None],
) -> Unseen:
    """What the others name alone, held against the last recording."""
    found = judged(_replays(recordings[:-1], sources[:-1]), drive, without, tell)
    diagnosis, final = assembled(found, ", ".join(sources[:-1]), drive_name)
    fitter = found.fitter
    last = Replay(recordings[-1], fitter.replay.nominal, sources[-1])
    every = JoinedReplay([*fitter.replay.parts, last])
    part = every.parts[-1]
    rows = part.usable
    white = pooled(part, np.ones(len(part.signals)))
    before = _pooled(part, part.gap({}), rows)
    gap = _played(every, len(sources) - 1, final, fitter.sheet)
    after = _pooled(part, gap, rows)
    closes = bool(diagnosis.causes) or diagnosis.verdict == "within_sheet"
    return Unseen(
        source=sources[-1],
        named_on=tuple(sources[:-1]),
        verdict=diagnosis.verdict,
        causes=tuple(one.effect for one in diagnosis.causes),
        before=before,
        after=after,
        floor=white,
        shrink=_shrink(before, after, white) if closes else 0.0,
    )
