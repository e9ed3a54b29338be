"""Drawing rigid drives with a hidden fault: what is sealed, and what a diagnosis is given."""

from __future__ import annotations

import math
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import combinations, starmap
from typing import NamedTuple

import numpy as np

from ....arrays import FloatArray
from ....effects.actuation_delay import LATE
from ....errors import InputError
from ....recording.signals import Recording
from ...judge.verdict import NO_GAP_RATIO
from ..case import STRUCTURE, Case
from .drawn import Drawn, draw_drive, moved_anew
from .equations import Truth, run
from .faults import STRANGE, Faulty, clear, faults
from .judgeable import SHOWS, pulled, standing
from .logger import record
from .structure import with_structure

SHARES = {"single": 0.5, "none": 0.2, "withheld": 0.1, "pair": 0.2, STRUCTURE: 0.6}
KINDS, USUAL = tuple(SHARES), ("single", "none", "withheld", "pair")
SHEET_SD, SHEET_SHARE = 0.05, 0.6  # of the drives are off their sheet by so much, unless told
RECORDINGS, SECONDS = "recordings", "seconds_each"  # facts of a case of several recordings
SILENT = "silent"  # fact of a case whose drive file states no tolerances
# Over all other noise, from which what another axis pulls raises it by what counts as a gap.
_PULLS = math.sqrt(NO_GAP_RATIO**2 - 1.0)
_TRIED = 40  # faults, for one that goes beside another
_ATTEMPTS = 8  # at a drive that keeps to its reference
_ASTRAY = 0.5  # of the travel: a drive that far from its reference has run away


class Played(NamedTuple):
    """A drive and how it moved with its faults: rows as `equations.run` gives them.

    truth: with all of them. alone: with each by itself, and its values, by name.
    """

    drawn: Drawn
    truth: Truth
    alone: dict[str, Faulty]
    rows: FloatArray


def plan_cases(
    count: int,
    seed: int,
    *,
    kinds: tuple[str, ...] = USUAL,
    effects: tuple[str, ...] | None = None,
    without: tuple[str, ...] = (),
    sheet: float | None = None,
    several: tuple[int, float] | None = None,
    silent: bool = False,
) -> list[Case]:
    """Cases without parameters: kinds in their shares, each fault equally often by output.

    Args:
        count, seed: the same give the same cases.
        kinds: of these alone. effects: cases of these faults alone, and without one.
        without: names that no diagnosis of the study is given; only withheld cases hold them.
        sheet: relative standard deviation of constants off the sheet; None: drawn by case.
        several: how many recordings of each drive, and how long each is, s; None: one, as usual.
        silent: whether drive files state no tolerances.
    """
    rng = np.random.default_rng([seed, count])
    usable = [kind for kind in KINDS if kind in kinds]
    queues: dict[tuple[bool, bool], Iterator[str]] = {}
    together = False
    for linear in (True, False):
        named = [name for name in faults(linear) if effects is None or name in effects]
        given = [name for name in named if name not in without]
        barred = [name for name in named if not without or name in without]
        for withheld, usual in ((False, given), (True, barred)):
            queues[linear, withheld] = _rounds(usual, rng)
        together = together or any(starmap(clear, combinations(given, 2)))
    if len(usable) > 1 and not together:
        usable = [kind for kind in usable if kind != "pair"]
    shares = np.array([SHARES[kind] for kind in usable])
    facts = {} if several is None else {RECORDINGS: several[0], SECONDS: several[1]}
    facts |= {SILENT: True} if silent else {}
    cases = []
    for index in range(count):
        linear = bool(rng.random() < 0.5)
        off = SHEET_SD if rng.random() < SHEET_SHARE else 0.0
        kind = str(rng.choice(usable, p=shares / shares.sum()))
        names: tuple[str, ...] = ()
        if kind != "none":
            names = _of_kind(queues, linear, kind)
            if not names:  # faults of the other output alone
                linear = not linear
                names = _of_kind(queues, linear, kind)
            if not names:
                raise InputError(
                    f"no case of kind {kind} is left with the effects asked for; expected one of "
                    f"{', '.join(dict.fromkeys([*faults(True), *faults(False)]))}"
                )
        hidden = set(without) | (set(names) if kind == "withheld" else set())
        cases.append(
            Case(
                index=index,
                seed=int(rng.integers(2**31)),
                kind=kind,
                effects={name: {} for name in names},
                withheld=tuple(sorted(hidden)),
                drives="rigid",
                sheet=off if sheet is None else sheet,
                facts={"linear": linear, **facts},
            )
        )
    return cases


def _of_kind(
    queues: Mapping[tuple[bool, bool], Iterator[str]], linear: bool, kind: str
) -> tuple[str, ...]:
    """The next fault of an output, of a pair two that can be told apart; none where none is."""
    queue = queues[linear, kind == "withheld"]
    first = next(queue, None)
    if first is None or kind != "pair":
        return () if first is None else (first,)
    others = (next(queue) for _ in range(_TRIED))
    second = next((one for one in others if clear(first, one)), None)
    return () if second is None else (first, second)


def _rounds(names: list[str], rng: np.random.Generator) -> Iterator[str]:
    """Every name once in random order, then again; nothing where there is none."""
    while names:
        yield from (names[index] for index in rng.permutation(len(names)))


