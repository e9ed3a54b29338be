"""The fields of a recording by what their names, units and types say: what could be a signal."""

from __future__ import annotations

import dataclasses
import re
from dataclasses import dataclass

from .headers import bare, ending, told, unit_of
from .names import COUNTED, NUMBERED, PARTS, QUANTITY, ordered
from .names import words as words_of
from .survey import FieldSurvey, TopicSurvey
from .units import UNITS, dimension_of, plain

_DIMENSIONS = {
    "position": ("length", "angle"),
    "velocity": ("speed", "angular speed"),
    "effort": ("torque", "force", "current", "voltage"),
    "current_q": ("current",),
    "current_d": ("current",),
    "voltage_q": ("voltage",),
    "voltage_d": ("voltage",),
}
_UNITS = tuple(one for one in UNITS if one not in ("time", "number", "counts", "counts per second"))
_MANY = 200.0  # of whole numbers without a unit: no drive turns or travels that many rad or m


@dataclass(frozen=True)
class Candidate:
    """One field with the words of its name, its topic's and its joint's."""

    topic: TopicSurvey
    field: FieldSurvey
    joint: str
    words: frozenset[str]
    numbered: bool = False  # the number in its name is a joint's

    @property
    def place(self) -> str:
        """Which of several joints it is of: its name, the part of a body, `elbow`, the index or
        the number; empty for none of them."""
        if self.joint:
            return self.joint
        parts = [word for word in ordered(bare(self.field.path)) if word in PARTS]
        found = re.search(r"\[(\d+)\]$", self.field.path)
        number = found[1] if found else ""
        if not number and (self.numbered or words_of(bare(self.field.path)) & NUMBERED):  # dq_1
            number = number_in(self.field.path)
        return " ".join([*parts, *([number] if number else [])])

    @property
    def path(self) -> str:
        """The field as a map writes it: by joint where it has one."""
        return re.sub(r"\[\d+\]$", "", self.field.path) if self.joint else self.field.path

    @property
    def far(self) -> float:
        """Its largest size."""
        return max(abs(self.field.low), abs(self.field.high))


def candidates_of(topic: TopicSurvey) -> list[Candidate]:
    """The fields of a topic that hold samples."""
    out = []
    for field in topic.fields:
        if not field.count:
            continue
        joint = _joint_of(topic, field.path)
        words = words_of(topic.name) | words_of(bare(field.path)) | words_of(joint)
        out.append(Candidate(topic, field, joint, frozenset(words)))
    return _numbered(out)


def number_in(path: str) -> str:
    """The number that a name ends with, whatever words follow it: `dq_1`, `tau2_meas`, `M 0 v`."""
    found = re.search(r"(?<=[A-Za-z_ ])(\d+)(?:[_ ][A-Za-z]+)*$", bare(path))
    return found[1] if found else ""


def _numbered(candidates: list[Candidate]) -> list[Candidate]:
    """Fields whose numbers are joints': names of two quantities that differ in the same numbers,
    `pos_meas1 pos_meas2 tau1 tau2`. Of one quantity alone they count readings, `pos1 pos2`."""
    seen: dict[str, set[str]] = {}
    for one in candidates:
        quantity, number = quantity_of(one), number_in(one.field.path)
        if quantity and number:
            seen.setdefault(quantity, set()).add(number)
    several = [numbers for numbers in seen.values() if len(numbers) > 1]
    if len(several) < 2 or len(joints := set.intersection(*several)) < 2:
        return candidates
    return [
        dataclasses.replace(one, numbered=True) if number_in(one.field.path) in joints else one
        for one in candidates
    ]


def _joint_of(topic: TopicSurvey, path: str) -> str:
    found = re.search(r"\[(\d+)\]$", path)
    if not found:
        return ""
    array = path[: found.start()]
    sizes = sum(
        1 for f in topic.fields if re.sub(r"\[\d+\]$", "", f.path) == array and f.path != array
    )
    for names in topic.names.values():
        # An array that never held a finite value has no fields; one with names has as many.
        if len(names) >= sizes and int(found[1]) < len(names):
            return names[int(found[1])]
    return ""


def told_of(one: Candidate) -> str:
    """The word for a unit that a line of units or a header's brackets hold; empty for none."""
    return told(re.sub(r"\[\d+\]$", "", one.field.path), one.field.unit)


def unit_told(one: Candidate) -> str:
    """The unit that a line of units or a name gives; empty for none that is known."""
    name = re.sub(r"\[\d+\]$", "", one.field.path)
    word = told_of(one)
    named = one.topic.name if name == "data" else name
    for dimensions in (_DIMENSIONS.get(quantity_of(one) or "", ()), _UNITS):
        unit = unit_of(word, dimensions) if word else ending(named, dimensions)
        if dimensions and dimension_of(unit) in dimensions:
            return unit
    return ""


def quantity_of(one: Candidate) -> str | None:
    """What a name speaks of; None where it says nothing of the kind."""
    # What stands last says most: `motor_position`, `reference.positions`, `/joint/torque` `data`.
    said = [*ordered(bare(one.field.path))[::-1], *ordered(bare(one.topic.name))[::-1]]
    return next((QUANTITY[word] for word in said if word in QUANTITY), None)


def counted(one: Candidate) -> bool:
    """Whether a field is in counts: its unit says so, its name, or that it is whole and large."""
    unit = plain(told_of(one)) if told_of(one) else ending(one.field.path)
    if dimension_of(unit) is not None:
        return (dimension_of(unit) or "").startswith("counts")
    if one.words & COUNTED:
        return True
    return one.field.whole and one.far >= _MANY and not in_si(one.topic.type)


def in_si(kind: str) -> bool:
    """Whether a message's type says what its numbers are, and so, by REP 103, their unit."""
    return "/msg/" in kind and not kind.startswith(("std_msgs/", "example_interfaces/"))
