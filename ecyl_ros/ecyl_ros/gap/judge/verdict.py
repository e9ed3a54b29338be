"""From a competition to a verdict: what is named, how surely, and when to say no."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from ...arrays import BoolArray, FloatArray
from ...effects.catalogue import CATALOGUE, EFFECTS
from ..compete.competition import Competition
from ..diagnosis import Candidate, Cause, FittedParameter
from ..fit.fit import Fit
from ..fit.robust import cost, misfit
from ..listed import listed
from ..replay.hidden import NO_GAP_RATIO
from ..replay.replay import Replay

STRUCTURELESS = 1.3  # robust misfit over that of a perfect model
EXPLAINED_SHRINK = 0.9
HELPS = 0.5  # share of the gap that must be gone for anything to be named
_NEAR, _FAR = 1.05, 1.2  # misfits over that of a perfect model: at the floor, and surely not
_CLEAR = 1.7  # times the winner's misfit: a rival further off is not close
NAMED = 0.6  # a cause less sure than this is not named
SEEN = 0.8  # tolerances: an interval as wide as the sheet's says nothing new
INDISTINCT = 0.02  # squared misfits closer than this share cannot be told apart
_MOST_CANDIDATES = 12
RARER = 1.0 / 3.0  # weight of a cause for each step of `Effect.rarity`
_UNKNOWN_SETTING = 2  # rarity of a change of the controller that the catalogue lacks


def verdict_of(
    *,
    no_gap: bool,
    within_sheet: bool = False,
    named: bool = False,
    shrink: float = 0.0,
    left: float = 0.0,
    whole: bool = True,
    flat: bool = False,
    undecided: bool = False,
) -> str:
    """One of `VERDICTS`.

    Args:
        no_gap: the nominal model is at the floor. within_sheet: constants within their tolerances
            bring it there. named: causes are.
        shrink: share of the gap that they remove. left: what they leave, over the floor. whole:
            all that was found is named.
        flat: the floor is as high as the signal. undecided: what was found looks like others.
    """
    if flat and not named:
        return "not_judgeable"
    if no_gap:
        return "no_gap"
    if within_sheet:
        return "within_sheet"
    if not named:
        return "not_judgeable" if undecided else "unexplained"
    closed = shrink >= EXPLAINED_SHRINK and left <= STRUCTURELESS
    return "explained" if closed and whole and not flat else "partly_explained"


def shrink_of(before: float, after: float, surplus: float) -> float:
    """Share of what stands above the floor (`surplus`) that is gone, 0 to 1."""
    return max(0.0, share_of(before - after, surplus))


def share_of(removed: float, surplus: float) -> float:
    """What a cause removed, or added, of the `surplus`, -1 to 1; of none, where causes that let
    noise through raise the floor above the gap, 0."""
    return min(max(removed / surplus, -1.0), 1.0) if surplus > 0.0 else 0.0


def named_cause(
    effect: str,
    parameters: Iterable[FittedParameter],
    sure: float,
    others: tuple[str, ...],
    taken_off: float,
    lost: float,
    *,
    needed: str,
) -> Cause:
    """An effect as a cause.

    Args:
        effect: its name. parameters: as fitted. sure: confidence. others: that look the same here.
        taken_off: share of the gap that adding it removed. lost: that comes back without it.
        needed: what a recording must contain to tell it from these others.
    """
    known = EFFECTS[effect]
    return Cause(
        effect=effect,
        block=known.block,
        title=known.title,
        confidence=sure,
        parameters=tuple(parameters),
        shrink=taken_off,
        shrink_alone_lost=lost,
        alternatives=others,
        excitation=needed,
    )


def undecided(causes: Sequence[Cause]) -> str:
    """Which causes look alike, where that alone keeps them from being named; empty else."""
    alike = [one for one in causes if one.alternatives]
    if not alike or min(one.confidence * (1 + len(one.alternatives)) for one in causes) < NAMED:
        return ""
    told = told_by(
        (alike[0].effect, *alike[0].alternatives), f"another motion ({alike[0].excitation})"
    )
    return f"{told}, and `ecyl plan --from` finds it"


def told_by(alike: Sequence[str], motion: str) -> str:
    """That these effects look alike, and the motion of a recording that would tell them."""
    return f"{in_words(alike)} look alike in this recording; one with {motion} would separate them"


def in_words(names: Sequence[str]) -> str:
    """Names of effects or signals as a sentence lists them."""
    return listed([one.replace("_", " ") for one in names])


def ranked(pool: Iterable[Candidate]) -> tuple[Candidate, ...]:
    """The best of each set of effects, best first."""
    best: dict[frozenset[str], Candidate] = {}
    for one in pool:
        key = frozenset(one.effects)
        if key not in best or one.judged < best[key].judged:
            best[key] = one
    return tuple(sorted(best.values(), key=lambda one: one.judged)[:_MOST_CANDIDATES])


@dataclass(frozen=True)
class Standing:
    """What the confidence of a set of causes rests on.

    left: robust misfit over that of a perfect model, held out. margin: misfit of the best rival
    over the winner's.
    """

    left: float
    margin: float


def ratios(fit: Fit, rows: BoolArray) -> list[float]:
    """RMS of each signal's gap over its noise floor."""
    return [float(np.sqrt(np.mean(values[rows] ** 2))) for values in fit.gap]


