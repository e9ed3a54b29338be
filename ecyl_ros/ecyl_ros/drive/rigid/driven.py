"""A rigid machine driven along a recording: by its own loop, or by the effort that was measured."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from ...arrays import BoolArray, FloatArray
from ..compiled import kernel
from .course import Course
from .law import remembered
from .loop import ask, gains_of, reference_speed
from .machine import Machine
from .packed import model_of, plant_of
from .plant import along, step

_FINEST_S = 1e-4  # steps are no longer than this, and two at least between two ticks
_FIRST = 5  # samples whose mean effort the loop's integral begins with
_REST = 1e-3  # of the largest speed: below it a piece begins at rest, so that friction can stick


@dataclass(frozen=True, eq=False)
class Driven:
    """Position, speed and effort on the grid of the motion, float64[n]; NaN between the pieces.

    effort: what the loop asks for, as it was recorded; NaN throughout where none is at work.
    """

    position: FloatArray
    velocity: FloatArray
    effort: FloatArray


@dataclass(frozen=True, eq=False)
class Pieces:
    """Parts of a motion that are driven by themselves, each begun at the measured state.

    first, behind: int64[k], samples; `behind` is no part of a piece.
    """

    first: NDArray[np.int64]
    behind: NDArray[np.int64]

    def __iter__(self) -> Iterator[tuple[int, int]]:
        return iter(zip(self.first.tolist(), self.behind.tolist(), strict=True))


def pieces(where: BoolArray, label: NDArray[np.int64] | None = None, least: int = 8) -> Pieces:
    """Runs of `where`, cut where `label` changes; shorter ones than `least` are left out."""
    cut = np.diff(where.astype(np.int8)) != 0
    if label is not None:
        cut |= np.diff(label) != 0
    edges = np.concatenate([[0], np.flatnonzero(cut) + 1, [where.size]])
    first, behind = edges[:-1], edges[1:]
    kept = where[first] & (behind - first >= least)
    return Pieces(first[kept], behind[kept])


def by_effort(
    motion: Course, machine: Machine, own: bool, parts: Pieces, push: FloatArray
) -> Driven:
    """Driven by the effort that was measured, piece by piece.

    push: load beyond the machine's, float64[n].
    """
    model = model_of(machine, own)
    plant = plant_of(model)
    memory = remembered(model.learned, motion, motion.effort)
    # The model counts effort as the drive's was recorded; what was injected is what it is.
    driving = motion.effort + (model.ratio - 1.0) * motion.injected
    rate = motion.rate_hz
    steps = max(1, math.ceil(2.0 / (5.0 * rate * _FINEST_S)))
    found = _nothing(motion)
    h = 1.0 / (rate * steps)
    for first, behind in parts:
        time = motion.time_s[first] + h * np.arange((behind - first) * steps)
        effort = np.interp(time + 0.5 * h - model.delay_s, motion.time_s, driving)
        pushed = np.interp(time + 0.5 * h, motion.time_s, push)
        position, speed = _begin(motion, first)
        positions, speeds = along(
            plant,
            float(motion.own_s[first]),
            position,
            speed,
            effort,
            pushed,
            np.repeat(memory[first:behind], steps, axis=0),
            h,
        )
        found.position[first:behind] = positions[::steps]
        found.velocity[first:behind] = speeds[::steps]
    return found


def by_loop(motion: Course, machine: Machine, own: bool, parts: Pieces, push: FloatArray) -> Driven:
    """Driven by the reference through the loop of the machine's file, piece by piece.

    push: load beyond the machine's, float64[n].
    """
    model = model_of(machine, own)
    plant, gains = plant_of(model), gains_of(machine)
    rate = motion.rate_hz
    ratio = (machine.rate_hz or rate) / rate
    ticks = max(1, round(ratio))  # between two samples
    hold = max(1, round(1.0 / ratio))  # samples that a slower controller's command stays
    period = 1.0 / (rate * ticks)
    steps = max(2, math.ceil(period / _FINEST_S))
    late = round(machine.delay_s * rate * ticks)
    wanted = reference_speed(machine, motion.reference_position, motion.reference_velocity, rate)
    memory = remembered(model.learned, motion, motion.effort)
    found = _nothing(motion)
    has_speed = bool(np.isfinite(motion.recorded_velocity).any())
    for first, behind in parts:
        position, speed = _begin(motion, first)
        begin = motion.effort[first : min(first + _FIRST, behind)]
        past = math.ceil(late + max(model.delay_s, 0.0) / period) + 1
        before = motion.time_s[first] + period * np.arange(-past, 0)
        commands = np.empty(past + (behind - first) * ticks)
        commands[:past] = np.interp(before, motion.time_s, motion.effort)
        _closed(
            plant,
            gains,
            motion.own_s[first],
            position,
            speed,
            has_speed,
            _fine(motion.reference_position[first:behind], ticks),
            _fine(wanted[first:behind], ticks),
            push[first:behind],
            memory[first:behind],
            float(np.mean(begin)),
            commands,
            past,
            ticks,
            hold,
            steps,
            period,
            late,
            model.delay_s / period,
            found.position[first:behind],
            found.velocity[first:behind],
            found.effort[first:behind],
        )
    return found


def _nothing(motion: Course) -> Driven:
    return Driven(*(np.full(motion.time_s.size, np.nan) for _ in range(3)))


def _begin(motion: Course, first: int) -> tuple[float, float]:
    """Measured position and speed, at rest where the speed is next to nought."""
    top = float(np.quantile(np.abs(motion.velocity[motion.usable]), 0.99))
    speed = float(motion.velocity[first])
    return float(motion.position[first]), speed if abs(speed) > _REST * top else 0.0


def _fine(values: FloatArray, ticks: int) -> FloatArray:
    """Values at every tick; between samples by a cubic spline, which hits smooth references."""
    if ticks == 1 or not np.isfinite(values).all():
        return np.repeat(values, ticks)
    course = scipy.interpolate.CubicSpline(np.arange(values.size), values)
    made: FloatArray = course(np.arange(values.size * ticks) / ticks)
    return made


@kernel
def _closed(
    plant,
    gains,
    start,
    position,
    speed,
    has_speed,
    reference,
    wanted,
    pushed,
    memory,
    first_effort,
    commands,
    past,
    ticks,
    hold,
    steps,
    period,
    late,
    delay_ticks,
    out_position,
    out_velocity,
    out_effort,
):
    h = period / steps
    turn = period * hold
    before, earlier = position - turn * speed, position - 2.0 * turn * speed
    acceleration = 0.0
    integral = 0.0
    if gains.speed_ki > 0.0:
        # Such that the loop asks at first for what was recorded.
        first, _ = ask(gains, reference[0], wanted[0], position, speed, 0.0, turn)
        integral = (first_effort - first) / gains.speed_ki
    command = first_effort
    for tick in range(reference.shape[0]):
        if tick % hold == 0:
            measured = speed if has_speed else (position - earlier) / (2.0 * turn)
            command, integral = ask(
                gains, reference[tick], wanted[tick], position, measured, integral, turn
            )
            earlier, before = before, position
        commands[past + tick] = command
        if tick % ticks == 0:
            out_position[tick // ticks] = position
            out_velocity[tick // ticks] = speed
            out_effort[tick // ticks] = commands[past + tick - late]
        for part in range(steps):
            at = math.floor(tick + part / steps - delay_ticks + 1e-9) - late
            effort = commands[past + min(at, tick)]
            time = start + (tick * steps + part) * h
            row = tick // ticks
            position, speed, acceleration = step(
                plant,
                time,
                position,
                speed,
                acceleration,
                effort,
                pushed[row],
                (memory[row, 0], memory[row, 1]),
                h,
            )
