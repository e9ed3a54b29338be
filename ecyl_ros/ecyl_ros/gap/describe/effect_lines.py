"""What the files of effects that play a learned law share: checks, and the law's table as code."""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np

from ...drive.law import Law, law_to_flat
from ...effects.catalogue import EFFECTS
from ...errors import InputError
from . import words

# Of a law's variables the one that has to be made of a kernel's arguments.
DIRECTION = "1.0 if speed > 0.0 else (-1.0 if speed < 0.0 else 0.0)"
_NAME = re.compile(r"[a-z][a-z0-9_]*")


def checked(law: Law, name: str, given: Mapping[str, str]) -> None:
    """Raises InputError where no effect of this name can play the law.

    given: variables that an effect at the law's port is given, and each as an expression.
    """
    if not _NAME.fullmatch(name):
        raise InputError(f"--name {name}: expected small letters, digits and _, a letter first")
    if name in EFFECTS or name == "learned":
        raise InputError(f"--name {name}: there is such an effect; expected a new name")
    for one in law.of:
        if one not in given:
            raise InputError(
                f"effects.learned.of = {one}: an effect at {law.port} is not given it; expected a "
                f"law of {', '.join(given)}"
            )


def opened(law: Law, name: str) -> list[str]:
    """The first lines of a file: its docstring, and what every file imports."""
    title = name.replace("_", " ").capitalize()
    return [f'"""{title}: {_said(law)}."""', "", "from __future__ import annotations", ""]


def described(law: Law, name: str) -> list[str]:
    """The fields of an `Effect` that the law and its name give; words to fill in among them."""
    said = _said(law)
    return [
        f'    name="{name}",',
        f'    block="{words.BLOCKS[law.port]}",',
        "    # FILL IN: what a drive engineer calls it, what it is, and what shows it.",
        f'    title="{name.replace("_", " ")}",',
        f'    summary="{said[:1].upper()}{said[1:]}.",',
        '    excitation="motion over what the law was learned on",',
    ]


def sized(law: Law) -> float:
    """The law's largest value, or 1 where it is 0 throughout."""
    return float(np.max(np.abs(law.values))) or 1.0


def constants(law: Law) -> list[str]:
    """The law's table over its largest value, as constants of a file."""
    lines = ["# As it was learned; its largest value is 1."]
    lines += [
        f"_AXIS_{k} = segments({_numbers(one)}, {period!r})"
        for k, (one, period) in enumerate(zip(law.at, law.periods, strict=True), 1)
    ]
    return [*lines, f"_SHAPE = np.array({_numbers(np.array(law.values) / sized(law))})"]


def looked_up(law: Law, given: Mapping[str, str]) -> list[str]:
    """Statements that leave the table's value in `value`."""
    if not law.of:
        return ["    value = _SHAPE[0]"]
    body = []
    for number, (one, places, period) in enumerate(
        zip(law.of, law.at, law.periods, strict=True), 1
    ):
        body.append(f"    x = {given[one]}")
        body.append(f"    at_{number} = places(_AXIS_{number}, {len(places)}, {period!r}, x)")
    if len(law.of) == 1:
        terms = [f"at_1[{k + 4}] * _SHAPE[at_1[{k}]]" for k in range(4)]
    else:
        width = len(law.at[1])
        terms = [
            f"at_1[{j + 4}] * at_2[{k + 4}] * _SHAPE[at_1[{j}] * {width} + at_2[{k}]]"
            for j in range(4)
            for k in range(4)
        ]
    return [*body, f"    value = {terms[0]}", *(f"    value += {one}" for one in terms[1:])]


def tested(law: Law) -> str:
    """The law as a test holds it: a mapping named LAW."""
    entries = ",\n    ".join(f'"{key}": {_entry(value)}' for key, value in law_to_flat(law).items())
    return f"LAW = {{\n    {entries},\n}}\n"


def _said(law: Law) -> str:
    return f"{words.place(law)} {words.depends(law)}"


def _numbers(values: object) -> str:
    """Numbers of a list, a few on each line."""
    texts = [f"{float(one):.9g}" for one in np.asarray(values)]
    texts = [one if any(c in one for c in ".en") else f"{one}.0" for one in texts]
    if len(texts) <= 4:
        return f"[{', '.join(texts)}]"
    rows = [", ".join(texts[k : k + 6]) for k in range(0, len(texts), 6)]
    return "[\n    " + ",\n    ".join(rows) + ",\n]"


def _entry(value: object) -> str:
    if isinstance(value, list) and value and isinstance(value[0], float):
        rows = [", ".join(repr(v) for v in value[k : k + 4]) for k in range(0, len(value), 4)]
        return "[\n        " + ",\n        ".join(rows) + ",\n    ]"
    return repr(value).replace("'", '"')