def robust_ratios(gap: FloatArray, rows: BoolArray) -> FloatArray:
    """Robust RMS of each signal's gap over its noise floor: float64[signals]."""
    return np.array([math.sqrt(cost(values[None, :], rows)) for values in gap])


def at_floor(fit: Fit, replay: Replay) -> bool:
    """Whether every signal stands at its floor, as far as noise round the loop lets it.

    By its RMS and by its robust RMS: few large differences count, and many small ones.
    """
    rows = replay.usable
    healthy = np.sqrt(np.mean(replay.healthy[:, rows] ** 2, axis=1))
    # Impacts that noise has moved are few and large: one draw of them says little of another.
    allowed = np.maximum(1.0, np.where(healthy > 1.1, 1.3 * healthy, healthy))
    robust = np.maximum(0.92, robust_ratios(replay.healthy, rows))
    return bool(
        np.all(np.array(ratios(fit, rows)) <= NO_GAP_RATIO * allowed)
        and np.all(robust_ratios(fit.gap, rows) <= NO_GAP_RATIO * robust)
    )


def standing(competition: Competition, perfect: float) -> Standing:
    """Where the winner stands; perfect: robust misfit of a perfect model."""
    winner = competition.winner
    left = misfit(winner.left) / perfect
    rivals = [one for one in competition.rivals if not _contains(one, winner)]
    margin = misfit(min((one.judged for one in rivals), default=competition.sheet.judged))
    return Standing(left, margin / misfit(winner.judged))


def helped(before: float, after: float, white: float, place: Standing, gone: float) -> bool:
    """Whether a set removes enough of the gap for anything to be named.

    By its RMS; or, where impacts that differ by chance stand for most of that, by the squared
    misfit, if no more is left than of a sound machine with the same causes.

    before, after: RMS without and with the set; white: of noise alone. gone: share of the squared
    misfit.
    """
    by_rms = before - after >= HELPS * (before - white)
    return by_rms or (place.left <= STRUCTURELESS and gone >= HELPS)


def _contains(larger: Fit, smaller: Fit) -> bool:
    """Whether a set holds another as a special case, so that it cannot lose to it by much."""
    for name in smaller.names:
        if name in larger.names:
            continue
        if not any(name in CATALOGUE[other].refines for other in larger.names):
            return False
    return True


def alternatives(competition: Competition, effect: str) -> tuple[str, ...]:
    """Effects that fit as well in the place of `effect`, as far as this recording can tell.

    One that needs more parameters to do no better is none.
    """
    winner = competition.winner
    others = set(winner.names) - {effect}
    found = []
    for rival in competition.rivals:
        names = set(rival.names)
        if not others <= names or effect in names or len(names) != len(winner.names):
            continue
        (other,) = names - others
        freedom = len(CATALOGUE[other].parameters) - len(CATALOGUE[effect].parameters)
        if freedom > 0 or effect in CATALOGUE[other].refines:
            continue
        if rival.judged - winner.judged < INDISTINCT * winner.judged:
            found.append(other)
    return tuple(found)


def settings_alone(names: Iterable[str]) -> float:
    """Probability that these settings of a controller are wrong, and not one that is not known.

    A controller is linear up to its limits: some settings together give nearly any smooth change of
    its answer. Each wrong one beside the first is a step rarer.
    """
    count = len(settings(names))
    if count < 2:
        return 1.0
    known, unknown = RARER ** (count - 1), RARER**_UNKNOWN_SETTING
    return known / (known + unknown)


def settings(names: Iterable[str]) -> list[str]:
    """Those of some effects that are settings of the controller, its limits aside.

    Beside one, a delay counts as one more: with it, it may stand for a filter that is not known.
    """
    every = {name: CATALOGUE[name] for name in names}
    tuned = [name for name, one in every.items() if one.block == "controller" and one.sized != ()]
    if not tuned:
        return []
    return [name for name, one in every.items() if name in tuned or one.block == "timing"]


def confidence(place: Standing, rivals_as_good: int) -> float:
    """Probability that a named cause is true, from how the fit stands.

    Near the floor a wrong set is rare however close its rivals; further up it takes a distance to
    the next best. The curve is drawn through what the sealed study shows.
    """
    away = min(max((place.left - _NEAR) / (_FAR - _NEAR), 0.0), 1.0)
    score = 4.5 - 2.6 * away
    # Where something is left and another set leaves hardly more, neither is known to be the cause.
    close = min(max((_CLEAR - place.margin) / (_CLEAR - 1.0), 0.0), 1.0)
    score -= 8.0 * math.sqrt(away) * close
    score += away * (2.0 * math.log(max(place.margin, 1.0)) - 2.5 * math.log(max(place.left, 1.0)))
    value = 1.0 / (1.0 + math.exp(-score))
    return value / (1.0 + rivals_as_good)
