"""The closest set of a rigid drive in simpler terms, where its finer ones cannot be told apart."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from ...effects import constant_load, load_coulomb_friction, load_viscous_friction
from ...effects.catalogue import EFFECTS
from ...effects.term import Term
from ..judge.verdict import NAMED, STRUCTURELESS
from .judge import SMALL, Judgement
from .void import SHEET


def simplest(judgement: Judgement) -> list[Term] | None:
    """The closest set without what is no cause, or in commoner terms; None where nothing is to be
    changed.

    In this order: friction of one level for a finer form that is no cause, which would make
    constants look sound that it stands for; nothing for constants that lie within their tolerance;
    a constant load where that does nearly all that a spring or a weight does; for a wave one of an
    effect that explains others of the set, where it is like that; friction of one level where its
    finer forms cannot be told apart. That there is friction is then sure, its form is not.
    """
    order = judgement.contest.order
    for term in order:
        if _rubs(judgement, term) and judgement.void(term) not in ("", SHEET):
            return _plainer(judgement, term)
    told = [one for one in order if judgement.void(one) != SHEET]
    if len(told) < len(order):
        return told
    forms: tuple[Callable[[Judgement, Sequence[Term]], list[Term] | None], ...]
    forms = (_with_a_load, _with_one_kind_of_wave, _with_plain_friction)
    return next((made for form in forms if (made := form(judgement, order)) is not None), None)


def _with_a_load(judgement: Judgement, order: Sequence[Term]) -> list[Term] | None:
    contest, rows, catalogue = judgement.contest, judgement.judged, judgement.catalogue
    level = catalogue.own(constant_load.term(catalogue.along))
    base, best = (fit.priced(rows) for fit in (contest.base, contest.winner))
    for at, term in enumerate(order):
        if level.effect in term.refines:
            simple = [*order[:at], level, *order[at + 1 :]]
            # A spring or a weight that adds too little to a constant to be named for itself.
            left = judgement.null.fit(simple).priced(rows)
            if base - left >= (1.0 - SMALL) * (base - best):
                return simple
    return None


def _with_one_kind_of_wave(judgement: Judgement, order: Sequence[Term]) -> list[Term] | None:
    waves = {one.effect for one in order if one.rate}
    for at, term in enumerate(order):
        for other, rival in judgement.contest.swaps[term.effect] if term.rate else ():
            commoner = EFFECTS[other.effect].rarity < EFFECTS[term.effect].rarity
            known = other.rate and other.effect in waves - {term.effect}
            if known and commoner and judgement.certainty.alike(rival):
                return [*order[:at], *order[at + 1 :], other]  # the strongest stay first
    return None


def _with_plain_friction(judgement: Judgement, order: Sequence[Term]) -> list[Term] | None:
    for term in order:
        if not _rubs(judgement, term):
            continue
        simple = _plainer(judgement, term)
        acts, sure, names = judgement.certainty.of(term)
        like = acts >= NAMED and bool(names)
        left = judgement.null.fit(simple).priced(judgement.judged)
        near = left <= STRUCTURELESS * judgement.floor
        if sure < NAMED and (like or near):
            return simple
    return None


def _rubs(judgement: Judgement, term: Term) -> bool:
    """Whether it is a finer form of friction of one level."""
    return load_coulomb_friction.term(judgement.catalogue.along).effect in term.refines


def _plainer(judgement: Judgement, finer: Term) -> list[Term]:
    """The set with friction of one level, and by speed if that is in it, for a finer form."""
    catalogue = judgement.catalogue
    forms = (load_coulomb_friction, load_viscous_friction)
    plain = [catalogue.own(one.term(catalogue.along)) for one in forms]
    rest = [one for one in judgement.contest.order if one is not finer]
    return [*rest, *(one for one in plain if one.effect in finer.refines)]
