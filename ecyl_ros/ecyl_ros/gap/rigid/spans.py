"""95 % intervals of what was fitted to a balance, noise of the motion included."""

from __future__ import annotations

import numpy as np

from .balance import Balance, Interval, Solution, beside
from .noise import acceleration_noise


def spans(balance: Balance, solution: Solution) -> dict[str, list[Interval]]:
    """Intervals of the parameters of each term, by its key, from all usable rows.

    Noise in a column makes its coefficient too small (attenuation): by the share that the noise has
    of what the column holds beside the others. The acceleration is differentiated twice, so that
    an inertia is open upwards by as much.
    """
    found = balance.intervals(solution, balance.usable)
    at = 0
    for term in solution.terms:
        if term.key == "inertia":
            first, *rest = found[term.key]
            up = abs(first.value) * _attenuation(balance, solution, at)
            found[term.key] = [first._replace(high=first.high + up), *rest]
        at += term.columns.shape[0]
    return found


def _attenuation(balance: Balance, solution: Solution, at: int) -> float:
    """By how much of its fitted value a coefficient may be too small, 1 at the most.

    at: of the acceleration among the columns.
    """
    columns = balance.columns(solution.terms)[balance.usable]
    rest = beside(columns[:, at], np.delete(columns, at, axis=1))
    both, noise = float(np.mean(rest**2)), acceleration_noise(balance.motion, counted=True) ** 2
    return noise / max(both - noise, noise, 1e-300)
