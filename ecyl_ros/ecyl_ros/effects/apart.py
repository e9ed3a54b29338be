"""A term of several recordings whose coefficients are each recording's own."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from ..arrays import FloatArray
from .term import Left, Parameters, Term

_KEY = "of each"  # what the keys of such terms end with


def apart(term: Term, parts: Sequence[slice], *, by_size: bool = False) -> Term:
    """A term with coefficients of its own for each recording; itself where there is but one.

    What it tells is of the last recording: the machine as it is now. by_size: the root of its mean
    square over all, for a sine whose phase is another in each; no phase is told then.

    parts: samples of each recording.
    """
    count = term.columns.shape[0]
    if len(parts) == 1 or term.key.endswith(_KEY):
        return term

    def split(columns: FloatArray) -> FloatArray:
        made = np.zeros((len(parts) * count, columns.shape[1]))
        for number, part in enumerate(parts):
            made[number * count : (number + 1) * count, part] = columns[:, part]
        return made

    def told(values: FloatArray) -> FloatArray:
        if by_size:
            size = np.sqrt(np.sum(np.square(values)) / len(parts))
            return np.concatenate([[size], np.zeros(count - 1)])
        return values[-count:]

    def parameters(values: FloatArray) -> Parameters:
        return term.parameters(told(values))

    def by_stem(values: FloatArray) -> dict[str, float]:
        return term.values(told(values))

    again: Callable[[Left, FloatArray], Term] | None = None
    follow = term.again
    if follow is not None:

        def again(left: Left, values: FloatArray) -> Term:
            return apart(follow(left, told(values)), parts, by_size=by_size)

    return replace(
        term,
        key=f"{term.key} {_KEY}",
        columns=split(term.columns),
        parameters=parameters,
        values=by_stem,
        low=term.low * len(parts),
        high=term.high * len(parts),
        carried=None if term.carried is None else split(term.carried),
        again=again,
        bare=None if term.bare is None else apart(term.bare, parts, by_size=by_size),
        moved=lambda fixed: apart(term.moved(fixed), parts, by_size=by_size),
        common=term,
    )
