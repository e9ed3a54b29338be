"""Which effects close the gap: all of them compete, alone and in sets, judged on what no fit saw.

0. The sheet alone: the constants, each at the price of leaving its tolerance. What follows has them
   free at the same price, and has to beat this.
1. Every effect is started from what the recording shows (regressions, lines, multiples of the
   nominal value) and replayed once per start.
2. The most promising are fitted in closed loop; the best of these with their shape parameters too.
3. Where one effect does not bring the model to the noise floor, sets of two and three are tried:
   candidates come from the responses already at hand, added up with free sizes, from fresh starts
   on what the best single effects leave, and from these in shares of the sizes they have alone.
4. An effect stays in a set only if leaving it out costs clearly more than it adds in freedom.
"""

from __future__ import annotations

import dataclasses
import math
import os
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from ..effects.catalogue import CATALOGUE, MODULES
from .evidence import gather
from .fit import Fit, Fitter, Values, robust_mean_square
from .joint import joined, resized
from .replay import FloatArray
from .ringing import Ringing
from .stages import MEDIUM
from .strain import effect_of, strains

AT_FLOOR = 1.14  # times a perfect model's misfit: a model this close needs no further effect
_WORTH = 0.6  # a further effect must bring the square of the misfit's surplus below this share ...
_LEAST = 0.04  # ... and lower the square itself by this
_HELPS = 0.5  # share of the cost below which a start counts as on the way
_LARGEST = 5.0  # times a start that its response may suggest
_STARTS = 6  # of one effect alone
_STARTS_IN_SETS = 2
_KEPT_SINGLES = 9
_POLISHED_SINGLES = 2
_SETTLING = 3  # polishes at the most
_POLISHING = 5  # derivatives at the most in each stage; a fit that has ended takes fewer
_FIRSTS = 2  # single effects that sets are built upon
_KEPT_SETS = 6
_CLOSE = 2.0  # times the best cost: a runner-up that finer fits may still put first
_SEARCHED_SETS = 3
_FURTHER_SETS = 3  # searched besides where they promised less than the best search left
_TOGETHER = 0.7  # of the cost alone: a set of two that promises to be a pair
_KEPT_RESPONSES = 4  # further sets from responses added up
_KEPT_JOINED = 4  # and from single effects in shares of their sizes
_MOST_EFFECTS = 3
_SHAKEN_LOOSE = 0.8  # times the least cost of a silent replay
EXCUSED = 0.75  # of the gap must be gone before noise round the loop may excuse the rest
_SHEET_STEPS = 5  # derivatives of the sheet alone at the most, in each stage
# The square of a normal variable by chance: 1 of 20 sound constants saves more than the first, 1 of
# 2000 more than the second, and may be a cause.
_PULLED_OUT, _STRAINED = 4.0, 12.0
_STRIDE = 5  # responses are added up on every fifth sample

Job = TypeVar("Job")
Report = Callable[[str, float], None]


def misfit(cost: float) -> float:
    """Root of a mean square."""
    return float(np.sqrt(cost))


@dataclass(frozen=True, eq=False)
class Competition:
    """What came of it.

    Attributes:
        nominal: the model without effects.
        sheet: the same with its constants fitted as far as the data sheet allows; every set of
            effects competes against this.
        singles: the best fit of each effect alone, best first.
        winner: the set that is named, or the nominal model if none earned its place.
        rivals: the best sets of the winner's size that hold another effect, best first.
        leave_one_out: for each effect of the winner, the best fit without it.
        replays: runs of the drive in all.
    """

    nominal: Fit
    sheet: Fit
    singles: tuple[Fit, ...]
    winner: Fit
    rivals: tuple[Fit, ...]
    leave_one_out: dict[str, Fit]
    replays: int


@dataclass(frozen=True, eq=False)
class _Promise:
    """A start upon `base`: what it may leave (`score`) at `size` times its size."""

    score: float
    size: float
    fit: Fit
    base: Fit


