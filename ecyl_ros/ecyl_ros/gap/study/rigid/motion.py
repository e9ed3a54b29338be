"""What rigid drives are asked to do: sines or moves, both ways or one, with or without rest."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from ....arrays import FloatArray

DURATION_S = 30.0
LOOP_HZ = 1000.0


def draw_reference(
    rng: np.random.Generator,
    reach: float,
    *,
    moves: bool,
    one_way: bool,
    rests: bool,
    seconds: float = DURATION_S,
) -> FloatArray:
    """float64[ticks] of position over `reach` in all, from rest.

    moves: from point to point instead of along sines. one_way: forwards alone. rests: it stands
    still for half of the time. seconds: that it lasts.
    """
    ticks = round(seconds * LOOP_HZ)
    time = np.arange(ticks) / LOOP_HZ
    if one_way:
        speed = _one_way(rng, time, moves)
    elif moves:
        speed = _there_and_back(rng, time)
    else:
        speed = _sines(rng, time)
    if rests:
        speed = _with_rests(rng, speed)
    position = np.cumsum(speed) / LOOP_HZ
    scaled: FloatArray = (position - position[0]) * (reach / float(np.ptp(position)))
    return scaled


def _sines(rng: np.random.Generator, time: FloatArray) -> FloatArray:
    """Speed of sines from 0.1 to 2 Hz that fade in."""
    frequencies = rng.uniform([0.1, 0.25, 0.5, 0.9, 1.4], [0.2, 0.45, 0.8, 1.3, 2.0])
    shares = np.array([1.0, 0.7, 0.35, 0.15, 0.08]) * rng.uniform(0.7, 1.3, 5)
    phases = rng.uniform(0.0, math.tau, 5)
    rates = math.tau * frequencies[:, None]
    waves = shares[:, None] * rates * np.cos(rates * time + phases[:, None])
    made: FloatArray = waves.sum(axis=0) * np.minimum(time / 0.5, 1.0) ** 2
    return made


def _bump(share: FloatArray) -> FloatArray:
    """Speed of a quintic move over its time, 0 outside."""
    inside = (share > 0.0) & (share < 1.0)
    made: FloatArray = np.where(inside, 30.0 * share**2 * (1.0 - share) ** 2, 0.0)
    return made


def _there_and_back(rng: np.random.Generator, time: FloatArray) -> FloatArray:
    """Moves about the middle, each of its own length and time."""
    speed, start, place = np.zeros_like(time), 0.2, 0.0
    while start < time[-1]:
        length = float(rng.uniform(0.4, 1.6))
        goal = float(rng.uniform(-1.0, 1.0))
        if abs(goal - place) < 0.3:
            goal = place - math.copysign(0.6, place)
        speed += (goal - place) / length * _bump((time - start) / length)
        place, start = goal, start + length + float(rng.uniform(0.02, 0.15))
    return speed


def _one_way(rng: np.random.Generator, time: FloatArray, moves: bool) -> FloatArray:
    """Forwards at changing speed; with moves it stops in between."""
    if not moves:
        rates = math.tau * rng.uniform([0.05, 0.2, 0.6], [0.15, 0.5, 1.2])
        phases = rng.uniform(0.0, math.tau, 3)
        shares = np.array([0.5, 0.25, 0.12])
        waves = shares[:, None] * np.sin(rates[:, None] * time + phases[:, None])
        made: FloatArray = (1.0 + waves.sum(axis=0)) * np.minimum(time / 0.5, 1.0) ** 2
        return made
    speed, start = np.zeros_like(time), 0.2
    while start < time[-1]:
        length = float(rng.uniform(0.6, 2.0))
        speed += float(rng.uniform(0.3, 1.0)) * _bump((time - start) / length)
        start += length + float(rng.uniform(0.02, 0.3))
    return speed


def _with_rests(rng: np.random.Generator, speed: FloatArray) -> FloatArray:
    """The same motion in pieces, standing still for as long in between; it stops softly."""
    pieces = int(rng.integers(3, 7))
    half = speed.size // 2
    cuts = np.concatenate([[0], np.sort(rng.integers(1, half, pieces - 1)), [half]])
    soft = round(0.15 * LOOP_HZ)
    made = []
    for first, last in pairwise(cuts):
        piece = speed[first:last].copy()
        edge = min(soft, piece.size // 2)
        ramp = 0.5 - 0.5 * np.cos(math.pi * np.arange(edge) / max(edge, 1))
        piece[:edge] *= ramp
        piece[piece.size - edge :] *= ramp[::-1]
        made += [piece, np.zeros(piece.size)]
    whole = np.concatenate(made)
    padded: FloatArray = np.pad(whole, (0, speed.size - whole.size))
    return padded
