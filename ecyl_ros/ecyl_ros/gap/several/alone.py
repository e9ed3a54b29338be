"""What one recording alone shows of causes and sheet that were found from all of them."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Sequence

from ...effects.catalogue import CATALOGUE
from ..cylinder import Judged, sheet_of
from ..fit.fit import Fit, Fitter
from ..fit.stages import COARSE, FINE, MEDIUM
from ..judge.clear import unclear
from ..judge.intervals import intervals
from ..replay.hidden import NO_GAP_RATIO
from .checks import check_one_machine, with_differences
from .joined_replay import JoinedReplay
from .of_recording import OwnValue

STEPS = 6  # of a fit to one recording, in each stage
# What neither wear, warmth nor another load changes.
_BUILT_IN = ("motor.rotor_inertia", "motor.torque_constant", "transmission.lead")


def joined(found: Judged) -> JoinedReplay:
    """The recordings that were judged together."""
    replay = found.fitter.replay
    assert isinstance(replay, JoinedReplay)  # which `several.cylinder` makes
    return replay


class Alone:
    """The recordings of one judgement, each by itself; a set of effects is fitted once.

    found: the judgement. sources: what the recordings are called.
    """

    def __init__(self, found: Judged, sources: Sequence[str]) -> None:
        self._found, self._sources = found, sources
        self._known: dict[Fit, list[list[OwnValue]]] = {}

    def values(self, fit: Fit) -> list[list[OwnValue]]:
        """What each recording alone shows of a set of effects and of the sheet.

        Raises InputError where they are of different machines.
        """
        if fit not in self._known:
            self._known[fit] = self._values(fit)
        return self._known[fit]

    def _values(self, fit: Fit) -> list[list[OwnValue]]:
        replay, sheet = joined(self._found), self._found.fitter.sheet
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
            check_one_machine(constants, built_in, self._sources)
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
            start = fitter.fit(start, steps=STEPS, stage=stage)
        if _sound(start, fitter):
            (value,) = (one for one in _of_causes(start, fitter) if one.of == name)
            key = str(effect.constant)
            return [dataclasses.replace(value, of=key, name=key)]
    return []


def _fitted(fitter: Fitter, replay: JoinedReplay, number: int, fit: Fit) -> Fit:
    """A fit of the same effects and sheet to one recording alone."""
    start = fitter.evaluate(replay.effects_in(number, fit.values), fit.pulls)
    for stage in (MEDIUM, FINE):
        start = fitter.fit(start, steps=STEPS, stage=stage)
    return start


def _of_causes(fit: Fit, fitter: Fitter) -> list[OwnValue]:
    spans, _ = intervals(fit, fitter)
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
