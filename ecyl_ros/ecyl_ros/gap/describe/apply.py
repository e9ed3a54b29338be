"""A diagnosis in which nothing was named, with the law that describes the gap, if there is one."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np

from ..compete.competition import Competition
from ..diagnosis import Diagnosis, SheetValue
from ..fit.fit import Fitter
from ..fit.robust import misfit
from ..judge.verdict import SEEN
from ..locate.locate import by_signal, pooled
from .chance import LEVEL
from .describe import Described, as_fit, describe
from .description import Description
from .words import BLOCKS, closest

_FAR = 50.0  # tolerances: what is known no better is not known


def with_description(
    diagnosis: Diagnosis,
    fitter: Fitter,
    competition: Competition,
    tell: Callable[[float], None] = lambda share: None,
) -> Diagnosis:
    """The diagnosis; where it is `unexplained` and a law holds on unseen data, `described`."""
    if diagnosis.verdict != "unexplained":
        return diagnosis
    found = describe(fitter, competition, tell)
    if found is None:
        return diagnosis
    law = found.description
    if law.chance > LEVEL:
        return dataclasses.replace(diagnosis, notes=(_perhaps_by_chance(law), *diagnosis.notes))
    return described(diagnosis, found, fitter)


def _perhaps_by_chance(law: Description) -> str:
    """What is said of a law that a recording of few independent parts cannot tell from chance."""
    return (
        f"{closest(law.words, law.shrink, 'the gap')}, with a probability of "
        f"{_percent(law.chance)} that this is by chance (at most {_percent(LEVEL)}); a longer "
        "recording could tell"
    )


def _percent(share: float) -> str:
    return f"{float(f'{100.0 * share:.2g}'):g} %"


def described(diagnosis: Diagnosis, found: Described, fitter: Fitter) -> Diagnosis:
    """The diagnosis with what was found in its place."""
    replay, played, law = fitter.replay, found.played, found.description
    white = np.ones(len(replay.signals))
    held = fitter.held
    ratios = np.sqrt(np.mean(played.gap[:, held] ** 2, axis=1))
    after = replay.playing(played.law).simulate({}, fitter.sheet.constants(played.pulls))
    return dataclasses.replace(
        diagnosis,
        verdict="described",
        block=BLOCKS[law.law.port],
        law=law,
        signals=by_signal(replay, fitter.nominal, as_fit(played), white, held),
        after=pooled(replay, ratios),
        shrink=law.shrink,
        values={},
        series=dataclasses.replace(diagnosis.series, after=after),
        replays=replay.runs,
        misfit_after=misfit(played.left),
        sheet=_sheet(fitter, found),
    )


def _sheet(fitter: Fitter, found: Described) -> tuple[SheetValue, ...]:
    """The data sheet as it was found beside the law."""
    sheet, played = fitter.sheet, found.played
    halves = np.minimum(played.pull_half, _FAR)
    value, low, high = (sheet.values(played.pulls + off) for off in (0.0, -halves, halves))
    return tuple(
        SheetValue(
            key,
            sheet.units[row],
            float(sheet.nominal[row]),
            float(sheet.tolerance[row]),
            float(value[row]),
            float(low[row]),
            float(high[row]),
            seen=bool(halves[row] < SEEN),
            stated=key not in fitter.replay.drive.left_out,
        )
        for row, key in enumerate(sheet.keys)
    )
