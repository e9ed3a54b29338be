"""`diagnose_long`: an hour and more. The nominal model is replayed on stretches all over it, one of
those with a gap is diagnosed, and what is found is tried on the others."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Collection, Sequence

from ..analysis.one_thread import on_one_thread
from ..drive.parameters import DriveParameters
from ..drive.stability import check_stability
from ..errors import InputError
from ..recording.load import LongRecording
from ..recording.signals import Recording
from ..recording.stretch import Stretch
from .diagnose import diagnose
from .diagnosis import Diagnosis, StretchGap
from .fit.fit import Fit, Fitter, Values
from .fit.robust import cost, misfit
from .judge.verdict import STRUCTURELESS, at_floor
from .replay.replay import Replay
from .split import held_out

MOST_STRETCHES = 12
_NEAR_LARGEST = 0.5  # of the largest misfit: among such gaps the liveliest stretch tells most
_NOISE = 1.05  # times a perfect model's misfit: less, on one of many stretches, is chance
_SMALL = 0.1  # of the largest misfit above noise: what is less is not that gap
_GAUGED, _JUDGED = 0.2, 0.9  # shares of the work done when these are


@on_one_thread
def diagnose_long(
    recording: LongRecording,
    drive: DriveParameters,
    *,
    without: Collection[str] = (),
    source: str,
    drive_name: str,
    progress: Callable[[float], None] | None = None,
) -> Diagnosis:
    """Diagnose a recording too long to be judged whole, in memory for one stretch.

    Args:
        recording: its stretches, the liveliest first.
        drive: the nominal model.
        without: effects that the diagnosis must do without.
        source, drive_name: what messages call the two.
        progress: called now and then with the share done, 0 to 1.

    Returns:
        The diagnosis of the liveliest stretch with a large gap (of the liveliest, where there is
        none), with the gap of the others before and after in `stretches`, by time.

    Raises:
        InputError: as `diagnose`, where not one stretch can be judged.
    """
    tell = progress or (lambda share: None)
    check_stability(drive, drive_name)
    stretches = recording.stretches.chosen
    gauged: dict[Stretch, _Gauge] = {}
    refused: list[str] = []
    first: InputError | None = None
    for number, stretch in enumerate(stretches):
        try:
            gauged[stretch] = _gauge(recording.read(stretch), drive, source, {})
        except InputError as error:
            first = first or error
            why = str(error).removeprefix(f"{source}: ")
            refused.append(f"from {stretch.begin_s:.1f} s to {stretch.end_s:.1f} s: {why}")
        tell(_GAUGED * (number + 1) / len(stretches))
    if first is not None and not gauged:
        raise first
    chosen = _telling(gauged)
    part = recording.read(chosen)
    found = diagnose(
        part,
        drive,
        without=without,
        source=source,
        drive_name=drive_name,
        progress=lambda share: tell(_GAUGED + (_JUDGED - _GAUGED) * share),
    )
    told = []
    largest = max(one.misfit for one in gauged.values()) - 1.0
    for number, (stretch, before) in enumerate(gauged.items()):
        after = before
        if found.causes:
            after = _gauge(recording.read(stretch), drive, source, found.values)
        told.append(
            StretchGap(
                stretch.begin_s,
                stretch.end_s,
                before.misfit,
                after.misfit,
                gap=before.gap and before.misfit - 1.0 >= _SMALL * largest,
                judged=stretch is chosen,
            )
        )
        tell(_JUDGED + (1.0 - _JUDGED) * (number + 1) / len(gauged))
    told.sort(key=lambda one: one.begin_s)
    read = [note.removeprefix(f"{source}: ") for note in part.notes]
    notes = (*_notes(told, recording, found), *refused, *read, *found.notes)
    return dataclasses.replace(found, stretches=tuple(told), notes=notes)


@dataclasses.dataclass(frozen=True)
class _Gauge:
    """How far a model is from a stretch: robust misfit over that of a perfect one."""

    misfit: float
    at_floor: bool

    @property
    def gap(self) -> bool:
        """Whether it is off its floor by more than one of many stretches is by chance."""
        return not self.at_floor and self.misfit >= _NOISE


def _gauge(recording: Recording, drive: DriveParameters, source: str, values: Values) -> _Gauge:
    replay = Replay(recording, drive, source)
    fitter = Fitter(replay, held_out(replay.time_s))
    fit: Fit = fitter.evaluate(values)
    left = misfit(cost(fit.gap, replay.usable)) / fitter.perfect
    return _Gauge(left, at_floor(fit, replay))


def _telling(gauged: dict[Stretch, _Gauge]) -> Stretch:
    """The liveliest stretch among those with a large gap, or of all where none has one."""
    gaps = {stretch: one.misfit for stretch, one in gauged.items() if one.gap}
    if not gaps:
        return next(iter(gauged))
    least = _NEAR_LARGEST * max(gaps.values())
    return next(stretch for stretch, size in gaps.items() if size >= least)


def _notes(told: Sequence[StretchGap], recording: LongRecording, found: Diagnosis) -> list[str]:
    judged = next(one for one in told if one.judged)
    open_, closed = [one for one in told if one.gap], [one for one in told if not one.gap]
    length = judged.end_s - judged.begin_s
    lines = [
        f"{recording.stretches.whole_s:.0f} s long: {len(told)} stretches of {length:.0f} s were "
        f"replayed, chosen by {recording.stretches.by}; judged from {judged.begin_s:.1f} s to "
        f"{judged.end_s:.1f} s"
    ]
    if len(told) == 1:
        return lines
    if not open_:
        lines.append("no stretch shows a gap")
    elif closed:
        lines.append(
            f"the gap is not there all the time: in the stretches from {_times(open_)}, not in "
            f"those from {_times(closed)}"
        )
    else:
        lines.append("all stretches show a gap")
    others = [one for one in open_ if not one.judged]
    if found.causes and others:
        left = [one for one in others if one.after > STRUCTURELESS]
        if left:
            most = max(one.after for one in left)
            lines.append(
                f"the named causes leave up to {most:.3g} times the misfit of noise in the "
                f"stretches from {_times(left)}: another size there, or another cause beside it"
            )
        else:
            lines.append("the named causes explain the gap in the other stretches too")
    return lines


def _times(stretches: Sequence[StretchGap]) -> str:
    return ", ".join(f"{one.begin_s:.0f}" for one in stretches) + " s on"
