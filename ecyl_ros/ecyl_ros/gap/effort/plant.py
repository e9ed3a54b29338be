"""A rigid machine moved by its effort: one inertia, friction that sticks, what acts over position.

    M dv/dt = e (1 - ripple) - friction - viscous v - stiffness q - constant - waves(q) - sines(t)

A step takes position and viscous friction at its middle (second order), Coulomb friction as a set:
the speed comes to nought within a step where friction is enough to stop it, and stays there while
friction holds the rest (time stepping after Moreau, "Unilateral contact and dry friction in finite
freedom dynamics", 1988), so that nothing has to be softened and no step is stiff.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from ...drive.compiled import kernel
from ..diagnosis import FloatArray
from .model import Model

_EDGE = 0.1  # of a jam's width, over which it sets in


class Plant(NamedTuple):
    """A `Model` packed for the step, a row an effect of its kind; all in the balance's unit.

    stribeck: [surplus, speed]. drift: change of the friction level per s. carried: level over
    |inertia a + constant|, that inertia and constant. jams: [level, middle, width].
    waves: [rad per position, sine, cosine]. ripples: the same over effort. sines: [rad/s, sine,
    cosine] over time.
    """

    inertia: float
    viscous_forwards: float
    viscous_backwards: float
    coulomb_forwards: float
    coulomb_backwards: float
    constant: float
    stiffness: float
    drift: float
    carried: FloatArray
    stribeck: FloatArray
    jams: FloatArray
    waves: FloatArray
    ripples: FloatArray
    sines: FloatArray


def plant_of(model: Model) -> Plant:
    """Pack a model whose inertia is known."""
    assert model.inertia is not None
    rows: dict[str, list[list[float]]] = {
        name: [] for name in ("carried", "stribeck", "jams", "waves", "ripples", "sines")
    }
    level, drift = 0.0, 0.0
    for one in model.shapes:
        values = one.values
        match one.name:
            case "stribeck_friction":
                level += values["coulomb"]
                rows["stribeck"].append([values["static"] - values["coulomb"], values["stribeck"]])
            case "friction_drift":
                level += values["coulomb"]
                drift += values["coulomb"] * values["rate"]
            case "load_dependent_friction":
                if "inertia" in values:
                    carried = [values["inertia"], 1.0, 0.0]
                else:
                    carried = [values["share"], model.keys[0] or model.inertia, model.keys[3]]
                rows["carried"].append(carried)
            case "local_jam":
                rows["jams"].append([values["coulomb"], values["position"], values["width"]])
            case "gravity_on_arm":
                rows["waves"].append([1.0, *_parts(values["amplitude"], values["phase"])])
            case "cogging_torque":
                parts = _parts(values["amplitude"], values["phase"])
                rows["waves"].append([values["wave"], *parts])
            case "torque_ripple":
                parts = _parts(values["fraction"], values["phase"])
                rows["ripples"].append([values["wave"], *parts])
            case "periodic_disturbance":
                parts = _parts(values["amplitude"], values["phase"])
                rows["sines"].append([math.tau * values["frequency"], *parts])
            case _:
                raise KeyError(one.name)
    tables = {name: _table(made, 2 if name == "stribeck" else 3) for name, made in rows.items()}
    return Plant(
        inertia=model.inertia,
        viscous_forwards=model.viscous[0],
        viscous_backwards=model.viscous[1],
        coulomb_forwards=model.coulomb[0] + level,
        coulomb_backwards=model.coulomb[1] + level,
        constant=model.constant,
        stiffness=model.stiffness,
        drift=drift,
        **tables,
    )


def _parts(amplitude: float, phase: float) -> list[float]:
    return [amplitude * math.cos(phase), amplitude * math.sin(phase)]


def _table(rows: Iterable[list[float]], columns: int) -> FloatArray:
    return np.array(list(rows), dtype=np.float64).reshape(-1, columns)


@kernel
def _level(p, time, position, speed, acceleration, way):
    """Friction level against motion to `way` (1, -1), viscous part left out; never below nought."""
    level = p.coulomb_forwards if way > 0.0 else p.coulomb_backwards
    level += p.drift * time
    for row in range(p.stribeck.shape[0]):
        level += p.stribeck[row, 0] * math.exp(-((speed / p.stribeck[row, 1]) ** 2))
    for row in range(p.carried.shape[0]):
        level += p.carried[row, 0] * abs(p.carried[row, 1] * acceleration + p.carried[row, 2])
    for row in range(p.jams.shape[0]):
        width = p.jams[row, 2]
        inside = (abs(position - p.jams[row, 1]) - 0.5 * width) / (_EDGE * width)
        level += 0.5 * p.jams[row, 0] * (1.0 - math.tanh(inside))
    return max(level, 0.0)


@kernel
def step(p, time, position, speed, acceleration, effort, pushed, h):
    """Position, speed and acceleration after `h` s under an effort that stays.

    time, position, speed: at the beginning. pushed: load beyond the model's, against positive
    motion. acceleration: of the last step.
    """
    middle = position + 0.5 * h * speed
    half = time + 0.5 * h
    share = 1.0
    for row in range(p.ripples.shape[0]):
        angle = p.ripples[row, 0] * middle
        share -= p.ripples[row, 1] * math.sin(angle) + p.ripples[row, 2] * math.cos(angle)
    load = p.constant + p.stiffness * middle + pushed
    for row in range(p.waves.shape[0]):
        angle = p.waves[row, 0] * middle
        load += p.waves[row, 1] * math.sin(angle) + p.waves[row, 2] * math.cos(angle)
    for row in range(p.sines.shape[0]):
        angle = p.sines[row, 0] * half
        load += p.sines[row, 1] * math.sin(angle) + p.sines[row, 2] * math.cos(angle)
    drive = effort * share - load
    left = h
    new = speed
    if speed != 0.0:
        way = math.copysign(1.0, speed)
        viscous = p.viscous_forwards if way > 0.0 else p.viscous_backwards
        level = _level(p, half, middle, speed, acceleration, way)
        rate = p.inertia / h
        new = ((rate - 0.5 * viscous) * speed + drive - way * level) / (rate + 0.5 * viscous)
        if new * way > 0.0:
            return position + 0.5 * h * (speed + new), new, (new - speed) / h
        # It stops within the step, and what is left of the step begins at rest.
        left = h * (1.0 - speed / (speed - new))
        middle = position + 0.5 * (h - left) * speed
        new = 0.0
    else:
        middle = position
    way = math.copysign(1.0, drive)
    level = _level(p, half, middle, 0.0, 0.0, way)
    if abs(drive) > level and left > 0.0:
        viscous = p.viscous_forwards if way > 0.0 else p.viscous_backwards
        new = (drive - way * level) / (p.inertia / left + 0.5 * viscous)
    stopped = position + 0.5 * (h - left) * speed
    return stopped + 0.5 * left * new, new, (new - speed) / h


@kernel
def along(p, time, position, speed, effort, pushed, h):
    """Positions and speeds at the beginning of each step under efforts given per step, both [n]."""
    n = effort.shape[0]
    positions, speeds = np.empty(n), np.empty(n)
    acceleration = 0.0
    for index in range(n):
        positions[index], speeds[index] = position, speed
        position, speed, acceleration = step(
            p, time + index * h, position, speed, acceleration, effort[index], pushed[index], h
        )
    return positions, speeds
