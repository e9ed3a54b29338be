"""Two causes of torque at once: each where the recording's own balance of torque puts it.

A spring and a load that cancel each other over the way, or friction that a viscous one hides, are
each of another size alone than together, so that neither is found upon a fit of the other. But the
torque that a replay leaves unexplained is measured, whatever the replay is worth: a regression puts
the first effect in it beside a constant or a direction, and what is then left puts the second.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence

from ...effects.catalogue import CATALOGUE
from ...effects.effect import Evidence
from ..fit.coordinate import is_phase
from ..fit.fit import Fit, Fitter, Values
from ..replay.evidence import gather
from ..side_by_side import side_by_side
from .begin import possible

_BLOCKS = ("motor_mechanical", "load")  # whose effects are torques on rotor or load


def chained(fitter: Fitter, base: Fit, names: Sequence[str]) -> list[Fit]:
    """Sets of two effects of torque upon `base`, each where it starts, best first.

    Args:
        base: the sheet alone.
        names: effects that compete.
    """
    replay = fitter.replay.at(fitter.sheet.constants(base.pulls))
    evidence = gather(replay, base.values)
    torques = [one for one in names if _plain_torque(one, names)]
    jobs: list[Values] = []
    for first in torques:
        begun = _start(first, evidence)
        if not begun:
            continue
        left = gather(replay, {**base.values, **begun})
        for second in torques:
            if second != first:
                following = _start(second, left)
                jobs += [{**base.values, **begun, **following}] if following else []
    best: dict[frozenset[str], Fit] = {}
    for one in side_by_side(functools.partial(fitter.evaluate, pulls=base.pulls), jobs):
        key = frozenset(one.names)
        if key not in best or one.fitted < best[key].fitted:
            best[key] = one
    return sorted(best.values(), key=lambda one: one.fitted)


def _plain_torque(name: str, names: Sequence[str]) -> bool:
    """Whether an effect is a torque that a regression finds: no wave, no finer form of others."""
    effect = CATALOGUE[name]
    waves = any(is_phase(one.name) for one in effect.parameters)
    return effect.block in _BLOCKS and not waves and not set(effect.refines) & set(names)


def _start(name: str, evidence: Evidence) -> Values:
    """The first start of an effect, empty where there is none that is possible."""
    for start in CATALOGUE[name].starts(evidence)[:1]:
        if possible(name, start):
            return {name: dict(start)}
    return {}
