"""Drawing the cases of a study of cylinders: balanced, each effect visible, none absurd."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from ....drive.parameters import DriveParameters
from ....effects.catalogue import CATALOGUE
from ....errors import InputError
from ....recording.signals import Recording
from ..case import KINDS, LAW, Case
from .effects import EFFECTS, SAME_CAUSE
from .imposed import Draw, Values
from .inside import INSIDE, nominal_values
from .machine import Run, record_machine, run_machine
from .outside import OUTSIDE
from .sheet import leaving_the_sheet, stated_tolerances, true_constants
from .stage import DRAWS, Setup, Stage, gaps_between, peak
from .unnamed import UNNAMED

SHARES = {
    "single": 0.46,
    "pair": 0.2,
    "none": 0.2,
    "outside": 0.08,
    "withheld": 0.04,
    "beyond": 0.02,
    "law": 0.5,
}

VISIBLE = 4.0  # an effect's gap in at least one signal, in noise floors of that signal
ABSURD = 3.0  # peak speed, current or voltage over the healthy machine's, at most
MOTIONS = 20  # or drives, tried before an effect is called impossible to show


def stated(drive: DriveParameters | Setup, sheet: float) -> DriveParameters:
    """The drive as its file is handed out, with tolerances for constants off by `sheet`, if any."""
    setup = Setup.of(drive)
    return replace(setup.drive, tolerances={} if setup.silent else stated_tolerances(sheet))


def _absurd(run: Run, stage: Stage) -> bool:
    """Whether the machine runs away, or does what nobody would record."""
    if not run.finite:
        return True
    names = ("rotor_velocity_rad_per_s", "current_q_a", "voltage_q_v", "rod_position_m")
    return any(peak(run.signals[n]) > ABSURD * peak(stage.healthy.signals[n]) for n in names)


def draw_effects(
    names: Iterable[str], seed: int, setup: Setup, stage: Stage, sheet: float
) -> tuple[dict[str, Values], dict[str, dict[str, float]]]:
    """(parameters, gaps) of named effects on the machine of `seed`, redrawn until all are visible.

    An effect is visible if taking it alone out of the machine changes some signal of some recording
    by `VISIBLE` noise floors. Raises InputError naming the effects where no draw shows them.
    """
    names = list(names)
    if not names:
        return {}, {}
    floor = setup.floor
    rng = np.random.default_rng([seed, 1])
    nominal = stated(setup, sheet)
    stages = [stage, *stage.others(seed, setup)]

    def run(one: Stage, effects: dict[str, Values]) -> Run:
        if not effects:
            return one.healthy
        machine = one.with_effects(effects, seed)
        return run_machine(machine, one.nuisances, setup.drive, one.reference)

    for _ in range(DRAWS):
        draw = Draw(rng, nominal, stage.scale)
        effects = {
            name: leaving_the_sheet(name, EFFECTS[name].draw(draw), nominal, rng) for name in names
        }
        complete = [run(one, effects) for one in stages]
        if any(_absurd(one, of) for one, of in zip(complete, stages, strict=True)):
            continue
        gaps = {}
        for name in names:
            rest = {other: values for other, values in effects.items() if other != name}
            each = [
                gaps_between(one, run(of, rest), floor)
                for one, of in zip(complete, stages, strict=True)
            ]
            gaps[name] = {signal: max(one[signal] for one in each) for signal in each[0]}
        if all(max(gap.values()) >= VISIBLE for gap in gaps.values()):
            return effects, gaps
        if not all(any(gap.values()) for gap in gaps.values()):
            break  # nothing that is recorded depends on it, at any size
    raise InputError(f"{' with '.join(names)}: no visible and sane size in {DRAWS} draws")


def _rounds(names: list[str], rng: np.random.Generator) -> Iterator[str]:
    """Every name once in random order, then again: equally often however many are taken."""
    while True:
        yield from (names[index] for index in rng.permutation(len(names)))


def plan_cases(
    count: int,
    seed: int,
    *,
    kinds: tuple[str, ...] = KINDS,
    effects: tuple[str, ...] | None = None,
    without: tuple[str, ...] = (),
    drives: str = "bench",
    sheet: float = 0.0,
) -> list[Case]:
    """Cases without parameters: kinds in their shares, effects equally often, in mixed order.

    Args:
        count: cases.
        seed: the same count and seed give the same cases.
        kinds: of these kinds alone, in the same proportion to each other.
        effects: cases of these effects alone; the second effect of a pair is any.
        without: effects that no diagnosis of this study is given; only withheld cases hold them.
        drives, sheet: as `Case` has them.
    """
    rng = np.random.default_rng([seed, count])
    chosen = [name for name in EFFECTS if effects is None or name in effects]
    inside = [name for name in chosen if name in INSIDE and name not in without]
    outside = [name for name in chosen if name in OUTSIDE]
    withheld = [name for name in chosen if name in INSIDE and (not without or name in without)]
    beyond = [name for name in outside if EFFECTS[name].twin and EFFECTS[name].twin not in without]
    names_of = {
        "single": inside,
        "pair": inside,
        "outside": outside,
        "withheld": withheld,
        "beyond": beyond,
        "law": [name for name in chosen if name in UNNAMED],
    }
    usable = [
        kind for kind in (*KINDS, LAW) if kind in kinds and (kind == "none" or names_of[kind])
    ]
    if not usable:
        raise InputError(
            f"no case is left of --kinds {','.join(kinds)} with the effects asked for; "
            "expected x_ effects for outside, the catalogue's for the others"
        )
    rounds = {kind: _rounds(names, rng) for kind, names in names_of.items()}
    partners = _rounds([name for name in INSIDE if name not in without], rng)
    cases = []
    for index, kind in enumerate(_kinds(count, usable, rng)):
        names = [] if kind == "none" else [next(rounds[kind])]
        if kind == "pair":
            names.append(
                next(
                    name
                    for name in partners
                    if name != names[0] and {names[0], name} not in SAME_CAUSE
                )
            )
        hidden = set(without) | (set(names) if kind == "withheld" else set())
        # A finer form of what is left out would be that same cause under another name.
        hidden |= {finer for finer, one in CATALOGUE.items() if hidden & set(one.refines)}
        if kind == "outside":
            hidden |= {twin for name in names if (twin := EFFECTS[name].twin)}
        cases.append(
            Case(
                index=index,
                seed=int(rng.integers(2**31)),
                kind=kind,
                effects={name: {} for name in names},
                withheld=tuple(sorted(hidden)),
                drives=drives,
                sheet=sheet,
            )
        )
    return cases


def _kinds(count: int, usable: list[str], rng: np.random.Generator) -> list[str]:
    """A kind for each case: in their shares, largest remainders rounded up, mixed."""
    total = sum(SHARES[kind] for kind in usable)
    wanted = {kind: SHARES[kind] / total * count for kind in usable}
    numbers = {kind: int(wanted[kind] + 1e-9) for kind in usable}
    by_remainder = sorted(usable, key=lambda kind: numbers[kind] - wanted[kind])
    for kind in by_remainder[: count - sum(numbers.values())]:
        numbers[kind] += 1
    return [str(kind) for kind in rng.permutation([k for k in usable for _ in range(numbers[k])])]


def complete_case(case: Case, setup_of: DriveParameters | Setup | Callable[[int], Setup]) -> Case:
    """The planned case with parameters drawn so that its effects are visible.

    setup_of: the drive, or a function that draws one from a seed.
    """
    for attempt in range(MOTIONS):  # another motion where this one shows the effects at no size
        seed = case.seed + attempt
        try:
            setup = setup_of(seed) if callable(setup_of) else Setup.of(setup_of)
            stage = Stage.of(seed, setup, case.sheet)
            effects, gaps = draw_effects(case.effects, seed, setup, stage, case.sheet)
        except InputError:
            if attempt == MOTIONS - 1:
                raise
            continue
        held = nominal_values(setup.drive)
        facts = setup.facts
        if case.kind == "withheld":  # by which a force described at the rotor is scored
            facts = facts | {"rod_per_rotor_m": setup.drive.transmission.rod_per_rotor}
        return replace(
            case,
            seed=seed,
            effects=effects,
            gaps=gaps,
            facts=facts,
            constants=true_constants(stage.with_effects(effects, seed), setup.drive),
            tolerances=dict(stated(setup, case.sheet).tolerances),
            nominal={
                name: {key: held[name, key] for key in values if (name, key) in held}
                for name, values in effects.items()
            },
        )
    raise AssertionError("unreachable")


def record_case(case: Case, drive: DriveParameters | Setup) -> Recording:
    """The recording of a case's machine, without the signals that its setup lacks."""
    return record_cases(case, drive)[0]


def record_cases(case: Case, drive: DriveParameters | Setup) -> list[Recording]:
    """The same of all recordings that its setup asks for."""
    setup = Setup.of(drive)
    stage = Stage.of(case.seed, setup, case.sheet)
    every = [stage, *stage.others(case.seed, setup)]
    return [record_on(case, one, setup) for one in every]


def record_on(case: Case, stage: Stage, setup: Setup) -> Recording:
    """The recording that a case's machine gives on one of its stages."""
    machine = stage.with_effects(case.effects, case.seed)
    recording = record_machine(machine, stage.nuisances, setup.drive, stage.reference)
    gone: dict[str, Any] = {name: np.full(len(recording), np.nan) for name in setup.missing}
    return replace(recording, **gone) if gone else recording
