"""A candidate for what a rigid model leaves of the effort: an effect as columns along the motion.

    effort = M a + F_v v + F_c s(v) + c + k q + ...

with s(v) the sign of the speed, softened over what its noise leaves unsure. Parameters of an effect
follow from its coefficients; they are named as in the catalogue, with the unit of the output: `_nm`
where it turns, `_n` where it moves straight, `_a` or `_v` where the gain from the recorded signal
to effort is unknown.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ..arrays import FloatArray
from .along import Along

# A parameter: name, unit, value.
Parameters = tuple[tuple[str, str, float], ...]

_AT_BOUND = 1e-6  # of a term's largest coefficient: so near, it is the bound


class Interval(NamedTuple):
    """A parameter with its 95 % interval."""

    name: str
    unit: str
    value: float
    low: float
    high: float

    def over(self, other: Interval) -> Interval:
        """Wide enough to hold that of another model, too."""
        return self._replace(low=min(self.low, other.low), high=max(self.high, other.high))


@dataclass(frozen=True, eq=False, kw_only=True)
class Term:
    """A candidate.

    Attributes:
        effect: its name. key: of this very form of it (an order, a Stribeck speed).
        columns: float64[k, n] on the grid of the motion.
        parameters: from its coefficients. values: the same by stem, phases and rest positions
            included; of inertia and gain what comes on top.
        low: least value of each coefficient; -inf where it may have any. high: the largest, where
            there is one.
        refines: effects that it contains. holds: others that it can take the place of.
        alternatives: effects that give the same columns in a rigid drive. bent_by: effects that
            bend its values but cannot make it.
        mean: whether it has a free mean. bare: the same without one, beside a term that `holds` a
            constant load.
        least: first coefficient that says anything; up to it, it is of how recordings come about.
        fixed: parameters that were searched, not fitted. reach: by how much those of them that may
            have any value have to differ to be told apart. moved: the term with others in `fixed`.
        rate: of a sine, per rad of the turn (per m, in Hz over time). phase: float64[n] of it.
            over_time: whether it is one of time.
        of_effort: whether its coefficients are efforts, by the file's gain: in N or N m they are
            others by another gain.
        inertia: share of the acceleration in its first column.
        unsure: half width by which its first parameter is unsure whatever a fit says.
        sought: what its first parameter would be by another property of the effort than its size.
        carried: of its columns, float64[k, n], what is load that the machine carries: by inertia,
            constant load, spring or weight; None: nothing.
        follows: whether its columns follow what is explained so far. again: the same beside what
            its set explains, itself included, and from its coefficients so far, where it has to be
            followed on.
        common: of one whose coefficients are each recording's own (`apart`), the same with one
            value for all.
    """

    effect: str
    key: str
    columns: FloatArray
    parameters: Callable[[FloatArray], Parameters]
    values: Callable[[FloatArray], dict[str, float]]
    low: tuple[float, ...]
    high: tuple[float, ...] = ()
    refines: tuple[str, ...] = ()
    holds: tuple[str, ...] = ()
    alternatives: tuple[str, ...] = ()
    bent_by: tuple[str, ...] = ()
    mean: bool = False
    bare: Term | None = None
    least: float = -math.inf
    fixed: Mapping[str, float] = field(default_factory=dict)
    reach: Mapping[str, float] = field(default_factory=dict)
    moved: Callable[[Mapping[str, float]], Term] = lambda fixed: _unmoved()
    rate: float = 0.0
    phase: FloatArray = field(default_factory=lambda: np.zeros(0))
    over_time: bool = False
    of_effort: bool = True
    inertia: float = 0.0
    unsure: float = 0.0
    sought: float = 0.0
    carried: FloatArray | None = None
    follows: bool = False
    again: Callable[[Left, FloatArray], Term] | None = None
    common: Term | None = None

    @property
    def size(self) -> int:
        """How many coefficients, found ones (an order, a speed) included."""
        return self.columns.shape[0] + len(self.fixed)

    @property
    def contained(self) -> tuple[str, ...]:
        """Effects that it can take the place of."""
        return (*self.refines, *self.holds)


def _unmoved() -> Term:
    raise TypeError("no parameter of this term was searched")


@dataclass(frozen=True, eq=False)
class Left:
    """What a set of terms leaves of the effort, and what can be found in it.

    Attributes:
        explained: effort that the set and the nominal model explain, float64[n]. carried: of it
            the load that the machine carries.
        orders: strongest orders over the turn, per rad of it, best first; as shares of an effort,
            float64[n], where one is given.
        lines: Hz of the strongest lines over time that are not the motion's own, best first.
        window: middle and width of the part of the travel that drags most; width 0: none does.
        delay: s by which the effort is ahead of what explains it, at the least 0.
        nearest: order, or (over time) Hz, of the sine that comes closest to a periodic term; 0
            where none can.
    """

    explained: FloatArray
    carried: FloatArray
    orders: Callable[[FloatArray | None], Sequence[float]]
    lines: Callable[[], Sequence[float]]
    window: Callable[[], tuple[float, float]]
    delay: Callable[[], float]
    nearest: Callable[[Term, bool], float]


@dataclass(frozen=True, eq=False)
class Fitted:
    """A term as it was fitted.

    Attributes:
        values: its coefficients, float64[k]. spans: its parameters.
        half_width: 95 % half width of a combination of its coefficients, float64[k], as an interval
            has it.
        inflation: variance inflation of its first column by terms, in the set or not.
        beside: its parameters as they are with such terms free beside it.
    """

    along: Along
    term: Term
    values: FloatArray
    spans: Sequence[Interval]
    half_width: Callable[[FloatArray], float]
    inflation: Callable[[Sequence[Term]], float]
    beside: Callable[[Sequence[Term]], Sequence[Interval]]


# Why a fitted term is no cause; empty where nothing speaks against it.


def at_bound(fitted: Fitted) -> str:
    """A Coulomb level that a finer form brings with it may be 0; the surplus may not."""
    low = np.array(fitted.term.low)
    bounded = np.isfinite(low)
    values = fitted.values
    reach = _AT_BOUND * max(np.abs(values).max(), 1e-300)
    return "it is at its bound" if np.any(values[bounded] - low[bounded] <= reach) else ""


def holds_nothing(span: Interval) -> str:
    """Its interval holds 0."""
    if span.low <= 0.0 <= span.high:
        return f"its interval, {span.low:.3g} to {span.high:.3g} {span.unit}, holds 0"
    return ""


def holds_nominal(span: Interval, nominal: float) -> str:
    """Its interval holds the value of the file."""
    return "its interval holds the value of the file" if span.low <= nominal <= span.high else ""


def plain(fitted: Fitted) -> str:
    """Off its bounds, and its first parameter clear of 0."""
    return at_bound(fitted) or holds_nothing(fitted.spans[0])