class _Competition:
    def __init__(
        self,
        fitter: Fitter,
        nominal: Fit,
        names: Sequence[str],
        report: Report,
        threads: ThreadPoolExecutor,
    ) -> None:
        self.fitter = fitter
        self.names = list(names)
        self.report = report
        self.replays = 0
        self._threads = threads
        self.nominal = nominal
        self.null = fitter.alone(_SHEET_STEPS, threads.map)
        self.library: list[Fit] = []
        thin = self.null.gap[:, np.flatnonzero(fitter.rows)[::_STRIDE]]
        scale = 3.0 + 3.0 * float(np.median(np.abs(thin)))
        self._weights = 1.0 / np.sqrt(1.0 + (thin / scale) ** 2)
        # What a pull weighs beside the thinned rows, as the sheet is weighed against a cost.
        level = float(np.mean((thin * self._weights) ** 2))
        self._pull_weight = 2.0 * math.sqrt(level * thin.size / fitter.sheet.evidence)
        self._ringing = Ringing(fitter, self.map)

    def map(self, work: Callable[[Job], Fit], jobs: Iterable[Job]) -> list[Fit]:
        """Do fits side by side."""
        results = list(self._threads.map(work, jobs))
        self.replays += sum(one.replays for one in results)
        return results

    def starts(self, base: Fit, names: Iterable[str], most: int) -> list[Fit]:
        """`base` with one more effect, at up to `most` starts that the recording suggests."""
        sheet = self.fitter.sheet
        evidence = gather(self.fitter.replay.at(sheet.constants(base.pulls)), base.values)
        jobs: list[tuple[str, dict[str, float], bool]] = []
        for name in names:
            if name in base.values:
                continue
            for rank, start in enumerate(CATALOGUE[name].starts(evidence)[:most]):
                if _possible(name, start):
                    jobs.append((name, dict(start), rank == 0))

        for name in names:
            if name not in base.values:
                jobs += [(name, values[name], False) for values in self._ringing.starts(base, name)]

        def begin(job: tuple[str, dict[str, float], bool]) -> Fit:
            name, start, first = job
            fit = self.fitter.evaluate({**base.values, name: start}, base.pulls)
            if "phase_rad" in fit.values[name]:
                return self._in_phase(base, name, fit, all_round=first)
            return fit

        return self._out_of_sheet(base, names) + self.map(begin, jobs)

    def _out_of_sheet(self, base: Fit, names: Iterable[str]) -> list[Fit]:
        """`base` with the effect of a strained constant, where all go once that one is free."""
        sheet, drive = self.fitter.sheet, self.fitter.replay.drive
        found = []
        for one in strains(base, self.fitter):
            name = effect_of(one.row, self.fitter)
            if one.saved < _PULLED_OUT or name is None or name not in names or name in base.values:
                continue
            effect = CATALOGUE[name]
            away = sheet.at_nominal
            away[one.row] = one.pull
            off = float(sheet.values(away)[one.row] - sheet.nominal[one.row])
            value = {effect.parameters[0].name: effect.neutral(drive) + off}
            if _possible(name, value):
                found.append(self.fitter.evaluate({**one.values, name: value}, one.pulls))
        return found

    def _in_phase(self, base: Fit, name: str, fit: Fit, *, all_round: bool) -> Fit:
        """A periodic effect with the size and phase that its response in quadrature suggests."""
        given = fit.values[name]
        size = CATALOGUE[name].parameters[0]
        shifted = {**given, "phase_rad": given["phase_rad"] + 0.5 * math.pi}
        other = self.fitter.evaluate({**base.values, name: shifted}, base.pulls)
        target = self._thin(base)
        pair = np.column_stack([target - self._thin(fit), target - self._thin(other)])
        sine, cosine = np.linalg.lstsq(pair, target, rcond=None)[0]
        turned = {
            **given,
            size.name: min(given[size.name] * math.hypot(sine, cosine), size.high),
            "phase_rad": math.remainder(
                given["phase_rad"] + math.atan2(cosine, sine), 2.0 * math.pi
            ),
        }
        third = self.fitter.evaluate({**base.values, name: turned}, base.pulls)
        tried = [fit, other, third]
        if all_round and min(one.fitted for one in tried) > _HELPS * base.fitted:
            # Not a linear matter (a load that rattles in its clearance): the phases all round.
            for quarters in (0.5, 1.5, 2.0, 2.5, 3.0, 3.5):
                moved = {**given, "phase_rad": given["phase_rad"] + 0.5 * math.pi * quarters}
                tried.append(self.fitter.evaluate({**base.values, name: moved}, base.pulls))
        best = min(tried, key=lambda one: one.fitted)
        return dataclasses.replace(best, replays=len(tried))

    def search(self, fits: Sequence[Fit]) -> list[Fit]:
        """Fit each from afar; best first."""
        found = self.map(lambda one: self.fitter.search(one, self.null), fits)
        return sorted(found, key=lambda one: one.fitted)

    def best_of(self, sets: Sequence[Fit], promised: Sequence[float]) -> list[Fit]:
        """Fit sets of effects, the less promising ones less far; best first.

        Args:
            sets: the most promising first; that one is searched whatever a short fit makes of it.
            promised: the cost that each might reach; those that promised less than the best search
                leaves are searched, too, and pairs that come to far more than either effect alone.
        """
        glimpsed = self.map(
            lambda one: self.fitter.fit(one, steps=2, stage=MEDIUM, known=self.null), sets
        )
        promise = {id(one): score for one, score in zip(glimpsed, promised, strict=True)}
        first = glimpsed[0]
        glimpsed.sort(key=lambda one: one.fitted)
        if first in glimpsed[_SEARCHED_SETS:]:
            glimpsed.remove(first)
            glimpsed.insert(_SEARCHED_SETS - 1, first)
        searched = self.search(glimpsed[:_SEARCHED_SETS])
        glimpsed = glimpsed[_SEARCHED_SETS:]
        left = min(one.fitted for one in searched)
        if misfit(left) > AT_FLOOR * self.fitter.perfect:
            hopeful = sorted(glimpsed, key=lambda one: promise[id(one)])[:_FURTHER_SETS]
            hopeful = [one for one in hopeful if promise[id(one)] < left]
            glimpsed = [one for one in glimpsed if one not in hopeful]
            hopeful += self._more_together(glimpsed)
            glimpsed = [one for one in glimpsed if one not in hopeful]
            searched = sorted(searched + self.search(hopeful), key=lambda one: one.fitted)
        close = [one for one in searched[1:2] if one.fitted < _CLOSE * searched[0].fitted]
        polished = self.polish([*searched[:1], *close], _POLISHING)
        rest = searched[len(polished) :] + glimpsed
        return sorted(polished + rest, key=lambda one: one.fitted)

    def _more_together(self, sets: Sequence[Fit]) -> list[Fit]:
        """The sets of two that come to far more than either effect alone, most of all first."""
        alone: dict[str, float] = {}
        for single in self.library:
            (name,) = single.names
            alone[name] = min(single.fitted, alone.get(name, math.inf))

        def share(one: Fit) -> float:
            return one.fitted / min(alone.get(name, self.null.fitted) for name in one.names)

        pairs = sorted((one for one in sets if len(one.names) == 2), key=share)
        return [one for one in pairs if share(one) < _TOGETHER][:_FURTHER_SETS]

    def polish(self, fits: Sequence[Fit], steps: int) -> list[Fit]:
        """Fit each to the end, with the parameters that only shape its effects."""
        return self.map(lambda one: self.fitter.polish(one, steps), fits)

    def singles(self) -> list[Fit]:
        """The best fit of each effect alone, best first."""
        started = self.starts(self.null, self.names, _STARTS)
        self.library = started
        self.report("starts", 0.3)
        order = self._most_promising(self.null, started)
        kept = order[:_KEPT_SINGLES]
        fitted = self.search(self._sized(kept))
        self.report("single effects", 0.5)
        close = [
            one for one in fitted[1:_POLISHED_SINGLES] if one.fitted < _CLOSE * fitted[0].fitted
        ]
        polished = self.polish([*fitted[:1], *close], _POLISHING)
        self.library = started + fitted + polished
        rest = [one.fit for one in order[_KEPT_SINGLES:]]
        return sorted(polished + fitted[len(polished) :] + rest, key=lambda one: one.fitted)

    def _thin(self, fit: Fit) -> FloatArray:
        """What a fit leaves on the thinned rows, and below it its pulls, weighed by their price."""
        rows = np.flatnonzero(self.fitter.rows)[::_STRIDE]
        gap = (fit.gap[:, rows] * self._weights).ravel()
        return np.concatenate([gap, self._pull_weight * fit.pulls])

    def _score(self, rest: FloatArray) -> float:
        """The cost of what is left, in the form of `_thin`."""
        size = rest.size - len(self.fitter.sheet)
        pulls = rest[size:] / self._pull_weight
        return self.fitter.sheet.priced(robust_mean_square(rest[:size]), pulls)

    def _most_promising(self, base: Fit, started: Sequence[Fit]) -> list[_Promise]:
        """The best start of each set upon `base`, most promising first.

        A response counts by what it would leave, were it free in size (and linear), beside what
        `base` could still do by its own parameters and by the sheet.
        """
        basis = self._basis(base)
        target = self._thin(base)
        free = target - basis @ (basis.T @ target)
        best: dict[frozenset[str], _Promise] = {}
        for one in started:
            response = target - self._thin(one)
            response -= basis @ (basis.T @ response)
            power = float(response @ response)
            size = float(response @ free) / power if power > 0.0 else 0.0
            size = min(max(size, 0.0), _LARGEST)
            score = min(one.fitted, self._score(free - size * response))
            key = frozenset(one.names)
            if key not in best or score < best[key].score:
                best[key] = _Promise(score, size, one, base)
        return sorted(best.values(), key=lambda one: one.score)

    def _sized(self, promises: Sequence[_Promise]) -> list[Fit]:
        """The starts, or the same in the size that their response suggests, if that is better."""
        drive = self.fitter.replay.drive

        def resize(promise: _Promise) -> Fit:
            fit = promise.fit
            (name,) = set(fit.names) - set(promise.base.names)
            if promise.size <= 0.0 or 0.8 < promise.size < 1.25:
                return fit
            values = CATALOGUE[name].scaled(fit.values[name], promise.size, drive)
            other = self.fitter.evaluate({**fit.values, name: values}, fit.pulls)
            return min((fit, other), key=lambda one: one.fitted)

        return self.map(resize, promises)

    def pairs_of_responses(self) -> list[tuple[float, Values]]:
        """Sets of two whose responses, added up with free sizes, leave least; and how much."""
        target, basis = self._thin(self.null), self._basis(self.null)
        responses = np.array([target - self._thin(one) for one in self.library])
        responses -= (responses @ basis) @ basis.T
        target = target - basis @ (basis.T @ target)
        gram, along = responses @ responses.T, responses @ target
        drive = self.fitter.replay.drive
        found: dict[frozenset[str], tuple[float, Values]] = {}
        for i, first in enumerate(self.library):
            for j in range(i):
                second = self.library[j]
                if first.names == second.names:
                    continue
                determinant = gram[i, i] * gram[j, j] - gram[i, j] ** 2
                if not determinant > 1e-6 * gram[i, i] * gram[j, j]:
                    continue
                a = (along[i] * gram[j, j] - along[j] * gram[i, j]) / determinant
                b = (along[j] * gram[i, i] - along[i] * gram[i, j]) / determinant
                if not (0.03 < a < 3.0 and 0.03 < b < 3.0):
                    continue
                left = float(target @ target - a * along[i] - b * along[j]) / target.size
                key = frozenset((*first.names, *second.names))
                if key not in found or left < found[key][0]:
                    found[key] = (
                        left,
                        {**resized(first, a, drive), **resized(second, b, drive)},
                    )
        return sorted(found.values(), key=lambda pair: pair[0])[: _KEPT_SETS + _KEPT_RESPONSES]

    def sets_upon(self, firsts: Sequence[Fit]) -> tuple[list[Fit], list[float]]:
        """Each of `firsts` with one more effect, the most promising started, not yet fitted.

        Returns (starts, what each might leave).
        """
        best: dict[frozenset[str], _Promise] = {}
        for rank, first in enumerate(firsts):
            most = _STARTS if rank == 0 else _STARTS_IN_SETS
            for one in self._most_promising(first, self.starts(first, self.names, most)):
                key = frozenset(one.fit.names)
                if key not in best or one.score < best[key].score:
                    best[key] = one
        order = sorted(best.values(), key=lambda one: one.score)[:_KEPT_SETS]
        return self._sized(order), [one.score for one in order]

    def _basis(self, fit: Fit) -> FloatArray:
        """Orthonormal directions in which the fit can still move, in the form of `_thin`.

        The sheet's are held back by their price, which stands among the rows.
        """
        size = self._thin(fit).size
        if fit.jacobian is None:
            return np.zeros((size, 0))
        signals, count = fit.gap.shape[0], fit.jacobian.shape[1]
        columns = fit.jacobian.reshape(signals, -1, count)[:, ::_STRIDE]
        columns = (columns * self._weights[:, :, None]).reshape(-1, count)
        priced = np.zeros((len(self.fitter.sheet), count))
        first = len(fit.coordinates)
        priced[list(fit.pulled), range(first, count)] = self._pull_weight
        basis: FloatArray = np.linalg.qr(np.concatenate([columns, priced]))[0]
        return basis


