"""What a rigid machine's file asks for along one motion, and the effects that compete for the rest.

What each effect asks for stands in its own file (`effects`).
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from ...arrays import FloatArray
from ...drive.rigid.law import asked
from ...drive.rigid.machine import KEYS, Machine
from ...drive.rigid.packed import model_of
from ...drive.rigid.units import Units
from ...effects import (
    constant_load,
    direction_dependent_friction,
    load_inertia_error,
    load_viscous_friction,
    spring_load,
    torque_constant_error,
)
from ...effects.along import Along
from ...effects.apart import apart
from ...effects.catalogue import RIGID, rigid_forms
from ...effects.term import Left, Term
from .motion import Motion

_ROUNDS = 4  # a ripple's share of itself: a third of a third of a third is below any floor


class Catalogue:
    """The effects that act on effort, along one motion.

    differing: effects that are found for each recording by itself, where the motion is of several.
    """

    def __init__(self, motion: Motion, machine: Machine, differing: Collection[str] = ()) -> None:
        self.motion, self.machine, self.differing = motion, machine, frozenset(differing)
        self.units = Units(motion.effort_unit, machine.linear)
        self.model = model_of(machine, self.units.own)
        self.along = Along(motion, machine, self.model, self.units, self._asked)

    def nominal(self) -> FloatArray:
        """The effort that the drive file's own values and effects ask for, float64[n]."""
        motion, made = self.motion, self._asked(self.along)
        if self.model.delay_s:
            made = np.interp(motion.time_s + self.model.delay_s, motion.time_s, made)
        return made

    def _asked(self, along: Along) -> FloatArray:
        """The same before it is delayed."""
        model, motion = self.model, self.motion
        made: FloatArray = (
            (model.inertia or 0.0) * motion.acceleration
            + model.viscous[0] * np.maximum(motion.velocity, 0.0)
            + model.viscous[1] * np.minimum(motion.velocity, 0.0)
            + model.coulomb[0] * along.forwards
            + model.coulomb[1] * along.backwards
            + model.constant
            + model.stiffness * motion.position
            + (1.0 - model.ratio) * motion.injected
        )
        shares = [one for one in model.shapes if RIGID[one.name].of_effort]
        for one in model.shapes:
            if one not in shares:
                made += RIGID[one.name].asked(along, one.values, made)
        if model.learned is not None:
            made += asked(model.learned, motion, along.sign, motion.smoothed(motion.effort))
        bare = made
        for _ in range(_ROUNDS if shares else 0):  # a share of the whole effort, itself included
            made = bare + sum(RIGID[one.name].asked(along, one.values, made) for one in shares)
        return made

    def own(self, term: Term) -> Term:
        """A term as it is sought: for each recording by itself where its effect differs."""
        return apart(term, self.motion.parts) if term.effect in self.differing else term

    def unknown(self) -> list[Term]:
        """What the file leaves out and no balance can do without: the gain, the inertia."""
        along, found = self.along, list[Term]()
        if not along.known_gain and any(along.model.keys):
            found.append(torque_constant_error.term(along))
        if not (along.known_inertia or along.model.keys.inertia):
            found.append(load_inertia_error.term(along))
        return found

    @property
    def stated(self) -> set[str]:
        """Effects that stand for constants which the file states."""
        machine, found = self.machine, set[str]()
        for name, one in rigid_forms(machine.linear).items():
            key = one.constant[not machine.linear]
            if key and getattr(machine, KEYS[key].field):
                found.add(name)
        return found

    def smooth(self) -> list[Term]:
        """What any machine may ask for along its motion, but for its inertia."""
        along = self.along
        made = [load_viscous_friction, constant_load, spring_load]
        if along.both_ways:
            made.append(direction_dependent_friction)
        return [one.term(along) for one in made]

    def candidates(self, left: Left, among: Collection[str] | None = None) -> list[Term]:
        """Every term that a set may be extended by, given what it leaves; among: effects, None for
        all."""
        return [
            self.own(form.term(self.along, *one))
            for name, form in rigid_forms(self.machine.linear).items()
            if among is None or name in among
            for one in form.tried(self.along, left)
        ]

    def untold(self, left: Left) -> list[Term]:
        """What does not compete, for one motion does not tell it, but may look like another."""
        forms = rigid_forms(self.machine.linear).values()
        return [
            form.term(self.along, *one) for form in forms for one in form.untold(self.along, left)
        ]

    def twins(self, one: Term, left: Left) -> list[Term]:
        """What an effect looks like where speed, or effort, hardly varies."""
        found = []
        for form in (RIGID[name] for name in RIGID[one.effect].twins):
            shape = form.like(self.along, left, one) if form.like is not None else (0.0,)
            if shape[0]:
                found.append(form.term(self.along, *shape))
        return found


def bare_beside(chosen: Sequence[Term], others: Sequence[Term]) -> list[Term]:
    """Terms as they act beside a set: without a mean of their own if one of it holds a constant
    load, for both would be one."""
    holds = any("constant_load" in one.holds for one in chosen)
    return [one.bare if holds and one.bare is not None else one for one in others]


def one_mean(terms: Sequence[Term]) -> list[Term]:
    """The same of a set beside itself."""
    return bare_beside(terms, terms)


def free_means(terms: Sequence[Term]) -> bool:
    """Whether one of the terms has a free mean."""
    return any(one.mean for one in terms)
