"""A plan from what is open: the motion, what it is predicted to show, and what others would."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from ..analysis.one_thread import on_one_thread
from ..drive.parameters import DriveParameters
from ..drive.reference.base import Reference
from ..drive.reference.planned import Planned
from ..errors import InputError
from ..gap.limits.columns import Base
from ..gap.limits.limit import Limit
from ..gap.limits.pairs import needed
from .fitted import fitted_separations
from .healthy import Healthy
from .hypotheses import TIMES, Hypothesis, Pair, given, probe_of, sized
from .others import MOVES, moves, usual
from .predict import Experiment, apart_from_sheet, predicted, separations, visible
from .search import planned, worth

BUDGET_S = 55.0  # for a plan, so that it is found within a minute
_SEARCHED = 1.0 / 3.0  # share of it that the search has at the least, whatever predictions take
PLANNED = "planned"


@dataclass(frozen=True, eq=False)
class Prediction:
    """What one motion would show.

    Attributes:
        motion: its name. reference: itself. apart: of each pair, see `fitted_separations`.
        alone: of each effect asked for by itself, from the sheet. limits: smallest visible sizes.
    """

    motion: str
    reference: Reference
    apart: tuple[float, ...]
    alone: tuple[float, ...]
    limits: tuple[Limit, ...]


@dataclass(frozen=True, eq=False)
class Plan:
    """The planned motion beside others of the same limits and time.

    Attributes:
        motion: to be played. pairs, alone: what it was planned for. needed: separation, in floors,
            from which a diagnosis tells two effects apart. predictions: the planned motion first.
        base: the predicted recording of the healthy drive. whole: whether the search for the motion
            went to its end in the time that it had.
    """

    motion: Planned
    pairs: tuple[Pair, ...]
    alone: tuple[Hypothesis, ...]
    needed: float
    predictions: tuple[Prediction, ...]
    base: Base
    whole: bool

    def as_json(self) -> dict[str, Any]:
        """Plain data, schema `ecyl.plan/1`."""
        return {
            "schema": "ecyl.plan/1",
            "duration_s": self.motion.duration_s,
            "needed": self.needed,
            "pairs": [
                [
                    {"effect": one.effect, "parameters": dict(one.values)}
                    for one in (pair.first, pair.second)
                ]
                for pair in self.pairs
            ],
            "alone": [{"effect": one.effect, "parameters": dict(one.values)} for one in self.alone],
            "motions": [
                {
                    "motion": one.motion,
                    "separations": list(one.apart),
                    "from_sheet": list(one.alone),
                    "limits": [limit.as_json() for limit in one.limits],
                }
                for one in self.predictions
            ],
        }


@on_one_thread
def make_plan(
    drive: DriveParameters,
    duration_s: float,
    pairs: Sequence[tuple[str, str]],
    alone: Sequence[str],
    known: Mapping[str, Mapping[str, float]],
    signals: tuple[str, ...],
    shown: Sequence[str],
    *,
    beside: Collection[str] | None = None,
    budget_s: float = BUDGET_S,
    tell: Callable[[float], None] = lambda share: None,
) -> Plan:
    """Plan a motion.

    Args:
        drive: nominal, with noise and tolerances. duration_s: of the motion.
        pairs, alone: effects to tell from each other, and from the sheet.
        known: sizes that a diagnosis has found; others are `TIMES` the smallest that moves of the
            same limits and time would show.
        signals: that the recording will hold. shown: effects whose smallest sizes are predicted.
        beside: usual motions to be predicted, too; all of them unless given. Moves always are.
        budget_s: for the plan. The predictions that stand beside it come first; what they leave is
            the search's, a third at the least. tell: takes the share done.

    Raises:
        InputError: limits that leave no motion, an effect without a size.
    """
    begin = time.monotonic()
    experiment = Experiment(drive, duration_s, signals)
    names = list(dict.fromkeys([*(one for pair in pairs for one in pair), *alone]))
    sizes = _sized(experiment, names, known)
    both = [Pair(sizes[first], sizes[second]) for first, second in pairs]
    singles = [sizes[name] for name in alone]
    tell(0.1)

    def shows(name: str, reference: Reference) -> tuple[Prediction, Base]:
        base = predicted(experiment, reference, duration_s)
        straight = separations(base, both)
        prediction = Prediction(
            name,
            reference,
            tuple(fitted_separations(experiment, reference, duration_s, both, straight)),
            tuple(apart_from_sheet(base, singles)),
            tuple(visible(base, shown)),
        )
        return prediction, base

    motions = usual(drive.limits, duration_s)
    if beside is not None:
        motions = {name: motions[name] for name in motions if name in {*beside, MOVES}}
    others: dict[str, tuple[Prediction, Base]] = {}
    longest_s = 0.0
    for name, reference in motions.items():
        now = time.monotonic()
        others[name] = shows(name, reference)
        longest_s = max(longest_s, time.monotonic() - now)
        tell(0.1 + 0.2 * len(others) / len(motions))
    left_s = budget_s - (time.monotonic() - begin) - longest_s  # for the search; one is to come
    deadline = time.monotonic() + max(left_s, _SEARCHED * budget_s)
    motion, whole = planned(
        experiment, both, singles, deadline, lambda share: tell(0.3 + 0.6 * share)
    )
    found = {PLANNED: shows(PLANNED, motion), **others}
    tell(1.0)
    # A search cut short can end below plain moves, which are a motion to be played as well.
    if _worth(found[MOVES][0]) > _worth(found[PLANNED][0]) and _in_reach(found[MOVES][0], drive):
        found[PLANNED] = replace(found[MOVES][0], motion=PLANNED), found[MOVES][1]
    chosen, base = found[PLANNED]
    assert isinstance(chosen.reference, Planned)
    return Plan(
        chosen.reference,
        tuple(both),
        tuple(singles),
        needed(base),
        tuple(one for one, _ in found.values()),
        base,
        whole,
    )


def _worth(one: Prediction) -> float:
    return worth(one.apart, one.alone)


def _in_reach(one: Prediction, drive: DriveParameters) -> bool:
    """Whether it is a motion that moves, and leaves the healthy drive's controller room."""
    motion = one.reference
    if not isinstance(motion, Planned) or not motion.legs:
        return False
    return Healthy.on(drive, motion, motion.duration_s).excess(drive) is None


def _sized(
    experiment: Experiment, names: Sequence[str], known: Mapping[str, Mapping[str, float]]
) -> dict[str, Hypothesis]:
    """Every effect in the size that it is asked for in."""
    from ..gap.limits.cylinder import seen_by
    from ..gap.limits.probes import Scale

    duration = experiment.duration_s
    found = {name: given(name, known[name]) for name in names if name in known}
    rest = [name for name in names if name not in known]
    if not rest:
        return found
    reference = moves(experiment.drive.limits, duration)
    if not reference.legs:
        raise InputError(
            f"--duration = {duration:g}: no move of the drive's limits fits; expected a longer "
            "motion, or more speed, acceleration or jerk"
        )
    base = predicted(experiment, reference, duration)
    scale = Scale.of(base.fitter.replay, {}, {})
    for name in rest:
        probe_of(name, experiment.drive, scale)  # refused before anything is searched for
    _, seen = seen_by(base.fitter, base.fit, rest, base)
    for one in seen:  # the first shape of each
        name = one.probe.effect
        if name not in found:
            size = TIMES * one.size if math.isfinite(one.size) else one.probe.first
            found[name] = sized(one.probe, size)
    return found