def _possible(name: str, start: object) -> bool:
    values = dict(start)  # type: ignore[call-overload]
    for quantity in CATALOGUE[name].parameters:
        value = values.get(quantity.name, quantity.default)
        if value is None or not np.isfinite(value):
            return False
        if not quantity.low <= value <= quantity.high:
            return False
    return True


def _simplified(run: _Competition, best: Fit) -> Fit:
    """`best`, or with a special case in an effect's place that does nearly as well."""
    for name in best.names:
        for simple in CATALOGUE[name].refines:
            if simple in best.names or simple not in run.names:
                continue
            values = {key: dict(given) for key, given in best.values.items() if key != name}
            shared = {
                one.name: best.values[name][one.name]
                for one in CATALOGUE[simple].parameters
                if one.name in best.values[name]
            }
            if all(one.name in shared for one in CATALOGUE[simple].reported):
                start = run.fitter.evaluate({**values, simple: shared}, best.pulls)
            else:
                started = run.starts(run.fitter.evaluate(values, best.pulls), [simple], _STARTS)
                if not started:
                    continue
                start = run.search([min(started, key=lambda one: one.fitted)])[0]
            (found,) = run.polish([start], _POLISHING)
            if found.judged < 1.15 * best.judged + 0.05:
                return found
    return best


