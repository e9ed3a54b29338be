"""What the rotor drives is heavier or lighter than the nominal model has it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..drive.parameters import DriveParameters
from .effect import Effect, Quantity
from .starts import multiples


def modify(record: np.ndarray, values: Mapping[str, float], drive: DriveParameters) -> None:
    """Put the true value in the nominal one's place."""
    record["per_load_inertia"] = 1.0 / values["inertia_kg_m2"]


EFFECT = Effect(
    name="load_inertia_error",
    block="load",
    title="wrong load inertia",
    summary="Torque in proportion to the load's acceleration, while the flanks are in contact.",
    excitation="acceleration; passages through the clearance tell it from the rotor's",
    parameters=(
        Quantity(
            name="inertia_kg_m2",
            unit="kg m^2",
            low=1e-9,
            high=100.0,
            meaning="true inertia of the load at the rotor",
        ),
    ),
    starts=multiples(
        "inertia_kg_m2", lambda evidence: evidence.drive.load.inertia, (0.5, 0.75, 1.5, 2.5)
    ),
    modify=modify,
    neutral=lambda drive: drive.load.inertia,
    constant="load.inertia",
)
