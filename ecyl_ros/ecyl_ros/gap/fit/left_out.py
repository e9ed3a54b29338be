"""A coupling that the drive file leaves out: found from the recording, and what that costs."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterator, Sequence

from ...arrays import FloatArray
from ...drive.coupling import BACKLASH, DAMPING, STIFFNESS
from ...drive.parameters import DriveParameters, leaf_fields
from ...drive.tolerances import constants_of, with_constants
from ...effects.catalogue import CATALOGUE
from ..diagnosis import SheetValue
from ..replay.replay import Replay
from .robust import cost

Coupling = dict[str, float]

# Tried first: every stiffness with every clearance, then finer steps about the best of them.
_SOFTER = (1.0, 0.3, 0.1, 0.03, 0.01, 0.003)  # times the rigid one
_CLEARANCES_RAD = (0.0, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2)
_STEPS = (1.6, 1.2, 1.05)  # factors, up and down, of each constant in turn
_SWEEPS = 12  # over the constants with one factor, as long as one of them does better
_STEEL = 0.1  # damping ratio of joints over that of the rigid coupling
_BETTER = 0.98  # of the rigid coupling's cost, from where another is believed


def with_coupling(replay: Replay) -> DriveParameters:
    """The drive with a coupling that suits the recording in place of what its file leaves out.

    By replays of a grid, to begin fits at; the drive itself where nothing was left out, or where
    no other coupling does better than a rigid one.
    """
    drive = replay.nominal
    if not drive.left_out:
        return drive
    look = _look(replay)

    def tried(values: Coupling) -> tuple[float, Coupling]:
        return cost(look(replay.gap({}, values)), replay.usable), values

    begin = tried({key: constants_of(drive)[key] for key in drive.left_out})
    best = min([begin, *map(tried, _grid(drive))], key=lambda one: one[0])
    for step in _STEPS:
        for _ in range(_SWEEPS):
            last = best
            for key in drive.left_out:
                if best[1][key] > 0.0:
                    moved = [{**best[1], key: best[1][key] * by} for by in (1.0 / step, step)]
                    likely = [one for one in moved if _swings(one, drive)]
                    best = min([best, *map(tried, likely)], key=lambda one: one[0])
            if best is last:
                break
    if best[0] > _BETTER * begin[0]:
        return drive
    return dataclasses.replace(with_constants(drive, best[1]), left_out=drive.left_out)


def _swings(values: Coupling, drive: DriveParameters) -> bool:
    """Whether the flanks are less than half critically damped, as joints are."""
    given = constants_of(drive)
    full = {**given, **values}
    softer = full[STIFFNESS] / given[STIFFNESS]
    return DAMPING not in values or full[DAMPING] <= given[DAMPING] * math.sqrt(softer) * 1.0001


def _look(replay: Replay) -> Callable[[FloatArray], FloatArray]:
    """What of a gap, float64[signals, n], tells the coupling: all of it, or the twist alone.

    What else is off moves rotor and rod alike.
    """
    rows = {one.name: row for row, one in enumerate(replay.signals)}
    if not {"rotor_position", "rod_position"} <= set(rows):
        return lambda gap: gap
    rotor, rod = rows["rotor_position"], rows["rod_position"]
    noise = replay.floor[rod] / replay.nominal.transmission.rod_per_rotor, replay.floor[rotor]
    over = math.hypot(*noise)
    return lambda gap: (gap[rotor] * noise[1] - gap[rod] * noise[0])[None] / over


def _grid(drive: DriveParameters) -> Iterator[Coupling]:
    given = constants_of(drive)
    open_ = set(drive.left_out)
    for softer in _SOFTER if STIFFNESS in open_ else (1.0,):
        for clearance in _CLEARANCES_RAD if BACKLASH in open_ else (given[BACKLASH],):
            values = {STIFFNESS: softer * given[STIFFNESS], BACKLASH: clearance}
            # Half critical damping of the rigid coupling; that of steel as the root of stiffness.
            values[DAMPING] = given[DAMPING] * (1.0 if softer == 1.0 else _STEEL * softer**0.5)
            yield {key: values[key] for key in open_}


def not_to_be_judged(drive: DriveParameters) -> set[str]:
    """Effects that give another value to what the file has none of."""
    return {name for name, one in CATALOGUE.items() if one.constant in drive.left_out}


def costs(drive: DriveParameters, sheet: Sequence[SheetValue]) -> list[str]:
    """What to say of each constant that was left out; sheet: as it was found."""
    seen = {one.parameter for one in sheet if one.seen}
    taken, leaves = constants_of(drive), leaf_fields()
    notes = []
    for key in drive.left_out:
        unit = leaves[key].metadata["unit"]
        how = "it was found from the recording"
        if key not in seen:
            how = f"{taken[key]:.3g} {unit} was assumed; this recording does not determine it"
        titles = [one.title for one in CATALOGUE.values() if one.constant == key]
        unjudged = f", so that a {titles[0]} cannot be seen" if titles else ""
        notes.append(f"{key} is left out: {how}{unjudged}")
    return notes
