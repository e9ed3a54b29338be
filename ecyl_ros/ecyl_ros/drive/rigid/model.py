"""What the values and effects of a machine's file come to, as one model of effort."""

from __future__ import annotations

from dataclasses import dataclass

from .acting import Acting
from .machine import Machine

Pair = tuple[float, float]  # forwards, backwards


@dataclass(frozen=True)
class Model:
    """The effort that a rigid machine asks for, in one unit of effort and SI of the output.

        effort(t - delay_s) = inertia a + viscous v + coulomb sign(v) + stiffness q + constant + ...

    Attributes:
        inertia: None where the file leaves it out. viscous, coulomb: forwards and backwards.
        keys: inertia, viscous, coulomb, constant and stiffness of the file's own keys alone.
        shapes: effects beyond these, by name and values as in `acting`.
    """

    inertia: float | None
    viscous: Pair
    coulomb: Pair
    constant: float
    stiffness: float
    delay_s: float
    keys: tuple[float, float, float, float, float]
    shapes: tuple[Acting, ...]


def model_of(machine: Machine, own: bool) -> Model:
    """The model of `machine`.

    own: whether effort is counted in N or N m of the output. Where it is not (the gain is unknown),
    the file's keys say nothing of it; its effects do.
    """
    keys = (0.0,) * 5
    if own:
        keys = (
            machine.inertia or 0.0,
            machine.viscous,
            machine.coulomb,
            machine.constant,
            machine.stiffness,
        )
    ratio = gain_ratio(machine)
    inertia, viscous, coulomb, constant, stiffness = (ratio * one for one in keys)
    known = own and machine.inertia is not None
    ways = [[viscous, viscous], [coulomb, coulomb]]
    delay = 0.0
    shapes = []
    for one in machine.effects:
        values = one.values
        match one.name.removeprefix("load_").removeprefix("rotor_"):
            case "inertia_error":
                inertia, known = inertia + values["inertia"] - keys[0], True
            case "viscous_friction":
                ways[0] = [value + values["viscous"] for value in ways[0]]
            case "coulomb_friction":
                ways[1] = [value + values["coulomb"] for value in ways[1]]
            case "direction_dependent_friction":
                for row, name in zip(ways, ("viscous", "coulomb"), strict=True):
                    row[0] += values[f"{name}_positive"]
                    row[1] += values[f"{name}_negative"]
            case "constant_load":
                constant += next(iter(values.values()))
            case "spring_load":
                stiffness += values["stiffness"]
                constant -= values["stiffness"] * values["rest"]
            case "actuation_delay":
                delay += values["delay"]
            case "torque_constant_error":
                pass  # in the ratio
            case _:
                shapes.append(one)
    return Model(
        inertia=inertia if known else None,
        viscous=(ways[0][0], ways[0][1]),
        coulomb=(ways[1][0], ways[1][1]),
        constant=constant,
        stiffness=stiffness,
        delay_s=delay,
        keys=(keys[0], keys[1], keys[2], keys[3], keys[4]),
        shapes=tuple(shapes),
    )


def gain_ratio(machine: Machine) -> float:
    """Effort by the file's gain over effort by the true one, which an effect may tell."""
    for one in machine.effects:
        if one.name == "torque_constant_error" and machine.gain is not None:
            return machine.gain / next(iter(one.values.values()))
    return 1.0
