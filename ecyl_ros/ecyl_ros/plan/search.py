"""Finds the motion: which blocks, in which shares, then their finer shape.

Blocks are moves out and back, or multisines; a multisine may also take all of the time.

What a recording tells adds up over its blocks: inner products of what the sheet, the hypotheses and
their differences do to the signals are taken once per block, from one long predicted run through
all of them, and summed for every choice (as in optimal design of experiments). The choice, and then
the figures of its blocks (reach, speed, acceleration; amplitude, frequencies), are found by
differential evolution (scipy); the finer search predicts each motion in full.
"""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import differential_evolution

from ..arrays import FloatArray
from ..drive.reference.leg import Leg
from ..drive.reference.planned import Planned
from ..drive.reference.swing import Swing
from ..errors import InputError
from ..gap.limits.columns import Base
from ..gap.limits.loss import weights
from .blocks import Block, library
from .healthy import Healthy, healthy_run
from .hypotheses import Hypothesis, Pair
from .predict import Experiment, apart_from_sheet, predicted, response, separations
from .waves import Wave, waves

SLOTS = 8  # blocks of a plan
_ROWS = 12000  # of each signal of the long run
_GENERATIONS, _POPULATION = 60, 8
_FINE_GENERATIONS, _FINE_MEMBERS = 5, 12
_SEED = 14
_NOTHING = 1e-6
# Times that a plan may hold one block: what it told after others it may not tell after itself (a
# load that never moves has no friction).
_OFTEN = 2


@dataclass(frozen=True, eq=False)
class Blocks:
    """Blocks with what each tells.

    Attributes:
        blocks: those that stay within current and voltage. grams: float64[blocks, c, c], of what
            can be told of the columns; free: how many of these, the first, are the sheet's.
        groups: columns of each hypothesis. rows: number of values that a mean is over, of a plan.
        level: mean square of noise. precision: of the sheet's price. evidence: of a plan.
    """

    blocks: list[Block | Wave]
    grams: FloatArray
    free: int
    groups: list[list[int]]
    rows: float
    level: float
    precision: FloatArray
    evidence: float


def planned(
    experiment: Experiment,
    pairs: Sequence[Pair],
    alone: Sequence[Hypothesis],
    deadline: float,
    tell: Callable[[float], None],
) -> tuple[Planned, bool]:
    """The motion that tells `pairs` apart, and shows `alone` beside the sheet.

    Returns (motion, whether the finer search went to its end).

    deadline: of `time.monotonic`, when a finer search ends. tell: takes the share done.
    """
    every = {one.key: one for pair in pairs for one in (pair.first, pair.second)}
    every |= {one.key: one for one in alone}
    hypotheses = list(every.values())
    at = {key: index for index, key in enumerate(every)}
    blocks = _told(experiment, hypotheses)
    tell(0.3)
    index = [(at[pair.first.key], at[pair.second.key]) for pair in pairs]
    singles = [at[one.key] for one in alone]

    most = max(_OFTEN, math.ceil(SLOTS / len(blocks.blocks)))

    def cost(choice: FloatArray) -> float:
        if np.bincount(choice.astype(int)).max() > most:
            return math.inf
        return -told_by(choice.astype(int))

    def told_by(choice: NDArray[np.int64]) -> float:
        gram = blocks.grams[choice].sum(axis=0) / blocks.rows
        return worth(*_apart(blocks, gram, index, singles))

    count = len(blocks.blocks)
    found = differential_evolution(
        cost,
        [(0, count - 1)] * SLOTS,
        integrality=[True] * SLOTS,
        maxiter=_GENERATIONS,
        popsize=_POPULATION,
        seed=_SEED,
        polish=False,
    )
    tell(0.5)
    chosen = [blocks.blocks[int(one)] for one in np.sort(found.x)]
    begun = [chosen]
    every_wave = [one for one in range(count) if isinstance(blocks.blocks[one], Wave)]
    if every_wave:
        # One that takes all of the time tells about as much as one in every slot.
        most_told = max(every_wave, key=lambda one: told_by(np.full(SLOTS, one)))
        begun.append([blocks.blocks[most_told]])
    best = _best(experiment, begun, pairs, alone, deadline)
    tell(0.6)
    return _finer(experiment, best, pairs, alone, deadline, tell)


