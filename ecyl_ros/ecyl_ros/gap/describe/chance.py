"""Whether a law predicts by chance: the search again on data whose signs are drawn.

What the sheet alone leaves is taken stretch by stretch, each with a sign of its own (fair coins).
That keeps how it runs within a stretch and what the machine did there, and takes away whatever
holds from stretch to stretch. As many sets of variables as before compete on it; the share of draws
in which the best of them predicts as large a part of it as the law does is the probability of
finding such a law where there is none.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .choose import Balance, Guess
from .regress import SMOOTH, Normal, folds_of

LEVEL = 0.01  # of a law by chance, over all sets that were looked at
_DRAWS = 399


def probability(balance: Balance, guesses: Sequence[Guess]) -> float:
    """Of so good a prediction by the best of `guesses` where nothing holds between stretches."""
    data = balance.data
    left = data.target - balance.alone().pulls @ data.sheet
    blocks = int(data.block.max()) + 1
    signs = np.random.default_rng(blocks).choice([-1.0, 1.0], size=(blocks, _DRAWS))
    signs = np.concatenate([np.ones((blocks, 1)), signs], axis=1)
    whole = float(data.weight @ left**2)
    best = np.full(_DRAWS + 1, np.inf)
    for guess in guesses:
        law, rough = balance.design(guess)
        normal = Normal(data, law, rough)
        squares = data.weight * left**2
        normal.square = np.bincount(data.block, weights=squares, minlength=blocks).astype(float)
        slope = np.zeros((blocks, len(normal.rough), _DRAWS + 1))
        design = np.concatenate([law, data.sheet])
        for block in range(blocks):
            chosen = data.block == block
            slope[block] = np.outer(design[:, chosen] @ (data.weight * left)[chosen], signs[block])
        for smooth in {guess.found.smooth, float(SMOOTH[4])}:
            errors = normal.predict(smooth, max(guess.found.error, 1.0), folds_of(data), slope)
            best = np.minimum(best, errors.sum(axis=0) / whole)
    return float(np.mean(best <= best[0] * (1.0 + 1e-12)))
