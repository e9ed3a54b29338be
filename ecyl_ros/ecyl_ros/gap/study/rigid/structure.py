"""Effort that no model knows: what is left of every real machine, beside its fault.

It repeats with the motion, as rails, cable chains and bristles make it, or wanders by itself. Drawn
along the way that the drive is asked to go, which it keeps to but for a share of its travel.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ....arrays import FloatArray
from .drawn import Drawn
from .motion import LOOP_HZ

SMALLEST, LARGEST = 0.05, 0.5  # RMS over the level of the fault
_WAVES = 6  # that a course along the travel is made of
_TURNS = 0.01  # of the top speed: over so much a direction changes
_WANDERS_HZ = (0.05, 0.5)

# By draws, place (0 to 1 over the travel) and speed, float64[n] each: the effort's course.
Along = Callable[[np.random.Generator, FloatArray, FloatArray], FloatArray]


def with_structure(drawn: Drawn, seed: int) -> tuple[Drawn, dict[str, float | str]]:
    """The drive with it, counted with what another axis pulls, and its facts for the label.

    seed: of the case; what it draws is the same in all recordings of the drive.
    """
    rng = np.random.default_rng([seed, 10])
    form = list(FORMS)[int(rng.integers(len(FORMS)))]
    share = float(np.exp(rng.uniform(math.log(SMALLEST), math.log(LARGEST))))
    # Of the drive, not of the recording: the same place in all recordings of it.
    place = 0.5 + (drawn.reference - drawn.size.middle) / drawn.size.reach
    made = FORMS[form](rng, place, np.gradient(drawn.reference, 1.0 / LOOP_HZ))
    made = made * (share * drawn.size.level / float(np.sqrt(np.mean(made**2))))
    facts: dict[str, float | str] = {"structure": form, "structure_over_fault": share}
    return replace(drawn, coupling=drawn.coupling + made), facts


def _course(rng: np.random.Generator, place: FloatArray, least: float, most: float) -> FloatArray:
    """Smooth, of waves from `least` to `most` a travel that are no multiples of each other."""
    numbers = np.exp(rng.uniform(math.log(least), math.log(most), _WAVES))
    phases = rng.uniform(0.0, math.tau, _WAVES)
    waves = np.cos(math.tau * numbers[:, None] * place + phases[:, None])
    made: FloatArray = (rng.normal(size=_WAVES) / np.sqrt(numbers)) @ waves
    return made


def _direction(speed: FloatArray) -> FloatArray:
    made: FloatArray = np.tanh(speed / (_TURNS * np.max(np.abs(speed))))
    return made


def _rail(rng: np.random.Generator, place: FloatArray, speed: FloatArray) -> FloatArray:
    """Friction that differs from place to place."""
    made = _course(rng, place, 0.7, 8.0)
    return (made - made.mean()) * _direction(speed)


def _chain(rng: np.random.Generator, place: FloatArray, speed: FloatArray) -> FloatArray:
    """A force of the place."""
    made = _course(rng, place, 1.2, 10.0)
    return made - made.mean()


def _settling(rng: np.random.Generator, place: FloatArray, speed: FloatArray) -> FloatArray:
    """Friction that settles over a way after each reversal."""
    reach = float(rng.uniform(0.03, 0.15))
    way, last = np.zeros(place.size), 0.0
    direction = np.sign(speed)
    for tick in range(1, place.size):
        turned = direction[tick] * direction[tick - 1] < 0.0
        last = 0.0 if turned else last + abs(place[tick] - place[tick - 1])
        way[tick] = last
    made: FloatArray = np.exp(-way / reach) * _direction(speed)
    return made


def _curved(rng: np.random.Generator, place: FloatArray, speed: FloatArray) -> FloatArray:
    """Friction over speed that is neither level nor line: what is left of a power of it."""
    share = np.abs(speed) / np.max(np.abs(speed))
    power = share ** float(rng.choice([0.4, 2.0, 3.0]))
    line = np.column_stack([np.ones(share.size), share])
    moving = share > _TURNS
    left = power - line @ np.linalg.lstsq(line[moving], power[moving], rcond=None)[0]
    made: FloatArray = left * moving * _direction(speed)
    return made


def _wander(rng: np.random.Generator, place: FloatArray, speed: FloatArray) -> FloatArray:
    """Friction that rises and falls with time, as grease does."""
    time = np.arange(place.size) / LOOP_HZ
    rates = math.tau * rng.uniform(*_WANDERS_HZ, _WAVES)
    course = np.cos(rates[:, None] * time + rng.uniform(0.0, math.tau, (_WAVES, 1))).sum(axis=0)
    made: FloatArray = course * _direction(speed)
    return made


FORMS: dict[str, Along] = {
    "rail": _rail,
    "chain": _chain,
    "settling": _settling,
    "curved": _curved,
    "wander": _wander,
}
