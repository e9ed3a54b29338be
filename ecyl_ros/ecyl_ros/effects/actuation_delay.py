"""Delay of the voltage on its way to the inverter."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..drive.parameters import DriveParameters
from .effect import Effect, Quantity
from .starts import multiples


def modify(record: np.ndarray, values: Mapping[str, float], drive: DriveParameters) -> None:
    """In control ticks, whole and broken ones."""
    record["actuation_delay"] += values["delay_s"] * drive.controller.rate


EFFECT = Effect(
    name="actuation_delay",
    block="timing",
    title="actuation delay",
    summary="The inverter applies each voltage a moment after it was commanded: the "
    "current loop rings.",
    excitation="fast changes of motion: impacts at reversals, chirps, steps",
    parameters=(
        Quantity(
            name="delay_s",
            unit="s",
            low=0.0,
            high=0.05,
            meaning="from command to inverter, beyond nominal",
        ),
    ),
    starts=multiples(
        "delay_s",
        lambda evidence: 1.0 / evidence.drive.controller.rate,
        (1.5, 0.7, 2.2, 3.5, 6.0, 15.0),
    ),
    modify=modify,
)
