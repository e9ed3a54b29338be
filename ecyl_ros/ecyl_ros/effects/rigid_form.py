"""What an effect is in a drive of one inertia: a module that defines `RIGID` has such a form.

It acts as another value of the model's constants (`modify`), or beside them by a kernel that the
module defines under the name of its port (see `rigid_ports`). Along a measured motion it is a term
of a regression: the same law as columns.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..arrays import FloatArray
from ..drive.rigid.model import Model
from .along import Along
from .term import Fitted, Left, Term, plain

HUGE = 1e9
# Kinds of a value that count effort: names in a file tell its unit.
EFFORT_KINDS = ("level", "load", "per_speed", "per_position", "inertia")


class Stem(NamedTuple):
    """A value of an effect in the file of a rigid drive, whatever effort is counted in.

    name: inside; in a file, kind and units add what it counts (`drive.rigid.effects_file`). low,
    high: possible. meaning: in the docs. default: where a file may leave it out. either: of those
    of an effect that have it, a file gives one.
    """

    name: str
    kind: str
    low: float
    high: float
    meaning: str
    default: float | None = None
    either: bool = False


def level(name: str, meaning: str) -> Stem:
    """An effort."""
    return Stem(name, "level", -HUGE, HUGE, meaning)


def per_speed(name: str, meaning: str) -> Stem:
    """An effort per speed."""
    return Stem(name, "per_speed", -HUGE, HUGE, meaning)


Values = Mapping[str, float]
Shape = tuple[Any, ...]  # of a term: what it takes beside the motion (an order, a Stribeck speed)


def added(old: Values, new: Values, along: Along) -> Values | None:
    """Two of an effect are one of their sums."""
    return {name: old.get(name, 0.0) + value for name, value in new.items()}


@dataclass(frozen=True, kw_only=True)
class RigidForm:
    """An effect of a rigid drive.

    Attributes:
        outputs: of drives that have it.
        stems: its values.
        term: what it asks along a motion, of a shape. tried: shapes to try beside what a set of
            terms leaves.
        untold: shapes that do not compete, for this motion does not tell them from simpler effects,
            but that may look like the term of another.
        modify: the model with an effect of these values.
        coefficients: or else those of its term; shape: of that, beside an effort of float64[n].
        of_effort: what is asked for is in proportion to the whole effort, itself included.
        packed: what its kernel takes; the values in the order of the stems unless given.
        ratio: effort by the file's gain over effort by that of these values; gain.
        several: may act more than once, of several orders or frequencies.
        like: shape in which it comes closest to another's term; 0 first where it cannot.
        twins: effects that it may look like where speed, or effort, hardly varies.
        gives_way: simpler sets in the place of its term; with a constant, unless others hold one.
        constant: keys (linear, rotary) of the constant that it gives another value. on_top: its
            parameter is what comes on top of the nominal value, not the value.
        void: why a fit of it is no cause; empty where nothing speaks against it.
        merged: values of one effect from those of the file (empty: none) and those found beyond
            them; None where both stand beside each other.
    """

    outputs: tuple[str, ...] = ("linear", "rotary")
    stems: tuple[Stem, ...]
    term: Callable[..., Term]
    tried: Callable[[Along, Left], Sequence[Shape]] = lambda along, left: [()]
    untold: Callable[[Along, Left], Sequence[Shape]] = lambda along, left: ()
    modify: Callable[[Model, Values], Model] | None = None
    coefficients: Callable[[Values], Sequence[float]] | None = None
    shape: Callable[[Along, Values, FloatArray], Shape] = lambda along, values, effort: ()
    of_effort: bool = False
    packed: Callable[[Values, Model], Sequence[float]] | None = None
    ratio: Callable[[Values, float], float] | None = None
    several: bool = False
    like: Callable[[Along, Left, Term], Shape] | None = None
    twins: tuple[str, ...] = ()
    gives_way: Callable[[Along, bool], Sequence[Sequence[Term]]] | None = None
    constant: tuple[str, str] = ("", "")
    on_top: bool = False
    void: Callable[[Fitted], str] = plain
    merged: Callable[[Values, Values, Along], Values | None] = lambda old, new, along: None

    def asked(self, along: Along, values: Values, effort: FloatArray) -> FloatArray:
        """What these values ask for along a motion beside an effort, both float64[n]."""
        assert self.coefficients is not None
        columns = self.term(along, *self.shape(along, values, effort)).columns
        made: FloatArray = np.array(self.coefficients(values)) @ columns
        return made
