"""Sizes of its own in each recording: what wears, warms or is loaded otherwise between them."""

from __future__ import annotations

from collections.abc import Sequence

from ...effects.catalogue import CATALOGUE
from ..compete.earn import at_noise, earns
from ..cylinder import Judged
from ..fit.fit import Fit, Fitter
from ..fit.stages import FINE, MEDIUM
from .alone import STEPS, Alone, joined
from .of_recording import OwnValue

_SINGLES = 3  # effects alone that may differ, of the closest
_SMALLEST = 0.05  # of a size over another, so that factors mean something


def own_sizes(found: Judged, alone: Alone) -> dict[str, list[float]]:
    """Sizes over that of the last recording, of what has to have another one in each.

    The intervals lie beside one another, and sizes of their own earn their place as an effect
    does: on stretches that no fit saw. Where no set comes to the floor with common sizes, one
    effect alone with sizes of its own may.
    """
    closest = found.closest
    tried = [closest] if not found.no_gap else []
    if tried and not at_noise(found.fitter, closest):
        tried += [one for one in found.competition.singles[:_SINGLES] if one.names]
    best, sizes = closest, dict[str, list[float]]()
    for fit in tried:
        own, after = _with_own_sizes(found, fit, alone)
        if own and after.judged < best.judged:
            best, sizes = after, own
            if at_noise(found.fitter, after):
                break
    return sizes


def _with_own_sizes(found: Judged, fit: Fit, alone: Alone) -> tuple[dict[str, list[float]], Fit]:
    """Sizes of its own of what differs in a set of effects, where they earn their place."""
    values = alone.values(fit)
    taken: dict[str, list[float]] = {}
    for key in sorted({one.of for each in values for one in each if one.differs}):
        factors = _factors(key, found, values)
        if factors is None:
            continue
        replay = joined(found).with_own({**taken, key: factors})
        fitter = Fitter(replay, replay.held_out())
        after = fitter.evaluate(fit.values, fit.pulls)
        for stage in (MEDIUM, FINE):
            after = fitter.fit(after, steps=STEPS, stage=stage)
        if earns(fitter, after, fit):
            taken[key] = factors
            fit = after
    return taken, fit


def _factors(key: str, found: Judged, values: Sequence[Sequence[OwnValue]]) -> list[float] | None:
    """How large a cause or constant is in each recording, over the last; None without a size."""
    sizes = []
    for each in values:
        value = next((one.value for one in each if one.of == key), None)
        if value is None:
            return None
        sizes.append(value - _neutral(key, found))
    if key in CATALOGUE and CATALOGUE[key].sized == ():
        return None
    most = max(abs(one) for one in sizes)
    if abs(sizes[-1]) < _SMALLEST * most:
        return None
    return [one / sizes[-1] for one in sizes]


def _neutral(key: str, found: Judged) -> float:
    return CATALOGUE[key].neutral(found.fitter.replay.nominal) if key in CATALOGUE else 0.0