def worth(apart: Sequence[float], seen: Sequence[float]) -> float:
    """What a motion is worth: the pair that it separates least, or all effects alike.

    In logarithms, so that what is told already does not outweigh what is not.
    """
    parts = []
    if apart:
        parts.append(math.log(max(min(apart), _NOTHING)))
        parts.append(0.1 * float(np.mean(np.log(np.maximum(apart, _NOTHING)))))
    if seen:
        parts.append(float(np.mean(np.log(np.maximum(seen, _NOTHING)))))
    return sum(parts)


def _told(experiment: Experiment, hypotheses: Sequence[Hypothesis]) -> Blocks:
    """Every block of the library, run one after the other."""
    drive = experiment.drive
    slot = experiment.duration_s / SLOTS
    every: list[Block | Wave] = [*library(drive, slot), *waves(slot)]
    legs: list[Leg | Swing] = []
    ends = [0.0]
    for block in every:
        legs += block.legs(drive.limits, slot)
        ends.append(Planned(tuple(legs), 0.0).moving_s)
    row = Planned(tuple(legs), ends[-1])
    base = predicted(experiment, row, ends[-1], _ROWS)
    columns, groups = [base.free], []
    at = len(base.free)
    for one in hypotheses:
        made = response(base, one)
        columns.append(made * np.sqrt(weights(made)))
        groups.append([*range(at, at + len(made))])
        at += len(made)
    rows = np.concatenate(columns).reshape(at, base.signals, -1)
    times = base.fitter.replay.time_s[base.rows]
    kept, grams = [], []
    run = healthy_run(drive, row, ends[-1])
    for block, begin, end in zip(every, ends[:-1], ends[1:], strict=True):
        part = rows[:, :, (times >= begin) & (times < end)].reshape(at, -1)
        if part.shape[1] and Healthy.between(run, begin, end).excess(drive) is None:
            # As if the block took all of its slot: shorter ones are repeated to fill it.
            grams.append(part @ part.T * min(slot / (end - begin), 1.5))
            kept.append(block)
    if not kept:
        raise InputError(
            "limits: no move stays within four fifths of controller.current_limit and "
            "controller.voltage_limit; expected lower limits.speed or limits.acceleration"
        )
    share = experiment.duration_s / float(base.fitter.replay.time_s[-1])
    evidence = base.fitter.sheet.evidence * share
    return Blocks(
        kept,
        np.array(grams),
        len(base.free),
        groups,
        base.signals * len(base.rows) * share,
        base.fit.left,
        base.precision,
        evidence,
    )


def _apart(
    blocks: Blocks, gram: FloatArray, pairs: Sequence[tuple[int, int]], alone: Sequence[int]
) -> tuple[list[float], list[float]]:
    """Separations of the pairs, both ways, and of hypotheses from the sheet alone."""
    prior = blocks.precision * blocks.level / blocks.evidence

    def left(acting: Sequence[int], beside: Sequence[int]) -> list[float]:
        """Of each hypothesis in `acting`, beside the sheet and one other's columns."""
        using = [*range(blocks.free), *beside]
        columns = [blocks.groups[one][0] for one in acting]
        ridge = gram[np.ix_(using, using)] + np.diag([*prior, *[0.0] * len(beside)])
        aim = gram[np.ix_(using, columns)]
        size = np.sqrt(np.maximum(np.diag(ridge), 1e-300))
        scaled = np.linalg.lstsq(ridge / np.outer(size, size), aim / size[:, None], rcond=1e-10)[0]
        # The least of what is left and what the sheet's pulls cost, as `pairs.separation` has it.
        taken = np.sum(scaled / size[:, None] * aim, axis=0)
        rest: FloatArray = np.sqrt(np.maximum(np.diag(gram)[columns] - taken, 0.0))
        return rest.tolist()

    apart = [
        left([one], blocks.groups[other])[0]
        for first, second in pairs
        for one, other in ((first, second), (second, first))
    ]
    return apart, left(alone, ())


def assembled(experiment: Experiment, blocks: Sequence[Block | Wave]) -> Planned:
    """Blocks in a row, from the start again where time is left, home at the end."""
    limits, duration = experiment.drive.limits, experiment.duration_s
    slot = duration / len(blocks)
    legs: list[Leg | Swing] = []
    used = 0.0
    parts = [block.legs(limits, slot) for block in blocks]
    lengths = [Planned(part, slot).moving_s for part in parts]
    # Short blocks leave time over: it goes to those that still fit, in turn.
    for part, length in itertools.islice(
        itertools.cycle(zip(parts, lengths, strict=True)), 4 * len(blocks)
    ):
        if used + length <= duration + 1e-9:
            legs += part
            used += length
    return Planned(tuple(legs), duration)


