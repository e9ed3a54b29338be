"""Several recordings of one full cylinder: replayed each from its own start, weighed together.

One set of causes with one value each and one sheet compete for all recordings at once. What one
recording alone shows is told by a fit of the same set to it; where a value differs by more than its
intervals, and another size in each recording earns its place, the effects compete again with such
sizes. First of all the others are judged without the last recording, which then says what their
causes are worth; where these account for the last as well, nothing else has to be searched for.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Collection, Mapping, Sequence

import numpy as np

from ...arrays import BoolArray, FloatArray
from ...drive.parameters import DriveParameters
from ...drive.stability import check_stability
from ...recording.signals import Recording
from ..cylinder import Judged, assembled, judged
from ..describe.apply import with_description
from ..diagnosis import Diagnosis
from ..fit.fit import Fit, Fitter
from ..fit.stages import FINE
from ..judge.verdict import shrink_of
from ..limits.cylinder import limits_of
from ..locate.locate import pooled
from ..replay.replay import SIGNALS, Replay
from ..sheet import Sheet
from .alone import STEPS, Alone, joined
from .checks import check_signals, marked_alone
from .differences import differences
from .joined_replay import JoinedReplay
from .of_recording import OfRecording, OwnValue, Unseen, names_of
from .own_sizes import own_sizes

_OTHERS, _JOINT, _ANEW = 0.5, 0.3, 0.2  # shares of the work


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

    others = judged(
        _replays(recordings[:-1], sources[:-1]),
        drive,
        without,
        lambda share: tell(_OTHERS * share),
    )
    found = judged(
        _replays(recordings, sources),
        drive,
        without,
        lambda share: tell(_OTHERS + _JOINT * share),
        others.to_go_on,
    )
    alone = Alone(found, sources)
    sizes = own_sizes(found, alone)
    if sizes:
        found = judged(
            _replays(recordings, sources, sizes),
            drive,
            without,
            lambda share: tell(_OTHERS + _JOINT + _ANEW * share),
            found.to_go_on,
        )
        alone = Alone(found, sources)
    winner = found.competition.winner
    fit = winner if winner.names else found.competition.sheet
    values = marked_alone(alone.values(fit), set(sizes))
    diagnosis, final = assembled(found, every, drive_name)
    diagnosis = with_description(diagnosis, found.fitter, found.competition)
    told = {*(one.effect for one in diagnosis.causes), *(one.parameter for one in diagnosis.sheet)}
    values = [[one for one in each if one.of in told] for each in values]
    unseen = _unseen(others, recordings, sources, drive_name)
    limits, not_told = limits_of(found.fitter, final, found.barred)
    names = names_of(sources)
    return dataclasses.replace(
        diagnosis,
        values=joined(found).effects_in(len(recordings) - 1, diagnosis.values),
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
    replay, fitter = joined(found), found.fitter
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
    fit = fitter.fit(fitter.evaluate(values, final.pulls), steps=STEPS, stage=FINE)
    return _played(replay.with_own({}), number, fit, fitter.sheet)


def _played(replay: JoinedReplay, number: int, fit: Fit, sheet: Sheet) -> FloatArray:
    """What a recording leaves with causes and constants that others gave, in floors."""
    constants = sheet.constants(fit.pulls)
    effects = replay.in_own_phase(number, fit.values, constants)
    return replay.parts[number].gap(effects, constants)


def _unseen(
    found: Judged, recordings: Sequence[Recording], sources: Sequence[str], drive_name: str
) -> Unseen:
    """What the others name alone, held against the last recording; found: of the others."""
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
