"""Whether several recordings may be of one machine: by their signals, and by what they show of it.

Friction wears and warms, a load may be another; what a machine is built of stays. Where two
recordings show values of such a constant that no one sheet can hold, they are of two machines.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from ...errors import InputError
from ...recording.map import in_map
from ...recording.signals import FOREIGN_SIGNALS, SIGNALS, Recording
from .of_recording import OwnValue


def check_signals(
    recordings: Sequence[Recording], sources: Sequence[str], wanted: Collection[str] | None = None
) -> None:
    """Raise InputError where a recording lacks a signal that another one has.

    wanted: signals that matter; all unless given.
    """
    names = [*SIGNALS, *FOREIGN_SIGNALS] if wanted is None else list(wanted)
    for name in names:
        having = [one.has(name) for one in recordings]
        if any(having) and not all(having):
            lacks, has = sources[having.index(False)], sources[having.index(True)]
            raise InputError(
                f"{lacks}: {in_map(name)} is missing, which {has} has; expected the same signals "
                "in all recordings of one machine"
            )


def check_different(recordings: Sequence[Recording], sources: Sequence[str]) -> None:
    """Raise InputError where two are copies: one would be held out of what the other tells."""
    for (one, first), (other, second) in combinations(enumerate(recordings), 2):
        if len(first) == len(second) and all(
            np.array_equal(getattr(first, name), getattr(second, name), equal_nan=True)
            for name in ("time_s", *SIGNALS, *FOREIGN_SIGNALS)
        ):
            raise InputError(
                f"{sources[one]} and {sources[other]} hold the same samples; expected different "
                "recordings of one machine"
            )


def check_one_machine(
    values: Sequence[Mapping[str, OwnValue]],
    tolerances: Mapping[str, float],
    sources: Sequence[str],
) -> None:
    """Raise InputError where two recordings show what one sheet cannot hold.

    values: by constant, of each recording. tolerances: half width of each constant's sheet. Two
    values within one sheet are no further apart than twice that; their intervals have to be, too.
    """
    for (one, first), (other, second) in combinations(enumerate(values), 2):
        for key, width in tolerances.items():
            if key not in first or key not in second:
                continue
            a, b = first[key], second[key]
            apart = max(a.low - b.high, b.low - a.high)
            if apart > 2.0 * width:
                raise InputError(
                    f"{sources[one]} and {sources[other]}: {key} is {a.value:.4g} in one and "
                    f"{b.value:.4g} {b.unit} in the other, further apart than one data sheet "
                    f"allows ({2.0 * width:.2g} {b.unit}); expected recordings of one machine, "
                    "whose parts move as one"
                )


def with_differences(values: Sequence[Sequence[OwnValue]]) -> list[list[OwnValue]]:
    """The values of each recording, marked where those of another one lie beside their interval."""
    by_name: dict[tuple[str, str], list[OwnValue]] = {}
    for one in (one for own in values for one in own):
        by_name.setdefault((one.of, one.name), []).append(one)
    return [
        [
            replace(one, differs=any(one.beside(other) for other in by_name[one.of, one.name]))
            for one in own
        ]
        for own in values
    ]


def marked_alone(
    values: Sequence[Sequence[OwnValue]], differing: Collection[str]
) -> list[list[OwnValue]]:
    """The values with marks on those of `differing` alone."""
    return [
        [replace(one, differs=one.differs and one.of in differing) for one in own] for own in values
    ]
