"""What a motion would show before it is played: its recording predicted, with noise and sheet."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..drive.parameters import DriveParameters
from ..drive.reference.base import Reference
from ..errors import InputError
from ..gap.fit.fit import Fitter
from ..gap.limits.columns import Base
from ..gap.limits.cylinder import seen_by
from ..gap.limits.limit import Limit
from ..gap.limits.pairs import separation
from ..gap.replay.replay import SIGNALS, Replay
from ..gap.replay.sensor_noise import declared_noise
from ..gap.side_by_side import side_by_side
from ..gap.split import held_out
from .healthy import healthy_run
from .hypotheses import Hypothesis, Pair


@dataclass(frozen=True)
class Experiment:
    """What is fixed while motions are compared.

    Attributes:
        drive: nominal, with its noise. duration_s: of every motion.
        signals: names of those that the recording will hold, as `replay.SIGNALS` has them.
    """

    drive: DriveParameters
    duration_s: float
    signals: tuple[str, ...]


def check_noise(drive: DriveParameters, signals: Collection[str], source: str) -> None:
    """Refuse a drive file that states no noise: nothing can be counted in floors then."""
    stated = declared_noise(drive)
    if not any(stated[name] > 0.0 for name in signals):
        raise InputError(
            f"{source}: sensors states no noise or resolution; expected them, for separations are "
            "counted in noise floors"
        )


def fitter_of_motion(
    experiment: Experiment,
    reference: Reference,
    duration_s: float,
    acting: Mapping[str, Mapping[str, float]],
) -> Fitter:
    """What a motion records on the drive with the effects `acting`, to be fitted by its file."""
    drive = experiment.drive
    machine = dataclasses.replace(drive, effects={**drive.effects, **acting})
    recording = healthy_run(machine, reference, duration_s)
    gone: dict[str, Any] = {
        one.recorded: np.full(len(recording), np.nan)
        for one in SIGNALS
        if one.name not in experiment.signals
    }
    recording = dataclasses.replace(recording, **gone)
    replay = Replay(recording, drive, "the planned motion")
    return Fitter(replay, held_out(replay.time_s))


def predicted(
    experiment: Experiment, reference: Reference, duration_s: float, rows: int | None = None
) -> Base:
    """The recording of a motion on the healthy drive, and what its sheet can do about it.

    rows: of each signal that are looked at.
    """
    fitter = fitter_of_motion(experiment, reference, duration_s, {})
    return Base.of(fitter, fitter.nominal, rows)


def response(base: Base, one: Hypothesis) -> FloatArray:
    """What a hypothesis does to the recording, float64[1 or 2, m]; see `Base.response`."""
    return base.response_to(one.effect, [one.values, *([one.turned] if one.turned else [])])


def separations(base: Base, pairs: Sequence[Pair]) -> list[tuple[float, float]]:
    """Of each pair: what the second leaves of the first, and the other way round, in floors."""
    every = {one.key: one for pair in pairs for one in (pair.first, pair.second)}
    made = side_by_side(partial(response, base), every.values())
    shown = dict(zip(every, made, strict=True))

    def both(pair: Pair) -> tuple[float, float]:
        first, second = shown[pair.first.key], shown[pair.second.key]
        return separation(base, first[0], second), separation(base, second[0], first)

    return side_by_side(both, pairs)


def visible(base: Base, names: Collection[str]) -> list[Limit]:
    """The smallest visible size of effects with the motion that `base` is of."""
    from ..gap.limits.cylinder import least_visible

    _, seen = seen_by(base.fitter, base.fit, names, base)
    return [one.limit for one in least_visible(seen)]


def apart_from_sheet(base: Base, alone: Sequence[Hypothesis]) -> list[float]:
    """What the sheet alone leaves of each hypothesis, in floors."""

    def left(one: Hypothesis) -> float:
        shown = response(base, one)
        return separation(base, shown[0], np.zeros((0, shown.shape[1])))

    return side_by_side(left, alone)
