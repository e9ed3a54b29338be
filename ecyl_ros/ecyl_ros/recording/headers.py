"""The unit that a column's header tells: in brackets, in a line of units, at a name's end."""

from __future__ import annotations

import re
from collections.abc import Collection

from .units import dimension_of, plain

_BRACKETED = re.compile(r"[\[(]\s*([^\[\]()]*[^\W\d][^\[\]()]*|[°%])\s*[\])]\s*$")
_SPOKEN = re.compile(r"\s+in\s+(\S+)\s*$", re.IGNORECASE)  # `Angle in deg`
_IN = re.compile(r"^in\s+(?=\S)", re.IGNORECASE)  # `(in mm)`
_SUFFIX = re.compile(r"_([A-Za-z]+(?:_per_[A-Za-z]+)?)$")
_RATE = re.compile(r"_([A-Za-z]+)_s$")  # `speed_mm_s`
_CASED = {"ma": "mA", "mv": "mV", "nm": "N m", "kn": "kN", "n": "N", "a": "A", "v": "V"}
# What stands in round brackets but is no unit.
_REMARKS = {
    *("actual", "measured", "filtered", "raw", "ref", "reference", "target", "set", "setpoint"),
    *("cmd", "command", "commanded", "demand", "desired", "left", "right", "motor", "rod", "rotor"),
    *("x", "y", "z", "q", "d"),
}


def bare(name: str) -> str:
    """The name without what it says of its unit at its end."""
    found = _BRACKETED.search(name) or _spoken(name)
    return name[: found.start()].rstrip() if found else name


def told(name: str, line: str = "") -> str:
    """The word for a unit that a header tells outright; empty for none.

    name: of the column; line: what the file's line of units says of it.
    """
    if line.strip("[]() "):
        return line.strip("[]() ")
    found = _BRACKETED.search(name)
    if found is None:
        spoken = _spoken(name)
        return spoken[1] if spoken else ""
    word = _IN.sub("", found[1].strip())
    in_round = name.rstrip().endswith(")")
    return "" if in_round and word.lower() in _REMARKS else word


def _spoken(name: str) -> re.Match[str] | None:
    """The end of a name that says in what it is, where that is a unit."""
    found = _SPOKEN.search(name)
    return found if found and dimension_of(plain(found[1])) is not None else None


def unit_of(word: str, dimensions: Collection[str] = ()) -> str:
    """The unit that a header's word means: `nm` of a torque is N m, of a length nm.

    dimensions: what the column may measure; a word that fits none of them keeps its own meaning.
    """
    unit = plain(word)
    if not dimensions or dimension_of(unit) in dimensions:
        return unit
    other = plain(_CASED.get(word.strip().lower(), unit))
    return other if dimension_of(other) in dimensions else unit


def ending(name: str, dimensions: Collection[str] = ()) -> str:
    """The unit that a name ends with, `target_mm`; empty where it is none that is known.

    dimensions: what it may measure; `torque_nm` is in N m, `stroke_nm` in nm, and so is what may
    measure either, `command_nm`, in N m: drives are not moved by nanometres. All by default.
    """
    found = _SUFFIX.search(name)
    if found is None:
        return ""
    word, rate = found[1].replace("_per_", "/"), _RATE.search(name)
    if rate is not None and dimension_of(plain(f"{rate[1]}/s")) is not None:
        word = f"{rate[1]}/s"
    for spelling in (_CASED.get(word.lower(), word), word, word.lower()):
        unit = plain(spelling)
        dimension = dimension_of(unit)
        if dimension is not None and (not dimensions or dimension in dimensions):
            return unit
    return ""
