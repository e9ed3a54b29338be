"""`describe`: what nothing in the catalogue explains, as a law at a port, or nothing.

1. What each balance of the drive leaves, the sheet free (`missing`).
2. The sets of variables that predict it best on stretches that were not fitted (`choose`), beyond
   chance (`chance`).
3. These laws at every port that the balance speaks of, played in closed loop (`play`); set and port
   that bring the replay nearest stand, of more variables only where they earn it.
4. A law is described only where it takes as much off the gap on held-out stretches as an effect
   must remove to be named.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import chain

import numpy as np

from ...arrays import FloatArray
from ...drive.law import PERIODS
from ..compete.candidates import CLOSE
from ..compete.competition import Competition
from ..compete.earn import earns
from ..fit.fit import Fit, Fitter
from ..fit.robust import misfit, robust_squares
from ..judge.place import open_ended
from ..judge.verdict import HELPS
from ..locate.locate import pooled
from ..side_by_side import side_by_side
from ..split import stretch_of
from . import words
from .balance import Balance, balances_of, driving
from .chance import probability
from .choose import Choice, choose
from .description import Course, Description, Resembled
from .formula import formula
from .guess import Guess
from .missing import ROD, TORQUE, VOLTAGE, missing
from .motion import Motion
from .nearest import played_curve
from .play import CLOSELY, ROUGHLY, Played, Playing, at_noise, evaluate
from .points import at_port

_PLAYED = 4  # laws of each number of variables that are fitted in closed loop
_AHEAD = 2  # of them that are looked at before laws of fewer variables are fitted to the end
_ALIKE = 1.02  # costs closer than this factor cannot be told apart
_PORTS = {
    "torque": ("rotor_torque", "load_torque"),
    "friction": ("rotor_friction", "load_friction"),
    "inverter_voltage": ("inverter_voltage",),
    "current_error": ("current_error",),
    "rod_error": ("rod_error", "rotor_angle_error"),
}
_BALANCE = {
    "torque": TORQUE,
    "friction": TORQUE,
    "inverter_voltage": VOLTAGE,
    "current_error": TORQUE,
    "rod_error": ROD,
}
# The balances that a law at a port shows in.
_COVERS = {
    "rotor_torque": {TORQUE},
    "rotor_friction": {TORQUE},
    "load_torque": {TORQUE},
    "load_friction": {TORQUE},
    "inverter_voltage": {VOLTAGE},
    "current_error": {TORQUE, VOLTAGE},
    "rod_error": {ROD},
    "rotor_angle_error": {ROD, TORQUE, VOLTAGE},
}


@dataclass(frozen=True, eq=False)
class _Candidate:
    """A law at a port, as it was regressed (`guess`) and as it begins in closed loop."""

    guess: Guess
    port: str
    choice: Choice
    balance: Balance
    begun: Played


@dataclass(frozen=True, eq=False)
class Described:
    """A description, and what is left with it."""

    description: Description
    played: Played


def describe(
    fitter: Fitter, competition: Competition, tell: Callable[[float], None]
) -> Described | None:
    """The law that comes nearest to the gap; None where none removes enough, or none can be known.

    It may do so by chance: see `Description.chance` and `chance.LEVEL`.

    Args:
        fitter: of the recording. competition: in which nothing earned its place.
        tell: called with the share done.
    """
    replay, sheet = fitter.replay, fitter.sheet
    if replay.drive.learned is not None:
        return None  # the drive file plays one already
    motion = Motion.of(replay, replay.full({}))
    left = missing(motion, sheet)
    balances = balances_of(left, motion, fitter.rows)
    by_balance = side_by_side(
        lambda kinds: _candidates(kinds, fitter, balances, motion),
        (("torque", "friction"), ("inverter_voltage",), ("rod_error",)),
    )
    candidates = list(chain.from_iterable(by_balance))
    tell(0.45)
    # Balances that something is missing from.
    broken = {_BALANCE[one.guess.kind] for one in candidates}
    if broken >= {TORQUE, VOLTAGE}:
        candidates += _candidates(("current_error",), fitter, balances, motion)
    if not candidates:
        return None
    candidates = _in_order(candidates, broken)
    played, chosen, alike = _in_loop(fitter, candidates, lambda share: tell(0.45 + 0.5 * share))
    null = competition.sheet
    if not (earns(fitter, as_fit(played), null) and _helps(fitter, played, null)):
        return None
    if any(_as_near(one, played, fitter) for one in _named(competition)):
        return None
    chance = _by_chance(fitter, null, played, chosen, candidates)
    return Described(_described(fitter, competition, played, chosen, motion, chance, alike), played)


def _in_order(candidates: list[_Candidate], broken: set[str]) -> list[_Candidate]:
    """Of each number of variables those that account for most of the balances that something is
    missing from, and those that begin nearest, in turn; of either sort the nearest first."""
    ordered: dict[_Candidate, None] = {}
    for size in sorted({len(one.guess.of) for one in candidates}):
        own = [one for one in candidates if len(one.guess.of) == size]
        nearest = sorted(own, key=lambda one: one.begun.fitted)
        covering = sorted(nearest, key=lambda one: -len(_COVERS[one.port] & broken))
        ordered |= dict.fromkeys(chain.from_iterable(zip(covering, nearest, strict=True)))
    return list(ordered)


def _in_loop(
    fitter: Fitter,
    candidates: list[_Candidate],
    tell: Callable[[float], None],
) -> tuple[Played, _Candidate, tuple[str, ...]]:
    """The law that brings the replay nearest, and the ports that it comes as near at.

    candidates: the most promising first. Laws of few variables go first; more have to earn it, as a
    further effect has to, on fitted and on held-out stretches. They are fitted to the end where
    they come nearer already, or stand in their balance; where that leaves more than noise, at every
    port that they come near at. Where laws of one variable more come so much nearer that finer fits
    of the fewer could not put them first, those are left out.
    """
    sizes = sorted({len(one.guess.of) for one in candidates})
    known: dict[_Candidate, Played] = {}

    def played_roughly(one: _Candidate) -> Played:
        return Playing(fitter, one.guess, one.port, one.begun.pulls).through(ROUGHLY)

    def roughly(number: int, most: int = _PLAYED) -> list[tuple[Played, _Candidate]]:
        own = [one for one in candidates if len(one.guess.of) == sizes[number]][:most]
        new = [one for one in own if one not in known]
        known.update(zip(new, side_by_side(played_roughly, new), strict=True))
        tell((number + 0.5) / len(sizes))
        return [(known[one], one) for one in own]

    found: tuple[Played, _Candidate, tuple[str, ...]] | None = None
    for number in range(len(sizes)):
        nearest = min(roughly(number), key=lambda one: one[0].fitted)
        near = nearest[0].fitted
        if near > CLOSE * fitter.perfect**2 and number + 1 < len(sizes):
            ahead = min(played.fitted for played, _ in roughly(number + 1, _AHEAD))
            if near > CLOSE * ahead:
                continue
        if found is None or near < found[0].fitted or _stands(roughly(number), found[0]):
            both = [nearest, *_predicting_better(roughly(number), *nearest)]
            playing, rough, chosen = _finished(fitter, both)
            moved = _at_other_ports(roughly(number), rough, chosen)
            if moved and not at_noise(fitter, playing.best.judged):
                ends = [(playing, rough, chosen), _finished(fitter, moved)]
                playing, rough, chosen = min(ends, key=lambda one: one[0].best.judged)
            closer = playing.known()
            if found is None or earns(fitter, as_fit(closer), as_fit(found[0])):
                found = (closer, chosen, _alike(roughly(number), rough, chosen))
        tell((number + 1) / len(sizes))
        if at_noise(fitter, found[0].judged):
            break  # more variables are not needed
    assert found is not None  # laws of the most variables are never left out
    return found


def _stands(roughly: list[tuple[Played, _Candidate]], found: Played) -> bool:
    """Whether a law that stands in its balance is among them, and finer fits may put it first."""
    return any(
        one.guess.of == one.choice.best.of and played.fitted < CLOSE * found.fitted
        for played, one in roughly
    )


def _predicting_better(
    roughly: list[tuple[Played, _Candidate]], nearest: Played, first: _Candidate
) -> list[tuple[Played, _Candidate]]:
    """Laws that come near and predict what is missing better than the nearest: at its port the best
    of other variables, and the best at another balance.

    A rough fit may take a drag of an angle for one of position, or a torque of the current for an
    error of its reading.
    """
    near = [
        (played, one)
        for played, one in roughly
        if one.guess.found.error < first.guess.found.error
        and played.fitted < CLOSE * nearest.fitted
    ]
    near.sort(key=lambda one: one[1].guess.found.error)
    own = [one for one in near if one[1].choice is first.choice and one[1].port == first.port]
    others = [one for one in near if one[1].choice is not first.choice]
    return [*own[:1], *others[:1]]


def _at_other_ports(
    roughly: list[tuple[Played, _Candidate]], nearest: Played, chosen: _Candidate
) -> list[tuple[Played, _Candidate]]:
    """The same law at other ports, where it comes near: a rough fit may take a torque on the rotor
    for one on the load."""
    return [
        (played, one)
        for played, one in roughly
        if one.guess.of == chosen.guess.of
        and one.choice is chosen.choice
        and one.port != chosen.port
        and played.fitted < CLOSE * nearest.fitted
    ]


def _finished(
    fitter: Fitter, roughly: list[tuple[Played, _Candidate]]
) -> tuple[Playing, Played, _Candidate]:
    """Of laws, fitted to the end, the one that leaves least; it as it was fitted roughly, too."""
    closely = side_by_side(lambda one: _closely(fitter, *one), roughly)
    ends = ((end, *rough) for end, rough in zip(closely, roughly, strict=True))
    return min(ends, key=lambda one: one[0].best.judged)


def _closely(fitter: Fitter, nearest: Played, one: _Candidate) -> Playing:
    """A law that was fitted roughly, as near as it goes."""
    begun = one.guess.with_values(np.array(nearest.law.values))
    playing = Playing(fitter, begun, one.port, nearest.pulls)
    playing.through(CLOSELY)
    return playing


def _alike(
    roughly: list[tuple[Played, _Candidate]], nearest: Played, chosen: _Candidate
) -> tuple[str, ...]:
    """Other ports at which the same law comes as near."""
    return tuple(
        one.port
        for other, one in roughly
        if one.port != chosen.port
        and other.fitted < _ALIKE * nearest.fitted
        and one.guess.of == chosen.guess.of
        and one.choice is chosen.choice
    )


def _candidates(
    kinds: tuple[str, ...], fitter: Fitter, balances: dict[str, Balance], motion: Motion
) -> list[_Candidate]:
    """The sets that come nearest at one balance, at each of its ports."""
    choice = choose(kinds, balances, motion)
    if choice is None:
        return []
    begun = []
    for guess in choice.near:
        pulls = fitter.sheet.at_nominal
        pulls[list(balances[guess.kind].pulled)] = guess.found.pulls
        for port in _PORTS[guess.kind]:
            # An error of the encoder shows in rod against rotor the other way round.
            turned = -1.0 if port == "rotor_angle_error" else 1.0
            begun.append((guess.with_values(turned * guess.found.values), port, pulls))

    def candidate(one: tuple[Guess, str, FloatArray]) -> _Candidate:
        guess, port, pulls = one
        played = evaluate(fitter, guess.law(port), pulls)
        return _Candidate(guess, port, choice, balances[guess.kind], played)

    return side_by_side(candidate, begun)


def _named(competition: Competition) -> tuple[Fit, ...]:
    return (competition.winner, *competition.rivals, *competition.singles)


def _as_near(fit: Fit, played: Played, fitter: Fitter) -> bool:
    """Whether a set of effects that the motion may have shown comes as near, unlike as it is."""
    return bool(fit.names) and fit.judged <= played.judged and not open_ended(fit, fitter)


def as_fit(played: Played) -> Fit:
    """What is left with a law, as fits are compared."""
    return Fit({}, played.pulls, played.gap, played.fitted, played.judged, played.left)


def _helps(fitter: Fitter, played: Played, null: Fit) -> bool:
    """Whether enough of the gap is gone, as an effect has to remove to be named."""
    if at_noise(fitter, played.judged):
        return True  # impacts that noise has moved stand for what is left
    before, after = (_pooled(fitter, gap) for gap in (null.gap, played.gap))
    white = pooled(fitter.replay, np.ones(len(fitter.replay.signals)))
    return before - after >= HELPS * (before - white)


def _by_chance(
    fitter: Fitter, null: Fit, played: Played, chosen: _Candidate, candidates: list[_Candidate]
) -> float:
    """The probability of as little a gap, or of as little in its balance, by a law without
    connection to what is missing.

    Either tells, at half the level. The loop's gap holds all that the law does; where flanks
    rattle, blows that come early or late hide it there, and in the balance they count for little.
    """
    guess, orders = chosen.guess, chosen.guess.looked_at
    went_on = {(one.guess.kind, one.guess.of) for one in candidates}
    in_loop = _chance_in_loop(fitter, null, played, len(went_on) + orders)
    tried = sum(one.sets for one in {one.choice for one in candidates})
    return min(1.0, 2.0 * min(in_loop, chosen.choice.by_chance(guess, tried + orders)))


def _chance_in_loop(fitter: Fitter, null: Fit, played: Played, sets: int) -> float:
    """The probability of as little a gap in closed loop; sets: of variables that went on."""
    usable = fitter.rows | fitter.held
    missing, left = (
        np.sign(gap[:, usable]) * np.sqrt(robust_squares(gap[:, usable]))
        for gap in (null.gap, played.unseen)
    )
    stretch = stretch_of(fitter.replay.time_s[usable])
    return probability(missing, left, stretch, fitter.perfect**2, sets)


def _pooled(fitter: Fitter, gap: FloatArray) -> float:
    """RMS on held-out stretches pooled over the signals."""
    return pooled(fitter.replay, np.sqrt(np.mean(gap[:, fitter.held] ** 2, axis=1)))


def _described(
    fitter: Fitter,
    competition: Competition,
    played: Played,
    chosen: _Candidate,
    motion: Motion,
    chance: float,
    alike: tuple[str, ...],
) -> Description:
    law, guess = played.law, chosen.guess
    replay = fitter.replay
    before = _pooled(fitter, fitter.nominal.gap)
    white = pooled(replay, np.ones(len(replay.signals)))
    shrink = (before - _pooled(fitter, played.gap)) / max(before - white, 1e-12)
    nearest = min(competition.singles, key=lambda one: one.judged, default=None)
    resembles = None
    if nearest is not None:
        (name,) = nearest.names
        part, gain = chosen.balance.parts[0]
        near = played_curve(fitter, nearest, law, guess, part.balance, gain)
        resembles = Resembled(name, misfit(nearest.left), misfit(played.left), near)
    rivals = chosen.choice.beside(guess)
    course, points = _course(fitter, chosen, motion, played)
    return Description(
        law=law,
        half=played.half,
        seen=chosen.balance.seen(guess),
        shrink=max(0.0, min(1.0, shrink)),
        formula=formula(law, played.half),
        words=f"{words.place(law)} {words.depends(law)}",
        chance=chance,
        next_best=tuple((one.of, one.found.error / guess.found.error) for one in rivals[:3]),
        ports=alike,
        turns={name: motion.periods(name, guess.on_load) for name in PERIODS},
        resembles=resembles,
        course=course,
        points=points,
    )


def _course(
    fitter: Fitter, chosen: _Candidate, motion: Motion, played: Played
) -> tuple[Course, FloatArray]:
    """The missing quantity, the sheet as it was found beside the law; the points of its curve."""
    part, gain = chosen.balance.parts[0]
    values, points = at_port(part, gain, played.pulls, chosen.port, chosen.guess, motion)
    unit = played.law.unit
    table = chosen.balance.table(chosen.guess)
    predicted = np.array(played.law.values) @ table
    half = 1.96 * part.noise / abs(gain)
    driven = predicted * driving(chosen.guess.kind, motion)
    course = Course(motion.time_s, values, half, part.known, driven, unit)
    return course, points