def at_noise(fitter: Fitter, fit: Fit) -> bool:
    """Whether noise and a sound sheet account for what the fit leaves: no effect is needed."""
    if any(one.saved > _STRAINED and effect_of(one.row, fitter) for one in strains(fit, fitter)):
        return False
    left = misfit(fit.judged)
    if left <= AT_FLOOR * fitter.perfect:
        return True
    return gone(fitter, fit) >= EXCUSED and left <= AT_FLOOR * fitter.perfect_with(fit.values)


def gone(fitter: Fitter, fit: Fit) -> float:
    """Share of the squared misfit above a perfect nominal model's that a fit takes off."""
    perfect = fitter.perfect**2
    before = max(fitter.nominal.judged - perfect, 1e-9)
    return 1.0 - max(fit.judged - perfect, 0.0) / before


def earns(fitter: Fitter, with_it: Fit, without: Fit) -> bool:
    """Whether the larger set lowers the misfit enough, on fitted and on held-out stretches."""
    if without.names and at_noise(fitter, without):
        return False
    perfect = fitter.perfect_with(with_it.values)
    for after, before in ((with_it.fitted, without.fitted), (with_it.judged, without.judged)):
        floor = min(0.95 * perfect**2, after)
        if before - after < _LEAST or (after - floor) > _WORTH * (before - floor):
            return False
    return True