def play(case: Case) -> tuple[Played, ...]:
    """The drive of a case with its fault, moved, once for each recording of it.

    Raises:
        InputError: it does not keep to its way.
    """
    effects = [one for one in case.effects if one not in STRANGE]
    count, seconds = int(case.facts.get(RECORDINGS, 1)), case.facts.get(SECONDS)
    linear = bool(case.facts["linear"])
    silent = bool(case.facts.get(SILENT, False))
    drawn = draw_drive(case.seed, linear, effects, case.sheet, silent=silent)
    truth, alone = drawn.truth, {}
    for effect in effects:
        fault, seed = faults(linear)[effect], [case.seed, zlib.crc32(effect.encode())]
        alone[effect] = fault(drawn.truth, drawn.size, np.random.default_rng(seed))
        truth = fault(truth, drawn.size, np.random.default_rng(seed)).truth
    if seconds is None:
        return (_moved(_disturbed(case, drawn), truth, alone),)
    found = []
    for number in range(count):
        again = _disturbed(case, moved_anew(drawn, case.seed, number, float(seconds)))
        swing, rate, _ = truth.sine  # begins wherever it happens to be
        phase = math.tau * np.random.default_rng([case.seed, 9, number]).random()
        found.append(_moved(again, truth._replace(sine=(swing, rate, phase)), alone))
    return tuple(found)


def _disturbed(case: Case, drawn: Drawn) -> Drawn:
    """With structure that no model knows, where the case has it."""
    if case.kind != STRUCTURE:
        return drawn
    found, facts = with_structure(drawn, case.seed)
    return replace(found, facts={**found.facts, **facts})


def _moved(drawn: Drawn, truth: Truth, alone: dict[str, Faulty]) -> Played:
    rows = run(
        truth,
        drawn.reference,
        np.zeros(drawn.reference.size),
        drawn.noise,
        drawn.resolution,
        drawn.coupling,
    )
    astray = np.abs(rows[:, 3] - drawn.reference)
    if not np.isfinite(rows).all() or float(np.max(astray)) > _ASTRAY * drawn.size.reach:
        named = ", ".join(alone) or "no effect"
        raise InputError(f"{named}: the drive does not keep to its reference")
    return Played(drawn, truth, alone, rows)


def complete_case(case: Case) -> Case:
    """The planned case with everything its label holds; another drive where one runs away."""
    for attempt in range(_ATTEMPTS):
        case = replace(case, seed=case.seed + bool(attempt))
        try:
            played = play(case)
        except InputError:
            if attempt == _ATTEMPTS - 1:
                raise
        else:
            return _labelled(case, played)
    raise AssertionError("unreachable")


def _labelled(case: Case, every: tuple[Played, ...]) -> Case:
    drawn, truth, alone, _ = every[0]
    gaps, nominal, unseen = {}, {}, []
    for effect in case.effects:
        own = alone[effect].truth
        stands = max(standing(one.drawn, own, effect, one.rows) for one in every)
        gaps[effect] = {"effort": stands}
        if stands < SHOWS:
            unseen.append(effect)
        held = drawn.machine.inertia
        if effect.endswith("inertia_error") and held is not None:
            nominal[effect] = dict.fromkeys(alone[effect].values, held / drawn.size.ratio)
    effects = {effect: dict(alone[effect].values) for effect in case.effects}
    kind, strange = case.kind, _strange(drawn)
    if kind == "none" and strange:
        kind, effects = "outside", {effect: {} for effect in strange}
    return replace(
        case,
        kind=kind,
        effects=effects,
        gaps=gaps,
        constants=true_constants(drawn, truth),
        tolerances=drawn.tolerances,
        nominal=nominal,
        unseen=tuple(unseen),
        also=_late(drawn),
        facts={**case.facts, **drawn.facts},
    )


def true_constants(drawn: Drawn, truth: Truth) -> dict[str, float]:
    """True constants by key of the drive file, with the fault where it is one of them, or comes on
    top of one; without friction that has no one value: by direction, or as time goes."""
    moved = dict(drawn.constants)
    for key in ("load.mass", "load.inertia"):
        if key in moved:
            moved[key] = truth.inertia
    pairs = {
        "load.viscous_friction": (truth.viscous, drawn.truth.viscous),
        "load.coulomb_friction": (truth.coulomb, drawn.truth.coulomb),
    }
    for key, ((forwards, backwards), (before, _)) in pairs.items():
        if forwards != backwards or ("coulomb" in key and truth.drift_per_s):
            del moved[key]
        else:
            moved[key] += forwards - before
    return moved


def _strange(drawn: Drawn) -> tuple[str, ...]:
    """What makes a gap of a drive without a fault: no name of the catalogue, and none is wanted."""
    axis = ("x_other_axis",) if pulled(drawn) > _PULLS else ()
    return axis + (("x_winding_lag",) if _late_samples(drawn) > LATE - 0.5 else ())


def _late(drawn: Drawn) -> tuple[str, ...]:
    """A lag of more than a sample between effort and motion may well be called a delay."""
    return ("actuation_delay",) if abs(_late_samples(drawn)) > 1.0 else ()


def _late_samples(drawn: Drawn) -> float:
    """Samples by which effort acts after it was logged: the logger's, and the winding's L/R."""
    logger = drawn.logger
    return drawn.truth.winding[2] * logger.rate_hz - logger.lag_samples


def record_case(case: Case) -> tuple[tuple[Recording, ...], Drawn]:
    """The recordings of a case's drive, and the drive."""
    every = play(case)
    found = [
        record(
            drawn.logger,
            np.random.default_rng([case.seed, 7] + [number] * (number > 0)),
            linear=drawn.machine.linear,
            effort_signal=drawn.effort_signal,
            position=rows[:, 0],
            speed=rows[:, 1],
            effort=rows[:, 2],
            reference=drawn.reference,
        )
        for number, (drawn, _, _, rows) in enumerate(every)
    ]
    return tuple(found), every[0].drawn