def _best(
    experiment: Experiment,
    begun: Sequence[Sequence[Block | Wave]],
    pairs: Sequence[Pair],
    alone: Sequence[Hypothesis],
    deadline: float,
) -> Sequence[Block | Wave]:
    """Of several rows of blocks the one whose motion is worth most, predicted in full.

    The first unless there is time for others: half of what is left, the rest is the finer search's.
    """
    most, best = -math.inf, begun[0]
    halfway = 0.5 * (time.monotonic() + deadline)
    for row in begun:
        reference = assembled(experiment, row)
        if time.monotonic() > halfway or not reference.legs:
            continue
        value = _valued(experiment, reference, pairs, alone)
        if value > most:
            most, best = value, row
    return best


def _valued(
    experiment: Experiment, reference: Planned, pairs: Sequence[Pair], alone: Sequence[Hypothesis]
) -> float:
    """What a motion is worth; minus infinity where the healthy drive would lack room, or where a
    diagnosis would refuse the recording (it moves too little to tell one machine from another)."""
    drive, duration_s = experiment.drive, experiment.duration_s
    if Healthy.on(drive, reference, duration_s).excess(drive) is not None:
        return -math.inf
    try:
        base = predicted(experiment, reference, duration_s)
    except InputError:
        return -math.inf
    return worth(*told(base, pairs, alone))


def _finer(
    experiment: Experiment,
    chosen: Sequence[Block | Wave],
    pairs: Sequence[Pair],
    alone: Sequence[Hypothesis],
    deadline: float,
    tell: Callable[[float], None],
) -> tuple[Planned, bool]:
    """The motion with the figures of its blocks let go, in full prediction."""
    limits = experiment.drive.limits
    top = max((one.reach for one in chosen if isinstance(one, Block)), default=math.nan)
    start = np.array([one.point for one in chosen]).ravel()
    spread = math.log(2.0)
    highest = np.array([one.highest(limits, top) for one in chosen]).ravel()
    low, high = start - spread, np.minimum(start + spread, highest)
    tried, whole = 0, True

    def motion(point: FloatArray) -> Planned:
        parts = zip(chosen, point.reshape(len(chosen), -1).tolist(), strict=True)
        return assembled(experiment, [one.moved_to(part) for one, part in parts])

    def cost(point: FloatArray) -> float:
        nonlocal tried, whole
        if time.monotonic() > deadline:
            whole = False
            return math.inf
        tried += 1
        tell(0.6 + 0.35 * min(tried / (_FINE_MEMBERS * (_FINE_GENERATIONS + 1)), 1.0))
        reference = motion(point)
        return -_valued(experiment, reference, pairs, alone) if reference.legs else math.inf

    rng = np.random.default_rng(_SEED)
    members = start + spread * rng.uniform(-1.0, 1.0, (_FINE_MEMBERS, start.size))
    members[0] = start
    found = differential_evolution(
        cost,
        list(zip(low, np.maximum(high, low + 1e-9), strict=True)),
        init=np.clip(members, low, np.maximum(high, low + 1e-9)),
        maxiter=_FINE_GENERATIONS,
        seed=_SEED,
        polish=False,
        tol=0.0,
    )
    if math.isfinite(found.fun):
        return motion(found.x), whole
    # No time was left, or nothing kept the limits: the blocks as they were chosen, if they do.
    begun = motion(start)
    healthy = Healthy.on(experiment.drive, begun, experiment.duration_s)
    if healthy.excess(experiment.drive) is not None:
        raise InputError(
            "limits: the blocks that tell most go beyond four fifths of controller.current_limit "
            "or controller.voltage_limit in a row; expected lower limits.speed or "
            "limits.acceleration"
        )
    return begun, whole


def told(
    base: Base, pairs: Sequence[Pair], alone: Sequence[Hypothesis]
) -> tuple[list[float], list[float]]:
    """Separations of a predicted motion: of the pairs, both ways, and from the sheet alone."""
    apart = [one for both in separations(base, pairs) for one in both]
    return apart, apart_from_sheet(base, alone)