def compete(fitter: Fitter, nominal: Fit, names: Sequence[str], report: Report) -> Competition:
    """Let the effects `names` compete for the gap that `nominal`, the bare model, leaves.

    report: takes a stage and the share done.
    """
    with ThreadPoolExecutor(os.cpu_count() or 1) as threads:
        return _compete(_Competition(fitter, nominal, names, report, threads))


def _compete(run: _Competition) -> Competition:
    fitter, report = run.fitter, run.report
    if run.null is not run.nominal and at_noise(fitter, run.null):
        return Competition(run.nominal, run.null, (), run.null, (), {}, run.replays)
    if _shaken_loose(run):
        fitter.replay.shake()
    singles = run.singles()
    report("single effects", 0.6)
    winner = run.null
    rivals: list[Fit] = []
    pool = list(singles)
    best = _settled(run, _simplified(run, singles[0])) if singles else run.null
    if singles and earns(fitter, best, run.null):
        winner = best
        rivals = [one for one in singles if one.names != best.names]
    firsts = [best, *(one for one in singles if one.names != best.names)][:_FIRSTS]
    size = 2
    while not at_noise(fitter, best) and size <= _MOST_EFFECTS and firsts:
        sets, promised = run.sets_upon(firsts)
        if size == 2:
            keys = {frozenset(one.names) for one in sets}
            pairs = [one for one in run.pairs_of_responses() if frozenset(one[1]) not in keys]
            del pairs[_KEPT_RESPONSES:]
            sets += run.map(
                lambda values: fitter.evaluate(values, run.null.pulls),
                [values for _, values in pairs],
            )
            promised += [left for left, _ in pairs]
            both = joined(fitter, singles, run.map)[:_KEPT_JOINED]
            sets += both
            promised += [one.fitted for one in both]
        report(f"sets of {size}", 0.6 + 0.1 * (size - 1))
        fitted = run.best_of(sets, promised)
        report(f"sets of {size}", 0.65 + 0.1 * (size - 1))
        pool += fitted
        best = _settled(run, _simplified(run, fitted[0]))
        if not earns(fitter, best, winner):
            break
        winner = best
        rivals = [one for one in fitted if set(one.names) != set(best.names)]
        firsts = [best, *(one for one in fitted if one.names != best.names)][:_FIRSTS]
        size += 1
    winner, without = _pruned(run, _settled(run, winner), pool)
    rivals.sort(key=lambda one: one.judged)
    return Competition(
        run.nominal, run.null, tuple(singles), winner, tuple(rivals), without, run.replays
    )


