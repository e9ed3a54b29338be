"""What a noise floor hides: a model can be no truer than the recording of a healthy machine shows.

Constants that are off by so little that the nominal replay stays at its floor do not show. Where an
effect brings a loop to the edge of stability, or makes the load rattle in its clearance, the same
differences grow to many floors: what they leave then is no evidence against the effect, nor for a
further one.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cached_property

import numpy as np

from ...arrays import FloatArray
from ...drive.tolerances import constants_of
from .replay import Constants, Effects, Replay

# Times its floor that a signal may stand at where the nominal model has no gap.
NO_GAP_RATIO = 1.15
_HIDDEN = math.sqrt(NO_GAP_RATIO**2 - 1.0)  # RMS in floors that adds up to this with the noise
_PROBE = 1e-3  # relative, of each constant, small enough to act in proportion
_MOST = 0.05  # relative: what the motion does not show may be off, but not by any size
_DRAWS = 4
_SEED = 0x41DD


class Hidden:
    """Machines that differ from the nominal one by what its replay does not show."""

    def __init__(self, replay: Replay) -> None:
        self._replay = replay
        nominal = constants_of(replay.nominal)
        self._nominal = {key: value for key, value in nominal.items() if value > 0.0}

    def _made(self, off: Mapping[str, float], constants: Constants) -> dict[str, float]:
        """Constants, each off by a share."""
        base = {**self._nominal, **constants}
        return {**constants, **{key: base[key] * (1.0 + share) for key, share in off.items()}}

    @cached_property
    def _nominal_gap(self) -> FloatArray:
        return self._replay.gap({})

    def _shown(self, effects: Effects, off: Mapping[str, float]) -> float:
        """RMS in floors of the signal that shows most of effects and constants off by shares."""
        moved = self._replay.gap(effects, self._made(off, {})) - self._nominal_gap
        return float(np.sqrt(np.mean(moved[:, self._replay.usable] ** 2, axis=1)).max())

    def small(self, effects: Effects) -> bool:
        """Whether effects alone would stay below the noise of every signal."""
        return self._shown(effects, {}) < 1.0

    @cached_property
    def _draws(self) -> tuple[dict[str, float], ...]:
        """Shares that the constants of healthy machines are off by, together just hidden."""
        sizes = {}
        for key in self._nominal:
            shown = self._shown({}, {key: _PROBE})
            sizes[key] = min(_PROBE * _HIDDEN / shown, _MOST) if shown > 0.0 else 0.0
        rng = np.random.default_rng(_SEED)
        found = []
        for _ in range(_DRAWS):
            signs = rng.choice([-1.0, 1.0], len(sizes)) / math.sqrt(len(sizes))
            off = {key: size * sign for (key, size), sign in zip(sizes.items(), signs, strict=True)}
            shown = self._shown({}, off)
            least = min(_HIDDEN / shown, 1.0) if shown > 0.0 else 0.0
            found.append({key: share * least for key, share in off.items()})
        return tuple(found)

    def left_with(self, effects: Effects, constants: Constants) -> FloatArray:
        """What the model with `effects` leaves of each such machine that has them.

        float64[draws, signals, n], in floors, without noise.
        """
        replay = self._replay
        gap = replay.gap(effects, constants)
        return np.array(
            [gap - replay.gap(effects, self._made(off, constants)) for off in self._draws]
        )
