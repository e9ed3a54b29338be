"""Whether an axis turns or travels: told by all its signals together, for those that leave it open.

A position and a speed of one axis are both of an angle or both of a length, and its effort is then
a torque or a force; so what one signal's name or unit tells holds for the others.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from .candidates import Candidate, counted, quantity_of, unit_told
from .headers import bare
from .names import ASKED, FORCE, JOINT, NO_SIGNAL, ROD, ROTOR, TORQUE, TURNS, words
from .units import dimension_of

_FAR = 3.0  # rad or m: a turn counter runs further, a rod and its speed seldom do
_TURNING, _TRAVELLING = ("angle", "angular speed"), ("length", "speed")


@dataclass(frozen=True)
class Axis:
    """What an axis does.

    Attributes:
        turns: whether its output is an angle; else it is a length.
        because: what tells, to follow "for"; empty where nothing does.
        sure: whether that is more than how far it moves.
        pushes: whether an effort of which nothing else is known is a force.
    """

    turns: bool
    because: str = ""
    sure: bool = True
    pushes: bool = False

    def body(self, one: Candidate) -> str:
        """Whether a measured motion is the rotor's or the rod's."""
        said = _said(one)
        return "rotor" if said or (said is None and self.turns) else "rod"


def open_to_doubt(one: Candidate) -> bool:
    """Whether neither name nor unit says of a motion that it turns or travels."""
    return _said(one) is None


def _said(one: Candidate) -> bool | None:
    """Whether its own unit or name says that it turns, or (False) that it travels."""
    dimension = dimension_of(unit_told(one))
    if dimension in _TRAVELLING:
        return False
    if dimension in _TURNING or one.words & ROTOR:
        return True
    if one.words & ROD:
        return False
    return True if words(bare(one.field.path)) & TURNS else None


def axis_of(candidates: Sequence[Candidate]) -> Axis:
    """What the fields of one axis say together."""
    known = [one for one in candidates if not one.words & NO_SIGNAL]
    motions = [one for one in known if _moves(one)]
    # Of a rotor alone nothing follows for the output, unless the rotor is all that was measured.
    outputs = [one for one in motions if not one.words & ROTOR]
    own = [one for one in outputs if not one.words & ASKED] or outputs
    told = {said: one for one in (outputs or motions)[::-1] if (said := _said(one)) is not None}
    if not own and motions:
        return Axis(True, "the motor's motion is all that was measured")
    if len(told) == 1:
        (turns, one), *_ = told.items()
        unit = unit_told(one)
        kind = "what turns" if turns else "what travels"
        because = f'"{one.path}" {f"is in {unit}" if unit else f"names {kind}"}'
        return Axis(turns, because, pushes=not turns and outputs == motions)
    if len(told) == 2:  # a cylinder's rotor and rod: what names neither is of the output
        return Axis(False, sure=False)
    efforts = {kind: one for one in known[::-1] if (kind := _effort(one))}
    if len(efforts) == 1:
        (kind, one), *_ = efforts.items()
        unit = unit_told(one)
        because = f'"{one.path}" {f"is in {unit}" if unit else f"names a {kind}"}'
        return Axis(kind == "torque", because)
    joint = next((one for one in own if one.words & JOINT), None)
    if joint is not None:
        return Axis(True, f'"{joint.joint or joint.path}" names a joint')
    far = next((one for one in own if one.far > _FAR and not counted(one)), None)
    because = f"none of its motions goes beyond {_FAR:g}"
    if far is not None:
        because = f'"{far.path}" goes beyond {_FAR:g}'
    return Axis(far is not None, because, sure=False)


def _moves(one: Candidate) -> bool:
    said = quantity_of(one)
    if said is None:
        return dimension_of(unit_told(one)) in (*_TURNING, *_TRAVELLING)
    return said in ("position", "velocity")


def _effort(one: Candidate) -> str:
    """Whether an effort is a torque or a force by its unit or name; empty where neither tells."""
    dimension = dimension_of(unit_told(one))
    if dimension in ("torque", "force"):
        return dimension
    if dimension is not None or quantity_of(one) != "effort":
        return ""
    if one.words & TORQUE:
        return "torque"
    return "force" if one.words & FORCE else ""
