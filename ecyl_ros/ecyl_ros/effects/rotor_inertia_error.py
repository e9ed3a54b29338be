"""The rotor is heavier or lighter than the nominal model has it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ..drive.parameters import DriveParameters
from . import load_inertia_error
from .effect import Effect, Quantity
from .starts import multiples


def modify(record: np.ndarray, values: Mapping[str, float], drive: DriveParameters) -> None:
    """Put the true value in the nominal one's place."""
    record["per_rotor_inertia"] = 1.0 / values["inertia_kg_m2"]


EFFECT = Effect(
    name="rotor_inertia_error",
    block="motor_mechanical",
    title="wrong rotor inertia",
    summary="Torque in proportion to the rotor's acceleration, in the backlash too.",
    excitation="acceleration",
    separated_by="passages through the backlash separate it from the load's inertia",
    parameters=(
        Quantity(
            name="inertia_kg_m2",
            unit="kg m^2",
            low=1e-9,
            high=10.0,
            meaning="true inertia of the rotor",
        ),
    ),
    starts=multiples(
        "inertia_kg_m2", lambda evidence: evidence.drive.motor.rotor_inertia, (0.5, 0.8, 1.3, 2.0)
    ),
    modify=modify,
    neutral=lambda drive: drive.motor.rotor_inertia,
    constant="motor.rotor_inertia",
)


# A drive of one inertia that turns has on its rotor what a straight one has on its load.
RIGID = replace(load_inertia_error.RIGID, outputs=("rotary",))