def _shaken_loose(run: _Competition) -> bool:
    """Whether friction, shaken by noise in the loop, is nearer than any silent replay of it."""
    replay = run.fitter.replay
    if not replay.noise_in_loop:
        return False
    ports = ("rotor_friction", "load_friction")
    names = [name for name in run.names if any(hasattr(MODULES[name], port) for port in ports)]
    silent = run.starts(run.null, names, _STARTS)
    replay.shake()
    shaken = run.map(lambda one: run.fitter.evaluate(one.values, one.pulls), silent)
    replay.calm()
    nearest = min(one.fitted for one in [run.null, *silent])
    return any(one.fitted < _SHAKEN_LOOSE * nearest for one in shaken)


def _settled(run: _Competition, winner: Fit) -> Fit:
    """The winner fitted until it no longer moves."""
    for _ in range(_SETTLING if winner.names else 0):
        if winner.ended:
            break
        better = run.fitter.polish(winner, _POLISHING)
        run.replays += better.replays
        still = winner.fitted - better.fitted < 0.01 * winner.fitted
        winner = better
        if still:
            break
    return winner


def _pruned(run: _Competition, winner: Fit, pool: Sequence[Fit]) -> tuple[Fit, dict[str, Fit]]:
    """Take out, one by one, what does not earn its place; with the fits that leave each one out."""
    while True:
        without = _leave_one_out(run, winner, pool)
        idle = [name for name, rest in without.items() if not earns(run.fitter, winner, rest)]
        if not idle or len(winner.names) == 0:
            return winner, without
        winner = min((without[name] for name in idle), key=lambda one: one.fitted)


def _leave_one_out(run: _Competition, winner: Fit, pool: Sequence[Fit]) -> dict[str, Fit]:
    def refit(start: Fit) -> Fit:
        known = [one for one in pool if set(one.names) == set(start.names)]
        return min([*known, *run.polish([start], _POLISHING)], key=lambda one: one.fitted)

    return leave_one_out(run.fitter, winner, run.null, refit)


def leave_one_out(
    fitter: Fitter, winner: Fit, nominal: Fit, refit: Callable[[Fit], Fit]
) -> dict[str, Fit]:
    """For each effect of `winner`, the fit without it: its others fitted anew, or `nominal`.

    refit: fits from a start with the others at the winner's values.
    """
    found: dict[str, Fit] = {}
    for name in winner.names:
        found[name] = refit(fitter.without(winner, [name])) if len(winner.names) > 1 else nominal
    return found
