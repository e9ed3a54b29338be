"""Simpler and finer forms of the effects in a set.

Friction by direction is a level and a rise with speed where it is the same both ways; Coulomb
friction is the plain form of Stribeck's. A simpler form takes the place of one that does hardly
better, a finer one that of a plain one only where it does clearly better.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product

from ...effects.catalogue import CATALOGUE
from ..fit.descent import glimpse
from ..fit.fit import Fit
from ..side_by_side import side_by_side
from .candidates import BEHIND, SEARCHED_SETS, STARTS, Candidates
from .earn import earns, surely_at_noise


class Forms:
    """Tries other forms of what `field` has found."""

    def __init__(self, field: Candidates) -> None:
        self.field, self.fitter, self.names = field, field.fitter, field.names

    def simplified(self, best: Fit, others: Sequence[Fit] = ()) -> Fit:
        """`best`, or with special cases in an effect's place that do nearly as well.

        In several places at once where `others`, fitted already, have them; in each place alone,
        then all that it may have together: friction that is the same in both directions is a level
        and a rise with speed. Sets that it gives way to come first, and have to do better: friction
        of one level beside a constant load differs by direction, too, until the motion rests.
        """
        best = self._special(best, others)
        for name in best.names:
            found = None if surely_at_noise(self.fitter, best) else self._giving_way(best, name)
            if found is not None and earns(self.fitter, found, best):
                return found
            refines = [one for one in CATALOGUE[name].refines if one in self.names]
            for simple in [
                *((one,) for one in refines),
                *([tuple(refines)] if refines[1:] else []),
            ]:
                if any(one in best.names for one in simple):
                    continue
                start = self._instead(best, name, simple)
                found = self._near(start, best) if start is not None else None
                if found is not None and _nearly_as_good(found, best):
                    return found
        return best

    @staticmethod
    def _special(best: Fit, others: Sequence[Fit]) -> Fit:
        """The best of `others` with special cases of effects of `best`, if nearly as good."""
        ways = product(*((name, *CATALOGUE[name].refines) for name in best.names))
        special = {frozenset(one) for one in ways} - {frozenset(best.names)}
        found = [one for one in others if frozenset(one.names) in special]
        found = [one for one in found if _nearly_as_good(one, best)]
        return min(found, key=lambda one: one.judged, default=best)

    def _giving_way(self, best: Fit, name: str) -> Fit | None:
        """The best fit with a set of others in an effect's place that act nearly alike."""
        sets = [
            others
            for others in CATALOGUE[name].gives_way(best.values[name], self.fitter.replay.drive)
            if all(one in self.names and one not in best.names for one in others)
        ]
        if not sets:
            return None
        rest = self.fitter.without(best, [name])
        started = [self.fitter.evaluate({**rest.values, **one}, rest.pulls) for one in sets]
        found = self.field.polish(self.field.searched(started)[:1])[0]
        self.fitter.test_floor(found)
        return found

    def _near(self, start: Fit, best: Fit) -> Fit | None:
        """A fit from a start near its end; None where it comes nowhere near the best."""
        near = self.field.near(start)
        if near.fitted > BEHIND * best.fitted:
            return None
        return self.field.polish([near])[0]

    def finer(self, best: Fit) -> Fit:
        """`best`, or with a finer form in an effect's place that does better.

        Where another effect is missing beside it, a finer form may come out as its opposite
        (friction that seems to rise with speed hides that it falls): it begins again once that is
        there.
        """
        started: list[Fit] = []
        for form in self.names:
            plain = [name for name in best.names if name in CATALOGUE[form].refines]
            if plain and form not in best.names:
                rest = self.fitter.without(best, plain)
                # How the contact gives is known; sizes are found again.
                told = {quantity.name for quantity in CATALOGUE[form].reported}
                shared = _shared(form, best.values[plain[0]])
                shape = {key: value for key, value in shared.items() if key not in told}
                started += self._kept(self.field.starts(rest, [form], STARTS), form, shape)
        glimpsed = side_by_side(lambda one: glimpse(self.fitter, one, self.field.null), started)
        searched = self.field.searched(sorted(glimpsed, key=lambda one: one.fitted)[:SEARCHED_SETS])
        if not searched or searched[0].fitted >= best.fitted:
            return best
        found = self.field.settled(self.field.polish(searched[:1])[0])
        return best if _nearly_as_good(best, found) else found

    def _instead(self, best: Fit, name: str, simple: Sequence[str]) -> Fit | None:
        """`best` with simpler effects, where they start, in the place of one; None where none can.

        They keep the parameters that they have in common with it.
        """
        found, near = self.fitter.without(best, [name]), True
        for one in simple:
            shared = _shared(one, best.values[name])
            if all(quantity.name in shared for quantity in CATALOGUE[one].reported):
                found = self.fitter.evaluate({**found.values, one: shared}, found.pulls)
                continue
            started = self._kept(self.field.starts(found, [one], STARTS), one, shared)
            if not started:
                return None
            found, near = min(started, key=lambda other: other.fitted), False
        return found if near else self.field.searched([found])[0]

    def _kept(self, started: Sequence[Fit], name: str, shared: dict[str, float]) -> list[Fit]:
        """Starts of an effect with parameters that it has in common with another's."""
        if not shared:
            return list(started)
        return side_by_side(
            lambda one: self.fitter.evaluate(
                {**one.values, name: {**one.values[name], **shared}}, one.pulls
            ),
            started,
        )


def _nearly_as_good(simple: Fit, best: Fit) -> bool:
    """Whether a special case does as well as a form that has more freedom."""
    return simple.judged < 1.15 * best.judged + 0.05


def _shared(name: str, values: Mapping[str, float]) -> dict[str, float]:
    """Of an effect's parameters, those that are among another's `values`."""
    known = [one.name for one in CATALOGUE[name].parameters]
    return {key: values[key] for key in known if key in values}
