"""References such as an engineer runs to get to know a drive: blocks of motion, rest between.

Every block begins and ends at rest where the last one stopped. Positions and velocities are exact
at each control tick: the stand-in's controller follows the curve itself, a diagnosis has samples.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ....arrays import FloatArray

Motion = tuple[FloatArray, FloatArray]  # position m, velocity m/s, on the ticks of one block

PEAK_OF_MOVE = 1.875  # peak over mean velocity of the quintic move


def _quintic(share: FloatArray) -> Motion:
    """Rise from 0 to 1 at rest at both ends, and its slope, for a share 0 to 1 of the time."""
    x = np.clip(share, 0.0, 1.0)
    return x**3 * (10.0 + x * (6.0 * x - 15.0)), 30.0 * x**2 * (1.0 - x) ** 2


def _windowed(time: FloatArray, wave: FloatArray, slope: FloatArray, ramp: float) -> Motion:
    """A wave that fades in and out over `ramp` s; slope is the wave's time derivative."""
    rise, rise_slope = _quintic(time / ramp)
    fall, fall_slope = _quintic((time[-1] - time) / ramp)
    window = rise * fall
    window_slope = (rise_slope * fall - rise * fall_slope) / ramp
    return window * wave, window * slope + window_slope * wave


def _legs(time: FloatArray, goals: list[float], speed: float, share: float, start: float) -> Motion:
    """Quintic moves through `goals` m, each in a slot of its own of which it takes `share`.

    A move that would ask for more than `speed` m/s is shortened.
    """
    slot = time[-1] / len(goals)
    length = share * slot
    reach = speed * length / PEAK_OF_MOVE
    position, velocity = np.full_like(time, start), np.zeros_like(time)
    place = start
    for index, goal in enumerate(goals):
        step = float(np.clip(goal - place, -reach, reach))
        rise, slope = _quintic((time - index * slot) / length)
        position += step * rise
        velocity += step * slope / length
        place += step
    return position, velocity


def _moves(rng: np.random.Generator, time: FloatArray, start: float, speed: float) -> Motion:
    """Moves of a few millimetres about the middle of the stroke, resting after each."""
    count = max(2, round(time[-1] / rng.uniform(0.5, 0.9)))
    share = rng.uniform(0.6, 0.85)
    reach = speed * share * time[-1] / count / PEAK_OF_MOVE
    goals, place = [], start
    for _ in range(count):
        goal = reach * rng.uniform(-0.75, 0.75)
        if abs(goal - place) < 0.3 * reach:  # a move worth the name
            goal = place - reach * rng.uniform(0.4, 0.9) * (1.0 if place > 0.0 else -1.0)
        goals.append(goal)
        place = goal
    return _legs(time, goals, speed, share, start)


def _staircase(rng: np.random.Generator, time: FloatArray, start: float, speed: float) -> Motion:
    """Quick steps one way and back, a short rest on each stair."""
    count = max(4, round(time[-1] / rng.uniform(0.35, 0.6)))
    share = rng.uniform(0.5, 0.8)
    rise = speed * share * time[-1] / count / PEAK_OF_MOVE * rng.uniform(0.4, 0.8)
    side = -1.0 if start > 0.0 else 1.0
    up = int(rng.integers(count // 2, count))
    signs = np.where(np.arange(count) < up, side, -side)
    return _legs(time, list(start + np.cumsum(rise * signs)), speed, share, start)


def _reversals(rng: np.random.Generator, time: FloatArray, start: float, speed: float) -> Motion:
    """A tiny slow sine: the load is picked up, turned round and let go."""
    amplitude = rng.uniform(5e-4, 2.5e-3) * speed  # some 20 to 90 um for a bench drive
    rate = 2.0 * np.pi * rng.uniform(0.4, 1.5)
    position, velocity = _windowed(
        time,
        amplitude * np.sin(rate * time),
        amplitude * rate * np.cos(rate * time),
        0.2 * time[-1],
    )
    return start + position, velocity


def _chirp(rng: np.random.Generator, time: FloatArray, start: float, speed: float) -> Motion:
    first, last = rng.uniform(0.5, 2.0), rng.uniform(5.0, 9.0)
    amplitude = speed / (2.0 * np.pi * last) * rng.uniform(0.7, 0.95)
    sweep = (last - first) / time[-1]
    angle = 2.0 * np.pi * (first * time + 0.5 * sweep * time**2)
    rate = 2.0 * np.pi * (first + sweep * time)
    position, velocity = _windowed(
        time, amplitude * np.sin(angle), amplitude * rate * np.cos(angle), 0.12 * time[-1]
    )
    return start + position, velocity


def _mixture(rng: np.random.Generator, time: FloatArray, start: float, speed: float) -> Motion:
    """A few sines at once."""
    rates = 2.0 * np.pi * rng.uniform(0.5, 3.5, size=3)
    phases = rng.uniform(0.0, 2.0 * np.pi, size=3)
    shares = rng.uniform(0.4, 1.0, size=3)
    wave, slope = np.zeros_like(time), np.zeros_like(time)
    for rate, phase, share in zip(rates, phases, shares, strict=True):
        wave += share / rate * np.sin(rate * time + phase)
        slope += share * np.cos(rate * time + phase)
    position, velocity = _windowed(time, wave, slope, 0.15 * time[-1])
    scale = speed * rng.uniform(0.7, 0.95) / np.max(np.abs(velocity))
    return start + scale * position, scale * velocity


Block = Callable[[np.random.Generator, FloatArray, float, float], Motion]


def draw_reference(
    rng: np.random.Generator, duration_s: float, tick_s: float, speed: float
) -> Motion:
    """A reference of four blocks in random order.

    Returns position m and velocity m/s, float64[ticks]. speed: m/s, the largest that is asked for.
    """
    large: list[Block] = [_moves, _moves, _staircase, _mixture]
    blocks: list[Block] = [_reversals, _chirp, _moves, large[int(rng.integers(len(large)))]]
    order = rng.permutation(len(blocks))
    ticks = round(duration_s / tick_s)
    shares = rng.uniform(0.8, 1.2, size=len(blocks))
    ends = np.round(np.cumsum(shares) / np.sum(shares) * ticks).astype(int)
    position, velocity = np.zeros(ticks), np.zeros(ticks)
    first, place = 0, 0.0
    for block, last in zip(order, ends, strict=True):
        time = np.arange(last - first + 1) * tick_s
        block_position, block_velocity = blocks[int(block)](rng, time, place, speed)
        position[first:last] = block_position[:-1]
        velocity[first:last] = block_velocity[:-1]
        first, place = last, float(block_position[-1])
    return position, velocity
