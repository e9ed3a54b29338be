"""What a recording lacks at a law's port, over the variables that the law is of."""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray
from .balance import driving
from .guess import Guess
from .missing import Missing
from .motion import Motion


def at_port(
    part: Missing, gain: float, pulls: FloatArray, port: str, guess: Guess, motion: Motion
) -> tuple[FloatArray, FloatArray]:
    """What acts at a port, and the points that a law of it is read from.

    Args:
        part: the balance. gain: what one unit at the port adds to it. pulls: float64[k], of the
            whole sheet.
        port: the law's. guess: its variables. motion: along which the balance is.

    Returns:
        float64[n], positive where it drives; float64[variables + 1, m] at the rows of the balance,
        the law's variables and its value.
    """
    values = (part.values - pulls[list(part.pulled)] @ part.columns) / gain
    if port == "rotor_angle_error":  # shows in rod against rotor the other way round
        values = -values
    level = values * driving(guess.kind, motion)
    every = [motion.variable(one, guess.on_load, guess.time_constant_s) for one in guess.of]
    return values, np.array([*every, level])[:, part.rows]
